"""BehaviorTree.CPP's recording of a run (`.btlog`, FileLogger2), which Groot2 replays.

Layout: `BTCPP4-FileLogger2`, 0x01, the XML's length (i32) and the XML, the start in microseconds (i64), then records
of 9 bytes: microseconds since the start (u48), node (u16), status (u8); all little-endian. Nodes are numbered from 1
in pre-order, through SubTrees. Times are simulated, from 0.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from llmbt.replay import Moment
from llmbt_ir.btcpp.document import Document, parse_document
from llmbt_ir.btcpp.findings import File
from llmbt_ir.condition import Facts, holds
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span
from llmbt_ir.quoting import quoteattr
from llmbt_ir.tree import Kind, Tree
from llmbt_ir.tree_xml import TreeFile, write_tree
from llmbt_runtime.tick import NodeStatus

__all__ = ["Numbered", "btlog", "number", "read_btlog", "transitions"]

MAGIC = b"BTCPP4-FileLogger2\x01"
IDLE, RUNNING, SUCCESS, FAILURE = 0, 1, 2, 3
CODE = {NodeStatus.RUNNING: RUNNING, NodeStatus.SUCCESS: SUCCESS, NodeStatus.FAILURE: FAILURE}
Transition = tuple[int, int, int]
"""Microseconds, node, status."""


@dataclass(frozen=True)
class Numbered:
    """A tree's XML with a number for each node, and the numbers of each of our nodes, outermost first: a negated
    condition has an Inverter's and its own, the top of a SubTree the SubTree's and its own."""

    xml: bytes
    numbers: Mapping[str, tuple[int, ...]]


def number(file: TreeFile) -> Numbered:
    """Number a tree's nodes as BehaviorTree.CPP does. E084 where there are more than its 16 bits can tell."""
    document = parse_document(write_tree(file.tree, file.signatures))
    uids = _uids(document)
    if len(uids) > 0xFFFF:
        raise LlmbtError(Diagnostic("E084", f"{len(uids)} nodes; a .btlog tells 65535 apart", Span(file.source)))
    found: dict[str, tuple[int, ...]] = {}
    outer: tuple[int, ...] = ()
    for index in sorted(uids, key=uids.__getitem__):
        element = document[index]
        if element.tag == "Inverter":
            outer = (uids[index],)
        elif element.tag == "SubTree":
            found[element.get("_id")] = (uids[index],)
        else:
            id_ = element.get("_id")
            found[id_] = (*found.get(id_, ()), *outer, uids[index])
            outer = ()
    return Numbered(_xml(document, uids, file.tree), found)


def _uids(document: Document) -> dict[int, int]:
    """The number of each element, in pre-order, each SubTree followed by what is in it."""
    calls = File(document).calls
    found: dict[int, int] = {}
    stack = list(document.kids(document.by_id[str(document.main)]))
    while stack:
        index = stack.pop()
        found[index] = len(found) + 1
        inside = document.kids(calls[index]) if index in calls else document.kids(index)
        stack.extend(reversed(inside))
    return found


def _xml(document: Document, uids: Mapping[int, int], tree: Tree) -> bytes:
    lines = ['<root BTCPP_format="4">']
    calls = {t: i for i, t in File(document).calls.items()}
    paths: dict[int, str] = {}
    for top in document.trees:
        call = calls.get(top)
        if call is not None:
            above = paths[_tree_of(document, call)]
            paths[top] = f"{above}/" * bool(above) + f"{document[call].get('ID')}::{uids[call]}"
        else:
            paths[top] = ""
        lines.append(f"<BehaviorTree ID={quoteattr(document[top].get('ID'))} _fullpath={quoteattr(paths[top])}>")
        lines.extend(_elements(document, top, uids, tree))
        lines.append("</BehaviorTree>")
    lines.append("<TreeNodesModel>")
    for model in document.named(document.root, "TreeNodesModel"):
        for declared in document.kids(model):
            lines.extend(_elements(document, declared, {}, tree, itself=True))
    return "\n".join([*lines, "</TreeNodesModel>", "</root>"]).encode()


def _tree_of(document: Document, index: int) -> int:
    while document[index].tag != "BehaviorTree":
        index = document[index].parent
    return index


def _elements(
    document: Document, top: int, uids: Mapping[int, int], tree: Tree, *, itself: bool = False
) -> Iterator[str]:
    stack = [(i, False) for i in ((top,) if itself else reversed(document.kids(top)))]
    while stack:
        index, closing = stack.pop()
        element, kids = document[index], document.kids(index)
        if closing:
            yield f"</{element.tag}>"
            continue
        pairs = list(element.attributes)
        if index in uids:
            node = tree.nodes.get(element.get("_id"))
            leaf = node.label() if node is not None and not node.children else element.tag
            pairs = [("name", leaf), *((k, v) for k, v in pairs if k != "_id"), ("_uid", str(uids[index]))]
            if element.tag == "SubTree":
                pairs = [p for p in pairs if p[0] != "name"]
        end = "" if kids else "/"
        yield f"<{element.tag}{''.join(f' {k}={quoteattr(v)}' for k, v in pairs)}{end}>"
        if kids:
            stack.append((index, True))
            stack.extend((c, False) for c in reversed(kids))


