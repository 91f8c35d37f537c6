"""Executions in the world of facts: actions that last and fail, disturbances, legal actions of others."""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from llmbt_ir.condition import ActionCall, Condition, Facts, Goals, parse_condition, satisfied
from llmbt_ir.diagnostics import LlmbtError
from llmbt_ir.tree import goal_tree
from llmbt_ir.tree_xml import parse_tree
from llmbt_ir.versions import VersionStore, sha256
from llmbt_runtime.disturbance import SOLVABLE, UNSOLVABLE, DisturbanceSpec, draw
from llmbt_runtime.executor import Settings
from llmbt_runtime.outcome import Outcome
from llmbt_runtime.record import signatures_of
from llmbt_runtime.symbolic import Event
from llmbt_runtime.symbolic_disturbance import symbolic_events
from llmbt_runtime.update.rollout import Certificate, rollout
from llmbt_runtime.world import ActionReport, Status
from tests.executor.episodes import Episode, Watched, others, play, read
from tests.oracle import Cargo
from tests.strategies import CANONICAL, canonical_cargo, cargo_library, domain_for, layout

C = Condition
FINE = (Outcome.SUCCESS,)
NAMES = tuple(n for n in SOLVABLE if n != "base_blocked")
"""Those of a robot that stands still."""


# -- the canonical case --------------------------------------------------------------------------------------


def disturbed(name: str, cargo: Cargo, goal: tuple[Condition, ...], seed: int) -> tuple[Event, ...]:
    domain = domain_for(cargo)
    specs = () if name == "none" else (DisturbanceSpec(name),)
    return symbolic_events(specs, domain, cargo.facts(), goal, np.random.default_rng(seed))


@pytest.mark.parametrize("name", ["none", *NAMES])
def test_the_canonical_execution(name: str, golden: Callable[[str, str], None], tmp_path: Path) -> None:
    """The versions and the result, byte for byte: a change of behaviour shows here."""
    cargo = canonical_cargo()
    done = play(cargo, (CANONICAL,), 0, events=disturbed(name, cargo, CANONICAL, 0), folder=tmp_path)
    assert done.result.outcome is Outcome.SUCCESS
    assert done.disturbances == (name != "none")
    assert done.uncertified == []
    document = json.loads((tmp_path / "result.json").read_bytes())
    del document["wall_time_s"]
    golden(f"{name}/result.json", json.dumps(document, indent=1) + "\n")
    for version in VersionStore(tmp_path).versions():
        golden(f"{name}/{version.path.name}", version.path.read_text())
    golden(f"{name}/events.jsonl", (tmp_path / "events.jsonl").read_text())


@pytest.mark.parametrize("name", NAMES)
def test_every_disturbance_breaks_something_and_is_dealt_with(name: str) -> None:
    for seed in range(5):
        cargo = canonical_cargo()
        done = play(cargo, (CANONICAL,), seed, events=disturbed(name, cargo, CANONICAL, seed))
        assert done.result.outcome is Outcome.SUCCESS
        (hit,) = [h for h in done.story if h.kind == "disturbance"]
        assert "ended" in hit.text
        first_grasp = next(h for h in done.story if h.kind == "started")
        assert first_grasp.time_s < hit.time_s < done.result.sim_time_s


def test_all_disturbances_at_once_leave_a_state_that_can_be() -> None:
    """One obstacle is in one place: what several disturbances bring is no contradiction."""
    cargo = canonical_cargo()
    for seed in range(5):
        domain = domain_for(cargo)
        rng = np.random.default_rng(seed)
        events = symbolic_events(tuple(map(DisturbanceSpec, NAMES)), domain, cargo.facts(), CANONICAL, rng)
        seen: list[Facts] = []

        class Recorded(Watched):
            def advance(self, seen: list[Facts] = seen) -> ActionReport:
                report = super().advance()
                seen.append(self.observe())
                return report

        done = play(cargo, (CANONICAL,), seed, events=events, world_type=Recorded)
        assert done.result.outcome is Outcome.SUCCESS
        assert done.disturbances >= len(NAMES) - 1  # one may take away another's occasion
        for facts in set(seen):
            domain = domain.for_state(facts)
            ours = sorted(f for f in facts if any(a.startswith("obstacle") for a in f.args))
            clash = [(str(a), str(b)) for i, a in enumerate(ours) for b in ours[i + 1 :] if domain.mutex(a, b)]
        assert not clash


