"""Two BehaviorTree.CPP files as tables whose ids mean the same, so that `diff_tables` can compare them.

Nodes that carry an `_id` are known by it. Others (files of editors, or written by hand) are paired by what they are:
equal branches first, then parents by their children, then what stands below a pair. Not compared: layout, comments,
attribute order, the explicit against the compact syntax, attributes that BehaviorTree.CPP ignores, TreeNodesModel.
"""

from __future__ import annotations

from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from hashlib import blake2s

from llmbt_ir.btcpp.document import Document
from llmbt_ir.btcpp.nodes import CONDITIONS_OF_NODES, KINDS
from llmbt_ir.diff import Entry, Table

__all__ = ["Content", "has_ids", "matched_tables"]


@dataclass(frozen=True, slots=True)
class Content:
    """What a node of any file is: its type, and what it is given, by name."""

    type: str
    attributes: tuple[tuple[str, str], ...] = ()

    def label(self) -> str:
        """As a person reads it."""
        given = ", ".join(f"{k}={v}" for k, v in self.attributes)
        return f"{self.type}({given})" if given else self.type


def has_ids(document: Document) -> bool:
    """Whether every node of a file has an `_id` (an Inverter goes with the node in it)."""
    return all(
        document[i].has("_id")
        for tree in document.trees
        for i in document.below(tree)
        if i != tree and document[i].tag != "Inverter"
    )


def content_of(document: Document, index: int) -> Content:
    """What an element means to BehaviorTree.CPP."""
    element = document[index]
    given = {k: v for k, v in element.attributes if k[0] != "_" or k in CONDITIONS_OF_NODES}
    type_ = element.tag
    if type_ in KINDS and type_ != "SubTree":
        type_ = given.pop("ID", type_)
    if given.get("name") == type_:
        del given["name"]
    return Content(type_, tuple(sorted(given.items())))


