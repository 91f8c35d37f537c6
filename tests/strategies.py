"""Hypothesis strategies that the suites share: trees of any shape, cargo states, goals."""

from __future__ import annotations

from functools import cache

from hypothesis import strategies as st

from llmbt_atl.library import Library, load_library
from llmbt_atl.state import Domain
from llmbt_ir.condition import ActionCall, Condition
from llmbt_ir.signatures import Signatures
from llmbt_ir.tree import Kind, Node, Tree
from tests.oracle import Cargo, Layout

FLAGS = tuple(Condition(f"P{i}") for i in range(6))
SIGNATURES = Signatures(
    {"On": ("target", "place"), "Holding": ("target",), "HandEmpty": (), **{f.name: () for f in FLAGS}},
    {"pick": ("target", "place"), "wave": (), **{f"a{i}": () for i in range(6)}},
)
NAMES = st.sampled_from(
    ["object_1", "position_12", "potato chips", 'a "quoted" <&> name', "x'y", "ünï", "a\tb\nc", "x{y}"]
)


# -- trees ---------------------------------------------------------------------------------------------------------


def conditions(*, plain: bool = False) -> st.SearchStrategy[Condition]:
    """A literal over SIGNATURES; `plain` ones have no arguments."""
    flags = st.builds(lambda f, n: Condition(f.name, (), n), st.sampled_from(FLAGS), st.booleans())
    if plain:
        return flags
    on = st.builds(lambda a, b, n: Condition("On", (a, b), n), NAMES, NAMES, st.booleans())
    return flags | on | st.builds(lambda a: Condition("Holding", (a,)), NAMES) | st.just(Condition("HandEmpty"))


def calls(*, plain: bool = False) -> st.SearchStrategy[ActionCall]:
    """A ground action over SIGNATURES."""
    flags = st.builds(lambda i: ActionCall(f"a{i}"), st.integers(0, 5))
    return flags if plain else flags | st.builds(lambda a, b: ActionCall("pick", (a, b)), NAMES, NAMES)


@st.composite
def trees(draw: st.DrawFn, *, max_leaves: int = 20, plain: bool = False) -> Tree:
    """A reactive tree of any shape; every composite has a child."""
    leaf = conditions(plain=plain) | calls(plain=plain)
    shape = draw(
        st.recursive(
            leaf,
            lambda below: st.tuples(
                st.sampled_from([Kind.SEQUENCE, Kind.FALLBACK]), st.lists(below, min_size=1, max_size=4)
            ),
            max_leaves=max_leaves,
        )
    )
    nodes: dict[str, Node] = {}

    def add(part: object, id_: str) -> str:
        if isinstance(part, Condition):
            nodes[id_] = Node(id_, Kind.CONDITION, condition=part)
        elif isinstance(part, ActionCall):
            nodes[id_] = Node(id_, Kind.ACTION, action=part)
        else:
            kind, below = part  # type: ignore[misc]
            nodes[id_] = Node(id_, kind)
            nodes[id_] = Node(id_, kind, tuple(add(b, f"{id_}.{i}") for i, b in enumerate(below, 1)))
        return id_

    return Tree(add(shape, "n"), nodes)


def deep_tree(levels: int) -> Tree:
    """Sequences and Fallbacks in turn, one in the other, each with a condition before the next."""
    nodes = {}
    for i in range(levels - 1):
        kind = Kind.SEQUENCE if i % 2 == 0 else Kind.FALLBACK
        below = f"d{i + 1}" if i + 2 < levels else "end"
        nodes[f"d{i}"] = Node(f"d{i}", kind, (f"c{i}", below))
        nodes[f"c{i}"] = Node(f"c{i}", Kind.CONDITION, condition=Condition("P0", (), i % 2 == 1))
    nodes["end"] = Node("end", Kind.ACTION, action=ActionCall("wave"))
    return Tree("d0", nodes)


def draw_tree(tree: Tree) -> str:
    """A tree as text, two spaces a level, as a person reads it."""
    lines, stack = [], [(tree.root, 0)]
    while stack:
        id_, level = stack.pop()
        lines.append("  " * level + tree[id_].label())
        stack.extend((c, level + 1) for c in reversed(tree[id_].children))
    return "\n".join(lines) + "\n"


# -- the cargo scene -----------------------------------------------------------------------------------------------


