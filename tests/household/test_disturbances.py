"""The disturbances in the world of facts: by name, by a schedule, several at once; those that end a run."""

from __future__ import annotations

import pytest

from llmbt_atl.library import load_library
from llmbt_atl.state import Domain, domain_of
from llmbt_ir.condition import Condition, Facts
from llmbt_ir.diagnostics import LlmbtError
from llmbt_ir.scene import load_scene, to_semantic_map
from llmbt_ir.tree import goal_tree
from llmbt_runtime.chance import chance
from llmbt_runtime.disturbance import NAMES, SOLVABLE, UNSOLVABLE, DisturbanceSpec, When, applicable, draw
from llmbt_runtime.executor import execute
from llmbt_runtime.initial import facts_of_map
from llmbt_runtime.outcome import Outcome, Result
from llmbt_runtime.schedule import parse_schedule
from llmbt_runtime.symbolic import SymbolicWorld
from llmbt_runtime.symbolic_disturbance import symbolic_events
from llmbt_runtime.world import Disturbed

Goals = tuple[Condition, ...]
C = Condition
BROUGHT: Goals = (C("On", ("milk", "user")), C("On", ("apple", "user")), C("On", ("tea", "table")))
SORTED: Goals = tuple(C("On", (f"object_{o}", f"position_{p}")) for o, p in ((1, 12), (3, 22), (6, 32)))
TASKS = {"household": BROUGHT, "cargo_sorting": SORTED}


def start_of(scene: str) -> tuple[Domain, Facts]:
    found = to_semantic_map(load_scene(scene))
    domain = domain_of(load_library(load_scene(scene).library), found)
    return domain, facts_of_map(domain, found)


def run(scene: str, specs: tuple[DisturbanceSpec, ...], seed: int, goals: Goals = ()) -> tuple[Result, list[Disturbed]]:
    domain, facts = start_of(scene)
    goals = goals or TASKS[scene]
    rng = chance(seed, "world")
    world = SymbolicWorld(domain, facts, rng, events=symbolic_events(specs, domain, facts, goals, rng))
    result = execute(world, domain, goal_tree((goals,)), (goals,), keep=lambda _: "v")
    return result, list(world.disturbances())


@pytest.mark.parametrize("scene", TASKS)
@pytest.mark.parametrize("name", NAMES)
def test_each_by_itself(scene: str, name: str) -> None:
    domain, facts = start_of(scene)
    if name not in applicable(domain, facts, TASKS[scene]):
        assert (scene, name) == ("cargo_sorting", "base_blocked")
        return
    for seed in range(8):
        result, log = run(scene, (DisturbanceSpec(name),), seed)
        assert [d.name for d in log] == [name] and log[0].broke, f"seed {seed}"
        assert 0 < log[0].fired_at_s < result.sim_time_s
        assert result.outcome is (Outcome.SUCCESS if name in SOLVABLE else Outcome.UNSOLVABLE), f"seed {seed}"
        if name in UNSOLVABLE:
            assert any(log[0].target in g.args for g in result.unsolvable), result.reason


@pytest.mark.parametrize("scene", TASKS)
def test_any_three_of_those_that_can_be_dealt_with(scene: str) -> None:
    domain, facts = start_of(scene)
    able = applicable(domain, facts, TASKS[scene])
    for seed in range(30):
        names = draw("random:3", chance(seed, "disturb"), able)
        result, log = run(scene, tuple(map(DisturbanceSpec, names)), seed)
        assert result.outcome is Outcome.SUCCESS, f"seed {seed}: {names}"
        assert len(log) >= 2, f"seed {seed}: {names}"


def test_one_errand_can_be_disturbed_from_its_start() -> None:
    """A robot that drives is under way before its first grasp."""
    domain, facts = start_of("household")
    able = applicable(domain, facts, BROUGHT[:1])
    assert set(SOLVABLE) - set(able) == {"placed_object_moved"}
    for name in able:
        result, log = run("household", (DisturbanceSpec(name),), 3, BROUGHT[:1])
        assert len(log) == 1 and (result.outcome is Outcome.SUCCESS) == (name in SOLVABLE), name


def test_by_the_phase_of_the_task() -> None:
    after_two = DisturbanceSpec("drop", when=When(grasp=2, transfer=0.5))
    for seed in range(5):
        result, log = run("cargo_sorting", (after_two,), seed)
        grasps = [a for a in result.actions if a.call.name == "pick" and a.ended_s <= log[0].fired_at_s]
        carrying = next(a for a in result.actions if a.started_s < log[0].fired_at_s <= a.ended_s)
        assert len(grasps) >= 2
        assert log[0].fired_at_s >= carrying.started_s + 0.5 * (carrying.ended_s - carrying.started_s) - 0.1


def test_by_time_and_after_an_action() -> None:
    late = DisturbanceSpec("object_moved", target="object_6", when=When(time_s=2.0))
    assert run("cargo_sorting", (late,), 1)[1][0].fired_at_s >= 2.0
    placed = DisturbanceSpec("object_taken", target="apple", when=When(after="place", count=1))
    result, log = run("household", (placed,), 0)
    first = next(a for a in result.actions if a.call.name == "place")
    assert log[0].target == "apple" and log[0].fired_at_s >= first.ended_s


SCHEDULE = b"""<Disturbances>
  <Disturbance name="drop" target="milk" grasp="1" transfer="0.4"/>
  <Disturbance name="base_blocked" time_s="1.5"/>
  <Disturbance name="obstacle_at_pick" target="apple" after="place"/>
</Disturbances>"""


def test_a_schedule_in_a_file() -> None:
    specs = parse_schedule(SCHEDULE)
    assert specs[0] == DisturbanceSpec("drop", "milk", When(grasp=1, transfer=0.4))
    assert [s.name for s in specs] == ["drop", "base_blocked", "obstacle_at_pick"]
    result, log = run("household", specs, 0)
    assert result.outcome is Outcome.SUCCESS and {d.name for d in log} == {s.name for s in specs}
    assert {d.target for d in log if d.name != "base_blocked"} == {"milk", "apple"}


@pytest.mark.parametrize(
    ("code", "line", "text"),
    [
        ("E061", 1, b'<Disturbances><Disturbance name="dorp"/></Disturbances>'),
        ("E066", 2, b'<Disturbances>\n<Disturbance name="drop" target="mikl"/></Disturbances>'),
        ("E066", 1, b'<Disturbances><Disturbance name="drop" after="dance"/></Disturbances>'),
        ("E006", 1, b'<Disturbances><Disturbance target="milk"/></Disturbances>'),
        ("E006", 1, b'<Disturbances><Disturbance name="drop" transfer="2"/></Disturbances>'),
    ],
)
def test_a_schedule_that_cannot_be(code: str, line: int, text: bytes) -> None:
    with pytest.raises(LlmbtError) as caught:
        parse_schedule(text, "d.xml", {"milk"}, {"pick", "place"})
    (fault,) = caught.value.diagnostics
    assert fault.code == code and fault.span is not None and fault.span.line == line
