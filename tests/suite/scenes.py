"""The paper's own scenes, each with the smallest tree that a person would write for it.

By hand means: in the same shape (post-condition first, every action behind its Pre), of the same templates, with
nothing that the scene does not need. Each of these trees is rolled out, too: it works.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

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
HERE = Path(__file__).with_name("minimal")


def tree_of(text: str) -> Tree:
    """A tree as a person writes it: two spaces a level, `?` and `->`, `!` before an action, `#` before a remark."""
    nodes: dict[str, Node] = {}
    stack: list[str] = []
    for number, line in enumerate(line for line in text.splitlines() if not line.startswith("#")):
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


def minimal(name: str) -> Tree:
    """The tree that is written out in `minimal/<name>.txt`."""
    return tree_of((HERE / f"{name}.txt").read_text(encoding="utf-8"))


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
    return Scene(name, domain_for(cargo), cargo.facts(), goals, minimal(by_hand), installed)


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
    return Scene(f"household: {name}", domain.for_state(facts), facts, goals, minimal(by_hand), installed)


def scenes() -> tuple[Scene, ...]:
    """All of them; those of the cargo with one goal and with all six."""
    start = canonical_cargo()
    one, three = ((CANONICAL[0],),), (tuple(c for c in CANONICAL if c.args[0] == "object_3"),)
    assert one[0][0].args[0] == "object_1"
    dropped = canonical_cargo(object_1="workbench")
    at_place = Cargo(SHELF, (*(e for e in start.at if e[0] != "object_1"), ("obstacle_1", "position_12")), "object_1")
    at_pick = Cargo(SHELF, (*start.at, ("obstacle_1", "sorting_area")), None, frozenset({("obstacle_1", "object_3")}))
    every = (CANONICAL,)
    return (
        _cargo("one goal", start, one, "cargo_one_goal"),
        _cargo(
            "one goal, obstacle at the place, object held", at_place, one, "cargo_one_goal_obstacle_at_the_place", start
        ),
        _cargo("one goal, obstacle at the pick", at_pick, three, "cargo_one_goal_obstacle_at_the_pick", start),
        _cargo("one goal, object dropped", dropped, one, "cargo_one_goal_dropped", start),
        _cargo("canonical, six goals", start, every, "cargo_canonical"),
        _cargo(
            "canonical, obstacle at the place, object held",
            at_place,
            every,
            "cargo_canonical_obstacle_at_the_place",
            start,
        ),
        _cargo("canonical, obstacle at the pick", at_pick, every, "cargo_canonical_obstacle_at_the_pick", start),
        _cargo("canonical, object dropped", dropped, every, "cargo_canonical_dropped", start),
        _household("milk for the user", "household_milk"),
        _household("an obstacle before the milk", "household_obstacle_before_the_milk", before=("obstacle_1", "milk")),
        _household(
            "an obstacle turns up before the milk",
            "household_obstacle_before_the_milk",
            before=("obstacle_1", "milk"),
            later=True,
        ),
        _household(
            "an obstacle on the way to the bar",
            "household_obstacle_on_the_way",
            before=("obstacle_3", "bar"),
            later=True,
        ),
    )
