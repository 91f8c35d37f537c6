"""Trees compared by meaning: what was added, removed, moved and changed under stable ids, as a value.

`apply(diff(a, b), a) == b`. Layout, attribute order and the place of a <SubTree> split are no part of a tree. The
same works on any table of nodes, which is how files of other engines are compared (`llmbt_ir.btcpp.match`).
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Generic, TypeVar

from llmbt_ir.tree import Node, Tree

__all__ = ["Added", "Change", "Changed", "Diff", "Entry", "Moved", "Removed", "Spot", "Table"]
__all__ += ["apply", "apply_table", "diff", "diff_tables", "table_of"]

C = TypeVar("C")


@dataclass(frozen=True, slots=True)
class Entry(Generic[C]):
    """A node of a table: what it is, and the ids of its children."""

    content: C
    children: tuple[str, ...] = ()


@dataclass(frozen=True)
class Table(Generic[C]):
    """Nodes by id below one root."""

    root: str
    entries: Mapping[str, Entry[C]] = field(default_factory=dict)

    def preorder(self) -> Iterator[str]:
        """The ids, parents before children, left to right."""
        stack = [self.root]
        while stack:
            here = stack.pop()
            yield here
            stack.extend(reversed(self.entries[here].children))

    def spots(self) -> dict[str, Spot]:
        """Where each node is."""
        found = {self.root: Spot(None, None)}
        for id_, entry in self.entries.items():
            before: str | None = None
            for child in entry.children:
                found[child] = Spot(id_, before)
                before = child
        return found


@dataclass(frozen=True, slots=True)
class Spot:
    """A place in a tree: below `parent` (None: the root), right after the sibling `after` (None: the first)."""

    parent: str | None
    after: str | None


@dataclass(frozen=True, slots=True)
class Added(Generic[C]):
    """A node that only the second tree has."""

    id: str
    content: C
    at: Spot


@dataclass(frozen=True, slots=True)
class Removed(Generic[C]):
    """A node that only the first tree has, and where it was."""

    id: str
    content: C
    at: Spot


@dataclass(frozen=True, slots=True)
class Moved(Generic[C]):
    """A node of both trees that has another parent, or another place among those of its siblings that stayed."""

    id: str
    content: C
    before: Spot
    at: Spot


@dataclass(frozen=True, slots=True)
class Changed(Generic[C]):
    """A node of both trees that is something else."""

    id: str
    before: C
    content: C


Change = Added[C] | Removed[C] | Moved[C] | Changed[C]


@dataclass(frozen=True, slots=True)
class Diff(Generic[C]):
    """What leads from one tree to another. Added and moved nodes stand in the second tree's pre-order, removed ones
    in the first's. Nodes of a removed or added subtree are listed one by one."""

    root: str
    added: tuple[Added[C], ...] = ()
    removed: tuple[Removed[C], ...] = ()
    moved: tuple[Moved[C], ...] = ()
    changed: tuple[Changed[C], ...] = ()

    def __bool__(self) -> bool:
        return bool(self.added or self.removed or self.moved or self.changed)

    def __iter__(self) -> Iterator[Change[C]]:
        yield from self.removed
        yield from self.added
        yield from self.moved
        yield from self.changed

    def __len__(self) -> int:
        return sum(1 for _ in self)


def diff_tables(first: Table[C], second: Table[C]) -> Diff[C]:
    """The difference of two tables whose ids mean the same. As few moves as the ids allow."""
    a, b = first.entries, second.entries
    was, now = first.spots(), second.spots()
    old, new = tuple(first.preorder()), tuple(second.preorder())
    in_a, in_b = set(old), set(new)
    stay = _staying(first, second, was, in_a)
    return Diff(
        second.root,
        tuple(Added(i, b[i].content, now[i]) for i in new if i not in in_a),
        tuple(Removed(i, a[i].content, was[i]) for i in old if i not in in_b),
        tuple(Moved(i, b[i].content, was[i], now[i]) for i in new if i in in_a and i not in stay),
        tuple(Changed(i, a[i].content, b[i].content) for i in new if i in in_a and a[i].content != b[i].content),
    )


