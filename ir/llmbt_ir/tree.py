"""Behaviour trees as frozen values: a flat table of nodes, so that nothing recurses on depth and edits are small.

A node's id comes from the goal and the chain of expansions that made it (`node_id`), and is kept when it moves.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from types import MappingProxyType

from llmbt_ir.condition import ActionCall, Condition, Goals

__all__ = ["Kind", "Node", "Tree", "goal_tree", "goals_of", "node_id"]


class Kind(StrEnum):
    """Node kinds; the value is the element's name in BehaviorTree.CPP's XML (leaves go by their own names)."""

    CONDITION = "Condition"
    ACTION = "Action"
    SEQUENCE = "ReactiveSequence"
    FALLBACK = "ReactiveFallback"


@dataclass(frozen=True, slots=True)
class Node:
    """One node. Exactly one of `condition` and `action` is set on a leaf of that kind, neither on an inner node."""

    id: str
    kind: Kind
    children: tuple[str, ...] = ()
    condition: Condition | None = None
    action: ActionCall | None = None

    def label(self) -> str:
        """What a person reads: the condition, the action, or the paper's symbol."""
        if self.kind is Kind.CONDITION:
            return str(self.condition)
        if self.kind is Kind.ACTION:
            return str(self.action)
        return "->" if self.kind is Kind.SEQUENCE else "?"


def node_id(goal: str, *chain: str) -> str:
    """A stable id: the goal's label and a hash of why the node is there. `goal` alone names the goal's own node."""
    if not chain:
        return goal
    digest = hashlib.blake2s("\0".join((goal, *chain)).encode(), digest_size=6).hexdigest()
    return f"{goal.split('.', maxsplit=1)[0]}.{digest}"


@dataclass(frozen=True)
class Tree:
    """A behaviour tree: the id of its root and its nodes by id. Every node but the root has exactly one parent."""

    root: str
    nodes: Mapping[str, Node] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "nodes", MappingProxyType(dict(self.nodes)))

    def __len__(self) -> int:
        return len(self.nodes)

    def __getitem__(self, id_: str) -> Node:
        return self.nodes[id_]

    def __hash__(self) -> int:
        return hash((self.root, frozenset(self.nodes.items())))

    @cached_property
    def parents(self) -> Mapping[str, str]:
        """The parent of each node but the root."""
        return {child: node.id for node in self.nodes.values() for child in node.children}

    def preorder(self, start: str | None = None) -> Iterator[Node]:
        """The nodes of a subtree, parents before children, left to right."""
        stack = [self.root if start is None else start]
        while stack:
            node = self.nodes[stack.pop()]
            yield node
            stack.extend(reversed(node.children))

    def ancestors(self, id_: str) -> Iterator[str]:
        """The ids above a node, nearest first."""
        here = self.parents.get(id_)
        while here is not None:
            yield here
            here = self.parents.get(here)

    def head(self, id_: str) -> Condition | None:
        """The condition that a child of a Sequence stands for: itself, or the first child of its Fallback."""
        node = self.nodes[id_]
        while node.kind is Kind.FALLBACK and node.children:
            node = self.nodes[node.children[0]]
        return node.condition

    def depth(self) -> int:
        """Levels from the root to the deepest leaf, the root counted."""
        deepest, stack = 0, [(self.root, 1)]
        while stack:
            id_, level = stack.pop()
            deepest = max(deepest, level)
            stack.extend((c, level + 1) for c in self.nodes[id_].children)
        return deepest

    def with_nodes(self, *changed: Node) -> Tree:
        """The tree with some nodes added or exchanged, and unreachable ones dropped."""
        nodes = dict(self.nodes)
        nodes.update((n.id, n) for n in changed)
        return Tree(self.root, nodes)

    def substitute(self, id_: str, new: Node, *added: Node) -> Tree:
        """The tree with `new` where `id_` was; `id_` itself stays in the table, since `new` may hold it as a child."""
        parent = self.parents.get(id_)
        if parent is None:
            return replace(self.with_nodes(new, *added), root=new.id)
        above = self.nodes[parent]
        swapped = replace(above, children=tuple(new.id if c == id_ else c for c in above.children))
        return self.with_nodes(new, *added, swapped)

    def move_before(self, id_: str, sibling: str) -> Tree:
        """The tree with the child `id_` moved to just before `sibling`. Both have the same parent."""
        above = self.nodes[self.parents[id_]]
        rest = [c for c in above.children if c != id_]
        rest.insert(rest.index(sibling), id_)
        return self.with_nodes(replace(above, children=tuple(rest)))

    def without(self, id_: str) -> Tree:
        """The tree with a subtree taken out. The root cannot be."""
        above = self.nodes[self.parents[id_]]
        gone = {n.id for n in self.preorder(id_)}
        nodes = {k: v for k, v in self.nodes.items() if k not in gone}
        nodes[above.id] = replace(above, children=tuple(c for c in above.children if c != id_))
        return Tree(self.root, nodes)

    def has_actions(self) -> bool:
        """Whether anything in it acts: an initial tree holds goals only."""
        return any(n.action is not None for n in self.nodes.values())


