"""The edits of a growing tree: expand a condition, give it a further achiever, take one out, move a subtree.

Each returns a new tree. Ids follow from the condition's own id and the action, so the same growth gives the same ids.
"""

from __future__ import annotations

from dataclasses import replace

from llmbt_atl.state import GroundAction
from llmbt_ir.condition import Condition
from llmbt_ir.tree import Kind, Node, Tree, node_id

__all__ = ["achievers_in", "ancestor_conditions", "branch", "expand", "protected", "remove_achiever"]


def branch(condition_id: str, action: GroundAction, pre: tuple[Condition, ...]) -> tuple[Node, ...]:
    """Fallback(c, Sequence(pre, a)) for a condition that stands in a tree: the new nodes, the Fallback first, the
    Sequence next. The same condition and action give the same ids."""
    text = str(action)
    leaves = tuple(Node(node_id(condition_id, text, str(c)), Kind.CONDITION, condition=c) for c in dict.fromkeys(pre))
    act = Node(node_id(condition_id, text, "!"), Kind.ACTION, action=action.call)
    children = (*leaves, act)
    sequence = Node(node_id(condition_id, text), Kind.SEQUENCE, tuple(n.id for n in children))
    return Node(node_id(condition_id, "?"), Kind.FALLBACK, (condition_id, sequence.id)), sequence, *children


def expand(tree: Tree, condition_id: str, action: GroundAction) -> Tree:
    """c becomes Fallback(c, Sequence(Pre(a), a)) (paper, Expand); a c that is expanded gets the Sequence as a further
    achiever, after those it has."""
    fallback, sequence, *children = branch(condition_id, action, action.pre)
    parent = tree.parents.get(condition_id)
    if parent is not None and tree[parent].kind is Kind.FALLBACK and tree[parent].children[0] == condition_id:
        above = tree[parent]
        return tree.with_nodes(replace(above, children=(*above.children, sequence.id)), sequence, *children)
    return tree.substitute(condition_id, fallback, sequence, *children)


def achievers_in(tree: Tree, condition_id: str) -> tuple[tuple[str, Node], ...]:
    """The achievers that a condition has in the tree: each Sequence's id and its action node."""
    parent = tree.parents.get(condition_id)
    if parent is None or tree[parent].kind is not Kind.FALLBACK or tree[parent].children[0] != condition_id:
        return ()
    found = []
    for branch in tree[parent].children[1:]:
        last = tree[tree[branch].children[-1]] if tree[branch].children else tree[branch]
        if last.action is not None:
            found.append((branch, last))
    return tuple(found)


def remove_achiever(tree: Tree, branch: str) -> Tree:
    """Take an achiever's Sequence out; a Fallback that is left with its condition alone becomes that condition."""
    fallback = tree.parents[branch]
    tree = tree.without(branch)
    above = tree[fallback]
    if len(above.children) > 1:
        return tree
    only = tree[above.children[0]]
    nodes = {k: v for k, v in tree.nodes.items() if k != fallback}
    parent = tree.parents.get(fallback)
    if parent is None:
        return Tree(only.id, nodes)
    grand = tree[parent]
    nodes[parent] = replace(grand, children=tuple(only.id if c == fallback else c for c in grand.children))
    return Tree(tree.root, nodes)


def protected(tree: Tree, condition_id: str) -> tuple[tuple[str, str, Condition], ...]:
    """What an expansion of a condition must not undo: for every ancestor Sequence each sibling i to the left of the
    branch j that leads to the condition, as (i, j, head of i), outermost Sequence first, left to right."""
    found: list[list[tuple[str, str, Condition]]] = []
    child = condition_id
    for ancestor in tree.ancestors(condition_id):
        node = tree[ancestor]
        if node.kind is Kind.SEQUENCE:
            level = []
            for sibling in node.children[: node.children.index(child)]:
                head = tree.head(sibling)
                if head is not None:
                    level.append((sibling, child, head))
            found.append(level)
        child = ancestor
    return tuple(entry for level in reversed(found) for entry in level)


def ancestor_conditions(tree: Tree, condition_id: str) -> tuple[str, ...]:
    """The ids of the heads of a condition's ancestor Fallbacks, nearest first."""
    found = []
    child = condition_id
    for ancestor in tree.ancestors(condition_id):
        node = tree[ancestor]
        if node.kind is Kind.FALLBACK and node.children[0] != child and tree[node.children[0]].condition is not None:
            found.append(node.children[0])
        child = ancestor
    return tuple(found)
