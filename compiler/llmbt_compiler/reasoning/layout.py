"""How a reply is laid out: lines, lists, tables, fences and JSON become items whose text knows where it came
from."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

__all__ = ["Item", "Kind", "View", "joined", "json_items", "lay_out", "view"]


class Kind(StrEnum):
    """What an item is in the reply."""

    NUMBER = "number"
    BULLET = "bullet"
    ROW = "row"
    HEADING = "heading"
    PROSE = "prose"


@dataclass(frozen=True, slots=True)
class View:
    """Plain text and, for each of its characters, its offset in the reply. `bold` is how much of it, from the
    start, is set in bold; a line break that may end a sentence is kept as such."""

    text: str
    origin: tuple[int, ...]
    bold: int = 0

    def part(self, start: int, end: int) -> View:
        """A slice, without the space around it."""
        while start < end and self.text[start].isspace():
            start += 1
        while end > start and self.text[end - 1].isspace():
            end -= 1
        return View(self.text[start:end], self.origin[start:end], max(0, min(self.bold, end) - start))

    @property
    def start(self) -> int:
        """Where it begins in the reply."""
        return self.origin[0] if self.origin else 0

    @property
    def end(self) -> int:
        """Where it ends in the reply."""
        return self.origin[-1] + 1 if self.origin else 0


@dataclass(slots=True)
class Item:
    """A piece of the reply: its number where it has one, the pieces of its lines, and what stands under
    it."""

    kind: Kind
    pieces: list[tuple[int, int]]
    number: int | None = None
    indent: int = 0
    fenced: bool = False
    titled: bool = False  # a heading like `### Step 1: ...`: the text below it is about it
    children: list[Item] = field(default_factory=list)
    view: View = View("", ())

    def all(self) -> Iterator[Item]:
        """Itself and all that stands under it."""
        yield self
        for child in self.children:
            yield from child.all()


_LINE = re.compile(r"[^\r\n]*(?:\r\n|\r|\n|\Z)")
_FENCE = re.compile(r"\s{0,8}(?:```|~~~)")
_RULE = re.compile(r"\s*(?:[-*_=]\s?){3,}$")
_QUOTE = re.compile(r"\s{0,3}(?:>\s?)+")
_HEADING = re.compile(r"\s{0,3}#{1,6}\s+")
_OPEN = r"(?:\*\*|__|\*|_)?\s*"
_SUB = re.compile(rf"(\s*){_OPEN}\(?\d{{1,3}}\.\d{{1,3}}[.)]?(?!\d)\s+(?=\S)")
_STEP = re.compile(rf"(\s*){_OPEN}step\s*#?(\d{{1,3}})\b(?:\s*\\?[.):\-–—])?\s*", re.IGNORECASE)
_NUMBER = re.compile(
    rf"(\s*){_OPEN}(?:[(\[](\d{{1,3}})[)\]][.:]?|(\d{{1,3}})(?:\ufe0f?\u20e3|\\?[.):\]](?!\d)|"
    rf"\s[-–—](?=\s)))\s*"
)
_BULLET = re.compile(r"(\s*)(?:[-*+•◦‣▪●○–—·]|\(?[a-z][.)]|\(?[ivx]{1,4}[.)])(?:\s+(?:\[[ xX]\]\s+)?|$)")
_ROW = re.compile(r"\s*\|.*\|\s*$")
_ROW_RULE = re.compile(r"\s*\|[\s:|-]+\|\s*$")
_INLINE = re.compile(r"(?:(?<=[.:;!?)])\s+|\A\s*)[(]?(\d{1,2})[.)]\s+(?=[A-Za-z*])")
_TAG = re.compile(r"</?[A-Za-z][^<>\n]{0,80}>|<!--[^\n]{0,200}?-->")
_LINK = re.compile(r"!?\[([^\[\]\n]{1,200})\]\([^()\n]{0,300}\)")
_EMPHASIS = re.compile(r"\*+|`+|~~+|(?<![A-Za-z0-9_])_{1,3}(?=\S)|(?<=\S)_{1,3}(?![A-Za-z0-9_])")
_INVISIBLE = re.compile(
    "[\x00-\x08\x0e-\x1f\x7f-\x84\x86-\x9f\u00ad\u200b-\u200f\u202a-\u202e\u2060-\u2064\ufeff\ufffd]"
)
_BOLD_HEAD = re.compile(r"\s*(?:\*\*|__)(.+?)(?:\*\*|__)")


def lay_out(reply: str) -> list[Item]:
    """The items of a reply at the top level, in order. Linear in its length."""
    reader = _Reader(reply)
    for match in _LINE.finditer(reply):
        if match.start() == match.end():
            break
        reader.line(match.start(), match.start() + len(match.group().rstrip("\r\n")))
    for top in reader.items:
        for item in top.all():
            item.view = view(reply, item.pieces)
    return reader.items


class _Reader:
    def __init__(self, reply: str) -> None:
        self.reply = reply
        self.items: list[Item] = []
        self.open: list[Item] = []  # the items that may still get children, outermost first
        self.current: Item | None = None  # takes lines that go on
        self.fenced = False
        self.blank = True
        counted = sum(1 for m in _LINE.finditer(reply) if m.group().strip() and _NUMBER.match(m.group()))
        self.split_inline = counted < 2

    def line(self, start: int, end: int) -> None:
        text = self.reply[start:end]
        if not text.strip():
            self.blank = True
            return
        if _FENCE.match(text):
            self.fenced = not self.fenced
            self.current, self.blank = None, True
            return
        quote = _QUOTE.match(text)
        if quote:
            start += quote.end()
            text = self.reply[start:end]
        if _ROW.match(text):
            self.row(start, text)
        elif not _RULE.match(text):
            parts = _inline(text) if self.split_inline else []
            for a, b in parts or [(0, len(text))]:
                self.piece(start + a, start + b)
        self.blank = False

    def piece(self, start: int, end: int) -> None:
        text = self.reply[start:end]
        heading = _HEADING.match(text)
        if heading:
            start += heading.end()
            text = self.reply[start:end]
        sub = _SUB.match(text)
        number = None if sub else _STEP.match(text) or _NUMBER.match(text)
        bullet = None if sub or number or heading else _BULLET.match(text)
        if sub:
            self.add(Item(Kind.BULLET, [(start + sub.end(), end)], None, len(sub.group(1)) + 2, self.fenced))
        elif number:
            found = next(g for g in number.groups()[1:] if g is not None)
            body = start + number.end()
            # **1. Pick it up.** opens its bold before the number
            opened = re.search(r"\*\*|__", number.group())
            pieces = [(start + opened.start(), start + opened.end()), (body, end)] if opened else [(body, end)]
            item = Item(Kind.NUMBER, pieces, int(found), len(number.group(1)), self.fenced, bool(heading))
            self.add(item)
            self.current = None if heading else item
        elif bullet:
            self.add(Item(Kind.BULLET, [(start + bullet.end(), end)], None, len(bullet.group(1)), self.fenced))
        elif heading or _is_title(text):
            self.items.append(Item(Kind.HEADING, [(start, end)], fenced=self.fenced))
            self.open, self.current = [], None
        else:
            self.prose(start, end, len(text) - len(text.lstrip()))

    def add(self, item: Item) -> None:
        """Put an item under the one it belongs to."""
        if item.kind is Kind.NUMBER:
            self.open = [o for o in self.open if o.indent + 1 < item.indent]
        else:
            self.open = [o for o in self.open if o.indent < item.indent or o.kind is Kind.NUMBER]
            numbers = [i for i, o in enumerate(self.open) if o.kind is Kind.NUMBER and o.indent > item.indent]
            self.open = self.open[: numbers[0] + 1] if numbers else self.open
        (self.open[-1].children if self.open else self.items).append(item)
        self.open.append(item)
        self.current = item

    def prose(self, start: int, end: int, indent: int) -> None:
        """A line of text: it goes on with the item or the paragraph before it, or begins a new one."""
        current = self.current
        if current is not None and not self.blank and current.fenced == self.fenced:
            current.pieces.append((start, end))
            return
        item = Item(Kind.PROSE, [(start, end)], None, indent, self.fenced)
        if self.open and (self.open[0].titled or indent > self.open[0].indent + 1) and not self.fenced:
            owners = [o for o in self.open if o.titled or o.indent < indent]
            owners[-1].children.append(item)
        else:
            self.items.append(item)
            self.open = []
        self.current = item

    def row(self, start: int, text: str) -> None:
        if _ROW_RULE.match(text):
            if self.items and self.items[-1].kind is Kind.ROW:
                self.items[-1].kind = Kind.HEADING  # what stands over the rule is the head of the table
            return
        bars = [m.start() for m in re.finditer(r"(?<!\\)\|", text)]
        cells = [(start + a + 1, start + b) for a, b in itertools.pairwise(bars)]
        number = None
        if cells and re.fullmatch(r"\s*(?:step\s*)?\d{1,3}[.)]?\s*", self.reply[slice(*cells[0])], re.IGNORECASE):
            number = int(re.sub(r"\D", "", self.reply[slice(*cells[0])]))
            cells = cells[1:]
        self.items.append(Item(Kind.ROW, cells, number, 0, self.fenced))
        self.open, self.current = [], None


def _inline(text: str) -> list[tuple[int, int]]:
    """Where a line holds a list of its own (`1. ... 2. ... 3. ...`): its parts."""
    cuts: list[int] = []
    for match in _INLINE.finditer(text):
        if int(match.group(1)) == len(cuts) + 1:
            cuts.append(match.start())
    if len(cuts) < 2:
        return []
    edges = [*([0] if cuts[0] > 0 else []), *cuts, len(text)]
    return list(itertools.pairwise(edges))


def _is_title(text: str) -> bool:
    """A line that is bold from end to end, or short and ends with a colon."""
    line = text.strip()
    bold = _BOLD_HEAD.match(line)
    return (bold is not None and not line[bold.end() :].strip(" :*_")) or (line.endswith(":") and len(line) < 60)


def view(reply: str, pieces: list[tuple[int, int]]) -> View:
    """Pieces of the reply as one plain text: markup, tags and invisible characters out, space collapsed."""
    chars: list[str] = []
    origin: list[int] = []
    for i, (start, end) in enumerate(pieces):
        if i:
            chars.append("\n")
            origin.append(max(0, start - 1))
        raw = reply[start:end]
        gone = bytearray(len(raw))
        for pattern in (_TAG, _EMPHASIS, _INVISIBLE):
            for m in pattern.finditer(raw):
                gone[m.start() : m.end()] = b"\x01" * (m.end() - m.start())
        for m in _LINK.finditer(raw):
            gone[m.start() : m.start(1)] = b"\x01" * (m.start(1) - m.start())
            gone[m.end(1) : m.end()] = b"\x01" * (m.end() - m.end(1))
        for j, c in enumerate(raw):
            if not gone[j]:
                chars.append(c)
                origin.append(start + j)
    text, places = _collapse(chars, origin)
    bold_end = _bold_end(reply, pieces)
    return View(text, tuple(places), sum(1 for o in places if o < bold_end))


def _collapse(chars: list[str], origin: list[int]) -> tuple[str, list[int]]:
    kept: list[str] = []
    places: list[int] = []
    for c, o in zip(chars, origin, strict=True):
        if not c.isspace():
            kept.append(c)
        elif kept and not kept[-1].isspace():
            kept.append("\n" if c == "\n" else " ")
        else:
            if kept and c == "\n":
                kept[-1] = "\n"
            continue
        places.append(o)
    while kept and kept[-1].isspace():
        kept.pop()
        places.pop()
    return "".join(kept), places


def _bold_end(reply: str, pieces: list[tuple[int, int]]) -> int:
    """The offset in the reply at which the bold text at the start of an item ends; 0 where it is not bold."""
    if not pieces:
        return 0
    if len(pieces) > 1 and reply[slice(*pieces[0])] in ("**", "__"):
        mark, (start, end) = reply[slice(*pieces[0])], pieces[1]
        close = reply.find(mark, start, end)
        return max(close, 0)
    start, end = pieces[0]
    bold = _BOLD_HEAD.match(reply[start:end])
    return start + bold.end(1) if bold else 0


# --- JSON ---------------------------------------------------------------------------------------------------

_STRING = re.compile(r'"(?:[^"\\\r\n]|\\.)*"')
_ESCAPE = re.compile(r"\\u[0-9a-fA-F]{4}|\\.|[^\\]", re.DOTALL)
_JSON_FENCE = re.compile(r"(?:```|~~~)[a-zA-Z]*\s*\n")
_JSON_LINE = re.compile(r"^[ \t]*(?=[\[{])", re.MULTILINE)
_LISTS = ("steps", "plan", "actions", "instructions", "tasks")
_ASIDE = ("id", "number", "reason", "explanation", "comment")
_TEXTS = ("text", "description", "instruction", "step", "action", "task", "content")
_SIMPLE = {
    '\\"': '"',
    "\\\\": "\\",
    "\\/": "/",
    "\\n": "\n",
    "\\t": "\t",
    "\\r": "\r",
    "\\b": "\b",
    "\\f": "\f",
}


def json_items(reply: str) -> list[Item] | None:
    """The items of a reply that is JSON, or has a fence of it; None where it is not. `{"question": ...}`
    becomes one heading that begins with QUESTION:."""
    opening = _JSON_FENCE.search(reply) or _JSON_LINE.search(reply)
    start = opening.end() if opening else len(reply)
    start += len(reply[start : start + 200]) - len(reply[start : start + 200].lstrip())
    if not reply[start : start + 1].strip() or reply[start] not in "[{":
        return None
    try:
        _, end = json.JSONDecoder().raw_decode(reply, start)
        parsed = json.JSONDecoder(object_pairs_hook=_Pairs).raw_decode(reply, start)[0]
        tokens = [_decoded(reply, m.start(), m.end()) for m in _STRING.finditer(reply, start, end)]
        return _collect(_with_places(parsed, iter(tokens)))
    except (ValueError, RecursionError, StopIteration):
        return None


class _Pairs(list[tuple[str, Any]]):
    """An object's members in order."""