@cache
def cargo_library() -> Library:
    """The shipped library."""
    return load_library("cargo_sorting")


def layout(levels: int, positions: int, *, second_buffer: bool = False) -> Layout:
    """A shelf of some levels with some positions each, a workbench and the sorting area on it."""
    slots = tuple(
        (f"position_{v}{p}", f"shelf_level_{v}") for v in range(1, levels + 1) for p in range(1, positions + 1)
    )
    if second_buffer:
        regions = (("workbench", None), ("sorting_area", "workbench"), ("tray", None))
        return Layout(slots, regions, ("sorting_area", "tray"))
    return Layout(slots)


def domain_for(cargo: Cargo) -> Domain:
    """The library over a physical state's things and places."""
    where = cargo.layout
    types = {"shelf": "container"} | {v: "level" for _, v in where.slots} | {s: "slot" for s, _ in where.slots}
    types |= {r: "buffer" if r in where.buffers else "region" for r, _ in where.regions}
    types |= {t: "obstacle" if t.startswith("obstacle") else "object" for t in cargo.things}
    parents = {v: "shelf" for _, v in where.slots} | dict(where.slots)
    parents |= {r: outer for r, outer in where.regions if outer is not None}
    return Domain(cargo_library(), types, parents).for_state(cargo.facts())


SHELF = layout(3, 4)
CANONICAL = tuple(
    Condition("On", (f"object_{o}", f"position_{p}")) for o, p in ((1, 12), (2, 13), (4, 14), (3, 22), (5, 23), (6, 32))
)


def canonical_cargo(**moved: str) -> Cargo:
    """The paper's case: six objects in the sorting area, and what else is said."""
    at = {f"object_{i}": "sorting_area" for i in range(1, 7)} | moved
    return Cargo(SHELF, tuple(sorted(at.items())))


@st.composite
def cargos(
    draw: st.DrawFn,
    *,
    max_objects: int = 4,
    max_levels: int = 2,
    max_positions: int = 3,
    max_obstacles: int = 2,
) -> Cargo:
    """A physical state: objects and obstacles on slots, regions or in the hand; some in the way of others."""
    where = layout(
        draw(st.integers(1, max_levels)),
        draw(st.integers(1, max_positions)),
        second_buffer=draw(st.booleans()),
    )
    things = [f"object_{i}" for i in range(1, draw(st.integers(1, max_objects)) + 1)]
    things += [f"obstacle_{i}" for i in range(1, draw(st.integers(0, max_obstacles)) + 1)]
    held = draw(st.sampled_from(things) | st.none() | st.none())
    at, free = {}, [s for s, _ in where.slots]
    for thing in things:
        if thing == held:
            continue
        place = draw(st.sampled_from([*free, "sorting_area", "workbench"]))
        at[thing] = place
        if place in free:
            free.remove(place)
    blocked = draw(st.lists(st.sampled_from([t for t in things if t != held] or things), max_size=2, unique=True))
    blocks = set()
    for target in blocked:
        others = [t for t in at if t != target]
        if others:
            blocks.add((draw(st.sampled_from(others)), target))
    return Cargo(where, tuple(sorted(at.items())), held, frozenset(blocks))


@st.composite
def cargo_goals(draw: st.DrawFn, cargo: Cargo, *, max_goals: int = 4, negated: bool = False) -> tuple[Condition, ...]:
    """Goals over a state's things: also swaps, cycles, two on one slot, one on two places."""
    objects = [t for t in cargo.things if t.startswith("object")]
    place = st.sampled_from(cargo.layout.places)
    slot = st.sampled_from([s for s, _ in cargo.layout.slots])
    on = st.builds(lambda o, p: Condition("On", (o, p)), st.sampled_from(objects), slot | slot | place)
    other = st.builds(lambda o: Condition("Holding", (o,)), st.sampled_from(objects)) | st.just(Condition("HandEmpty"))
    other |= st.builds(lambda s: Condition("Free", (s,)), slot)
    literal = on | on | on | other
    if negated:
        literal |= literal.map(lambda c: ~c)
    return tuple(draw(st.lists(literal, min_size=1, max_size=max_goals, unique=True)))


@st.composite
def tasks(draw: st.DrawFn, **limits: int) -> tuple[Cargo, tuple[Condition, ...]]:
    """A state and its goals."""
    cargo = draw(cargos(**limits))
    return cargo, draw(cargo_goals(cargo))
