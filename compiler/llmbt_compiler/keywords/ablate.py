"""What each part of the training data and of the parser's snapping is worth: one small training for each row."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from llmbt_compiler.keywords.evaluate import Evaluation, Example, evaluate
from llmbt_compiler.keywords.generate import CONTEXT, MIXTURE
from llmbt_compiler.keywords.tagger import OnnxTagger, Tagger
from llmbt_compiler.keywords.train import TrainSettings, train
from llmbt_compiler.parsing.evaluate import ConditionScores, evaluate_conditions

__all__ = ["ROWS", "Outcome", "Row", "ablate"]


@dataclass(frozen=True, slots=True)
class Row:
    """A way to make training data; `snap`: whether the parser brings keywords to the names of the map."""

    name: str
    mixture: Mapping[str, float] = field(default_factory=lambda: MIXTURE)
    unknown_nouns: bool = True
    snap: bool = True


@dataclass(frozen=True, slots=True)
class Outcome:
    """The figures of a row: in-template, on the development steps, and steps to conditions on the development cases."""

    row: Row
    in_template: Evaluation
    dev: Evaluation
    conditions: ConditionScores


def _without(*names: str) -> Mapping[str, float]:
    return {name: 0.0 if name in names else weight for name, weight in MIXTURE.items()}


ROWS: Sequence[Row] = (
    Row("all"),
    Row("all, without snapping", snap=False),
    Row("without unknown nouns", unknown_nouns=False),
    Row("without context clauses", _without(*CONTEXT)),
    Row("plain structures only", _without(*(name for name in MIXTURE if name != "plain"))),
    Row("plain structures, listed nouns, no snapping", _without(*(n for n in MIXTURE if n != "plain")), False, False),
)


def ablate(
    folder: Path,
    settings: TrainSettings,
    dev: Sequence[Example],
    cases: Path,
    rows: Sequence[Row] = ROWS,
    observe: Callable[[Outcome], None] = lambda _: None,
) -> tuple[Outcome, ...]:
    """Trains for each row into a folder of its own, and scores it.

    Rows that differ in nothing but `snap` share a training. Raises BaseWeightsError, GrammarError, CaseError, OSError.
    """
    out: list[Outcome] = []
    trained: dict[tuple[tuple[tuple[str, float], ...], bool], tuple[Tagger, Evaluation]] = {}
    for i, row in enumerate(rows):
        key = (tuple(sorted(row.mixture.items())), row.unknown_nouns)
        if key not in trained:
            home = folder / f"{i}"
            found = train(home, settings, mixture=row.mixture, unknown_nouns=row.unknown_nouns)
            trained[key] = OnnxTagger(home), found.in_template
        tagger, in_template = trained[key]
        scored = evaluate(dev, [t.spans for t in tagger.tag([e.text for e in dev])])
        out.append(Outcome(row, in_template, scored, evaluate_conditions(cases, tagger, snap=row.snap)))
        observe(out[-1])
    return tuple(out)