def _decoded(reply: str, start: int, end: int) -> View:
    chars: list[str] = []
    origin: list[int] = []
    at = start + 1
    for token in _ESCAPE.findall(reply[start + 1 : end - 1]):
        char = _SIMPLE.get(token) or (chr(int(token, 0)) if token.startswith("\\u") else token)
        chars.append(" " if char.isspace() or "\ud800" <= char <= "\udfff" else char)
        origin.append(at)
        at += len(token)
    text, places = _collapse(chars, origin)
    return View(text, tuple(places))


def _with_places(value: Any, tokens: Iterator[View]) -> Any:
    """The parsed value with each string replaced by its view."""
    if isinstance(value, str):
        return next(tokens)
    if isinstance(value, _Pairs):
        return {next(tokens).text.lower(): _with_places(v, tokens) for _, v in value}
    if isinstance(value, list):
        return [_with_places(v, tokens) for v in value]
    return value


def _collect(value: Any) -> list[Item]:
    if isinstance(value, View):
        return [_entry(value)]
    if isinstance(value, list):
        return [item for v in value for item in _collect(v)]
    return _collect_object(value) if isinstance(value, dict) else []


def _collect_object(value: dict[str, Any]) -> list[Item]:
    """An object is a question, a holder of lists, steps by their numbers, or one step in one or several
    parts."""
    question = value.get("question")
    if isinstance(question, View) and question.text:
        return [Item(Kind.HEADING, [], view=question)]
    inner = [v for v in value.values() if isinstance(v, list | dict)]
    if inner:
        listed = [value[k] for k in _LISTS if isinstance(value.get(k), list | dict)]
        return _collect(listed[:1] or inner)
    texts = {k: v for k, v in value.items() if isinstance(v, View) and v.text}
    if texts and all(k.strip("step_ ").isdigit() for k in texts):
        return [_entry(v) for v in texts.values()]
    whole = [texts[k] for k in _TEXTS if k in texts and len(texts[k].text.split()) > 2]
    parts = whole[:1] or [v for k, v in texts.items() if k not in _ASIDE]
    return [_entry(joined(parts))] if parts else []


def joined(parts: list[View]) -> View:
    """Views one after the other, a space between them."""
    origin: list[int] = []
    for v in parts:
        origin += [*origin[-1:], *v.origin]
    return View(" ".join(v.text for v in parts), tuple(origin))


def _entry(v: View) -> Item:
    return Item(Kind.ROW, [(v.start, v.end)], view=v)
