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
from llmbt.experiment.scenario import ATTACKS, CELLS, UNSOLVABLE_CELLS, Scenario, applies, right_goals, seed_of, tell
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
        kinds = [c for c in (*CELLS, *UNSOLVABLE_CELLS) if _pick(experiment, rights, c, 0) is not None]
        if world == "bullet":
            kinds = [c for c in kinds if c in NAMES]
            cells = [kinds[i % len(kinds)] for i in range(order.trials)]
        else:
            cells = [c for c in kinds for _ in range(order.trials)] + [c for c in ATTACKS for _ in range(order.attacks)]
        counts = dict.fromkeys(cells, 0)
        for cell in cells:
            number = counts[cell]
            counts[cell] += 1
            found = _pick(experiment, rights, cell, number)
            assert found is not None
            case, request, goals = found
            seed, n = seed_of(order.seed, world, cell, number), ATTACKS.get(cell, 0)
            events = tuple(map(tell, attack(case, (goals,), seed, events=n))) if n else ()
            yield Scenario(world, cell, case.name, request.id, tuple(map(str, goals)), number, seed, events)


def _pick(
    experiment: Experiment, rights: _Rights, cell: str, number: int
) -> tuple[Case, Request, tuple[Condition, ...]] | None:
    firsts = ((c, rights.get(c, 0)) for c in experiment.cases)
    able = [c for c, first in firsts if first is not None and applies(cell, c, first[1])]
    if not able:
        return None
    case = able[number % len(able)]
    found = rights.get(case, number // len(able))
    return None if found is None else (case, *found)


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
