"""The named planning problems: blocks world with four actions, and pick-and-place on the cargo library."""

from __future__ import annotations

import random
from itertools import pairwise

from llmbt_atl.library import Library, load_library, parse_library
from llmbt_atl.state import Domain
from llmbt_ir.condition import Condition, Facts

Problem = tuple[Domain, Facts, tuple[Condition, ...]]

BLOCKS = b"""<library name="blocks"><types><type name="block"/></types>
<conditions>
  <condition name="on" goal="true"><param name="a" type="block"/><param name="b" type="block"/></condition>
  <condition name="ontable" goal="true"><param name="a" type="block"/></condition>
  <condition name="clear" goal="true"><param name="a" type="block"/></condition>
  <condition name="holding" goal="true"><param name="a" type="block"/></condition>
  <condition name="handempty" goal="true"/>
</conditions>
<variables>
  <variable name="hand"><handempty/><holding a="*"/></variable>
  <variable name="below"><param name="x" type="block"/>
    <on a="{x}" b="*"/><ontable a="{x}"/><holding a="{x}"/></variable>
  <variable name="above"><param name="x" type="block"/>
    <clear a="{x}"/><on a="*" b="{x}"/><holding a="{x}"/></variable>
</variables>
<templates>
  <template name="pickup"><param name="a" type="block"/>
    <start><clear a="{a}"/><ontable a="{a}"/><handempty/></start><post><holding a="{a}"/></post></template>
  <template name="putdown"><param name="a" type="block"/>
    <hold><holding a="{a}"/></hold><post><ontable a="{a}"/><clear a="{a}"/><handempty/></post></template>
  <template name="stack"><param name="a" type="block"/><param name="b" type="block"/><unequal first="a" second="b"/>
    <hold><holding a="{a}"/><clear a="{b}"/></hold>
    <post><on a="{a}" b="{b}"/><clear a="{a}"/><handempty/></post></template>
  <template name="unstack"><param name="a" type="block"/><param name="b" type="block"/><unequal first="a" second="b"/>
    <start><on a="{a}" b="{b}"/><clear a="{a}"/><handempty/></start>
    <post><holding a="{a}"/><clear a="{b}"/></post></template>
</templates></library>"""


def blocks_library() -> Library:
    """Four actions, one hand."""
    return parse_library(BLOCKS, "blocks.xml")


def _towers(n: int, rng: random.Random) -> list[list[str]]:
    order = [f"b{i}" for i in range(n)]
    rng.shuffle(order)
    towers: list[list[str]] = []
    for block in order:
        k = rng.randrange(len(towers) + 1)
        if k == len(towers):
            towers.append([block])
        else:
            towers[k].append(block)
    return towers


def _on(towers: list[list[str]]) -> set[Condition]:
    return {Condition("on", (up, low)) for t in towers for low, up in pairwise(t)}


def blocks(n: int, seed: int) -> Problem:
    """Random towers to random towers."""
    rng = random.Random(seed)
    first, last = _towers(n, rng), _towers(n, rng)
    facts = _on(first) | {Condition("handempty")}
    facts |= {Condition("ontable", (t[0],)) for t in first} | {Condition("clear", (t[-1],)) for t in first}
    return Domain(blocks_library(), {f"b{i}": "block" for i in range(n)}), frozenset(facts), tuple(sorted(_on(last)))


def cargo(n: int, k: int, seed: int = 0) -> Problem:
    """`n` objects, two in three on the workbench and the others in wrong slots, to go to `n` of `k` slots on levels."""
    rng = random.Random(seed)
    types = {"workbench": "region", "sorting_area": "buffer", "shelf": "container"}
    parents = {"sorting_area": "workbench"}
    levels = max(1, k // 4)
    slots = [f"position_{i % levels + 1}_{i // levels + 1}" for i in range(k)]
    for level in range(1, levels + 1):
        types[f"level_{level}"] = "level"
        parents[f"level_{level}"] = "shelf"
    for i, slot in enumerate(slots):
        types[slot] = "slot"
        parents[slot] = f"level_{i % levels + 1}"
    objects = [f"object_{i + 1}" for i in range(n)]
    types |= dict.fromkeys(objects, "object")
    domain = Domain(load_library("cargo_sorting"), types, parents)
    free = rng.sample(slots, len(slots))
    facts = {Condition("HandEmpty"), Condition("Free", ("workbench",)), Condition("Free", ("sorting_area",))}
    for i, thing in enumerate(objects):
        place = "sorting_area" if i % 3 else free.pop()
        facts |= set(domain.upward(Condition("On", (thing, place)))) | {Condition("Clear", (thing,))}
    facts |= {Condition("Free", (slot,)) for slot in free}
    goals = tuple(Condition("On", (o, s)) for o, s in zip(objects, rng.sample(slots, len(objects)), strict=True))
    return domain.for_state(frozenset(facts)), frozenset(facts), goals
