"""Text in XML. The standard library's xml.sax.saxutils does this too, but brings urllib and ssl with it."""

from __future__ import annotations

__all__ = ["escape", "quoteattr"]

_TEXT = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;"})
_VALUE = str.maketrans(
    {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}
)


def escape(text: str) -> str:
    """Text between tags."""
    return text.translate(_TEXT)


def quoteattr(value: str) -> str:
    """An attribute's value, in double quotation marks."""
    return f'"{value.translate(_VALUE)}"'
