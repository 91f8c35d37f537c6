"""The model in torch and transformers: for training, and as the reference of the fast path.

Importing this module takes seconds. Nothing here reaches a hub: the architecture is built from numbers, the vocabulary
read from a file beside the weights.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

os.environ.setdefault("HF_HUB_OFFLINE", "1")
os.environ.setdefault("TRANSFORMERS_VERBOSITY", "error")

import numpy as np
import torch
from numpy.typing import NDArray
from transformers import BertConfig, BertForTokenClassification, BertTokenizer
from transformers.utils import logging as transformers_logging

from llmbt_compiler.keywords.labels import LABELS
from llmbt_compiler.keywords.pieces import PAD, Window
from llmbt_compiler.keywords.weights import ModelConfig, smoothing

__all__ = ["build", "column_scales", "forward", "new_model", "pad", "tensors_of", "word_cutter"]

transformers_logging.set_verbosity_error()  # type: ignore[no-untyped-call]
transformers_logging.disable_progress_bar()  # type: ignore[no-untyped-call]


def new_model(config: ModelConfig) -> BertForTokenClassification:
    """A model of that shape with random weights (drawn from torch's global generator)."""
    return BertForTokenClassification(
        BertConfig(
            vocab_size=config.vocabulary,
            hidden_size=config.hidden,
            num_hidden_layers=config.layers,
            num_attention_heads=config.heads,
            intermediate_size=config.intermediate,
            max_position_embeddings=config.positions,
            id2label=dict(enumerate(map(str, LABELS))),
            label2id={str(name): i for i, name in enumerate(LABELS)},
        )
    )


def build(config: ModelConfig, tensors: Mapping[str, NDArray[np.float32]]) -> BertForTokenClassification:
    """A model with these weights, ready to tag. Raises RuntimeError where they do not fit its shape."""
    model = new_model(config)
    missing, unknown = model.load_state_dict({k: torch.from_numpy(v) for k, v in tensors.items()}, strict=False)
    if unknown or [name for name in missing if "position_ids" not in name]:
        raise RuntimeError(f"the weights do not fit: missing {missing}, unknown {unknown}")
    model.train(False)
    return model


def tensors_of(model: BertForTokenClassification) -> dict[str, NDArray[np.float32]]:
    """The model's weights by name."""
    return {k: v.detach().numpy().astype(np.float32) for k, v in model.state_dict().items() if v.is_floating_point()}


def word_cutter(vocabulary: Path) -> Callable[[str], list[int]]:
    """Word to piece ids, by transformers' own tokenizer."""
    tokenizer = BertTokenizer(vocab=str(vocabulary), do_lower_case=True)

    def cut(word: str) -> list[int]:
        return tokenizer(word, add_special_tokens=False)["input_ids"] or [tokenizer.unk_token_id]

    return cut


def pad(batch: Sequence[Window]) -> tuple[torch.Tensor, torch.Tensor]:
    """Piece ids (windows x longest) and the mask of what is no padding."""
    longest = max(len(w.ids) for w in batch)
    ids = torch.full((len(batch), longest), PAD, dtype=torch.long)
    mask = torch.zeros((len(batch), longest), dtype=torch.long)
    for i, w in enumerate(batch):
        ids[i, : len(w.ids)] = torch.tensor(w.ids)
        mask[i, : len(w.ids)] = 1
    return ids, mask


@torch.inference_mode()
def column_scales(
    model: BertForTokenClassification, batches: Sequence[Sequence[Window]]
) -> dict[str, NDArray[np.float32]]:
    """How the inputs of the encoder's matrices, as they are on these windows, are best scaled for eight bits.

    By the matrices' names; those with a common input have common scales.
    """
    largest: dict[str, NDArray[np.float32]] = {}
    hooks = []
    for name, module in model.named_modules():
        if isinstance(module, torch.nn.Linear) and name.startswith("bert.encoder."):

            def note(_: torch.nn.Module, args: tuple[torch.Tensor, ...], name: str = name) -> None:
                here = args[0].abs().flatten(0, -2).amax(dim=0).numpy()
                largest[name] = np.maximum(largest[name], here) if name in largest else here

            hooks.append(module.register_forward_pre_hook(note))
    for batch in batches:
        forward(model, batch)
    for hook in hooks:
        hook.remove()
    tensors = tensors_of(model)
    groups: dict[str, list[str]] = {}
    for name in largest:
        groups.setdefault(re.sub(r"self\.(query|key|value)$", "self", name), []).append(f"{name}.weight")
    return {
        name: scales
        for names in groups.values()
        for scales in (smoothing(largest[names[0].removesuffix(".weight")], *(tensors[n] for n in names)),)
        for name in names
    }


@torch.inference_mode()
def forward(model: BertForTokenClassification, batch: Sequence[Window]) -> list[NDArray[np.float32]]:
    """As `llmbt_compiler.keywords.forward.forward`: for each window the scores of its words' first pieces."""
    if not batch:
        return []
    ids, mask = pad(batch)
    logits = model(input_ids=ids, attention_mask=mask).logits.numpy()
    return [logits[i, list(w.first)] for i, w in enumerate(batch)]
