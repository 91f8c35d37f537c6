"""What is drawn of a tree, whoever wrote it: boxes with a symbol, a text, a status and children."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum

from llmbt_ir.btcpp.document import Document
from llmbt_ir.btcpp.findings import File
from llmbt_ir.btcpp.match import content_of
from llmbt_ir.btcpp.nodes import NodeKind
from llmbt_ir.tree import Kind, Node, Tree

__all__ = ["Box", "Picture", "Shape", "box_of", "picture_of_document", "picture_of_tree"]


class Shape(StrEnum):
    """How a box is drawn."""

    SEQUENCE = "sequence"
    FALLBACK = "fallback"
    CONTROL = "control"
    DECORATOR = "decorator"
    CONDITION = "condition"
    ACTION = "action"
    SUBTREE = "subtree"


BRACKETS = {
    Shape.CONDITION: ("(", ")"),
    Shape.ACTION: ("[", "]"),
    Shape.DECORATOR: ("<", ">"),
    Shape.SUBTREE: ("{", "}"),
}


@dataclass(frozen=True, slots=True)
class Box:
    """One node: `text` is the paper's symbol or the leaf's call; `status` is empty where it was not ticked."""

    id: str
    shape: Shape
    text: str
    children: tuple[str, ...] = ()
    status: str = ""

    def mark(self) -> str:
        """As a line of text shows it: ?, ->, (condition), [action], <decorator>, {subtree}."""
        left, right = BRACKETS.get(self.shape, ("", ""))
        return f"{left}{self.text}{right}"


@dataclass(frozen=True)
class Picture:
    """Boxes by id below one or more tops (a file of several trees has one for each)."""

    tops: tuple[str, ...]
    boxes: Mapping[str, Box]

    def preorder(self) -> Iterator[Box]:
        """The boxes, parents before children."""
        stack = list(reversed(self.tops))
        while stack:
            box = self.boxes[stack.pop()]
            yield box
            stack.extend(reversed(box.children))


SHAPES = {
    Kind.SEQUENCE: Shape.SEQUENCE,
    Kind.FALLBACK: Shape.FALLBACK,
    Kind.CONDITION: Shape.CONDITION,
    Kind.ACTION: Shape.ACTION,
}


def box_of(node: Node, status: str = "") -> Box:
    """The box of one of our nodes."""
    return Box(node.id, SHAPES[node.kind], node.label(), node.children, status)


def picture_of_tree(tree: Tree, statuses: Mapping[str, str] | None = None) -> Picture:
    """One of our trees; `statuses` by node id."""
    found = {n.id: box_of(n, (statuses or {}).get(n.id, "")) for n in tree.preorder()}
    return Picture((tree.root,), found)


SYMBOLS = {
    "ReactiveSequence": (Shape.SEQUENCE, "->"),
    "ReactiveFallback": (Shape.FALLBACK, "?"),
    "Sequence": (Shape.SEQUENCE, "->*"),
    "SequenceWithMemory": (Shape.SEQUENCE, "->**"),
    "AsyncSequence": (Shape.SEQUENCE, "->* async"),
    "Fallback": (Shape.FALLBACK, "?*"),
    "AsyncFallback": (Shape.FALLBACK, "?* async"),
}
"""* stands for memory, as in the literature."""
KINDS = {
    NodeKind.CONTROL: Shape.CONTROL,
    NodeKind.DECORATOR: Shape.DECORATOR,
    NodeKind.CONDITION: Shape.CONDITION,
    NodeKind.ACTION: Shape.ACTION,
    NodeKind.SUBTREE: Shape.SUBTREE,
}


def picture_of_document(document: Document) -> Picture:
    """Any BehaviorTree.CPP file: each of its trees, the main one first, SubTrees not written out."""
    file = File(document)
    boxes: dict[str, Box] = {}
    tops = sorted(document.trees, key=lambda t: document[t].get("ID") != document.main)
    for tree in tops:
        for i in document.below(tree):
            shape, text = _drawn(file, i, tree)
            boxes[str(i)] = Box(str(i), shape, text, tuple(str(c) for c in document.kids(i)))
    return Picture(tuple(str(t) for t in tops), boxes)


def _drawn(file: File, index: int, tree: int) -> tuple[Shape, str]:
    content = content_of(file.document, index)
    if index == tree:
        return Shape.CONTROL, f"{dict(content.attributes).get('ID', 'a tree')}:"
    given = [(k, v) for k, v in content.attributes if k != "ID"]
    if content.type == "SubTree":
        name = file.document[index].get("ID")
        return Shape.SUBTREE, _call(name, given)
    shape, symbol = SYMBOLS.get(content.type, (None, content.type))
    if shape is not None:
        return shape, _call(symbol, given)
    kind = file.kind_of(index)
    grows = Shape.CONTROL if file.document.kids(index) else Shape.ACTION
    return KINDS[kind] if kind else grows, _call(content.type, given)


def _call(name: str, given: list[tuple[str, str]]) -> str:
    return f"{name}({', '.join(f'{k}={v}' for k, v in given)})" if given else name