# -- many episodes -------------------------------------------------------------------------------------------


def solvable(rng: random.Random) -> tuple[Cargo, Goals]:
    """A random state, and goals that hold in a state that can be reached from it."""
    where = layout(rng.randint(1, 2), rng.randint(2, 3))
    things = [f"object_{i}" for i in range(1, rng.randint(1, 3) + 1)] + ["obstacle_9"] * rng.randint(0, 1)
    spots = [s for s, _ in where.slots]
    rng.shuffle(spots)
    at = {t: spots.pop() if spots and rng.random() < 0.5 else rng.choice(["sorting_area", "workbench"]) for t in things}
    start = Cargo(where, tuple(sorted(at.items())))
    if len(things) > 1 and rng.random() < 0.4:
        start = Cargo(where, start.at, None, frozenset({(things[-1], things[0])}))
    end = start
    for _ in range(rng.randint(2, 12)):
        end = rng.choice([then for _, then in end.steps()])
    pool = [f for f in sorted(end.facts()) if f.name in ("On", "Holding", "HandEmpty", "Free")]
    on = [f for f in pool if f.name == "On"]
    goal = rng.sample(on, min(len(on), rng.randint(0, 3))) + rng.sample(pool, 1)
    return start, (tuple(dict.fromkeys(goal)),)


def episode(seed: int, folder: Path | None = None) -> tuple[Episode, Goals, Cargo]:
    rng = random.Random(seed)
    cargo, goals = solvable(rng)
    domain, chance = domain_for(cargo), np.random.default_rng(seed)
    events = others(domain, cargo.facts(), chance, rng.choice([0, 0, 1, 3, 6]))
    for name in rng.sample(NAMES, rng.randint(0, 2)):
        try:
            events += symbolic_events((DisturbanceSpec(name),), domain, cargo.facts(), goals[0], chance)
        except LlmbtError as fault:
            assert fault.diagnostics[0].code == "E062"
    rate = rng.choice([0.0, 0.0, 0.1, 0.2])
    done = play(cargo, goals, seed, ticks=(1, rng.choice([1, 3, 8])), failure_rate=rate, events=events, folder=folder)
    return done, goals, cargo


def in_order(done: Episode, seed: int) -> None:
    """What the design note claims of every run."""
    result = done.result
    assert done.uncertified == [], f"seed {seed}: {done.uncertified}"
    if result.outcome is Outcome.ACTION_FAILED:
        assert max(Counter(e.call for e in result.actions if e.result == "FAILURE").values()) >= 3, f"seed {seed}"
    else:
        assert result.outcome is Outcome.SUCCESS, f"seed {seed}: {result.outcome} {result.reason}"
        assert all(g[1] for g in result.goals)
    assert done.searches <= 1 + done.disturbances + done.failures, f"seed {seed}"
    assert result.updates == len(done.changes)
    started = [h for h in done.story if h.kind == "started"]
    assert len(started) == len(result.actions)
    if started:
        first = next((h for h in done.story if h.kind == "update"), None)
        assert first is not None and done.story.index(first) < done.story.index(started[0])


@pytest.mark.parametrize("block", range(4))
def test_many_episodes(block: int) -> None:
    for seed in range(block * 50, block * 50 + 50):
        in_order(episode(seed)[0], seed)


