"""PA-BT: Colledanchise, Almeida and Ögren, "Towards blended reactive planning and acting using behavior trees",
ICRA 2019 (arXiv 1611.00230): the first failed condition, breadth first, that was not expanded yet gets all its
achievers; while one of them is in conflict with what is to its left, the new subtree's priority is increased."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field

from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import Facts
from llmbt_ir.tree import Tree
from llmbt_runtime.baselines.shell import Ended
from llmbt_runtime.outcome import Outcome
from llmbt_runtime.tick import NodeStatus, TickRecord
from llmbt_runtime.update.edit import expand, protected

__all__ = ["PaBtPolicy", "breadth_first", "resolve"]


def breadth_first(tree: Tree) -> Iterator[str]:
    """The ids of a tree's conditions, level by level."""
    queue = deque([tree.root])
    while queue:
        node = tree[queue.popleft()]
        if node.condition is not None:
            yield node.id
        queue.extend(node.children)


def resolve(tree: Tree, condition_id: str, actions: tuple[GroundAction, ...], domain: Domain) -> Tree:
    """`while Conflict(T): IncreasePriority(T_new)`: the branch with the new subtree goes before the outermost sibling
    that an achiever would undo, or that cannot hold together with what it needs. Ends: what is to the left shrinks."""
    while True:
        clash = next(
            (
                (i, j)
                for i, j, f in protected(tree, condition_id)
                if any(a.falsifies(f) or any(domain.mutex(c, f) for c in a.pre) for a in actions)
            ),
            None,
        )
        if clash is None:
            return tree
        tree = tree.move_before(clash[1], clash[0])


@dataclass
class PaBtPolicy:
    """PA-BT's main loop. A condition is expanded once; with none left to expand it is at its end."""

    planner_calls: int = 0
    expansions: int = 0
    expanded: set[str] = field(default_factory=set)

    def objects(self, _facts: Facts, _running: GroundAction | None) -> bool:
        """A tree is changed only where it fails."""
        return False

    def revise(self, tree: Tree, domain: Domain, _facts: Facts, record: TickRecord) -> Tree | Ended:
        """Expand the first failed condition that has achievers."""
        failed = {id_ for id_, status in record.trace if status is NodeStatus.FAILURE}
        for id_ in breadth_first(tree):
            condition = tree[id_].condition
            if id_ not in failed or id_ in self.expanded or condition is None:
                continue
            self.expanded.add(id_)
            actions = domain.achievers(condition)
            for action in actions:
                tree = expand(tree, id_, action)
            if actions:
                return resolve(tree, id_, actions, domain)
        return Ended(Outcome.BUDGET, "nothing is left to expand", stuck=True)

    def ended(self, _action: GroundAction, _success: bool) -> None:
        """Nothing is remembered."""
