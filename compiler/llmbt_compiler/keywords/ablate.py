"""What each part of the training data and of the parser's snapping is worth: one small training for each row."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from llmbt_compiler.keywords.evaluate import Evaluation, Example, evaluate
from llmbt_compiler.keywords.generate import CONTEXT, MIXTURE
from llmbt_compiler.keywords.stages import GRAMMAR, NATURAL, natural_steps
from llmbt_compiler.keywords.tagger import OnnxTagger
from llmbt_compiler.keywords.train import TrainSettings, train
from llmbt_compiler.parsing.evaluate import ConditionScores, evaluate_conditions, read_cases

__all__ = ["ROWS", "Outcome", "Row", "ablate"]

_Key = tuple[tuple[tuple[str, float], ...], bool, bool]


@dataclass(frozen=True, slots=True)
class Row:
    """A way to make training data.

    `natural`: a second stage on the natural steps follows. `snap`: the parser brings keywords to the map's names.
    """

    name: str
    mixture: Mapping[str, float] = field(default_factory=lambda: MIXTURE)
    unknown_nouns: bool = True
    snap: bool = True
    natural: bool = False


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
    Row("all, then the natural steps", natural=True),
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

    Rows that differ in nothing but `snap` share a training, those that differ in `natural` its first stage. Natural
    steps that are scored on, in `dev` or `cases`, are left out. Raises BaseWeightsError, GrammarError, CaseError,
    ExampleError, OSError.
    """
    scored_on = {e.text for e in dev} | {step for case in read_cases(cases) for step in case.steps}
    natural = [e for e in natural_steps() if e.text not in scored_on]
    trained: dict[_Key, tuple[Path, Evaluation]] = {}

    def training(row: Row) -> tuple[Path, Evaluation]:
        key = (tuple(sorted(row.mixture.items())), row.unknown_nouns, row.natural)
        if key not in trained:
            before = training(replace(row, natural=False))[0] if row.natural else None
            home = folder / f"{len(trained)}"
            found = train(
                home,
                _in_proportion(settings) if row.natural else settings,
                extra=natural if row.natural else (),
                mixture=row.mixture,
                unknown_nouns=row.unknown_nouns,
                start_from=before,
            )
            trained[key] = home, found.in_template
        return trained[key]

    out: list[Outcome] = []
    for row in rows:
        home, in_template = training(row)
        tagger = OnnxTagger(home)
        scored = evaluate(dev, [t.spans for t in tagger.tag([e.text for e in dev])])
        out.append(Outcome(row, in_template, scored, evaluate_conditions(cases, tagger, snap=row.snap)))
        observe(out[-1])
    return tuple(out)


def _in_proportion(settings: TrainSettings) -> TrainSettings:
    """The second stage, as much smaller than the shipped weights' as `settings` are than their first."""
    share = settings.samples / GRAMMAR.samples
    return replace(
        settings,
        samples=max(1, round(NATURAL.samples * share)),
        extra_times=max(1, round(NATURAL.extra_times * share)),
        learning_rate=NATURAL.learning_rate,
    )
