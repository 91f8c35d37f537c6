"""The paper's own scenes, each with the smallest tree that a person would write for it.

By hand means: in the same shape (post-condition first, every action behind its Pre), of the same templates, with
nothing that the scene does not need. Each of these trees is rolled out, too: it works.
"""

from __future__ import annotations

from dataclasses import dataclass
from textwrap import dedent, indent

from llmbt_atl.library import load_library
from llmbt_atl.state import Domain, domain_of
from llmbt_ir.condition import ActionCall, Condition, Facts, Goals, parse_condition
from llmbt_ir.scene import load_scene, to_semantic_map
from llmbt_ir.tree import Kind, Node, Tree, goal_tree
from llmbt_runtime.initial import facts_of_map
from llmbt_runtime.update.loop import Grown, update
from llmbt_runtime.update.rollout import Certificate, rollout
from tests.oracle import Cargo
from tests.strategies import CANONICAL, SHELF, canonical_cargo, domain_for

C = Condition


def tree_of(text: str) -> Tree:
    """A tree as a person writes it: two spaces a level, `?` and `->`, `!` before an action."""
    nodes: dict[str, Node] = {}
    stack: list[str] = []
    for number, line in enumerate(dedent(text).strip().splitlines()):
        level, label = (len(line) - len(line.lstrip())) // 2, line.strip()
        id_ = f"h{number}"
        del stack[level:]
        if label in ("?", "->"):
            nodes[id_] = Node(id_, Kind.FALLBACK if label == "?" else Kind.SEQUENCE)
        else:
            literal = parse_condition(label.removeprefix("!"))
            assert literal is not None, label
            if label.startswith("!"):
                nodes[id_] = Node(id_, Kind.ACTION, action=ActionCall(literal.name, literal.args))
            else:
                nodes[id_] = Node(id_, Kind.CONDITION, condition=literal)
        if stack:
            above = nodes[stack[-1]]
            nodes[above.id] = Node(above.id, above.kind, (*above.children, id_))
        stack.append(id_)
    return Tree("h0", nodes)


def together(*parts: str) -> str:
    """Parts under one Sequence."""
    return "->\n" + "".join(indent(dedent(p).strip() + "\n", "  ") for p in parts)


def sorted_from(thing: str, spot: str, goal: str) -> str:
    """Pick a thing and place it."""
    return f"""
    ?
      On({thing}, {goal})
      ->
        ?
          Holding({thing})
          ->
            HandEmpty
            On({thing}, {spot})
            Clear({thing})
            !pick({thing}, {spot})
        Free({goal})
        !place({thing}, {goal})
    """


GOALS = {str(c.args[0]): str(c.args[1]) for c in CANONICAL}
REST = tuple(sorted_from(o, "sorting_area", p) for o, p in GOALS.items() if o != "object_1")
REST_3 = tuple(sorted_from(o, "sorting_area", p) for o, p in GOALS.items() if o != "object_3")

AT_THE_PLACE = """
    ?
      On(object_1, position_12)
      ->
        ?
          Free(position_12)
          ->
            ?
              HandEmpty
              ->
                Holding(object_1)
                Free(sorting_area)
                !put_down(object_1, sorting_area)
            On(obstacle_1, position_12)
            Clear(obstacle_1)
            Free(sorting_area)
            !move_aside(obstacle_1, position_12, sorting_area)
        ?
          Holding(object_1)
          ->
            HandEmpty
            On(object_1, sorting_area)
            Clear(object_1)
            !pick(object_1, sorting_area)
        !place(object_1, position_12)
    """

AT_THE_PICK = """
    ?
      On(object_3, position_22)
      ->
        ?
          Holding(object_3)
          ->
            HandEmpty
            On(object_3, sorting_area)
            ?
              Clear(object_3)
              ->
                HandEmpty
                Blocks(obstacle_1, object_3)
                On(obstacle_1, sorting_area)
                Clear(obstacle_1)
                Free(sorting_area)
                !clear_away(obstacle_1, object_3, sorting_area, sorting_area)
            !pick(object_3, sorting_area)
        Free(position_22)
        !place(object_3, position_22)
    """

DRIVE = """
        ?
          Near({place})
          ->
            Clear({place})
            !navigate({place})
    """
ASIDE = """
        ?
          Clear(milk)
          ->
            HandEmpty
            Blocks(obstacle_1, milk)
            On(obstacle_1, bar)
            Clear(obstacle_1)
            Free(bar)
            {near}
            !clear_away(obstacle_1, milk, bar)
    """
WAY = """
        ?
          Near(bar)
          ->
            HandEmpty
            Blocks(obstacle_3, bar)
            Fallen(obstacle_3)
            Clear(obstacle_3)
            !clear_way(obstacle_3, bar)
    """


