"""The household in physics, from the goals to the end: with each disturbance, with several, with none."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

from llmbt_runtime.disturbance import SOLVABLE, UNSOLVABLE, DisturbanceSpec, When
from llmbt_runtime.outcome import Outcome


def _load() -> ModuleType:
    spec = importlib.util.spec_from_file_location("household_episodes", Path(__file__).with_name("episodes.py"))
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


episodes = _load()
MILK = episodes.on(("milk", "user"))
TWO = episodes.on(("tea", "user"), ("apple", "desk"))


def test_the_milk() -> None:
    result, log = episodes.play("household", MILK)
    assert result.outcome is Outcome.SUCCESS and result.updates == 1 and log == ()
    assert [a.call.name for a in result.actions] == ["navigate", "pick", "navigate", "place"]
    assert result.sim_time_s < 30


def test_the_milk_behind_an_obstacle() -> None:
    """The paper's figure: (a) the obstacle is moved away, (b) the milk is picked, (c) and brought to the user."""
    result, (log,) = episodes.play("household", MILK, (DisturbanceSpec("obstacle_at_pick"),))
    assert result.outcome is Outcome.SUCCESS
    names = [a.call.name for a in result.actions if a.result == "SUCCESS"]
    assert names == ["navigate", "clear_away", "pick", "navigate", "place"]
    assert [str(f) for f in log.broke] == ["Clear(milk)"] and log.recovered_at_s is not None


@pytest.mark.parametrize("name", [*SOLVABLE, *UNSOLVABLE])
def test_each_disturbance(name: str) -> None:
    result, log = episodes.play("household", TWO, (DisturbanceSpec(name),), seed=2)
    assert [d.name for d in log] == [name] and log[0].broke, f"{result.outcome} {result.reason}"
    assert 0 < log[0].fired_at_s < result.sim_time_s
    if name in SOLVABLE:
        assert result.outcome is Outcome.SUCCESS, result.reason
        assert log[0].recovered_at_s is not None
    else:
        assert result.outcome is Outcome.UNSOLVABLE, result.reason
        assert any(log[0].target in g.args for g in result.unsolvable)


@pytest.mark.slow
@pytest.mark.parametrize("place", ["shelf", "desk", "bar"])
def test_what_takes_the_room_somewhere_fits_elsewhere(place: str) -> None:
    """On the shelf only the parcel takes the room and leaves a way out; on the bar, which is half full, so does nothing
    that would fit anywhere else: nothing comes then."""
    goals = episodes.on(("cookies", place))
    result, log = episodes.play("household", goals, (DisturbanceSpec("obstacle_at_place"),), seed=71)
    assert result.outcome is Outcome.SUCCESS, result.reason
    assert [(d.name, d.target) for d in log] == [("obstacle_at_place", place)] * (place != "bar")
    assert ("move_aside" in [a.call.name for a in result.actions if a.result == "SUCCESS"]) == (place != "bar")


def test_three_at_once_by_their_moments() -> None:
    specs = (
        DisturbanceSpec("base_blocked", when=When(time_s=0.5)),
        DisturbanceSpec("drop", target="tea", when=When(grasp=1, transfer=0.3)),
        DisturbanceSpec("placed_object_moved", when=When(after="place", count=1)),
    )
    result, log = episodes.play("household", TWO, specs)
    assert result.outcome is Outcome.SUCCESS
    assert {d.name for d in log} == {s.name for s in specs}
    assert log[0].name == "base_blocked" and log[0].fired_at_s >= 0.5


@pytest.mark.slow
def test_the_same_seed_gives_the_same_run() -> None:
    runs = [episodes.play("household", TWO, (DisturbanceSpec("drop"),), seed=5) for _ in range(2)]
    assert runs[0] == runs[1]
