"""The weights file: int8 a row with fp16 scales, in safetensors; widened to float32 when it is read.

A matrix ``name`` is stored as ``name`` (int8, rows x columns) and ``name.scale`` (fp16, rows); a vector as float32.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save_file

__all__ = [
    "EMBEDDINGS",
    "ModelConfig",
    "Weights",
    "WeightsError",
    "quantise",
    "read_weights",
    "widen",
    "write_weights",
]

EMBEDDINGS = "bert.embeddings.word_embeddings.weight"
"""Half of all weights; a tagger that reads few words need not widen them."""

_HEADER = "llmbt.keywords"


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


@dataclass(frozen=True)
class Weights:
    """Tensors by the names that `transformers.BertForTokenClassification` gives them, and what made them.

    `tensors` are float32; the word embeddings (vocabulary x hidden) may stay in `packed` as int8 with their scales.
    """

    config: ModelConfig
    tensors: Mapping[str, NDArray[np.float32]]
    packed: Mapping[str, tuple[NDArray[np.int8], NDArray[np.float16]]]
    about: Mapping[str, str]

    def rows(self, name: str, indices: NDArray[np.int64]) -> NDArray[np.float32]:
        """Some rows of a matrix, as float32 (indices.shape x columns)."""
        if name in self.tensors:
            return self.tensors[name][indices]
        values, scales = self.packed[name]
        return widen(values[indices], scales[indices])


def quantise(matrix: NDArray[np.float32]) -> tuple[NDArray[np.int8], NDArray[np.float16]]:
    """A matrix as int8 and one fp16 scale a row; the error is at most half a scale, and fp16's, for each element."""
    scales = (np.abs(matrix).max(axis=-1) / 127).astype(np.float16)
    divisor = np.maximum(scales.astype(np.float32), np.float32(6e-8))[..., None]
    values = np.clip(np.rint(matrix / divisor), -127, 127).astype(np.int8)
    return values, scales


def widen(values: NDArray[np.int8], scales: NDArray[np.float16]) -> NDArray[np.float32]:
    """The float32 matrix that int8 rows and their scales stand for."""
    out = values.astype(np.float32)
    out *= scales.astype(np.float32)[..., None]
    return out


def write_weights(
    path: Path, config: ModelConfig, tensors: Mapping[str, NDArray[np.float32]], about: Mapping[str, str]
) -> None:
    """Quantises and writes. The same tensors give the same bytes. Raises OSError."""
    out: dict[str, NDArray[np.generic]] = {}
    for name in sorted(tensors):
        if tensors[name].ndim == 2:
            out[name], out[name + ".scale"] = quantise(tensors[name])
        else:
            out[name] = tensors[name].astype(np.float32)
    header = json.dumps({"config": asdict(config), "about": dict(about)}, sort_keys=True)
    path.parent.mkdir(parents=True, exist_ok=True)
    save_file(out, path, metadata={_HEADER: header})  # one entry: safetensors writes several in any order
    path.chmod(0o644)  # safetensors writes it for its owner alone


def read_weights(path: Path, *, widen_embeddings: bool = False) -> Weights:
    """The weights of a file. Raises WeightsError where it is not one of ours, OSError where it cannot be read."""
    tensors: dict[str, NDArray[np.float32]] = {}
    packed: dict[str, tuple[NDArray[np.int8], NDArray[np.float16]]] = {}
    try:
        with safe_open(path, framework="numpy") as f:
            header = json.loads((f.metadata() or {})[_HEADER])
            config, about = ModelConfig(**header["config"]), header["about"]
            names = set(f.keys())
            for name in sorted(names):
                if name.endswith(".scale"):
                    continue
                value = f.get_tensor(name)
                if name + ".scale" not in names:
                    tensors[name] = value
                elif name == EMBEDDINGS and not widen_embeddings:
                    packed[name] = (value, f.get_tensor(name + ".scale"))
                else:
                    tensors[name] = widen(value, f.get_tensor(name + ".scale"))
    except (SafetensorError, KeyError, TypeError, json.JSONDecodeError) as e:
        raise WeightsError(f"{path} holds no keyword tagger: {e}") from e
    return Weights(config, tensors, packed, about)
