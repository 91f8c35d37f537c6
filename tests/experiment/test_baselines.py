"""Scenarios are the same for every method, and the tables say what the lines say."""

from __future__ import annotations

import json
from collections import Counter

import pytest

from llmbt.experiment.adversary import attack
from llmbt.experiment.adversary_table import adversary_tables
from llmbt.experiment.baselines_job import measured
from llmbt.experiment.baselines_study import BaselineOrder, run_baselines, scenarios
from llmbt.experiment.baselines_tables import baseline_tables, time_tables
from llmbt.experiment.cases import load_experiment
from llmbt.experiment.scenario import Scenario, heard, open_world, tell
from llmbt.experiment.workers import Pool
from llmbt_ir.scene import to_semantic_map
from llmbt_runtime.disturbance import NAMES
from llmbt_runtime.initial import facts_of_map
from llmbt_runtime.search import Plan, search

CARGO = load_experiment("cargo_sorting")
CASES = {c.name: c for c in CARGO.cases}
GOALS = ("On(object_1, position_11)", "On(object_2, position_12)", "On(object_3, position_21)")


def scenario(cell: str = "drop", seed: int = 5, **more) -> Scenario:
    return Scenario("symbolic", cell, "sort_by_colour", "01", GOALS, 0, seed, **more)


@pytest.mark.parametrize("cell", ["drop", "obstacle_at_place", "two", "failures"])
def test_a_scenario_s_world_is_the_same_at_every_call(cell):
    one, two = (open_world(scenario(cell), CASES["sort_by_colour"]) for _ in range(2))
    assert vars(one)["_events"] == vars(two)["_events"] != ()
    assert one.truth() == two.truth()


def test_a_line_repeats_but_for_its_times():
    lines = [measured(scenario(), CASES["sort_by_colour"], "loop") for _ in range(2)]
    for line in lines:
        assert line.pop("cpu_s") >= line.pop("planning_s") > 0
    assert lines[0] == lines[1]


class TestAttacks:
    case = CASES["swap_groups"]
    goals = Scenario("symbolic", "one_attack", "swap_groups", "01",
                     ("On(object_1, position_21)", "On(object_3, position_11)"), 0, 0).conditions()  # fmt: skip

    @pytest.mark.parametrize("seed", range(6))
    def test_they_repeat_can_be_told_and_leave_a_way(self, seed):
        events = attack(self.case, self.goals, seed, events=2)
        assert len(events) == 2
        assert events == attack(self.case, self.goals, seed, events=2)
        domain = self.case.domain()
        start = facts_of_map(domain, to_semantic_map(self.case.scene))
        for event in events:
            again = heard(tell(event))
            assert (again.removes, again.adds, set(again.when)) == (event.removes, event.adds, set(event.when))
            assert event.removes or event.adds
            known = domain.for_state(start | event.adds)
            for fact in event.adds | event.removes:
                assert fact.name in domain.library.conditions
                assert all(known.fits(a, p.type) for a, p in zip(
                    fact.args, domain.library.conditions[fact.name].params, strict=True))  # fmt: skip

    def test_after_one_the_goals_can_still_be_reached_by_a_plan(self):
        domain = self.case.domain()
        for seed in range(4):
            (event,) = attack(self.case, self.goals, seed, events=1)
            world = open_world(scenario("one_attack", events=(tell(event),)), self.case)
            while not world.disturbances() and world.time_s < 1:
                world.advance()
            truth = world.truth()
            assert isinstance(search(domain.for_state(truth), truth, self.goals[0], budget=50_000), Plan)


