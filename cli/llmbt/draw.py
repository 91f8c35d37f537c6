"""A tree as Unicode text, with the paper's symbols."""

from __future__ import annotations

from llmbt_ir.tree import Kind, Node, Tree

__all__ = ["drawing"]


def _symbol(node: Node) -> str:
    if node.kind is Kind.CONDITION:
        return f"({node.label()})"
    if node.kind is Kind.ACTION:
        return f"[{node.label()}]"
    return node.label()


def drawing(tree: Tree) -> str:
    """One line a node, children below their parent; does not recurse."""
    lines: list[str] = []
    stack: list[tuple[str, str, str]] = [(tree.root, "", "")]
    while stack:
        id_, lead, below = stack.pop()
        node = tree[id_]
        lines.append(lead + _symbol(node))
        last = len(node.children) - 1
        for i in range(last, -1, -1):
            branch, bar = ("└─ ", "   ") if i == last else ("├─ ", "│  ")
            stack.append((node.children[i], below + branch, below + bar))
    return "\n".join(lines)
