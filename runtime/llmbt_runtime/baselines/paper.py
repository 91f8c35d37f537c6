"""The paper's BTs Update to the letter (LLM-BT, section IV.D, Algorithm 1), with what the letter brings about.

What the pseudo-code says, line by line, and what follows from it:

- line 4, `GetFailedNode`, is not defined where several conditions failed: here the last one of the tick, expanded or
  not. A condition that fails again after its expansion is not the last: what its achiever needs is.
- line 12, `Gamma <- T_st`, overwrites: the last template that matches is the only achiever, whatever it costs.
- line 15 returns `Pre(a)` after the loop: the preconditions of the LAST TEMPLATE OF THE LIBRARY, matching or not.
- line 14 makes `Fallback(c_f)` where nothing matches: the tree fails as before, at the same node, for ever.
- line 18, `Type`, is not defined: here a condition's name. So On(a, p) and On(b, q) conflict, HandEmpty
  and Holding(a) do not.
- line 17, `HigherPriorityNodes`: every condition that ranks before c_f, also the heads of Fallbacks above it.
- line 22, `Add`, puts T_exp before the first of these that is of a conflicting type, wherever that stands: before the
  head of a Fallback, T_exp becomes the Fallback's first child. c_f stays where it was, a second time.
- line 1, `while R != Success`, has no bound: `Limits` is one.

A template's free parameters (the paper's "L-parameter") are not said to be bound by anything: here those of which most
preconditions hold at present, in the library's order. Sequence and Fallback are reactive, as section III describes.

`Reading.KIND` is the algorithm as the text around it means it: Gamma collects every match, Pre(a) is that of the
matches, and a conflict is what section IV.D says of one: where a node in C_h returns Success, one in C_a is never
satisfied: C_h are the conditions that succeeded on this tick, and one that excludes a condition of Pre(a) conflicts
with it. That gives the paper's own example; what is left is that c_f stays where it was, that nothing looks for a way
to the end, and that nothing bounds it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import Condition, Facts, holds
from llmbt_ir.tree import Kind, Node, Tree, node_id
from llmbt_runtime.baselines.shell import Ended
from llmbt_runtime.outcome import Outcome
from llmbt_runtime.tick import NodeStatus, TickRecord

__all__ = ["Expanded", "PaperPolicy", "Reading", "expand", "failed_node", "insert"]


class Reading(Enum):
    """How the pseudo-code is read."""

    LETTER = "to the letter"
    KIND = "as the text around it means it"


@dataclass(frozen=True, slots=True)
class Expanded:
    """T_exp, whose top is its Fallback and whose first child is a copy of c_f; Pre(a), and the names in it."""

    subtree: Tree
    pre: tuple[Condition, ...]
    types: frozenset[str]


def failed_node(tree: Tree, record: TickRecord) -> str | None:
    """GetFailedNode: the last condition of the tick that failed."""
    return next((i for i in record.failed_leaves() if tree[i].condition is not None), None)


def achievers(condition: Condition, domain: Domain, facts: Facts) -> tuple[GroundAction, ...]:
    """Of each template, in the library's order, the instance with the condition in its Post that is nearest to
    being possible."""
    found = []
    for name in domain.library.templates:
        matching = [a for a in domain.achievers(condition) if a.call.name == name]
        if matching:
            found.append(min(matching, key=lambda a: sum(not holds(c, facts) for c in a.pre)))
    return tuple(found)


def expand(
    tree: Tree, failed: str, domain: Domain, facts: Facts, serial: int, reading: Reading = Reading.LETTER
) -> Expanded:
    """Lines 7-15."""
    condition = tree[failed].condition
    assert condition is not None
    chain = ("paper", str(serial))
    head = Node(node_id(failed, *chain, "c"), Kind.CONDITION, condition=condition)
    nodes, gamma = [head], list[str]()
    matching = achievers(condition, domain, facts)
    for action in matching if reading is Reading.KIND else matching[-1:]:
        why = (*chain, str(action))
        leaves = [Node(node_id(failed, *why, str(c)), Kind.CONDITION, condition=c) for c in dict.fromkeys(action.pre)]
        act = Node(node_id(failed, *why, "!"), Kind.ACTION, action=action.call)
        branch = Node(node_id(failed, *why), Kind.SEQUENCE, (*(n.id for n in leaves), act.id))
        nodes += [branch, *leaves, act]
        gamma.append(branch.id)
    top = Node(node_id(failed, *chain), Kind.FALLBACK, (head.id, *gamma))
    pre = tuple(dict.fromkeys(c for a in matching for c in a.pre))
    last = list(domain.library.templates.values())[-1]
    return Expanded(Tree(top.id, {n.id: n for n in (top, *nodes)}), pre, frozenset(p.name for p in last.pre))


def higher(tree: Tree, failed: str) -> tuple[str, ...]:
    """HigherPriorityNodes: the conditions that rank before c_f."""
    found = []
    for node in tree.preorder():
        if node.id == failed:
            break
        if node.condition is not None:
            found.append(node.id)
    return tuple(found)


def conflict(
    tree: Tree, failed: str, expanded: Expanded, domain: Domain, record: TickRecord, reading: Reading
) -> str | None:
    """The first condition of C_h that is in C_t."""
    succeeded = {id_ for id_, status in record.trace if status is NodeStatus.SUCCESS}
    for id_ in higher(tree, failed):
        condition = tree[id_].condition
        assert condition is not None
        if reading is Reading.LETTER:
            if condition.name in expanded.types:
                return id_
        elif id_ in succeeded and any(domain.mutex(condition, c) for c in expanded.pre):
            return id_
    return None


def insert(tree: Tree, failed: str, expanded: Expanded, before: str | None) -> Tree:
    """Lines 16-23: Replace c_f, or Add before the first condition that is in conflict."""
    top, *rest = expanded.subtree.preorder()
    if before is not None:
        above = tree[tree.parents[before]]
        at = above.children.index(before)
        raised = replace(above, children=(*above.children[:at], top.id, *above.children[at:]))
        return tree.with_nodes(raised, top, *rest)
    swapped = tree.substitute(failed, top, *rest)
    return Tree(swapped.root, {n.id: n for n in swapped.preorder()})


@dataclass
class PaperPolicy:
    """Lines 1-6 as a policy: expand and insert whenever the tree fails."""

    reading: Reading = Reading.LETTER
    planner_calls: int = 0
    expansions: int = 0
    serial: int = 0

    def objects(self, _facts: Facts, _running: GroundAction | None) -> bool:
        """The paper changes a tree only where it fails."""
        return False

    def revise(self, tree: Tree, domain: Domain, facts: Facts, record: TickRecord) -> Tree | Ended:
        """Expand and Insert."""
        failed = failed_node(tree, record)
        if failed is None:
            return Ended(Outcome.BUDGET, "no condition failed", stuck=True)
        self.serial += 1
        expanded = expand(tree, failed, domain, facts, self.serial, self.reading)
        return insert(tree, failed, expanded, conflict(tree, failed, expanded, domain, record, self.reading))

    def ended(self, _action: GroundAction, _success: bool) -> None:
        """Nothing is remembered."""