def line(method: str, number: int, good: bool, cell: str = "drop", **more) -> dict:
    return {
        "key": f"{cell}.{number}.{method}", "world": "symbolic", "cell": cell, "case": "c", "number": number,
        "method": method, "verdict": "success" if good else "failure", "actions": 4, "planner_calls": 1, "updates": 2,
        "nodes": 10 + number, "changes": [[0.1, 10], [2.0, 3]], "growth": [[0.1, 10], [2.0, 12]], "sim_time_s": 9.0,
        "disturbances": [["drop", "x", 1.0, 2.5 if good else None]], "planning_s": 0.002, "reason": "why",
        "events": [["a stone falls", "x", [], [], []]],
    } | more  # fmt: skip


class TestTables:
    lines = [line("loop", k, True) for k in range(6)] + [line("script", k, k == 0) for k in range(6)]

    def tables(self) -> dict[str, tuple[tuple[str, ...], ...]]:
        return {t.name: t.rows for t in baseline_tables(self.lines, "symbolic")}

    def test_success(self):
        rows = self.tables()["symbolic_success"]
        assert rows[0] == ("script", "1/6 = 16.7 % (3–56 %)", "1/6")
        assert rows[1] == ("loop", "6/6 = 100.0 % (61–100 %)", "6/6")
        assert rows[2][:2] == ("replanning by a language model", "not run")

    def test_pairs(self):
        assert self.tables()["symbolic_paired"] == (("script", "5 : 0 of 6", "0.062", "0.125", "5 : 0"),)

    def test_costs(self):
        script, ours = self.tables()["symbolic_costs"]
        assert script == ("drop", "script", "1/6", "4.0", "1.0", "–", "–", "–", "–", "5/6")
        assert ours == ("drop", "loop", "6/6", "4.0", "1.0", "2.0", "12", "3", "1.5", "0/6")

    def test_time_stands_apart(self):
        assert time_tables(self.lines, ["symbolic", "bullet"])[0].rows[1] == ("loop", "6", "2.0", "2.0")
        assert not any("ms" in " ".join(t.head) for t in baseline_tables(self.lines, "symbolic"))

    def test_attacks(self):
        lines = [line(m, k, m == "loop" or k, cell="one_attack") for m in ("loop", "script") for k in range(2)]
        success, events = adversary_tables(lines)
        assert [r[1] for r in success.rows] == ["1/2 = 50.0 % (9–91 %)", "2/2 = 100.0 % (34–100 %)"]
        assert events.rows == (("script", "c: a stone falls", "why", "all others"), ("loop", "none found", "", ""))


def test_scenarios_in_physics_are_in_equal_parts_and_paired_over_methods():
    order = BaselineOrder(("bullet",), 16, methods=("loop",))
    found = list(scenarios(CARGO, order))
    assert set(Counter(s.cell for s in found).values()) == {2}
    assert {s.cell for s in found} == set(NAMES) - {"base_blocked"}
    assert len({s.seed for s in found}) == 16
    assert found == list(scenarios(CARGO, order))


def test_what_physics_brings_in_is_declared_in_the_scene():
    order = BaselineOrder(("bullet",), 5 * (len(NAMES) - 1), methods=("loop",))
    scenes = [CASES[s.case].scene for s in scenarios(CARGO, order) if s.cell == "impossible"]
    assert len(scenes) == 5
    assert all(any(not b.movable for b in scene.obstacles) for scene in scenes)


@pytest.mark.slow
def test_from_beginning_to_end_twice_the_same(tmp_path):
    order = BaselineOrder(("symbolic",), 1, 1, 3, ("script", "loop"))
    for name in ("a", "b"):
        run_baselines(CARGO, order, tmp_path / name, Pool(), quiet=True)
    assert (tmp_path / "a/table.json").read_bytes() == (tmp_path / "b/table.json").read_bytes()
    told = json.loads((tmp_path / "a/table.json").read_text())
    assert told["n"] == 2 * told["scenarios"] == 2 * (9 + 2 + 2)
    assert (tmp_path / "a/tables/symbolic_success.tex").read_text().startswith("\\begin{table}")
    assert json.loads((tmp_path / "a/timing.json").read_text())["tables"]
