"""The weights file: int8 matrices with fp16 scales, in safetensors; as they are for the fast path, widened for torch.

A matrix ``name`` is stored as ``name`` (int8, rows x columns) and ``name.scale`` (fp16, rows), and may have
``name.columns`` (float32, columns): its value is int8 x scale x columns. Column scales take the outliers of what the
matrix is multiplied with into the weights, so that those inputs, too, can be rounded to eight bits (SmoothQuant, Xiao
et al. 2023). A vector is stored as float32.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save_file

__all__ = [
    "EMBEDDINGS",
    "BaseWeightsError",
    "Matrix",
    "ModelConfig",
    "Weights",
    "WeightsError",
    "quantise",
    "read_weights",
    "smoothing",
    "write_weights",
]

EMBEDDINGS = "bert.embeddings.word_embeddings.weight"
"""Half of all weights; a tagger that reads few words needs few of its rows."""

_HEADER = "llmbt.keywords"
_STRENGTH = 0.85
"""How much of an input's outliers goes into the weights (0 to 1); by trial, of 0.5 to 1."""


class BaseWeightsError(RuntimeError):
    """The base weights are not installed."""


class WeightsError(ValueError):
    """A file that holds no weights of this kind."""


@dataclass(frozen=True, slots=True)
class ModelConfig:
    """The shape of the BERT; the defaults are those of the shipped one."""

    vocabulary: int = 30522
    hidden: int = 384
    layers: int = 6
    heads: int = 12
    intermediate: int = 1536
    positions: int = 512


@dataclass(frozen=True, slots=True)
class Matrix:
    """A matrix as stored: `values` (rows x columns), `scales` (rows), `columns` (columns; ones for none)."""

    values: NDArray[np.int8]
    scales: NDArray[np.float16]
    columns: NDArray[np.float32]

    def rows(self, indices: NDArray[np.int64]) -> NDArray[np.float32]:
        """Some rows as float32 (indices.shape x columns)."""
        out = self.values[indices].astype(np.float32)
        out *= self.scales[indices].astype(np.float32)[..., None]
        out *= self.columns
        return out

    def widened(self) -> NDArray[np.float32]:
        """All of it as float32."""
        return self.rows(np.arange(len(self.values)))


@dataclass(frozen=True)
class Weights:
    """Matrices and vectors by the names that `transformers.BertForTokenClassification` gives them; what made them."""

    config: ModelConfig
    matrices: Mapping[str, Matrix]
    vectors: Mapping[str, NDArray[np.float32]]
    about: Mapping[str, str]

    def widened(self) -> dict[str, NDArray[np.float32]]:
        """All tensors as float32."""
        return {**{name: m.widened() for name, m in self.matrices.items()}, **self.vectors}


def smoothing(largest: NDArray[np.float32], *matrices: NDArray[np.float32]) -> NDArray[np.float32]:
    """The column scales for matrices (rows x columns) whose common input reaches `largest` (columns, absolute)."""
    weight = np.maximum(np.abs(np.concatenate(matrices)).max(axis=0), np.float32(1e-3))
    grown = np.maximum(largest, np.float32(1e-3)) ** _STRENGTH / weight ** (1 - _STRENGTH)
    grown /= np.exp(np.mean(np.log(grown)))
    scales: NDArray[np.float32] = (1 / grown).astype(np.float32)
    return scales


def quantise(matrix: NDArray[np.float32], columns: NDArray[np.float32] | None = None) -> Matrix:
    """A matrix as int8: off by at most half a row's scale, and fp16's error, times the column's."""
    columns = np.ones(matrix.shape[-1], np.float32) if columns is None else columns
    scaled = matrix / columns
    scales = (np.abs(scaled).max(axis=-1) / 127).astype(np.float16)
    divisor = np.maximum(scales.astype(np.float32), np.float32(6e-8))[..., None]
    return Matrix(np.clip(np.rint(scaled / divisor), -127, 127).astype(np.int8), scales, columns)


def write_weights(
    path: Path,
    config: ModelConfig,
    tensors: Mapping[str, NDArray[np.float32]],
    about: Mapping[str, str],
    columns: Mapping[str, NDArray[np.float32]] = MappingProxyType({}),
) -> None:
    """Quantises and writes; `columns` are the column scales of some matrices. The same tensors give the same bytes.

    Raises OSError.
    """
    out: dict[str, NDArray[np.generic]] = {}
    for name in sorted(tensors):
        if tensors[name].ndim != 2:
            out[name] = tensors[name].astype(np.float32)
            continue
        stored = quantise(tensors[name], columns.get(name))
        out[name], out[name + ".scale"] = stored.values, stored.scales
        if name in columns:
            out[name + ".columns"] = stored.columns
    header = json.dumps({"config": asdict(config), "about": dict(about)}, sort_keys=True)
    path.parent.mkdir(parents=True, exist_ok=True)
    save_file(out, path, metadata={_HEADER: header})  # one entry: safetensors writes several in any order
    path.chmod(0o644)  # safetensors writes it for its owner alone


def read_weights(path: Path) -> Weights:
    """The weights of a file. Raises WeightsError where it is not one of ours, OSError where it cannot be read."""
    matrices: dict[str, Matrix] = {}
    vectors: dict[str, NDArray[np.float32]] = {}
    try:
        with safe_open(path, framework="numpy") as f:
            header = json.loads((f.metadata() or {})[_HEADER])
            config, about = ModelConfig(**header["config"]), header["about"]
            names = set(f.keys())
            for name in sorted(n for n in names if not n.endswith((".scale", ".columns"))):
                value = f.get_tensor(name)
                if name + ".scale" not in names:
                    vectors[name] = value
                    continue
                plain = name + ".columns" not in names
                columns = np.ones(value.shape[1], np.float32) if plain else f.get_tensor(name + ".columns")
                matrices[name] = Matrix(value, f.get_tensor(name + ".scale"), columns)
    except (SafetensorError, KeyError, TypeError, json.JSONDecodeError) as e:
        raise WeightsError(f"{path} holds no keyword tagger: {e}") from e
    return Weights(config, matrices, vectors, about)
