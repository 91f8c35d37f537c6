"""The comparison of methods from beginning to end: scenarios, trials, tables."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from llmbt import __version__
from llmbt.experiment.adversary import attack
from llmbt.experiment.baselines_job import BaselineJob, work
from llmbt.experiment.cases import Case, Experiment, Request, experiment_names
from llmbt.experiment.results import Results, write_results
from llmbt.experiment.scenario import (
    ATTACKS,
    CELLS,
    UNSOLVABLE_CELLS,
    Scenario,
    applies,
    comes_about,
    right_goals,
    seed_of,
    tell,
)
from llmbt.experiment.study import Study, run_study
from llmbt.experiment.workers import Pool
from llmbt_ir.condition import Condition
from llmbt_runtime.baselines import EXECUTORS
from llmbt_runtime.disturbance import NAMES

__all__ = ["BaselineOrder", "run_baselines", "scenarios"]


@dataclass(frozen=True, slots=True)
class BaselineOrder:
    """What is asked for. `trials`: in the world of facts so many scenarios a cell, in physics so many in all, in equal
    parts of each disturbance; `attacks`: scenarios of one event and as many of two, to search for what breaks a
    method."""

    worlds: tuple[str, ...] = ("symbolic",)
    trials: int = 50
    attacks: int = 0
    seed: int = 0
    methods: tuple[str, ...] = tuple(EXECUTORS)


class _Rights:
    """The right goals of each case, compiled as they are asked for."""

    def __init__(self, experiment: Experiment) -> None:
        self._makers = {c.name: right_goals(c) for c in experiment.cases}
        self._made: dict[str, list[tuple[Request, tuple[Condition, ...]]]] = {c.name: [] for c in experiment.cases}

    def get(self, case: Case, number: int) -> tuple[Request, tuple[Condition, ...]] | None:
        """The goals of the so-manieth right request, from the first again after the last; None where there is none."""
        made = self._made[case.name]
        while len(made) <= number:
            following = next(self._makers[case.name], None)
            if following is None:
                break
            made.append(following)
        return made[number % len(made)] if made else None


def scenarios(experiment: Experiment, order: BaselineOrder) -> Iterator[Scenario]:
    """The scenarios: cells in turn, cases in turn within a cell, requests in turn within a case. Cells that no case can
    meet are left out."""
    rights = _Rights(experiment)
    for world in order.worlds:
        kinds = [c for c in (*CELLS, *UNSOLVABLE_CELLS) if _able(experiment, rights, world, c)]
        if world == "bullet":
            kinds = [c for c in kinds if c in NAMES]
            cells = [kinds[i % len(kinds)] for i in range(order.trials)]
        else:
            cells = [c for c in kinds for _ in range(order.trials)] + [c for c in ATTACKS for _ in range(order.attacks)]
        counts = dict.fromkeys(cells, 0)
        for cell in cells:
            number = counts[cell]
            counts[cell] += 1
            seed = seed_of(order.seed, world, cell, number)
            turn = _turn(experiment, rights, world, cell, number)
            found = (_scenario(world, cell, case, rights, number, seed) for case in turn)
            scenario = next((s for s, case in found if s.events or comes_about(s, case)), None)
            if scenario is not None:
                yield scenario


def _able(experiment: Experiment, rights: _Rights, world: str, cell: str) -> list[Case]:
    firsts = ((c, rights.get(c, 0)) for c in experiment.cases)
    return [c for c, first in firsts if first is not None and applies(world, cell, c, first[1])]


def _turn(experiment: Experiment, rights: _Rights, world: str, cell: str, number: int) -> Iterator[Case]:
    """The case whose turn it is, and then those after it, should the disturbance not come about in it."""
    able = _able(experiment, rights, world, cell)
    yield from (able[(number + i) % len(able)] for i in range(len(able)))


def _scenario(world: str, cell: str, case: Case, rights: _Rights, number: int, seed: int) -> tuple[Scenario, Case]:
    found = rights.get(case, number // 5)
    assert found is not None
    request, goals = found
    n = ATTACKS.get(cell, 0)
    events = tuple(map(tell, attack(case, (goals,), seed, events=n))) if n else ()
    return Scenario(world, cell, case.name, request.id, tuple(map(str, goals)), number, seed, events), case


def run_baselines(
    experiment: Experiment,
    order: BaselineOrder,
    folder: Path,
    pool: Pool,
    *,
    resume: bool = False,
    force: bool = False,
    quiet: bool = False,
) -> Results:
    """Run what is left of the comparison in `folder`, and write its results there. Errors as `run_study`."""
    plan = tuple(scenarios(experiment, order))
    source = experiment.name if experiment.name in experiment_names() else str(Path(experiment.source).resolve())
    jobs = [BaselineJob(s, m, source) for s in plan for m in order.methods]
    header = {
        "schema_version": 1,
        "kind": "baselines",
        "experiment": experiment.name,
        "source": source,
        "seed": order.seed,
        "worlds": list(order.worlds),
        "trials": order.trials,
        "attacks": order.attacks,
        "methods": list(order.methods),
        "scenarios": len(plan),
        "n": len(jobs),
        "order": [j.key for j in jobs],
        "llmbt_version": __version__,
    }
    run_study(Study(folder, header, pool, resume, force, quiet), jobs, work)
    return write_results(folder)