@dataclass
class _Side:
    """One file while it is matched: the elements that count, by index; `names` are the ids they get."""

    document: Document
    order: list[int] = field(default_factory=list)
    children: dict[int, tuple[int, ...]] = field(default_factory=dict)
    parent: dict[int, int] = field(default_factory=dict)
    content: dict[int, Content] = field(default_factory=dict)
    shape: dict[int, int] = field(default_factory=dict)
    size: dict[int, int] = field(default_factory=dict)
    names: dict[int, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        d = self.document
        main = (("main_tree_to_execute", d.main),) if d.main else ()
        trees = tuple(sorted(d.trees, key=lambda i: d[i].get("ID")))
        self.content[d.root], self.children[d.root] = Content("root", main), trees
        stack = [d.root]
        while stack:
            here = stack.pop()
            self.order.append(here)
            if here != d.root:
                tree = here in trees
                self.content[here] = (
                    Content("BehaviorTree", (("ID", d[here].get("ID")),)) if tree else content_of(d, here)
                )
                self.children[here] = d.kids(here)
            self.parent.update(dict.fromkeys(self.children[here], here))
            stack.extend(reversed(self.children[here]))

    def measure(self, known: dict[tuple[object, ...], int]) -> None:
        """Give equal branches, in both files, the same number."""
        for i in reversed(self.order):
            key = (self.content[i], *(self.shape[c] for c in self.children[i]))
            self.shape[i] = known.setdefault(key, len(known))
            self.size[i] = 1 + sum(self.size[c] for c in self.children[i])

    def table(self) -> Table[Content]:
        entries = {
            self.names[i]: Entry(self.content[i], tuple(self.names[c] for c in self.children[i])) for i in self.order
        }
        return Table(self.names[self.order[0]], entries)


def matched_tables(first: Document, second: Document) -> tuple[Table[Content], Table[Content]]:
    """Both files as tables; nodes of the same id are the same node."""
    a, b = _Side(first), _Side(second)
    known: dict[tuple[object, ...], int] = {}
    a.measure(known)
    b.measure(known)
    pairs = _pairs(a, b)
    _name(a, {}, set())
    _name(b, {j: a.names[i] for i, j in pairs.items()}, set(a.names.values()))
    return a.table(), b.table()


def _pairs(a: _Side, b: _Side) -> dict[int, int]:
    """Which element of the first is which of the second."""
    found: dict[int, int] = {a.order[0]: b.order[0]}
    back: dict[int, int] = {b.order[0]: a.order[0]}

    def pair(i: int, j: int) -> None:
        if i not in found and j not in back:
            found[i], back[j] = j, i

    for key in (_tree_name, _own_id):
        for i, j in _unique(a, b, key):
            pair(i, j)
    _equal_branches(a, b, found, back, pair)
    for same_type in (True, False):
        _by_children(a, b, found, back, pair, same_type=same_type)
    for j in b.order:
        if j in back:
            _below(a, b, back[j], j, found, back, pair)
    return found


def _tree_name(side: _Side, i: int) -> str | None:
    return side.document[i].get("ID") if side.parent.get(i) == side.order[0] else None


def _own_id(side: _Side, i: int) -> str | None:
    return side.document[i].get("_id") or None


def _unique(a: _Side, b: _Side, key: Callable[[_Side, int], str | None]) -> Iterable[tuple[int, int]]:
    tables: list[dict[str, list[int]]] = []
    for side in (a, b):
        table: dict[str, list[int]] = defaultdict(list)
        for i in side.order:
            name = key(side, i)
            if name is not None:
                table[name].append(i)
        tables.append(table)
    for name, here in tables[0].items():
        there = tables[1].get(name, [])
        if len(here) == 1 == len(there):
            yield here[0], there[0]


def _equal_branches(
    a: _Side, b: _Side, found: dict[int, int], back: dict[int, int], pair: Callable[[int, int], None]
) -> None:
    """Pair equal branches from the top: below paired parents, and elsewhere those that cannot be mistaken."""
    where: dict[int, deque[int]] = defaultdict(deque)
    for i in a.order:
        where[a.shape[i]].append(i)
    often = Counter(b.shape.values())
    for j in b.order:
        if j in back:
            continue
        above = back.get(b.parent[j])
        free = [i for i in where[b.shape[j]] if i not in found] if len(where[b.shape[j]]) <= 64 else []
        best = next((i for i in free if a.parent[i] == above), None)
        alone = len(where[b.shape[j]]) == 1 == often[b.shape[j]]
        if best is None and free and (alone or b.size[j] > 2):
            best = free[0]
        if best is None:
            continue
        stack = [(best, j)]
        while stack:
            i, k = stack.pop()
            pair(i, k)
            stack.extend(zip(a.children[i], b.children[k], strict=True))


def _by_children(
    a: _Side,
    b: _Side,
    found: dict[int, int],
    back: dict[int, int],
    pair: Callable[[int, int], None],
    *,
    same_type: bool,
) -> None:
    """Pair nodes with those that most of their children's partners are below, from the bottom."""
    for j in reversed(b.order):
        if j in back:
            continue
        above = [a.parent[back[c]] for c in b.children[j] if c in back]
        votes = Counter(
            i for i in above if i not in found and (not same_type or a.content[i].type == b.content[j].type)
        )
        if votes:
            pair(votes.most_common(1)[0][0], j)


def _below(
    a: _Side, b: _Side, i: int, j: int, found: dict[int, int], back: dict[int, int], pair: Callable[[int, int], None]
) -> None:
    """Pair the children that are left of two paired nodes: those that are the same, then those of one type."""
    sames: tuple[Callable[[_Side, int], object], ...] = (lambda s, k: s.content[k], lambda s, k: s.content[k].type)
    for same in sames:
        waiting: dict[object, deque[int]] = defaultdict(deque)
        for c in a.children[i]:
            if c not in found:
                waiting[same(a, c)].append(c)
        for c in b.children[j]:
            if c not in back and waiting[same(b, c)]:
                pair(waiting[same(b, c)].popleft(), c)


def _name(side: _Side, given: dict[int, str], used: set[str]) -> None:
    """An id for each element: the one given, its own, or else its place as `Main.2.1`."""
    places: dict[int, str] = {side.order[0]: "root"}
    for i in side.order:
        for number, child in enumerate(side.children[i], 1):
            tree = side.document[child].get("ID") if i == side.order[0] else ""
            places[child] = tree or (f"tree{number}" if i == side.order[0] else _place(places[i], number))
        name = given.get(i)
        if name is None:
            name = side.document[i].get("_id") or places[i]
            while name in used:
                name += "'"
            used.add(name)
        side.names[i] = name


def _place(above: str, number: int) -> str:
    """Deep places are cut short, so that names do not grow with the depth."""
    if len(above) < 60:
        return f"{above}.{number}"
    return f"{above[:12]}~{blake2s(above.encode(), digest_size=5).hexdigest()}.{number}"
