"""Problems about things: coins that are spent, places that are swapped, rooms that are walked to, blocks that are
stacked, and the shipped cargo library. The small libraries are written out here."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np

from llmbt_atl.library import Library, load_library, parse_library
from llmbt_atl.state import Domain
from llmbt_ir.condition import Condition, Facts
from llmbt_runtime.episodes.model import Draft, legal, pick_some
from llmbt_runtime.symbolic import Event

__all__ = ["blocks", "cargo", "coins", "cycles", "rooms", "rooms_library"]

C = Condition

COINS = b"""<library name="coins"><types><type name="coin"/><type name="ware"/></types>
<conditions>
  <condition name="Coin" goal="true"><param name="coin" type="coin"/></condition>
  <condition name="Has" goal="true"><param name="ware" type="ware"/></condition>
  <condition name="Buys"><param name="coin" type="coin"/><param name="ware" type="ware"/></condition>
  <condition name="Trades"><param name="given" type="ware"/><param name="got" type="ware"/></condition>
  <condition name="Pays"><param name="ware" type="ware"/><param name="coin" type="coin"/></condition>
</conditions>
<templates>
  <template name="buy"><param name="coin" type="coin"/><param name="ware" type="ware"/>
    <start><Coin coin="{coin}"/><Buys coin="{coin}" ware="{ware}"/></start>
    <post><Has ware="{ware}"/></post><delete><Coin coin="{coin}"/></delete></template>
  <template name="trade"><param name="given" type="ware"/><param name="got" type="ware"/>
    <unequal first="given" second="got"/>
    <start><Has ware="{given}"/><Trades given="{given}" got="{got}"/></start>
    <post><Has ware="{got}"/></post><delete><Has ware="{given}"/></delete></template>
  <template name="sell"><param name="ware" type="ware"/><param name="coin" type="coin"/>
    <start><Has ware="{ware}"/><Pays ware="{ware}" coin="{coin}"/></start>
    <post><Coin coin="{coin}"/></post><delete><Has ware="{ware}"/></delete></template>
</templates></library>"""

CYCLES = b"""<library name="cycles"><types><type name="object"/><type name="slot"/></types>
<conditions>
  <condition name="At" goal="true"><param name="target" type="object"/><param name="place" type="slot"/></condition>
  <condition name="Free" goal="true"><param name="place" type="slot"/></condition>
  <condition name="Holding" goal="true"><param name="target" type="object"/></condition>
  <condition name="HandEmpty" goal="true"/>
</conditions>
<variables>
  <variable name="hand"><HandEmpty/><Holding target="*"/></variable>
  <variable name="position"><param name="x" type="object"/>
    <At target="{x}" place="*"/><Holding target="{x}"/></variable>
  <variable name="content"><param name="x" type="slot"/><Free place="{x}"/><At target="*" place="{x}"/></variable>
</variables>
<templates>
  <template name="pick"><param name="target" type="object"/><param name="place" type="slot"/>
    <start><HandEmpty/></start><hold><At target="{target}" place="{place}"/></hold>
    <post><Holding target="{target}"/><Free place="{place}"/></post></template>
  <template name="put"><param name="target" type="object"/><param name="place" type="slot"/>
    <hold><Holding target="{target}"/><Free place="{place}"/></hold>
    <post><At target="{target}" place="{place}"/><HandEmpty/></post></template>
</templates></library>"""

ROOMS = b"""<library name="rooms"><types><type name="movable"/><type name="object" parent="movable"/>
<type name="obstacle" parent="movable"/><type name="location"/></types>
<conditions>
  <condition name="Near" goal="true"><param name="location" type="location"/></condition>
  <condition name="On" goal="true"><param name="target" type="movable"/>
    <param name="location" type="location"/></condition>
  <condition name="Holding" goal="true"><param name="target" type="movable"/></condition>
  <condition name="HandEmpty" goal="true"/>
  <condition name="Clear"><param name="target" type="movable"/></condition>
  <condition name="Blocks"><param name="obstacle" type="movable"/><param name="target" type="movable"/></condition>
</conditions>
<variables>
  <variable name="base"><Near location="*"/></variable>
  <variable name="hand"><HandEmpty/><Holding target="*"/></variable>
  <variable name="position"><param name="x" type="movable"/>
    <On target="{x}" location="*"/><Holding target="{x}"/></variable>
  <variable name="approach"><param name="x" type="movable"/>
    <Clear target="{x}"/><Blocks obstacle="*" target="{x}"/></variable>