# -- ticking as BehaviorTree.CPP logs it ---------------------------------------------------------------------------


@dataclass
class _Engine:
    """Ticks a tree and notes each change of a status, in BehaviorTree.CPP's order: a composite runs when it is
    entered, resets its children before it ends, halts the others when one runs."""

    tree: Tree
    numbers: Mapping[str, tuple[int, ...]]
    now: dict[int, int] = field(default_factory=dict)
    noted: list[tuple[int, int]] = field(default_factory=list)

    def set(self, uid: int, status: int) -> None:
        if self.now.get(uid, IDLE) != status:
            self.now[uid] = status
            self.noted.append((uid, status))

    def tick(self, facts: Facts, reports: Mapping[str, NodeStatus]) -> None:
        """One tick from the root; an action without a report runs."""
        stack: list[tuple[str, int]] = [(self.tree.root, 0)]
        returned = IDLE
        while stack:
            id_, at = stack.pop()
            node = self.tree[id_]
            if at == 0:
                self.enter(id_)
            if node.condition is not None:
                returned = self.finish(id_, SUCCESS if holds(node.condition, facts) else FAILURE)
            elif node.action is not None:
                returned = self.finish(id_, CODE[reports.get(id_, NodeStatus.RUNNING)])
            else:
                go_on = SUCCESS if node.kind is Kind.SEQUENCE else FAILURE
                if at == 0 or (returned == go_on and at < len(node.children)):
                    stack += [(id_, at + 1), (node.children[at], 0)]
                    continue
                running = node.children[at - 1] if returned == RUNNING else None
                for child in node.children:
                    if child != running:
                        self.halt(child)
                returned = self.finish(id_, returned)
        if returned != RUNNING:
            self.set(self.numbers[self.tree.root][0], IDLE)

    def enter(self, id_: str) -> None:
        """Decorators and composites run as soon as they are ticked."""
        uids = self.numbers[id_]
        for uid in uids if self.tree[id_].children else uids[:-1]:
            self.set(uid, RUNNING)

    def finish(self, id_: str, status: int) -> int:
        """A node returns, from the inside out; what ended in a decorator is reset before that ends too."""
        uids, condition = self.numbers[id_], self.tree[id_].condition
        inner = SUCCESS + FAILURE - status if condition is not None and condition.negated else status
        self.set(uids[-1], inner)
        for k in range(len(uids) - 2, -1, -1):
            if status != RUNNING:
                self.set(uids[k + 1], IDLE)
            self.set(uids[k], status)
        return status

    def halt(self, id_: str) -> None:
        """Whatever in a branch is not idle becomes so, children first."""
        stack = [(id_, False)]
        while stack:
            here, leaving = stack.pop()
            uids = self.numbers[here]
            if leaving:
                for uid in reversed(uids):
                    self.set(uid, IDLE)
            elif any(self.now.get(u, IDLE) != IDLE for u in uids):
                stack.append((here, True))
                stack.extend((c, False) for c in reversed(self.tree[here].children))


def transitions(tree: Tree, numbers: Mapping[str, tuple[int, ...]], story: Iterable[Moment]) -> Iterator[Transition]:
    """Every change of a status, in order."""
    engine = _Engine(tree, numbers)
    for moment in story:
        reports: dict[str, NodeStatus] = {}
        if moment.ended is not None:
            node, status = moment.ended
            if status is NodeStatus.SUCCESS:
                engine.set(numbers[node][-1], SUCCESS)
            else:
                reports[node] = status
        engine.tick(moment.facts, reports)
        usec = round(moment.time_s * 1_000_000)
        yield from ((usec, uid, status) for uid, status in engine.noted)
        engine.noted.clear()


def btlog(file: TreeFile, story: Iterable[Moment]) -> bytes:
    """The recording of one version."""
    numbered = number(file)
    parts = [MAGIC, struct.pack("<i", len(numbered.xml)), numbered.xml, struct.pack("<q", 0)]
    for usec, uid, status in transitions(file.tree, numbered.numbers, story):
        parts.append(usec.to_bytes(6, "little") + uid.to_bytes(2, "little") + bytes((status,)))
    return b"".join(parts)


def read_btlog(data: bytes) -> tuple[bytes, int, tuple[Transition, ...]]:
    """The XML, the start and the transitions of a recording. ValueError where it is none."""
    if not data.startswith(MAGIC):
        raise ValueError("not a .btlog of BehaviorTree.CPP 4")
    (size,) = struct.unpack_from("<i", data, len(MAGIC))
    at = len(MAGIC) + 4 + size
    (start,) = struct.unpack_from("<q", data, at)
    rest = data[at + 8 :]
    rows = (rest[k : k + 9] for k in range(0, len(rest) - 8, 9))
    found = tuple((int.from_bytes(r[:6], "little"), int.from_bytes(r[6:8], "little"), r[8]) for r in rows)
    return data[len(MAGIC) + 4 : at], start, found
