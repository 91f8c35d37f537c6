"""A sample of the suite: what is claimed of the whole loop holds, and the other methods run within their limits."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from llmbt_runtime.baselines import METHODS
from llmbt_runtime.episodes import EVENTS, KINDS, Episode, episode
from llmbt_runtime.episodes.truth import label
from llmbt_runtime.outcome import Outcome
from tests.suite.measure import LIMITS, measure
from tests.suite.scenes import Scene, scenes

SAMPLE = [
    (kind, events, rough, seed) for kind in KINDS for events in EVENTS for rough in (False, True) for seed in (1, 2)
]


@pytest.mark.parametrize("kind", KINDS)
def test_the_whole_loop_keeps_what_is_claimed(kind: str) -> None:
    for k, events, rough, seed in SAMPLE:
        if k == kind:
            row = measure(episode(kind, seed, events=events, rough=rough), events, "loop")
            assert row.violations == (), (kind, seed, events, rough)
            assert row.outcome in (Outcome.SUCCESS, Outcome.UNSOLVABLE)


@pytest.mark.parametrize("kind", KINDS)
def test_every_method_ends_within_its_limits_and_says_nothing_that_is_not_so(kind: str) -> None:
    problem = episode(kind, 3, events=1)
    for method in METHODS:
        row = measure(problem, 1, method)
        assert not row.wrong
        assert row.method == method and row.updates <= LIMITS.updates
        if method in ("paper", "paper-kind", "pa-bt", "local"):
            assert row.outcome in (Outcome.SUCCESS, Outcome.BUDGET) and row.planner_calls == 0


def test_unsolvable_problems_are_among_them_and_only_the_search_says_so() -> None:
    problem = next(e for s in range(20) if (e := episode("coins", s)).solvable is False)
    said = {m: measure(problem, 0, m) for m in METHODS}
    assert [m for m, row in said.items() if row.right] == ["chain", "loop"]


def told(e: Episode) -> str:
    events = [(v.tick, sorted(v.removes), sorted(v.adds), v.when) for v in e.events]
    return repr((sorted(map(str, e.facts)), e.goals, events, e.solvable, [str(a) for a in e.domain.actions]))


def test_an_episode_is_the_same_in_every_process() -> None:
    code = (
        "import hashlib; from llmbt_runtime.episodes import *; from tests.suite.test_suite import told\n"
        "t = ''.join(told(episode(k, 5, events=3, rough=True)) for k in KINDS)\n"
        "print(hashlib.sha256(t.encode()).hexdigest())"
    )
    said = {
        subprocess.run(
            [sys.executable, "-c", code], env={"PYTHONHASHSEED": h, "PYTHONPATH": "."}, capture_output=True, check=True
        ).stdout
        for h in ("1", "2")
    }
    assert len(said) == 1


@pytest.mark.parametrize("kind", KINDS)
def test_what_the_maker_knows_is_what_looking_at_every_state_shows(kind: str) -> None:
    maker, _ = KINDS[kind]
    for seed in range(25):
        draft = maker(np.random.default_rng([seed, 99]))
        found = label(draft.domain, draft.facts, draft.goals, ())
        if found is not None and draft.expected is not None:
            assert found.solvable is draft.expected, (kind, seed)


def test_the_kinds_are_what_they_say() -> None:
    assert all(episode("strips", s, events=3).solvable for s in range(5))
    assert {episode("dead-ends", s).solvable for s in range(5)} == {True, False}
    assert any(c.negated for s in range(5) for g in episode("negation", s).goals for c in g)
    assert any(c.negated for s in range(5) for a in episode("negation", s).domain.actions for c in a.pre)
    assert all(len(episode("alternatives", s).goals) > 1 for s in range(5))
    for kind in KINDS:
        assert [len(episode(kind, 4, events=n).events) for n in EVENTS] == list(EVENTS)


SCENES = scenes()


@pytest.mark.parametrize("scene", SCENES, ids=[s.name for s in SCENES])
def test_certified_trees_are_about_as_small_as_those_by_hand(scene: Scene) -> None:
    assert scene.works(), "the tree by hand does not reach the goals"
    assert len(scene.grown()) <= 1.5 * len(scene.by_hand)
