"""What `make bench` measures does the same in every engine: statuses, and how many conditions the naive ones ask."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bench.engines import GOALS, MADE, SCENARIOS, situation
from tests.bench.loops import in_a_world

RUN = Path(__file__).parents[1] / "tree" / "runs" / "obstacle_at_place"
SHAPES = (("97", None), ("v001", str(RUN)), ("v002", str(RUN)))


def statuses(engine: str, shape: str, scenario: str, run: str | None) -> list[str]:
    subject = MADE[engine](situation(shape, scenario, run))
    return [subject.tick() for _ in range(6)]


@pytest.mark.parametrize("scenario", SCENARIOS)
@pytest.mark.parametrize(("shape", "run"), SHAPES)
@pytest.mark.parametrize(
    "engine", [pytest.param(e, marks=pytest.mark.extras) if e == "py_trees" else e for e in MADE if e != "naive"]
)
def test_every_engine_does_the_same(engine: str, shape: str, run: str | None, scenario: str) -> None:
    if engine == "py_trees":
        pytest.importorskip("py_trees")
    assert statuses(engine, shape, scenario, run) == statuses("naive", shape, scenario, run)
    subjects = [MADE[e](situation(shape, scenario, run)) for e in (engine, "naive")]
    for subject in subjects:
        for _ in range(6):
            subject.tick()
    if engine != "incremental":
        assert subjects[0].evaluations == subjects[1].evaluations


@pytest.mark.parametrize(("shape", "run"), SHAPES)
def test_where_every_node_is_to_be_visited_every_node_is(shape: str, run: str | None) -> None:
    given = situation(shape, "every", run)
    subject = MADE["naive"](given)
    subject.tick()
    assert subject.evaluations == sum(n.condition is not None for n in given.tree.nodes.values())


def test_sizes() -> None:
    assert [len(situation(s, "nothing", None).tree) for s in GOALS] == [int(s) for s in GOALS]


@pytest.mark.parametrize("update", [False, True])
def test_the_executors_own_tick_is_measured_against_a_world(update: bool) -> None:
    """Told of nothing it evaluates nothing; of one fact, the condition that looks at it."""
    for scenario, evaluations in (("nothing", 0), ("one", 1)):
        found = in_a_world(situation("97", scenario, None), None, update=update)
        assert found["evaluations"] == evaluations and found["us"] > 0
