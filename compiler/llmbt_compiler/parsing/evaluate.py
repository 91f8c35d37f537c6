"""What tagger and parser together make of steps: cases with their map and the conditions they mean, scored whole.

fixtures/parsing/README.md has the convention and the format of the cases.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from math import sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any

from llmbt_atl.library import Library, library_names, load_library
from llmbt_compiler.parsing.model import LabelledStep, ParseResult
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.walk import THRESHOLD, parse
from llmbt_ir.condition import Condition, parse_condition
from llmbt_ir.semantic_map import SemanticMap, read_map

if TYPE_CHECKING:
    from llmbt_compiler.keywords.tagger import Tagger

__all__ = [
    "Case",
    "CaseError",
    "ConditionScores",
    "Intent",
    "Outcome",
    "Verdict",
    "evaluate_conditions",
    "judge",
    "read_cases",
    "read_scene",
    "wilson",
]


class CaseError(ValueError):
    """A line of a file of cases that cannot be read; the message names the file and the line (from 1)."""


class Intent(StrEnum):
    """What the author of a case means: goals; nothing that changes the scene; that one has to ask."""

    GOALS = "goals"
    NOTHING = "nothing"
    ASK = "ask"


class Verdict(StrEnum):
    """RIGHT: exactly what is meant. REFUSED: a diagnostic where one was not called for. WRONG: goals not meant."""

    RIGHT = "right"
    REFUSED = "refused"
    WRONG = "wrong"


@dataclass(frozen=True, slots=True)
class Case:
    """Steps over a map, and the sets of goals that are right: an empty one where nothing is to be done, or asked.

    `within`: a place stands for any of the places in it.
    """

    map: str
    steps: tuple[str, ...]
    goals: tuple[frozenset[Condition], ...]
    ask: bool = False
    phenomenon: str = ""
    within: bool = False

    @property
    def intent(self) -> Intent:
        """Which of the three kinds it is."""
        if self.ask:
            return Intent.ASK
        return Intent.GOALS if any(self.goals) else Intent.NOTHING


@dataclass(frozen=True, slots=True)
class Outcome:
    """A case and what came of it."""

    case: Case
    verdict: Verdict
    result: ParseResult


@dataclass(frozen=True)
class ConditionScores:
    """The outcomes, and the counts that are quoted."""

    outcomes: tuple[Outcome, ...]
    counts: Mapping[Intent, Counter[Verdict]] = field(default_factory=dict)
    by_phenomenon: Mapping[str, Counter[Verdict]] = field(default_factory=dict)
    codes: Counter[str] = field(default_factory=Counter)

    @property
    def n(self) -> int:
        """All cases."""
        return len(self.outcomes)

    def rate(self, verdict: Verdict, intent: Intent = Intent.GOALS) -> float:
        """The share of a verdict among the cases of a kind; 0 where there are none."""
        counted = self.counts.get(intent, Counter())
        return counted[verdict] / counted.total() if counted.total() else 0.0

    @property
    def wrong(self) -> int:
        """Cases of any kind on which something not meant would be built."""
        return sum(c[Verdict.WRONG] for c in self.counts.values())

    def as_dict(self) -> dict[str, Any]:
        """For JSON; totals only, so that a blind file stays blind."""
        return {
            "n": self.n,
            "steps": sum(len(o.case.steps) for o in self.outcomes),
            "goals": _told(self.counts.get(Intent.GOALS, Counter())),
            "nothing": _told(self.counts.get(Intent.NOTHING, Counter())),
            "ask": _told(self.counts.get(Intent.ASK, Counter())),
            "wrong_of_all": {"n": self.wrong, "interval": list(wilson(self.wrong, self.n))},
            "by_phenomenon": {k: {str(v): c[v] for v in Verdict} for k, c in sorted(self.by_phenomenon.items())},
            "refused_by_code": dict(sorted(self.codes.items())),
        }


def _told(counted: Counter[Verdict]) -> dict[str, Any]:
    n = counted.total()
    out: dict[str, Any] = {"n": n}
    for v in Verdict:
        out[str(v)] = {
            "n": counted[v],
            "rate": counted[v] / n if n else None,
            "interval": list(wilson(counted[v], n)),
        }
    return out


def wilson(k: int, n: int, z: float = 1.96) -> tuple[float, float]:
    """The 95 % interval of a rate of k in n (Wilson); (0, 1) where n is 0."""
    if n == 0:
        return 0.0, 1.0
    p, zz = k / n, z * z
    middle = (p + zz / (2 * n)) / (1 + zz / n)
    half = z * sqrt(p * (1 - p) / n + zz / (4 * n * n)) / (1 + zz / n)
    return max(0.0, middle - half), min(1.0, middle + half)


def read_cases(path: Path) -> tuple[Case, ...]:
    """JSON lines ``{"map", "steps", "goals", "or"?, "ask"?, "phenomenon"?, "within"?}``. Raises CaseError, OSError."""
    out: list[Case] = []
    for number, line in enumerate(path.read_text("utf-8").splitlines(), start=1):
        if not line.strip():
            continue
        try:
            out.append(_case(json.loads(line)))
        except (KeyError, TypeError, ValueError) as e:
            raise CaseError(f"{path}:{number}: {type(e).__name__}: {e}") from e
    return tuple(out)


def _case(record: Any) -> Case:
    steps = tuple(record["steps"])
    if not steps or not all(isinstance(s, str) and s.strip() for s in steps):
        raise TypeError("steps is no list of texts")
    sets = tuple(_conditions(g) for g in (record["goals"], *record.get("or", ())))
    ask = bool(record.get("ask", False))
    if ask and any(sets):
        raise ValueError("a case that asks has no goals")
    return Case(str(record["map"]), steps, sets, ask, str(record.get("phenomenon", "")), bool(record.get("within")))


def _conditions(texts: Sequence[str]) -> frozenset[Condition]:
    found = [parse_condition(t) for t in texts]
    if None in found:
        raise ValueError(f"no condition: {texts[found.index(None)]!r}")
    return frozenset(c for c in found if c is not None)


def read_scene(folder: Path, name: str) -> tuple[SemanticMap, Library]:
    """A map of the cases by name, ``maps/NAME.xml``, with its library: a shipped one or ``libraries/NAME.xml``.

    Raises LlmbtError.
    """
    found = read_map(folder / "maps" / f"{name}.xml")
    shipped = found.library in library_names()
    return found, load_library(found.library if shipped else str(folder / "libraries" / f"{found.library}.xml"))


def _check(cases: Iterable[Case], scenes: Mapping[str, tuple[SemanticMap, Library]]) -> None:
    for i, case in enumerate(cases, start=1):
        semantic_map, library = scenes[case.map]
        ids = {o.id for o in semantic_map.objects} | {p.id for p in semantic_map.places}
        for c in frozenset[Condition]().union(*case.goals):
            if c.name not in library.conditions or not set(c.args) <= ids:
                raise CaseError(f"case {i}: {c} is no condition over the map `{case.map}`")


def judge(case: Case, result: ParseResult, semantic_map: SemanticMap, *, crowded: bool = False) -> Verdict:
    """What a result is worth. E340 (nothing to be done) is the answer to a case that asks for nothing.

    `crowded`: two things are to stand on one slot, which the compiler proves impossible after the parser.
    """
    if result.ok and not crowded:
        found = frozenset(result.conditions)
        meant = found in case.goals or (case.within and any(_within(found, g, semantic_map) for g in case.goals))
        return Verdict.RIGHT if not case.ask and meant else Verdict.WRONG
    nothing = {d.code for d in result.errors()} == {"E340"}
    return Verdict.RIGHT if case.ask or (nothing and case.intent is Intent.NOTHING) else Verdict.REFUSED


def _within(found: frozenset[Condition], wanted: frozenset[Condition], semantic_map: SemanticMap) -> bool:
    """Whether each goal is wanted, or puts the same thing on a place in the wanted one, and none is missing."""

    def meets(goal: Condition, other: Condition) -> bool:
        alike = goal.name == other.name == "On" and goal.negated == other.negated and goal.args[0] == other.args[0]
        return goal == other or (alike and other.args[1] in semantic_map.containers(goal.args[1]))

    return all(any(meets(g, w) for w in wanted) for g in found) and all(any(meets(g, w) for g in found) for w in wanted)


def _crowded(result: ParseResult, scene: Scene) -> bool:
    slots = [c.args[1] for c in result.conditions if len(c.args) == 2 and not c.negated and scene.single(c.args[1])]
    return len(set(slots)) < len(slots)


def evaluate_conditions(
    path: Path, tagger: Tagger, *, threshold: float = THRESHOLD, snap: bool = True
) -> ConditionScores:
    """The figures of a tagger and the parser on a file of cases, whose maps lie beside it; `snap` as for `parse`.

    Raises CaseError, LlmbtError, OSError.
    """
    cases = read_cases(path)
    scenes = {name: read_scene(path.parent, name) for name in sorted({c.map for c in cases})}
    _check(cases, scenes)
    tagged = iter(tagger.tag([s for c in cases for s in c.steps]))
    outcomes: list[Outcome] = []
    counts: dict[Intent, Counter[Verdict]] = {i: Counter() for i in Intent}
    by_phenomenon: dict[str, Counter[Verdict]] = {}
    codes: Counter[str] = Counter()
    for case in cases:
        steps = [LabelledStep.of(i, next(tagged)) for i in range(1, len(case.steps) + 1)]
        result = parse(steps, *scenes[case.map], threshold=threshold, snap=snap)
        semantic_map = scenes[case.map][0]
        verdict = judge(case, result, semantic_map, crowded=_crowded(result, Scene(*scenes[case.map])))
        outcomes.append(Outcome(case, verdict, result))
        counts[case.intent][verdict] += 1
        by_phenomenon.setdefault(case.phenomenon, Counter())[verdict] += 1
        if verdict is Verdict.REFUSED:
            codes.update({d.code for d in result.errors()})
    return ConditionScores(tuple(outcomes), counts, by_phenomenon, codes)
