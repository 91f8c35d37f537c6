"""The paper's BTs Update to the letter (LLM-BT, section IV.D, Algorithm 1), with what the letter brings about.

What the pseudo-code says, line by line, and what follows from it:

- line 4, `GetFailedNode`, is not defined where several conditions failed: here the last one of the tick, expanded or
  not. A condition that fails again after its expansion is not the last: what its achiever needs is.
- line 12, `Gamma <- T_st`, overwrites: the last template that matches is the only achiever, whatever it costs.
- line 15 returns `Pre(a)` after the loop: the preconditions of the LAST TEMPLATE OF THE LIBRARY, matching or not.
- line 14 makes `Fallback(c_f)` where nothing matches: the tree fails as before, at the same node, for ever.
- line 18, `Type`, is not defined: here a condition's name. So On(a, p) and On(b, q) conflict, HandEmpty and
  Holding(a) do not.
- line 17, `HigherPriorityNodes`: every condition that ranks before c_f, also the heads of Fallbacks above and beside it.
- line 22, `Add`, puts T_exp before the first of these that is of a conflicting type, wherever that stands: before the
  head of a Fallback, T_exp becomes the Fallback's first child. c_f stays where it was, a second time.
- line 1, `while R != Success`, has no bound: `Limits` is one.

A template's free parameters (the paper's "L-parameter") are not said to be bound by anything: here those of which most
preconditions hold at present, in the library's order. Sequence and Fallback are reactive, as section III describes.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from llmbt_atl.state import Domain, GroundAction
from llmbt_ir.condition import Condition, Facts, holds
from llmbt_ir.tree import Kind, Node, Tree, node_id
from llmbt_runtime.baselines.shell import Ended
from llmbt_runtime.outcome import Outcome
from llmbt_runtime.tick import TickRecord

__all__ = ["KIND", "LETTER", "Expanded", "PaperPolicy", "Reading", "expand", "failed_node", "insert"]


@dataclass(frozen=True, slots=True)
class Reading:
    """How the pseudo-code is read. `appends`: Gamma collects all achievers; `matching`: Pre(a) is theirs."""

    appends: bool
    matching: bool


LETTER = Reading(appends=False, matching=False)
KIND = Reading(appends=True, matching=True)


@dataclass(frozen=True, slots=True)
class Expanded:
    """T_exp, whose top is its Fallback and whose first child is a copy of c_f, and the types in Pre(a)."""

    subtree: Tree
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
    tree: Tree, failed: str, domain: Domain, facts: Facts, serial: int, reading: Reading = LETTER
) -> Expanded:
    """Lines 7-15."""
    condition = tree[failed].condition
    assert condition is not None
    chain = ("paper", str(serial))
    head = Node(node_id(failed, *chain, "c"), Kind.CONDITION, condition=condition)
    nodes = [head]
    gamma: tuple[str, ...] = ()
    types: set[str] = set()
    for action in achievers(condition, domain, facts):
        why = (*chain, str(action))
        leaves = [Node(node_id(failed, *why, str(c)), Kind.CONDITION, condition=c) for c in dict.fromkeys(action.pre)]
        act = Node(node_id(failed, *why, "!"), Kind.ACTION, action=action.call)
        branch = Node(node_id(failed, *why), Kind.SEQUENCE, (*(n.id for n in leaves), act.id))
        nodes += [branch, *leaves, act]
        gamma = (*gamma, branch.id) if reading.appends else (branch.id,)
        types |= {c.name for c in action.pre}
    if not reading.matching:
        types = {p.name for p in list(domain.library.templates.values())[-1].pre}
    top = Node(node_id(failed, *chain), Kind.FALLBACK, (head.id, *gamma))
    subtree = Tree(top.id, {n.id: n for n in (top, *nodes)})
    kept = {n.id: n for n in subtree.preorder()}
    return Expanded(Tree(top.id, kept), frozenset(types))


def higher(tree: Tree, failed: str) -> tuple[str, ...]:
    """HigherPriorityNodes: the conditions that rank before c_f."""
    found = []
    for node in tree.preorder():
        if node.id == failed:
            break
        if node.condition is not None:
            found.append(node.id)
    return tuple(found)


def insert(tree: Tree, failed: str, expanded: Expanded) -> Tree:
    """Lines 16-23: Replace c_f, or Add before the first condition of a conflicting type."""
    top, *rest = expanded.subtree.preorder()
    for id_ in higher(tree, failed):
        condition = tree[id_].condition
        if condition is not None and condition.name in expanded.types:
            above = tree[tree.parents[id_]]
            at = above.children.index(id_)
            raised = replace(above, children=(*above.children[:at], top.id, *above.children[at:]))
            return tree.with_nodes(raised, top, *rest)
    swapped = tree.substitute(failed, top, *rest)
    return Tree(swapped.root, {n.id: n for n in swapped.preorder()})


@dataclass
class PaperPolicy:
    """Lines 1-6 as a policy: expand and insert whenever the tree fails."""

    reading: Reading = LETTER
    planner_calls: int = 0
    expansions: int = 0
    serial: int = field(default=0)

    def objects(self, facts: Facts, running: GroundAction | None) -> bool:
        """The paper changes a tree only where it fails."""
        return False

    def revise(self, tree: Tree, domain: Domain, facts: Facts, record: TickRecord) -> Tree | Ended:
        """Expand and Insert."""
        failed = failed_node(tree, record)
        if failed is None:
            return Ended(Outcome.BUDGET, "no condition failed", stuck=True)
        self.serial += 1
        return insert(tree, failed, expand(tree, failed, domain, facts, self.serial, self.reading))

    def ended(self, action: GroundAction, success: bool) -> None:
        """Nothing is remembered."""
