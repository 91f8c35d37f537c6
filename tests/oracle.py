"""The naive models that the product is held against: a recursive tick, and the cargo scene as things on places.

Nothing here uses the templates' ground effects, state variables or containment of `llmbt_atl`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from llmbt_ir.condition import ActionCall, Condition, Facts, holds
from llmbt_ir.tree import Kind, Tree

C = Condition


# -- ticking -------------------------------------------------------------------------------------------------------


def naive_tick(
    tree: Tree, facts: Facts, reports: Mapping[str, str] | None = None
) -> tuple[str, list[str], list[tuple[str, str]]]:
    """The root's status, the running actions, and (id, status) of every ticked node in the order of returning."""
    running: list[str] = []
    trace: list[tuple[str, str]] = []

    def visit(id_: str) -> str:
        node = tree[id_]
        if node.condition is not None:
            status = "SUCCESS" if holds(node.condition, facts) else "FAILURE"
        elif node.action is not None:
            status = (reports or {}).get(id_, "RUNNING")
            if status == "RUNNING":
                running.append(id_)
        else:
            status = go_on = "SUCCESS" if node.kind is Kind.SEQUENCE else "FAILURE"
            for child in node.children:
                status = visit(child)
                if status != go_on:
                    break
        trace.append((id_, status))
        return status

    return visit(tree.root), running, trace


# -- the cargo scene -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Layout:
    """What stands where it may: the slots with their level, the regions with what they lie in, the buffers."""

    slots: tuple[tuple[str, str], ...]
    regions: tuple[tuple[str, str | None], ...] = (("workbench", None), ("sorting_area", "workbench"))
    buffers: tuple[str, ...] = ("sorting_area",)

    def chain(self, place: str) -> tuple[str, ...]:
        """A place and all that it lies in."""
        for slot, level in self.slots:
            if slot == place:
                return (slot, level, "shelf")
        inside = dict(self.regions)
        found = [place]
        while inside.get(found[-1]) is not None:
            found.append(str(inside[found[-1]]))
        return tuple(found)

    @property
    def places(self) -> tuple[str, ...]:
        """Slots, regions, levels and the shelf."""
        return (
            *(s for s, _ in self.slots),
            *(r for r, _ in self.regions),
            *dict.fromkeys(v for _, v in self.slots),
            "shelf",
        )


@dataclass(frozen=True)
class Cargo:
    """One physical state: the most specific place of everything that stands, what is held, what blocks what."""

    layout: Layout
    at: tuple[tuple[str, str], ...]
    held: str | None = None
    blocks: frozenset[tuple[str, str]] = frozenset()

    @property
    def things(self) -> tuple[str, ...]:
        """All movable things."""
        return tuple(sorted([t for t, _ in self.at] + ([self.held] if self.held else [])))

    def facts(self) -> Facts:
        """What the conditions say of this state."""
        found = {C("Holding", (self.held,)) if self.held else C("HandEmpty")}
        found |= {C("On", (t, p)) for t, place in self.at for p in self.layout.chain(place)}
        taken = {p for _, p in self.at}
        found |= {C("Free", (s,)) for s, _ in self.layout.slots if s not in taken}
        found |= {C("Free", (r,)) for r, _ in self.layout.regions}
        found |= {C("Clear", (t,)) for t in self.things if self.clear(t)}
        found |= {C("Blocks", pair) for pair in self.blocks}
        return frozenset(found)

    def clear(self, thing: str) -> bool:
        """Nothing is in the way of it."""
        return all(t != thing for _, t in self.blocks)

    def within(self, thing: str, place: str) -> bool:
        """It stands on a place or on one inside it."""
        spot = dict(self.at).get(thing)
        return spot is not None and place in self.layout.chain(spot)

    def room(self, place: str) -> bool:
        """Something can be put there: a region, or a slot that holds nothing."""
        if place in dict(self.layout.slots):
            return all(p != place for _, p in self.at)
        return place in dict(self.layout.regions)

    def _put(self, thing: str, place: str) -> Cargo:
        at = dict(self.at) | {thing: place}
        return replace(self, at=tuple(sorted(at.items())), held=None if self.held == thing else self.held)

    def after(self, call: ActionCall) -> Cargo | None:
        """The state after an action, None where it cannot be done."""
        a, free = call.args, self.held is None
        if call.name == "pick":
            if free and self.within(a[0], a[1]) and self.clear(a[0]):
                return replace(self, at=tuple(e for e in self.at if e[0] != a[0]), held=a[0])
        elif call.name in ("place", "put_down"):
            fits = call.name == "place" or a[1] in self.layout.buffers
            if self.held == a[0] and self.room(a[1]) and fits:
                return self._put(a[0], a[1])
        elif call.name == "move_aside":
            if free and dict(self.at).get(a[0]) == a[1] and self.clear(a[0]) and a[2] in self.layout.buffers:
                return self._put(a[0], a[2])
        elif call.name == "clear_away":
            thing, target, place, buffer = a
            ok = free and (thing, target) in self.blocks and self.within(thing, place) and self.clear(thing)
            if ok and buffer in self.layout.buffers:
                return replace(self._put(thing, buffer), blocks=self.blocks - {(thing, target)})
        return None

    def calls(self) -> Iterator[ActionCall]:
        """Every action that can be done here, places given as specifically as they can be."""
        for thing, spot in self.at:
            yield ActionCall("pick", (thing, spot))
            for buffer in self.layout.buffers:
                yield ActionCall("move_aside", (thing, spot, buffer))
                for target in self.things:
                    yield ActionCall("clear_away", (thing, target, spot, buffer))
        if self.held:
            for place in self.layout.places:
                yield ActionCall("place", (self.held, place))

    def steps(self) -> Iterator[tuple[ActionCall, Cargo]]:
        """Each possible action with the state after it."""
        for call in self.calls():
            slot = call.name != "move_aside" or call.args[1] in dict(self.layout.slots)
            then = self.after(call) if slot else None
            if then is not None:
                yield call, then


def shortest(start: Cargo, goals: tuple[Condition, ...]) -> int | None:
    """Breadth first over the physical states: the fewest actions to the goals, None where they cannot be reached."""
    seen, queue = {start}, deque([(start, 0)])
    while queue:
        here, far = queue.popleft()
        facts = here.facts()
        if all(holds(g, facts) for g in goals):
            return far
        for _, then in here.steps():
            if then not in seen:
                seen.add(then)
                queue.append((then, far + 1))
    return None


def carry_out(
    tree: Tree, start: Cargo, goals: tuple[Condition, ...], limit: int = 500
) -> tuple[list[ActionCall], Cargo]:
    """Run a tree in the physical model, each action to its end; AssertionError where it does not reach the goals."""
    state, done = start, []
    for _ in range(limit):
        status, running, _ = naive_tick(tree, state.facts())
        if status == "SUCCESS":
            assert all(holds(g, state.facts()) for g in goals), "success, and a goal does not hold"
            return done, state
        assert status == "RUNNING", f"the tree fails after {done}"
        assert len(running) == 1
        call = tree[running[0]].action
        assert call is not None
        then = state.after(call)
        assert then is not None, f"{call} cannot be done after {done}"
        state = then
        done.append(call)
    raise AssertionError(f"no end after {limit} actions")
