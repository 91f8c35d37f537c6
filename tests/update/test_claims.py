"""What the design claims of the whole loop, over random domains with durations, failures and events.

Checked of each run (`tests/suite/measure.py`): planner calls, reported and counted outside, at most one for the start
and one for each event and failure, times the alternatives; after the last event or failure the actions of the
certificate from there, no more; every version, restarted from the state that it was made for, reaches the goals by its
certificate's actions without a change; no node lost but by a version that says so; SUCCESS by the truth; UNSOLVABLE
where looking at every state says so, and there only; an end, always.
"""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import assume, given, settings
from hypothesis import strategies as st

from llmbt_atl.library import Library
from llmbt_atl.state import Domain
from llmbt_ir.condition import Condition, Facts, Goals
from llmbt_ir.tree import Tree, goal_tree
from llmbt_ir.tree_xml import write_tree
from llmbt_runtime.baselines import Limits
from llmbt_runtime.episodes import Episode
from llmbt_runtime.executor import Change, Settings, execute
from llmbt_runtime.outcome import Outcome
from llmbt_runtime.record import signatures_of
from llmbt_runtime.symbolic import Event
from tests.search.random_problems import Sample, ground_facts, samples
from tests.strips import Op, Strips
from tests.suite.measure import measure, watched

C = Condition
LIMITS = Limits(ticks=3_000, expansions=50_000, attempts=12)
"""Twelve failures in a row exclude an action here: the failures are dice."""
SETTINGS = settings(max_examples=max(100, settings().max_examples))


@dataclass(frozen=True)
class Weather:
    """What a run meets: how long actions last, how often they fail, what happens meanwhile, and the seed of chance."""

    ticks: tuple[int, int]
    failure_rate: float
    events: tuple[Event, ...]
    seed: int


def weather(facts: list[Condition]) -> st.SearchStrategy[Weather]:
    """Up to ten events; each ends and begins a few facts, some only where something holds."""
    few = st.frozensets(st.sampled_from(facts), max_size=2)
    literal = st.builds(lambda c, n: ~c if n else c, st.sampled_from(facts), st.booleans())
    event = st.builds(
        lambda t, r, a, w: Event(t, r - a, a, tuple(w)), st.integers(1, 30), few, few, st.lists(literal, max_size=1)
    )
    return st.builds(
        Weather,
        st.sampled_from([(1, 1), (1, 4), (1, 8), (3, 3)]),
        st.sampled_from([0.0, 0.1, 0.3]),
        st.lists(event, max_size=10).map(tuple),
        st.integers(0, 1_000_000),
    )


FLAGS = [C(f"p{i}") for i in range(7)]


@st.composite
def problems(draw: st.DrawFn) -> Strips:
    """Templates over propositions, with negation; most have dead ends, things that can be spent wrongly, or both."""
    flags = FLAGS[: draw(st.integers(3, len(FLAGS)))]
    subsets = st.frozensets(st.sampled_from(flags), max_size=2)

    def literals(low: int, high: int) -> tuple[Condition, ...]:
        chosen = draw(st.lists(st.sampled_from(flags), min_size=low, max_size=high, unique=True))
        return tuple(~c if draw(st.integers(0, 3)) == 0 else c for c in chosen)

    ops = []
    for i in range(draw(st.integers(1, 8))):
        pre = literals(0, 3)
        cut = draw(st.integers(0, len(pre)))
        adds, deletes = draw(subsets), draw(subsets)
        if draw(st.booleans()):
            deletes |= {c for c in pre[:1] if not c.negated}
        if adds or deletes - adds:
            ops.append(Op(f"do{i}", pre[:cut], pre[cut:], adds, deletes - adds))
    assume(ops)
    goals = dict.fromkeys(literals(1, 3) for _ in range(draw(st.integers(1, 2))))
    return Strips(tuple(ops), draw(st.frozensets(st.sampled_from(flags))), tuple(goals))


def reactive(tree: Tree, library: Library) -> None:
    """No node of a tree file has memory."""
    text = write_tree(tree, signatures_of(library)).decode()
    assert "<Sequence" not in text and "<Fallback" not in text


def holds_what_is_claimed(episode: Episode) -> None:
    row = measure(episode, len(episode.events), "loop", limits=LIMITS)
    assert row.violations == ()
    assert row.outcome in (Outcome.SUCCESS, Outcome.UNSOLVABLE), row.reason


def episode_of(domain: Domain, facts: Facts, goals: Goals, sky: Weather) -> Episode:
    return Episode("drawn", sky.seed, domain, facts, goals, sky.events, sky.ticks, sky.failure_rate, None, False)


@SETTINGS
@given(problems(), weather(FLAGS))
def test_over_propositions(problem: Strips, sky: Weather) -> None:
    holds_what_is_claimed(episode_of(problem.domain, problem.facts, problem.goals, sky))


@SETTINGS
@given(samples(), st.data())
def test_over_things_with_types_variables_and_containment(sample: Sample, data: st.DataObject) -> None:
    sky = data.draw(weather(ground_facts(sample.domain)))
    holds_what_is_claimed(episode_of(sample.domain, sample.facts, (sample.goals,), sky))


@SETTINGS
@given(problems(), weather(FLAGS))
def test_the_verdict_is_that_of_an_independent_search(problem: Strips, sky: Weather) -> None:
    """By the model of `tests/strips.py`, which knows nothing of ours; with three attempts, as it is shipped."""
    world = watched(episode_of(problem.domain, problem.facts, problem.goals, sky))
    trees: list[Tree] = []

    def keep(change: Change) -> str:
        trees.append(change.grown.tree)
        return f"v{len(trees):03d}"

    result = execute(world, problem.domain, goal_tree(problem.goals), problem.goals, keep=keep, settings=Settings())
    there = problem.shortest(world.truth())
    assert result.outcome in (Outcome.SUCCESS, Outcome.UNSOLVABLE, Outcome.ACTION_FAILED)
    assert (result.outcome is Outcome.UNSOLVABLE) == (there is None)
    assert (result.outcome is Outcome.SUCCESS) == (there == 0)
    if result.outcome is Outcome.ACTION_FAILED:
        assert sum(a.result == "FAILURE" for a in result.actions) >= 3
    for tree in trees:
        reactive(tree, problem.domain.library)
