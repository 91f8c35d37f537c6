"""What a tree is told while an action runs."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_runtime.bullet.reporting import Reporter, post_of


def facts(text: str) -> Facts:
    found = set()
    for word in text.split("; "):
        name, _, rest = word.strip().partition("(")
        found.add(Condition(name, tuple(a.strip() for a in rest.rstrip(")").split(",")) if rest else ()))
    return frozenset(found)


def containers(place: str) -> Iterator[str]:
    yield place
    if place == "slot":
        yield "level"


START = facts("HandEmpty; On(o, table); Clear(o); Clear(x); Free(slot); Free(other)")


def test_a_contact_phase_keeps_the_hand_and_the_thing_as_they_were() -> None:
    reporter = Reporter(containers)
    reporter.report(START)
    reporter.begin(ActionCall("pick", ("o", "table")))
    reporter.enter_contact("o", ("table",))
    told = reporter.report(facts("Touching(o); Clear(o); Clear(x); Free(slot)"))
    assert told == START - facts("Free(other)")  # what has nothing to do with the hand is told as it is


def test_the_new_facts_come_all_at_once_when_the_action_ends() -> None:
    reporter = Reporter(containers)
    reporter.report(START)
    reporter.begin(ActionCall("pick", ("o", "table")))
    after = facts("Holding(o); Clear(o); Clear(x); Free(slot); Free(other)")
    reporter.enter_contact("o", ("table",))
    assert reporter.report(after) == START
    reporter.end()
    assert reporter.report(after) == after


def test_what_an_action_brings_about_is_withheld_with_its_containers() -> None:
    reporter = Reporter(containers)
    held = facts("Holding(o); Clear(o); Free(slot)")
    reporter.report(held)
    reporter.begin(ActionCall("place", ("o", "slot")))
    told = reporter.report(facts("HandEmpty; On(o, slot); On(o, level); Clear(o)"))
    assert told == facts("Clear(o)")
    reporter.end()
    assert Condition("On", ("o", "level")) in reporter.report(facts("HandEmpty; On(o, slot); On(o, level)"))


def test_what_held_already_is_not_withheld() -> None:
    reporter = Reporter(containers)
    reporter.report(facts("HandEmpty; Free(table); On(o, table)"))
    reporter.begin(ActionCall("pick", ("o", "table")))
    assert Condition("Free", ("table",)) in reporter.report(facts("HandEmpty; Free(table); On(o, table)"))


def test_a_thing_stays_blocked_until_the_way_is_cleared() -> None:
    reporter = Reporter(containers)
    before = facts("HandEmpty; On(b, table); Clear(b); Blocks(b, o); On(o, table)")
    reporter.report(before)
    reporter.begin(ActionCall("clear_away", ("b", "o", "table", "area")))
    told = reporter.report(facts("Holding(b); Clear(b); Clear(o); On(o, table)"))
    assert Condition("Blocks", ("b", "o")) in told
    assert Condition("Clear", ("o",)) not in told
    reporter.end()
    assert Condition("Clear", ("o",)) in reporter.report(facts("HandEmpty; Clear(o)"))


def test_an_unknown_action_or_arity_is_refused() -> None:
    for action in (ActionCall("fly", ("o",)), ActionCall("pick", ("o",))):
        with pytest.raises(ValueError, match="no such action"):
            post_of(action)