def goal_tree(goals: Goals) -> Tree:
    """The paper's initial tree: a Sequence `root` of the goal conditions `g1`, `g2`, ..., each once (section IV.C).

    Several alternatives become a Fallback `root` of such Sequences, `alt1`, `alt2`, .... ValueError where there is no
    goal: an empty Sequence would succeed at once.
    """
    if not goals or not all(goals):
        raise ValueError("a tree needs at least one goal")
    nodes: list[Node] = []
    tops: list[Node] = []
    for k, alternative in enumerate(goals, 1):
        leaves = [
            Node(f"g{len(nodes) + i}", Kind.CONDITION, condition=c) for i, c in enumerate(dict.fromkeys(alternative), 1)
        ]
        nodes += leaves
        top = "root" if len(goals) == 1 else f"alt{k}"
        tops.append(Node(top, Kind.SEQUENCE, tuple(n.id for n in leaves)))
    if len(tops) > 1:
        tops.insert(0, Node("root", Kind.FALLBACK, tuple(t.id for t in tops)))
    return Tree("root", {n.id: n for n in (*tops, *nodes)})


MAX_ALTERNATIVES = 256


def goals_of(tree: Tree) -> Goals:
    """The goals that a tree states: of an initial tree the formula it is (Sequence: and, Fallback: or), of a tree that
    acts the heads of its root's children. Contradictory alternatives are left out where there
    are others; ValueError where there are more
    than `MAX_ALTERNATIVES`, or none."""
    if tree.has_actions():
        root = tree[tree.root]
        children = root.children if root.kind is Kind.SEQUENCE else (tree.root,)
        heads = tuple(h for c in children if (h := tree.head(c)) is not None)
        goals: Goals = (tuple(dict.fromkeys(heads)),) if heads else ()
    else:
        goals = _formula(tree)
    if not goals or not all(goals):
        raise ValueError("the tree states no goals")
    return goals


def _formula(tree: Tree) -> Goals:
    values: dict[str, Goals] = {}
    for node in reversed(tuple(tree.preorder())):
        if node.condition is not None:
            values[node.id] = ((node.condition,),)
        elif node.kind is Kind.FALLBACK:
            values[node.id] = tuple(dict.fromkeys(a for c in node.children for a in values[c]))
        else:
            product: Goals = ((),)
            for child in node.children:
                product = tuple((*left, *right) for left in product for right in values[child])
                if len(product) > MAX_ALTERNATIVES:
                    raise ValueError(f"the goals have more than {MAX_ALTERNATIVES} alternatives")
            values[node.id] = product
    unique = tuple(dict.fromkeys(tuple(dict.fromkeys(alternative)) for alternative in values[tree.root]))
    return tuple(a for a in unique if not any(~c in a for c in a)) or unique[:1]
