"""The settings of the factorial: what is looked at, and where, changes no trial's seed, request or disturbance."""

from __future__ import annotations

import pytest

from llmbt.experiment.cases import load_experiment
from llmbt.experiment.plan import Setting, plan, under
from llmbt.experiment.scenario import Scenario, open_world
from llmbt.experiment.trial import run_trial

CARGO = load_experiment("cargo_sorting")
CASE = next(c for c in CARGO.cases if c.name == "clear_level")
TRIAL = next(t for t in plan(CARGO, seed=0, repeat=1) if t.case == CASE.name and t.request == "02")


@pytest.mark.parametrize("perception", ["truth", "camera"])
@pytest.mark.parametrize("scenes", ["nominal", "varied"])
def test_facts_are_those_of_the_scene_or_those_that_are_recognised(tmp_path, perception, scenes):
    (trial,) = under([TRIAL], [Setting("symbolic", perception, scenes)])
    line = run_trial(trial, CASE, tmp_path)
    assert (line["verdict"], line["seed"], line["drawn"]) == ("success", TRIAL.seed, ["obstacle_at_pick"])
    assert (tmp_path / "seen.json").exists() == (perception == "camera")
    assert line.get("seen_right", True)


@pytest.mark.slow
def test_a_robot_that_sees_does_what_one_does_that_knows_in_a_world_of_its_own_and_in_one_that_is_kept(tmp_path):
    settings = [
        Setting("bullet", p, s) for p, s in (("camera", "nominal"), ("camera", "nominal"), ("camera", "varied"))
    ]
    lines = []
    for number, trial in enumerate(under([TRIAL], settings)):
        folder = tmp_path / str(number)
        folder.mkdir()
        lines.append(run_trial(trial, CASE, folder))
    assert [x["verdict"] for x in lines] == ["success"] * 3
    assert all(x["seen_right"] for x in lines)
    first, again = ({k: v for k, v in x.items() if k != "wall_time_s"} for x in lines[:2])
    assert first == again  # the world that is taken back is as a new one


def test_a_disturbance_of_physics_with_a_target_comes_when_its_target_is_up():
    """Whichever thing it is, also one that is taken first."""
    case = next(c for c in CARGO.cases if c.name == "sort_by_colour")
    goals = tuple(map(str, case.success[0]))
    seen = set()
    for seed in range(6):
        world = open_world(Scenario("bullet", "obstacle_at_pick", case.name, "01", goals, 0, seed), case)
        (waiting,) = world._disturber._waiting
        assert waiting.when.grasp == 1
        seen.add(waiting.draw.target)
        world.close()
    assert len(seen) > 1