def brought(clear: str = "Clear(milk)", near: str = DRIVE.format(place="bar")) -> str:
    """Milk from the bar to the user."""
    lines = ["?", "  On(milk, user)", "  ->", "    ?", "      Holding(milk)", "      ->", "        HandEmpty"]
    lines += ["        On(milk, bar)"]
    for part in (clear, near, "!pick(milk, bar)"):
        lines += indent(dedent(part).strip(), " " * 8).splitlines()
    lines += ["    Free(user)", *indent(dedent(DRIVE.format(place="user")).strip(), " " * 4).splitlines()]
    return "\n".join([*lines, "    !place(milk, user)"])


def aside(near: str) -> str:
    """What is before the milk goes out of the way first."""
    wanted = indent(dedent(near).strip(), " " * 4).strip()
    return dedent(ASIDE).strip().replace("{near}", wanted)


@dataclass(frozen=True)
class Scene:
    """A state, the goals, the tree installed before it came about (None: the goals), and the tree by hand."""

    name: str
    domain: Domain
    facts: Facts
    goals: Goals
    by_hand: Tree
    installed: Tree | None = None

    def grown(self) -> Tree:
        """The tree that the loop certifies."""
        found = update(self.installed or goal_tree(self.goals), self.domain, self.facts, self.goals)
        assert isinstance(found, Grown)
        return found.tree

    def works(self) -> bool:
        """Whether the tree by hand reaches the goals."""
        return isinstance(rollout(self.by_hand, self.domain, self.facts, self.goals), Certificate)


def _cargo(name: str, cargo: Cargo, goals: Goals, by_hand: str, before: Cargo | None = None) -> Scene:
    installed = None
    if before is not None:
        first = update(goal_tree(goals), domain_for(before), before.facts(), goals)
        assert isinstance(first, Grown)
        installed = first.tree
    return Scene(name, domain_for(cargo), cargo.facts(), goals, tree_of(by_hand), installed)


def _household(name: str, by_hand: str, *, before: tuple[str, str] | None = None, later: bool = False) -> Scene:
    """Milk for the user, in the shipped scene; with an obstacle `before` something, there from the start or turning up
    once a tree is installed."""
    semantic_map = to_semantic_map(load_scene("household"))
    domain = domain_of(load_library("household"), semantic_map)
    start = facts_of_map(domain, semantic_map)
    goals = ((C("On", ("milk", "user")),),)
    facts = start
    if before is not None:
        obstacle, what = before
        stands = C("On", (obstacle, "bar")) if what == "milk" else C("Fallen", (obstacle,))
        facts = (start - {C("Clear", (what,))}) | {C("Blocks", before), C("Clear", (obstacle,)), stands}
    installed = None
    if later:
        first = update(goal_tree(goals), domain, start, goals)
        assert isinstance(first, Grown)
        installed = first.tree
    return Scene(f"household: {name}", domain.for_state(facts), facts, goals, tree_of(together(by_hand)), installed)


def scenes() -> tuple[Scene, ...]:
    """All of them; those of the cargo with one goal and with all six."""
    start = canonical_cargo()
    one, three = ((CANONICAL[0],),), (tuple(c for c in CANONICAL if c.args[0] == "object_3"),)
    assert one[0][0].args[0] == "object_1"
    here = sorted_from("object_1", "sorting_area", "position_12")
    lies = "On(object_1, workbench)"
    fell = sorted_from("object_1", "workbench", "position_12").replace(
        f"            {lies}\n", f"            {lies}\n            not On(object_1, sorting_area)\n"
    )
    dropped = canonical_cargo(object_1="workbench")
    at_place = Cargo(SHELF, (*(e for e in start.at if e[0] != "object_1"), ("obstacle_1", "position_12")), "object_1")
    at_pick = Cargo(SHELF, (*start.at, ("obstacle_1", "sorting_area")), None, frozenset({("obstacle_1", "object_3")}))
    every = (CANONICAL,)
    return (
        _cargo("one goal", start, one, together(here)),
        _cargo("one goal, obstacle at the place, object held", at_place, one, together(AT_THE_PLACE), start),
        _cargo("one goal, obstacle at the pick", at_pick, three, together(AT_THE_PICK), start),
        _cargo("one goal, object dropped", dropped, one, together(fell), start),
        _cargo("canonical, six goals", start, every, together(here, *REST)),
        _cargo("canonical, obstacle at the place, object held", at_place, every, together(AT_THE_PLACE, *REST), start),
        _cargo("canonical, obstacle at the pick", at_pick, every, together(AT_THE_PICK, *REST_3), start),
        _cargo("canonical, object dropped", dropped, every, together(fell, *REST), start),
        _household("milk for the user", brought()),
        _household(
            "an obstacle before the milk",
            brought(aside(DRIVE.format(place="bar")), "Near(bar)"),
            before=("obstacle_1", "milk"),
        ),
        _household(
            "an obstacle turns up before the milk",
            brought(aside(DRIVE.format(place="bar")), "Near(bar)"),
            before=("obstacle_1", "milk"),
            later=True,
        ),
        _household("an obstacle on the way to the bar", brought(near=WAY), before=("obstacle_3", "bar"), later=True),
    )