</variables>
<templates>
  <template name="navigate"><param name="location" type="location"/>
    <post><Near location="{location}"/></post></template>
  <template name="pick"><param name="target" type="movable"/><param name="location" type="location"/>
    <start><HandEmpty/></start>
    <hold><On target="{target}" location="{location}"/><Clear target="{target}"/><Near location="{location}"/></hold>
    <post><Holding target="{target}"/></post></template>
  <template name="place"><param name="target" type="movable"/><param name="location" type="location"/>
    <hold><Holding target="{target}"/><Near location="{location}"/></hold>
    <post><On target="{target}" location="{location}"/><HandEmpty/></post></template>
  <template name="move_away"><param name="obstacle" type="movable"/><param name="target" type="movable"/>
    <param name="location" type="location"/><unequal first="obstacle" second="target"/>
    <start><HandEmpty/><Blocks obstacle="{obstacle}" target="{target}"/></start>
    <hold><On target="{obstacle}" location="{location}"/>
    <Clear target="{obstacle}"/><Near location="{location}"/></hold>
    <post><Clear target="{target}"/><HandEmpty/></post></template>
</templates></library>"""

BLOCKS = b"""<library name="stack"><types><type name="block"/></types>
<conditions>
  <condition name="on" goal="true"><param name="a" type="block"/><param name="b" type="block"/></condition>
  <condition name="table" goal="true"><param name="a" type="block"/></condition>
  <condition name="clear" goal="true"><param name="a" type="block"/></condition>
  <condition name="holding" goal="true"><param name="a" type="block"/></condition>
  <condition name="empty" goal="true"/>
</conditions>
<variables>
  <variable name="hand"><empty/><holding a="*"/></variable>
  <variable name="below"><param name="x" type="block"/><on a="{x}" b="*"/><table a="{x}"/><holding a="{x}"/></variable>
  <variable name="above"><param name="x" type="block"/><clear a="{x}"/><on a="*" b="{x}"/><holding a="{x}"/></variable>
</variables>
<templates>
  <template name="lift"><param name="a" type="block"/>
    <start><empty/><table a="{a}"/><clear a="{a}"/></start><post><holding a="{a}"/></post></template>
  <template name="lower"><param name="a" type="block"/>
    <hold><holding a="{a}"/></hold><post><table a="{a}"/><clear a="{a}"/><empty/></post></template>
  <template name="stack"><param name="a" type="block"/><param name="b" type="block"/><unequal first="a" second="b"/>
    <hold><holding a="{a}"/><clear a="{b}"/></hold><post><on a="{a}" b="{b}"/><clear a="{a}"/><empty/></post></template>
  <template name="unstack"><param name="a" type="block"/><param name="b" type="block"/><unequal first="a" second="b"/>
    <start><empty/><on a="{a}" b="{b}"/><clear a="{a}"/></start>
    <post><holding a="{a}"/><clear a="{b}"/></post></template>