@pytest.mark.slow
@pytest.mark.parametrize("block", range(10))
def test_very_many_episodes(block: int) -> None:
    for seed in range(10_000 + block * 300, 10_000 + block * 300 + 300):
        in_order(episode(seed)[0], seed)


def restarted(folder: Path, goals: Goals) -> int:
    """Roll every version out from the state that its record names; how many there were."""
    signatures = signatures_of(cargo_library())
    versions = VersionStore(folder).versions()
    for v in versions:
        file = parse_tree(v.path.read_bytes(), v.path.name, signatures)
        assert file.goals == goals
        state = frozenset(parse_condition(t) for t in v.record["certificate"]["state"])
        cargo = domain_for(canonical_cargo())
        things = {a for f in state for a in f.args}
        domain = cargo.for_state(state)
        found = rollout(file.tree, domain, state, goals)
        assert isinstance(found, Certificate), (v.name, things, found.kind)
        assert [str(a) for a in found.actions] == v.record["certificate"]["actions"]
        assert satisfied(goals, found.states[-1])
    return len(versions)


@pytest.mark.parametrize("name", ["none", *NAMES])
def test_every_version_restarted_from_its_recorded_state_reaches_the_goals(name: str, tmp_path: Path) -> None:
    cargo = canonical_cargo()
    play(cargo, (CANONICAL,), 1, failure_rate=0.1, events=disturbed(name, cargo, CANONICAL, 1), folder=tmp_path)
    assert restarted(tmp_path, (CANONICAL,)) >= (2 if name != "none" else 1)


def test_versions_form_a_chain_of_parents(tmp_path: Path) -> None:
    cargo = canonical_cargo()
    events = disturbed("obstacle_at_place", cargo, CANONICAL, 2)
    play(cargo, (CANONICAL,), 2, events=events, folder=tmp_path)
    versions = VersionStore(tmp_path).versions()
    assert [v.number for v in versions] == list(range(1, len(versions) + 1))
    for before, after in pairwise(versions):
        assert after.record["parent"] == before.path.name
        assert after.record["parent_sha256"] == sha256(before.path.read_bytes())
        assert parse_tree(after.path.read_bytes(), "t").provenance.parent_sha256 == after.record["parent_sha256"]
        assert after.record["cause"] and after.record["steps"]