def _staying(first: Table[C], second: Table[C], was: Mapping[str, Spot], common: set[str]) -> set[str]:
    """The nodes that keep their parent and their order: of each node's children a longest increasing subsequence."""
    stay = {second.root} if second.root == first.root else set()
    for id_ in second.preorder():
        if id_ not in common:
            continue
        rank = {c: k for k, c in enumerate(first.entries[id_].children)}
        kept = [c for c in second.entries[id_].children if c in rank and was[c].parent == id_]
        stay.update(kept[i] for i in _increasing([rank[c] for c in kept]))
    return stay


def _increasing(values: list[int]) -> list[int]:
    """The indices of a longest increasing subsequence."""
    tails: list[int] = []
    ends: list[int] = []
    back: list[int] = []
    for i, value in enumerate(values):
        k = bisect_left(tails, value)
        back.append(ends[k - 1] if k else -1)
        tails[k : k + 1] = [value]
        ends[k : k + 1] = [i]
    found: list[int] = []
    at = ends[-1] if ends else -1
    while at >= 0:
        found.append(at)
        at = back[at]
    return found


def apply_table(edit: Diff[C], first: Table[C]) -> Table[C]:
    """The second table of a diff, from its first. ValueError where the diff is not of this table."""
    content = {i: e.content for i, e in first.entries.items()}
    children = {i: list(e.children) for i, e in first.entries.items()}
    was = first.spots()
    for removed in edit.removed:
        _check(content.get(removed.id) == removed.content and was.get(removed.id) == removed.at, removed.id)
    for change in edit.changed:
        _check(content.get(change.id) == change.before, change.id)
        content[change.id] = change.content
    for move in edit.moved:
        _check(was.get(move.id) == move.before, move.id)
    for added in edit.added:
        _check(added.id not in content, added.id)
    gone = {e.id for e in edit.removed} | {e.id for e in edit.moved}
    for parent in {was[i].parent for i in gone} - {None}:
        assert parent is not None
        children[parent] = [c for c in children[parent] if c not in gone]
    for removed in edit.removed:
        del content[removed.id], children[removed.id]
    for added in edit.added:
        content[added.id], children[added.id] = added.content, []
    _insert(edit, children)
    return Table(edit.root, {i: Entry(c, tuple(children[i])) for i, c in content.items()})


def _insert(edit: Diff[C], children: dict[str, list[str]]) -> None:
    """Put added and moved nodes in: each right after the sibling that it follows, which is there by then."""
    following = {e.at: e.id for e in edit.added} | {e.at: e.id for e in edit.moved}
    for parent in {s.parent for s in following} - {None}:
        assert parent is not None
        _check(parent in children, parent)
        row: list[str] = []
        for kept in (None, *children[parent]):
            at: str | None = kept
            if at is not None:
                row.append(at)
            while (at := following.pop(Spot(parent, at), None)) is not None:
                row.append(at)
        children[parent] = row
    _check(all(s.parent is None for s in following), edit.root)


def _check(holds: bool, id_: str) -> None:
    if not holds:
        raise ValueError(f"the diff is not of this tree: `{id_}` is not as it says")


# -- our own trees -------------------------------------------------------------------------------------------------


def table_of(tree: Tree) -> Table[Node]:
    """A tree as a table; what is not below its root is left out."""
    return Table(tree.root, {n.id: Entry(replace(n, children=()), n.children) for n in tree.preorder()})


def diff(first: Tree, second: Tree) -> Diff[Node]:
    """What leads from one tree to another."""
    return diff_tables(table_of(first), table_of(second))


def apply(edit: Diff[Node], first: Tree) -> Tree:
    """The second tree of a diff, from its first. ValueError where the diff is not of this tree."""
    table = apply_table(edit, table_of(first))
    return Tree(table.root, {i: replace(e.content, children=e.children) for i, e in table.entries.items()})
