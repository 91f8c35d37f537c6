"""Events made to break a method: what somebody could do at each moment of a run, drawn at random, in twos where one is
not enough. What breaks which method is found by trying all of them on all."""

from __future__ import annotations

from collections.abc import Iterator

from llmbt.experiment.cases import Case
from llmbt_atl.state import Domain, GroundAction, apply
from llmbt_ir.condition import Condition, Facts, Goals, all_hold
from llmbt_ir.scene import to_semantic_map
from llmbt_runtime.baselines.steps import Steps, steps_for
from llmbt_runtime.chance import chance
from llmbt_runtime.episodes.model import legal
from llmbt_runtime.initial import facts_of_map
from llmbt_runtime.search import Plan, search
from llmbt_runtime.symbolic import Event

__all__ = ["attack"]

C = Condition
TRIES = 200


def attack(case: Case, goals: Goals, seed: int, *, events: int) -> tuple[Event, ...]:
    """Events at moments of the undisturbed run, each once, each such that from the state it would leave there the goals
    can still be reached. The same arguments give the same events."""
    domain = case.domain()
    facts = facts_of_map(domain, to_semantic_map(case.scene))
    steps = steps_for(domain, facts, goals, 50_000)
    assert isinstance(steps, Steps)
    rng = chance(seed, "attack")
    moments = list(_moments(steps.actions, facts))
    chosen: list[Event] = []
    for _ in range(TRIES):
        action, state = moments[rng.integers(len(moments))]
        able = [e for e in _deeds(domain, state, f"obstacle_{len(chosen) + 1}") if e.adds | e.removes]
        event = _at(action, state, able[rng.integers(len(able))])
        after = (state - event.removes) | event.adds
        if isinstance(search(domain.for_state(after), after, goals[0], budget=20_000), Plan):
            chosen.append(event)
        if len(chosen) == events:
            break
    return tuple(chosen)


def _moments(actions: tuple[GroundAction, ...], facts: Facts) -> Iterator[tuple[GroundAction, Facts]]:
    """The states between the actions of a run, each with the action before it; the last is left out."""
    for action in actions[:-1]:
        facts = apply(action, facts)
        yield action, facts


def _at(action: GroundAction, state: Facts, event: Event) -> Event:
    """The event at the moment after an action: once what the action brought about holds."""
    new = min(action.adds & state, key=lambda c: (c.name not in ("Holding", "On"), c))
    when = tuple(dict.fromkeys((new, *event.when)))
    return Event(1, event.removes, event.adds, when, f"{event.name} {event.target}, once {new}", event.target)


def _deeds(domain: Domain, state: Facts, obstacle: str) -> Iterator[Event]:
    """What somebody, or bad luck, can do in a state; things that are not there yet are called `obstacle`."""
    at = _places(domain, state)
    slots = [s for s in domain.by_type.get("slot", ()) if C("Free", (s,)) in state]
    regions = [r for r in domain.by_type.get("region", ()) if C("Free", (r,)) in state]
    spots = [*slots, *regions]
    for held in (f.args[0] for f in sorted(state) if f.name == "Holding"):
        for spot in spots:
            what = "falls onto" if spot in regions else "is taken from the hand and put on"
            gone, new = {C("Holding", (held,))}, {C("On", (held, spot)), C("HandEmpty")}
            yield _deed(domain, state, f"{held} {what}", spot, gone | _free(domain, spot), new)
    for thing, place in at.items():
        for spot in spots:
            if spot != place:
                gone = {C("On", (thing, place)), *_free(domain, spot)}
                new = {C("On", (thing, spot)), *_free(domain, place)}
                yield _deed(domain, state, f"somebody moves {thing} to", spot, gone, new)
        for other, there in at.items():
            if thing < other and place != there:
                gone = {C("On", (thing, place)), C("On", (other, there))}
                new = {C("On", (thing, there)), C("On", (other, place))}
                yield _deed(domain, state, f"somebody exchanges {thing} and", other, gone, new)
        if C("Clear", (thing,)) in state and regions:
            new = {C("Blocks", (obstacle, thing)), C("Clear", (obstacle,)), C("On", (obstacle, regions[0]))}
            yield _deed(domain, state, f"{obstacle} turns up before", thing, {C("Clear", (thing,))}, new)
    for slot in slots:
        new = {C("On", (obstacle, slot)), C("Clear", (obstacle,))}
        yield _deed(domain, state, f"{obstacle} turns up on", slot, {C("Free", (slot,))}, new)


def _deed(domain: Domain, state: Facts, name: str, target: str, gone: set[Condition], new: set[Condition]) -> Event:
    """As an event that can happen wherever the facts that it ends hold."""
    when = tuple(sorted(gone))
    assert all_hold(when, state)
    made = legal(domain.for_state(state | frozenset(new)), name, when, gone, new)
    return Event(1, made.removes, made.adds, when, name, target)


def _free(domain: Domain, spot: str) -> set[Condition]:
    return {C("Free", (spot,))} if domain.fits(spot, "slot") else set()


def _places(domain: Domain, state: Facts) -> dict[str, str]:
    """Where each thing is, as exactly as is known."""
    found: dict[str, str] = {}
    for fact in sorted(state):
        if fact.name == "On":
            thing, place = fact.args
            if thing not in found or domain.contains(found[thing], place):
                found[thing] = place
    return found