</templates></library>"""


@cache
def _parsed(text: bytes) -> Library:
    return parse_library(text, "episodes")


def rooms_library() -> Library:
    """A small household: what stands where, where the robot is, and what is in the way of what."""
    return _parsed(ROOMS)


# -- coins ---------------------------------------------------------------------------------------------------------


def coins(rng: np.random.Generator) -> Draft:
    """Coins that buy one of several wares each, wares that can be traded or sold: spent wrongly, something is out of
    reach for good."""
    wares = [f"ware{i}" for i in range(int(rng.integers(3, 5)))]
    money = [f"coin{i}" for i in range(int(rng.integers(2, 4)))]
    fixed = {C("Buys", (c, w)) for c in money for w in pick_some(rng, wares, 1, 2)}
    fixed |= {C("Trades", (a, b)) for a in wares for b in wares if a != b and rng.random() < 0.12}
    fixed |= {C("Pays", (w, c)) for w in wares for c in money if rng.random() < 0.06}
    facts = frozenset(fixed | {C("Coin", (c,)) for c in money})
    types = dict.fromkeys(money, "coin") | dict.fromkeys(wares, "ware")
    domain = Domain(_parsed(COINS), types).for_state(facts)
    goals = tuple(C("Has", (w,)) for w in pick_some(rng, wares, 2, len(money)))
    moves = [legal(domain, "find", (~C("Coin", (c,)),), set(), {C("Coin", (c,))}) for c in money]
    moves += [legal(domain, "gift", (~C("Has", (w,)),), set(), {C("Has", (w,))}) for w in wares]
    if rng.random() < 0.5:
        moves += [legal(domain, "theft", (C("Has", (w,)),), {C("Has", (w,))}, set()) for w in wares]
    return Draft(domain, facts, (goals,), _some(rng, moves))


def _some(rng: np.random.Generator, moves: list[Event]) -> tuple[Event, ...]:
    return tuple(moves[i] for i in rng.permutation(len(moves)))


# -- swaps and cycles ----------------------------------------------------------------------------------------------


def cycles(rng: np.random.Generator) -> Draft:
    """Objects on slots that are to change places; with no slot to spare it cannot be done."""
    n = int(rng.integers(2, 4))
    objects = [f"object_{i}" for i in range(1, n + 1)]
    slots = [f"slot_{i}" for i in range(1, n + 1 + int(rng.random() < 0.7))]
    facts = {C("HandEmpty")} | {C("At", (o, s)) for o, s in zip(objects, slots, strict=False)}
    facts |= {C("Free", (s,)) for s in slots[n:]}
    shift = int(rng.integers(1, n))
    goals = [C("At", (o, slots[(i + shift) % n])) for i, o in enumerate(objects)]
    types = dict.fromkeys(objects, "object") | dict.fromkeys(slots, "slot")
    domain = Domain(_parsed(CYCLES), types).for_state(frozenset(facts))
    moves = [
        legal(
            domain,
            "somebody moves",
            (C("At", (o, a)), C("Free", (b,))),
            {C("At", (o, a)), C("Free", (b,))},
            {C("At", (o, b)), C("Free", (a,))},
        )
        for o in objects
        for a in slots
        for b in slots
        if a != b
    ]
    moves += [
        legal(
            domain,
            "drop",
            (C("Holding", (o,)), C("Free", (s,))),
            {C("Holding", (o,)), C("Free", (s,))},
            {C("HandEmpty"), C("At", (o, s))},
        )
        for o in objects
        for s in slots
    ]
    order = [goals[i] for i in rng.permutation(len(goals))]
    return Draft(domain, frozenset(facts), (tuple(order),), _some(rng, moves))


# -- rooms ---------------------------------------------------------------------------------------------------------


def rooms(rng: np.random.Generator) -> Draft:
    """Things in rooms that are to be brought elsewhere, with obstacles before them."""
    places = ["kitchen", "table", "shelf", "user"][: int(rng.integers(3, 5))]
    objects = ["milk", "cup", "book"][: int(rng.integers(1, 3))]
    at = {o: places[int(rng.integers(len(places)))] for o in objects}
    facts = {C("HandEmpty"), C("Near", (places[int(rng.integers(len(places)))],))}
    facts |= {C("On", (o, p)) for o, p in at.items()}
    obstacles = ["box"] if rng.random() < 0.6 else []
    blocked = objects[int(rng.integers(len(objects)))] if obstacles else ""
    facts |= {C("On", (b, at[blocked])) for b in obstacles} | {C("Blocks", (b, blocked)) for b in obstacles}
    facts |= {C("Clear", (t,)) for t in (*objects, *obstacles) if t != blocked}
    types = dict.fromkeys(places, "location") | dict.fromkeys(objects, "object") | dict.fromkeys(obstacles, "obstacle")
    domain = Domain(rooms_library(), types).for_state(frozenset(facts))
    goals = [C("On", (o, [p for p in places if p != at[o]][int(rng.integers(len(places) - 1))])) for o in objects]
    if rng.random() < 0.3:
        goals.append(C("Near", (places[int(rng.integers(len(places)))],)))
    expected: bool | None = True
    if rng.random() < 0.15:
        goals.append(C("Near", (next(p for p in reversed(places)),)))
        goals.append(C("Near", (places[0],)))
        expected = False
    named = [*dict.fromkeys(goals)]
    if len({g.args for g in named if g.name == "Near"}) > 1:
        expected = False
    moves = [
        legal(domain, "somebody moves", (C("On", (o, a)),), {C("On", (o, a))}, {C("On", (o, b))})
        for o in objects
        for a in places
        for b in places
        if a != b
    ]
    moves += [
        legal(
            domain,
            "drop",
            (C("Holding", (o,)), C("Near", (p,))),
            {C("Holding", (o,))},
            {C("HandEmpty"), C("On", (o, p))},
        )
        for o in objects
        for p in places
    ]
    absent = (~C("Holding", ("crate",)), *(~C("On", ("crate", x)) for x in places))
    moves += [
        legal(
            domain,
            "obstacle before",
            (C("Clear", (o,)), C("On", (o, p)), *absent),
            {C("Clear", (o,))},
            {C("Blocks", ("crate", o)), C("On", ("crate", p)), C("Clear", ("crate",))},
        )
        for o in objects
        for p in places
    ]
    order = tuple(named[i] for i in rng.permutation(len(named)))
    return Draft(domain, frozenset(facts), (order,), _some(rng, moves), expected)


# -- blocks --------------------------------------------------------------------------------------------------------


def _towers(rng: np.random.Generator, names: list[str]) -> list[list[str]]:
    towers: list[list[str]] = []
    for i in rng.permutation(len(names)):
        k = int(rng.integers(len(towers) + 1))
        if k == len(towers):
            towers.append([names[i]])
        else:
            towers[k].append(names[i])
    return towers


def _stacked(towers: list[list[str]]) -> list[Condition]:
    return [C("on", (up, low)) for t in towers for low, up in pairwise(t)]


def blocks(rng: np.random.Generator) -> Draft:
    """Towers to other towers, with one hand; somebody else moves blocks, and some fall."""
    names = list("abcde"[: int(rng.integers(3, 6))])
    first = _towers(rng, names)
    facts = {C("empty"), *_stacked(first)}
    facts |= {C("table", (t[0],)) for t in first} | {C("clear", (t[-1],)) for t in first}
    goals: list[Condition] = []
    while not goals or all(g in facts for g in goals):
        last = _towers(rng, names)
        goals = _stacked(last) + [C("table", (t[0],)) for t in last if rng.random() < 0.3]
    expected = True
    if rng.random() < 0.12:
        goals = [C("on", (names[0], names[1])), C("on", (names[1], names[0])), *goals[:1]]
        expected = False
    domain = Domain(_parsed(BLOCKS), dict.fromkeys(names, "block"))
    moves = []
    for a in names:
        moves.append(
            legal(
                domain,
                "drop",
                (C("holding", (a,)),),
                {C("holding", (a,))},
                {C("table", (a,)), C("clear", (a,)), C("empty")},
            )
        )
        for b in names:
            if a == b:
                continue
            moves.append(
                legal(
                    domain,
                    "topple",
                    (C("clear", (a,)), C("on", (a, b))),
                    {C("on", (a, b))},
                    {C("table", (a,)), C("clear", (b,))},
                )
            )
            moves.append(
                legal(
                    domain,
                    "somebody stacks",
                    (C("clear", (a,)), C("table", (a,)), C("clear", (b,))),
                    {C("table", (a,)), C("clear", (b,))},
                    {C("on", (a, b))},
                )
            )
    order = tuple(goals[i] for i in rng.permutation(len(goals)))
    return Draft(domain.for_state(frozenset(facts)), frozenset(facts), (order,), _some(rng, moves), expected)


# -- cargo ---------------------------------------------------------------------------------------------------------


def cargo(rng: np.random.Generator, *, obstacles: bool = False) -> Draft:
    """The shipped cargo library: objects in a sorting area or on wrong slots, to go to slots or levels; somebody moves
    them, they fall; with `obstacles` things stand on slots and in the way, and turn up there."""
    levels, per = int(rng.integers(1, 3)), int(rng.integers(2, 4))
    slots = [f"position_{v}{p}" for v in range(1, levels + 1) for p in range(1, per + 1)]
    types: dict[str, str] = {"workbench": "region", "sorting_area": "buffer", "shelf": "container"}
    parents = {"sorting_area": "workbench"}
    for v in range(1, levels + 1):
        types[f"level_{v}"] = "level"
        parents[f"level_{v}"] = "shelf"
    for s in slots:
        types[s] = "slot"
        parents[s] = f"level_{s[9]}"
    objects = [f"object_{i}" for i in range(1, min(len(slots) - 1, int(rng.integers(2, 5))) + 1)]
    blockers = ["obstacle_1", "obstacle_2"][: int(rng.integers(1, 3))] if obstacles else []
    types |= dict.fromkeys(objects, "object") | dict.fromkeys(blockers, "obstacle")
    domain = Domain(load_library("cargo_sorting"), types, parents)
    free = [slots[i] for i in rng.permutation(len(slots))]
    at = {}
    for thing in (*objects, *blockers):
        share = 0.7 if thing in blockers else 0.35
        at[thing] = free.pop() if len(free) > 1 and rng.random() < share else "sorting_area"
    held = objects[0] if rng.random() < 0.2 else ""
    if held and at[held] != "sorting_area":
        free.append(at[held])
    facts = {C("Holding", (held,)) if held else C("HandEmpty"), C("Free", ("workbench",)), C("Free", ("sorting_area",))}
    facts |= {u for t, p in at.items() if t != held for u in domain.upward(C("On", (t, p)))}
    facts |= {C("Free", (s,)) for s in free}
    expected, hidden = True, set()
    for b in blockers:
        if at[b] == "sorting_area":
            target = objects[int(rng.integers(len(objects)))]
            if target != held and target not in hidden and rng.random() < 0.8:
                facts.add(C("Blocks", (b, target)))
                hidden.add(target)
    facts |= {C("Clear", (t,)) for t in (*objects, *blockers) if t not in hidden}
    order = [slots[i] for i in rng.permutation(len(slots))]
    goals = [C("On", (o, s)) for o, s in zip(objects, order, strict=False)]
    draw = rng.random()
    if draw < 0.15 and len(objects) > 1:
        # more on a level than it has slots, or two things on one slot
        goals = [C("On", (o, order[0])) for o in objects[:2]] + goals[2:]
        expected = False
    elif draw < 0.3 and len(objects) <= per:
        goals = [C("On", (o, "level_1")) for o in objects]
    moves = _cargo_moves(domain, objects, [*slots, "sorting_area", "workbench"], order, obstacles)
    state = frozenset(facts)
    return Draft(domain.for_state(state), state, (tuple(goals),), _some(rng, moves), expected)


def _cargo_moves(
    domain: Domain, objects: list[str], spots: list[str], order: list[str], obstacles: bool
) -> list[Event]:
    moves: list[Event] = []

    def free(p: str) -> set[Condition]:
        return {C("Free", (p,))} if domain.types[p] == "slot" else set()

    for o in objects:
        unblocked = {C("Blocks", (b, o)) for b in ("obstacle_1", "obstacle_2", "obstacle_3")}
        moves.append(
            legal(
                domain, "drop", (C("Holding", (o,)),), {C("Holding", (o,))}, {C("HandEmpty"), C("On", (o, "workbench"))}
            )
        )
        for a in spots:
            for b in spots:
                if a == b or (b == "sorting_area" and a == "workbench") or (a, b) == ("sorting_area", "workbench"):
                    continue
                off = C("On", (o, a))
                elsewhere = tuple(~C("On", (o, "sorting_area")) for _ in range(a == "workbench"))
                moves.append(
                    legal(
                        domain,
                        "somebody moves",
                        (off, *elsewhere, *sorted(free(b))),
                        {off, *free(b), *unblocked},
                        {C("On", (o, b)), *free(a), C("Clear", (o,))},
                    )
                )
    if obstacles:
        new = "obstacle_3"
        gone: Facts = frozenset(C("On", (new, p)) for p in [*spots, "shelf"])
        absent = (*(~f for f in sorted(gone)), ~C("Holding", (new,)))
        known = Domain(domain.library, {**domain.types, new: "obstacle"}, domain.parents)
        moves += [
            legal(
                known,
                "obstacle at",
                (C("Free", (s,)), *absent),
                free(s),
                {C("On", (new, s)), C("Clear", (new,))},
            )
            for s in order[:3]
        ]
        moves += [
            legal(
                known,
                "obstacle before",
                (C("Clear", (o,)), C("On", (o, "sorting_area")), *absent),
                {C("Clear", (o,))},
                {C("Blocks", (new, o)), C("On", (new, "sorting_area")), C("Clear", (new,))},
            )
            for o in objects
        ]
    return moves
