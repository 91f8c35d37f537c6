"""How the shipped weights are made: from the base on the grammar alone, then on with steps as writers write them."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path

from llmbt_compiler.keywords.evaluate import Example, read_examples
from llmbt_compiler.keywords.grammar import DATA
from llmbt_compiler.keywords.train import Progress, Trained, TrainSettings, train

__all__ = ["GRAMMAR", "NATURAL", "NATURAL_STEPS", "natural_steps", "train_in_stages"]

GRAMMAR = TrainSettings()
"""The first stage: from the base weights, on generated steps alone."""

NATURAL = TrainSettings(samples=4_000, extra_times=4, learning_rate=1.5e-4)
"""The second: from the weights of the first, on the natural steps, with generated ones among them."""

NATURAL_STEPS = DATA / "natural.jsonl"


def natural_steps() -> tuple[Example, ...]:
    """The labelled steps of the second stage. Raises ExampleError, OSError."""
    return read_examples(NATURAL_STEPS)


def train_in_stages(
    out: Path,
    first: TrainSettings = GRAMMAR,
    second: TrainSettings = NATURAL,
    *,
    natural: Sequence[Example] | None = None,
    dev: Sequence[Example] = (),
    start_from: Path | None = None,
    progress: Callable[[Progress], None] = lambda _: None,
) -> Trained:
    """Trains both stages and writes what `train` writes into `out`, with the record of the first as ``grammar.json``.

    Until the second has ended the weights of the first lie in ``out/grammar``; an interrupted run goes on after the
    last whole epoch of either. `start_from` takes the place of the base weights. Raises as `train` does.
    """
    steps = natural_steps() if natural is None else natural
    home = out / "grammar"
    if not _ended(home, first):
        train(home, first, dev=dev, start_from=start_from, progress=lambda p: progress(replace(p, stage="grammar")))
    told = (home / "training.json").read_bytes()
    trained = train(
        out, second, dev=dev, extra=steps, start_from=home, progress=lambda p: progress(replace(p, stage="natural"))
    )
    (out / "grammar.json").write_bytes(told)
    shutil.rmtree(home)
    return trained


def _ended(home: Path, settings: TrainSettings) -> bool:
    """Whether the first stage has been trained, with these settings, by a run that did not come to its end."""
    record = home / "training.json"
    return record.is_file() and bool(json.loads(record.read_text("utf-8"))["settings"] == asdict(settings))
