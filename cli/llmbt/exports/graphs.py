"""A tree as a graph for Graphviz (DOT) and for Mermaid."""

from __future__ import annotations

from llmbt.picture import Picture, Shape

__all__ = ["dot", "mermaid"]

FILL = {"SUCCESS": "#d7f0d8", "FAILURE": "#f8d7d7", "RUNNING": "#fdeec4", "": "#ffffff"}
DOT = {
    Shape.CONDITION: "ellipse",
    Shape.DECORATOR: "diamond",
    Shape.SUBTREE: "box3d",
    Shape.SEQUENCE: "square",
    Shape.FALLBACK: "square",
}
MERMAID = {
    Shape.CONDITION: ("([", "])"),
    Shape.DECORATOR: ("{{", "}}"),
    Shape.SUBTREE: ("[[", "]]"),
    Shape.SEQUENCE: ("[", "]"),
    Shape.FALLBACK: ("[", "]"),
}


def dot(picture: Picture) -> str:
    """For `dot -Tpdf`: children in their order."""
    lines = [
        "digraph tree {",
        '  graph [ordering="out"];',
        '  node [style="filled", fontname="monospace", fontsize=10];',
    ]
    number = {b.id: f"n{k}" for k, b in enumerate(picture.preorder())}
    for box in picture.preorder():
        text = "".join(c if c.isprintable() else " " for c in box.text).replace("\\", "\\\\").replace('"', '\\"')
        shape = DOT.get(box.shape, "box")
        lines.append(f'  {number[box.id]} [label="{text}", shape="{shape}", fillcolor="{FILL[box.status]}"];')
        lines += [f"  {number[box.id]} -> {number[c]};" for c in box.children]
    return "\n".join([*lines, "}", ""])


def mermaid(picture: Picture) -> str:
    """For Markdown: a flowchart; its renderers draw up to some hundreds of edges."""
    lines = ["flowchart TD"]
    number = {b.id: f"n{k}" for k, b in enumerate(picture.preorder())}
    for box in picture.preorder():
        left, right = MERMAID.get(box.shape, ("[", "]"))
        text = {"->": "→", "->*": "→*"}.get(box.text, box.text)
        text = "".join(_entity(c) for c in text)
        style = f":::{box.status.lower()}" if box.status else ""
        lines.append(f'  {number[box.id]}{left}"{text}"{right}{style}')
        lines += [f"  {number[box.id]} --> {number[c]}" for c in box.children]
    used = {b.status for b in picture.boxes.values()} - {""}
    lines += [f"  classDef {s.lower()} fill:{FILL[s]}" for s in sorted(used)]
    return "\n".join([*lines, ""])


def _entity(character: str) -> str:
    """A character as Mermaid's text holds it."""
    if not character.isprintable():
        return " "
    return f"#{ord(character)};" if character in '"#;<>&`\\{}[]' else character