@pytest.mark.parametrize("seed", range(6))
def test_the_same_seed_gives_the_same_bytes(seed: int, tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        episode(seed * 7 + 1, tmp_path / name)
    assert read(tmp_path / "a") == read(tmp_path / "b")


def test_the_same_seed_gives_the_same_bytes_whatever_the_hash_seed(tmp_path: Path) -> None:
    code = (
        "import sys; from pathlib import Path; from tests.executor.test_episodes import episode\n"
        "for s in range(8):\n p = Path(sys.argv[1]) / str(s); p.mkdir(parents=True); episode(s * 11 + 2, p)"
    )
    root = Path(__file__).parents[2]
    for name in ("1", "2"):
        env = os.environ | {"PYTHONHASHSEED": name, "PYTHONPATH": os.pathsep.join([str(root), *sys.path])}
        subprocess.run([sys.executable, "-c", code, str(tmp_path / name)], check=True, cwd=root, env=env)
    for s in range(8):
        assert read(tmp_path / "1" / str(s)) == read(tmp_path / "2" / str(s))


# -- how it ends ---------------------------------------------------------------------------------------------


def test_goals_that_hold_already_need_no_version_and_no_action() -> None:
    cargo = canonical_cargo(object_1="position_12")
    done = play(cargo, (CANONICAL[:1],), 0)
    assert (done.result.outcome, done.changes, done.result.actions) == (Outcome.SUCCESS, [], ())


@pytest.mark.parametrize(
    "goal",
    [
        (C("On", ("object_1", "position_12")), C("On", ("object_2", "position_12"))),
        (C("On", ("object_1", "position_12")), C("On", ("object_1", "position_13"))),
        (C("Holding", ("object_1",)), C("HandEmpty")),
    ],
)
def test_what_cannot_be_done_is_said_before_anything_moves(goal: tuple[Condition, ...]) -> None:
    done = play(canonical_cargo(), (goal,), 0)
    assert done.result.outcome is Outcome.UNSOLVABLE
    assert set(done.result.unsolvable) == set(goal) and done.result.reason
    assert done.result.actions == () and done.changes == []
    assert done.result.ticks < 50


def test_a_spent_budget_is_no_proof() -> None:
    where = layout(1, 2)
    at = (("object_1", "position_11"), ("object_2", "position_12"))
    goal = (C("On", ("object_1", "position_12")), C("On", ("object_2", "position_11")), C("Holding", ("object_1",)))
    done = play(Cargo(where, at), (goal,), 0, settings=Settings(budget=0))
    assert done.result.outcome in (Outcome.BUDGET, Outcome.UNSOLVABLE)
    assert done.result.expansions == 0


class Stubborn(Watched):
    """A world in which some actions never succeed; `drops` lets what is held fall back to the sorting area."""

    never: frozenset[str] = frozenset()
    drops = False

    def start(self, action: ActionCall) -> None:
        super().start(action)
        self._failing = self._failing or str(action) in self.never or action.name in self.never

    def advance(self) -> ActionReport:
        running = self._running
        report = super().advance()
        if self.drops and running is not None and report.status is Status.FAILURE and running.call.name == "place":
            thing = running.call.args[0]
            on = {C("On", (thing, "sorting_area")), C("On", (thing, "workbench")), C("HandEmpty")}
            self._state.write({C("Holding", (thing,))}, on)
        return report


def test_an_action_that_never_succeeds_is_tried_three_times() -> None:
    class World(Stubborn):
        never = frozenset({"place(object_1, position_12)"})

    done = play(canonical_cargo(), (CANONICAL[:1],), 0, world_type=World)
    assert done.result.outcome is Outcome.ACTION_FAILED
    assert [str(e.call) for e in done.result.actions if e.result == "FAILURE"] == ["place(object_1, position_12)"] * 3
    assert "place(object_1, position_12)" in done.result.reason


def test_what_fails_three_times_is_done_another_way_where_there_is_one() -> None:
    class World(Stubborn):
        never = frozenset({"place(object_1, position_11)"})

    done = play(
        Cargo(layout(1, 2), (("object_1", "sorting_area"),)),
        ((C("On", ("object_1", "shelf_level_1")),),),
        0,
        world_type=World,
    )
    assert done.result.outcome is Outcome.SUCCESS
    assert str(done.result.actions[-1].call) == "place(object_1, position_12)"


def test_an_action_that_fails_and_disturbs_what_came_before_it_does_not_go_on_for_ever() -> None:
    """Every place slips and drops the thing: after some attempts that is said, long before the guard on ticks."""

    class World(Stubborn):
        never = frozenset({"place"})
        drops = True

    done = play(canonical_cargo(), (CANONICAL[:1],), 0, world_type=World, settings=Settings(max_ticks=3_000))
    assert done.result.outcome is Outcome.ACTION_FAILED
    assert done.failures <= 12


def test_places_that_all_slip_sometimes_with_a_drop_do_not_go_on_for_ever() -> None:
    class World(Stubborn):
        never = frozenset({"place"})
        count = 0

        @property
        def drops(self) -> bool:  # type: ignore[override]
            self.count += 1
            return self.count % 5 < 2

    goal = (C("On", ("object_1", "shelf_level_1")),)
    cargo = Cargo(layout(1, 3), (("object_1", "sorting_area"),))
    done = play(cargo, (goal,), 0, world_type=World, settings=Settings(max_ticks=5_000))
    assert done.result.outcome is Outcome.ACTION_FAILED
    assert done.failures <= 40


def test_an_interrupted_run_says_so_and_halts() -> None:
    class World(Watched):
        count = 0

        def advance(self) -> ActionReport:
            self.count += 1
            if self.count == 4:
                raise KeyboardInterrupt
            return super().advance()

    done = play(canonical_cargo(), (CANONICAL,), 0, ticks=(8, 8), world_type=World)
    assert done.result.outcome is Outcome.INTERRUPTED
    assert done.result.actions[-1].result == "HALTED"


def test_a_disturbance_that_does_not_touch_the_running_action_does_not_halt_it() -> None:
    """Something falls onto a place that is needed later, while object_1 is on its way to another."""
    cargo = canonical_cargo()
    free = C("Free", ("position_32",))
    adds = frozenset({C("On", ("obstacle_1", p)) for p in ("position_32", "shelf_level_3", "shelf")})
    event = Event(
        1, frozenset({free}), adds | {C("Clear", ("obstacle_1",))}, (C("Holding", ("object_1",)),), "fall", "x"
    )
    done = play(cargo, (CANONICAL,), 0, ticks=(6, 6), events=(event,))
    assert done.result.outcome is Outcome.SUCCESS
    assert [e.result for e in done.result.actions] == ["SUCCESS"] * len(done.result.actions)


def test_a_higher_branch_halts_first_and_starts_then() -> None:
    """A placed object is moved while a later one is on its way: what is undone comes first again."""
    cargo = canonical_cargo()
    gone = frozenset(domain_for(cargo).upward(CANONICAL[0]))
    adds = frozenset(
        {C("On", ("object_1", "sorting_area")), C("On", ("object_1", "workbench")), C("Free", ("position_12",))}
    )
    when = (CANONICAL[0], C("Holding", ("object_4",)))
    done = play(cargo, (CANONICAL,), 0, ticks=(6, 6), events=(Event(1, gone, adds, when, "moved", "object_1"),))
    assert done.result.outcome is Outcome.SUCCESS
    results = [(e.call.name, e.call.args[0], e.result) for e in done.result.actions]
    halted = next(i for i, r in enumerate(results) if r[2] == "HALTED")
    assert results[halted][1] == "object_4"
    assert all(a.ended_s <= b.started_s for a, b in pairwise(done.result.actions))


# -- disturbances by name ------------------------------------------------------------------------------------


def test_disturbances_are_drawn_by_name() -> None:
    rng = np.random.default_rng(0)
    assert draw("none", rng) == ()
    assert draw("drop,obstacle_at_pick", rng) == ("drop", "obstacle_at_pick")
    assert set(draw("random:7", rng)) == set(SOLVABLE)
    assert not set(draw("random:50", rng)) & set(UNSOLVABLE) and draw("impossible", rng) == ("impossible",)
    assert len(draw("random:9", rng)) == 9 and "none" not in draw("random:50", rng)
    assert draw("random", np.random.default_rng(3)) == draw("random", np.random.default_rng(3))


@pytest.mark.parametrize("name", ["dorp", "drop:2", "", "random:x"])
def test_an_unknown_disturbance_is_a_diagnostic(name: str) -> None:
    with pytest.raises(LlmbtError) as caught:
        draw(name, np.random.default_rng(0))
    assert caught.value.diagnostics[0].code == "E061"


def test_a_disturbance_that_does_not_apply_is_a_diagnostic() -> None:
    cargo = canonical_cargo()
    for name in ("placed_object_moved", "obstacle_at_pick"):
        with pytest.raises(LlmbtError) as caught:
            disturbed(name, cargo, CANONICAL[:1], 0)
        assert caught.value.diagnostics[0].code == "E062"


def test_the_initial_tree_is_not_changed_by_an_execution() -> None:
    tree = goal_tree((CANONICAL,))
    play(canonical_cargo(), (CANONICAL,), 0)
    assert tree == goal_tree((CANONICAL,))
