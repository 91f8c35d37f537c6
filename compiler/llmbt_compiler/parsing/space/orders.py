"""The words that ask for an order of several things: "from small to large", "in a row", "smallest on the left"."""

from __future__ import annotations

import re
from dataclasses import dataclass

__all__ = ["Arrangement", "arrangement"]

_SMALL, _LARGE = r"(?:small\w*|tiny|tiniest|littlest)", r"(?:large\w*|big\w*|great\w*)"
_GAP = r"\s+(?:one\s+|object\s+|block\s+|item\s+)?(?:(?:up|down)\s+)?to\s+(?:the\s+)?"
_UP, _DOWN = r"(?:ascending|increasing|growing|rising)", r"(?:descending|decreasing|falling|shrinking)"
_SIZE, _ORDER = r"(?:size|volume)s?", r"(?:order\s+(?:of|by)\s+)?(?:the(?:ir)?\s+)?"
_UNKNOWN = "unknown"


def _words(pattern: str) -> re.Pattern[str]:
    return re.compile(rf"\b(?:{pattern})\b", re.IGNORECASE)


_KEYS = tuple(
    (name, _words(pattern))
    for name, pattern in (
        ("small", rf"{_SMALL}{_GAP}{_LARGE}"),
        ("large", rf"{_LARGE}{_GAP}{_SMALL}"),
        ("short", rf"short\w*{_GAP}(?:tall|high)\w*"),
        ("tall", rf"(?:tall|high)\w*{_GAP}(?:short|low)\w*"),
        ("small", rf"{_UP}\s+{_ORDER}{_SIZE}|{_SIZE}\s*,?\s+(?:in\s+)?{_UP}|{_SMALL}\s+(?:one\s+)?first"),
        ("large", rf"{_DOWN}\s+{_ORDER}{_SIZE}|{_SIZE}\s*,?\s+(?:in\s+)?{_DOWN}|{_LARGE}\s+(?:one\s+)?first"),
        ("short", rf"(?:by|{_UP}|according\s+to)\s+{_ORDER}heights?"),
        ("small", rf"(?:by|in|according\s+to)\s+{_ORDER}{_SIZE}(?:\s+order)?"),
        ("number", rf"by\s+(?:their\s+)?(?:number|id|index|name)s?|in\s+(?:numerical|alphabetical|{_UP})\s+order"),
        (_UNKNOWN, r"(?:by|according\s+to)\s+(?:their\s+)?(?:colou?r|shape|weight|mass|kind|type|price|age|width)s?"),
    )
)
_STARTING = r"(?:starting|beginning)\s+(?:on|at|from|with)\s+the\s+(?:far\s+)?"
_DIRECTIONS = tuple(
    (name, _words(rf"{name}\s+to\s+(?:the\s+)?{other}|{_STARTING}{name}(?:\s+(?:end|side))?"))
    for name, other in (("left", "right"), ("right", "left"), ("front", "back"), ("back", "front"))
)
_BEGINNING = _words(
    r"(?:starting|beginning|start|begin)\s+(?:on|from|at|with)\s+the\s+(?:very\s+|far\s+)?(?P<end>left|right|front|back)"
)
_ENDING = _words(
    rf"(?P<what>{_SMALL}|{_LARGE}|short\w*|tall\w*)\s+(?:one\s+|block\s+|object\s+)?(?:is\s+|goes\s+|being\s+)?"
    r"(?:(?:on|to|at|onto)\s+the\s+(?:far\s+)?(?P<end>left|right|front|back)|(?P<most>leftmost|rightmost))"
)
_ROW = _words(
    r"in(?:to)?\s+(?:a|one|the\s+same|a\s+single|a\s+straight|one\s+single)\s+(?:row|line)|side\s+by\s+side|"
    r"(?:next\s+to|beside|adjacent\s+to|alongside)\s+(?:each\s+other|one\s+another)|line[ds]?\s+.{0,60}?\bup|"
    r"lin(?:e|ed|ing)\s+up|in\s+an?\s+(?:un)?broken\s+(?:row|line)"
)
_LISTED = _words(r"in\s+(?:this|that|the\s+(?:given|following|listed|same))\s+order")
_LEAD = re.compile(r"\b(?:(?:sorted|ordered|arranged|ranked)\s+)?(?:(?:from|in|by)\s+)?(?:the\s+)?$", re.IGNORECASE)
_MOST = 2000


@dataclass(frozen=True, slots=True)
class Arrangement:
    """What a step asks of several things.

    `key`: what comes first, as an end of `relations.DIRECTIONS` (small, large, short, tall), the `number` of the id,
    the things as `listed`, or something `unknown`. `end`: the side that the first of them stands on. `row`: they stand
    without gaps. `parts`: where the words are.
    """

    key: str
    end: str
    row: bool
    parts: tuple[tuple[int, int], ...]

    @property
    def known(self) -> bool:
        """Whether the map tells what it orders by."""
        return self.key != _UNKNOWN


def arrangement(text: str, start: int = 0, end: int | None = None) -> Arrangement | None:
    """The order that text[start:end] asks for; None where it asks for none."""
    stop = len(text) if end is None else end
    if stop - start > _MOST:
        return None
    found: list[tuple[int, int]] = []
    key = direction = ""
    for name, pattern in _KEYS:
        hit = pattern.search(text, start, stop)
        if hit is not None:
            key = name
            lead = _LEAD.search(text, start, hit.start())
            found.append((lead.start() if lead is not None else hit.start(), hit.end()))
            break
    for name, pattern in _DIRECTIONS:
        hit = pattern.search(text, start, stop)
        if hit is not None:
            direction = name
            lead = _LEAD.search(text, start, hit.start())
            found.append((lead.start() if lead is not None else hit.start(), hit.end()))
            break
    beginning = _BEGINNING.search(text, start, stop)
    if beginning is not None and found:
        direction = beginning["end"].lower()
        found.append(beginning.span())
    ending = _ENDING.search(text, start, stop)
    if ending is not None:
        found.append(ending.span())
        key = _first(ending["what"].lower())
        direction = (ending["end"] or ending["most"].lower().removesuffix("most")).lower()
    row = _ROW.search(text, start, stop)
    listed = _LISTED.search(text, start, stop)
    found += [m.span() for m in (row, listed) if m is not None]
    if not found or (key == _UNKNOWN and not direction and row is None):
        return None
    return Arrangement(key or "listed", direction or "left", row is not None, tuple(sorted(found)))


def _first(word: str) -> str:
    for name, begins in (("small", ("small", "tin", "little")), ("short", ("short",)), ("tall", ("tall",))):
        if word.startswith(begins):
            return name
    return "large"
