"""Reading goals: JSON by `goals.schema.json`, a PDDL goal, or a model's JSON reply, which may ask back instead.

What comes out are literals as written, each with its place in the text; nothing is looked up here.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from typing import Any

from llmbt_atl.pddl.reader import Group, Item, Source, Word, lists
from llmbt_compiler.parsing import Extent
from llmbt_compiler.reasoning.prompt import clean
from llmbt_compiler.reasoning.steps import Question
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span

__all__ = ["Literal", "Stated", "read_reply", "read_stated"]

MAX_CHARS = 200_000
MAX_GOALS = 200
MAX_ARGS = 8
_GOAL_KEYS = {"name", "args", "negated", "says", "step", "words", "span", "reply"}
_UNSUPPORTED = {"", "or", "imply", "forall", "exists", "when", "and", "not", "=", "preference", ">=", "<=", ">", "<"}
_TOP_KEYS = {"schema_version", "goals", "notes", "left_out"}


@dataclass(frozen=True, slots=True)
class Literal:
    """A goal as it is written, and where: `extent` in the text, line and column from 1."""

    name: str
    args: tuple[str, ...]
    negated: bool
    extent: Extent
    line: int
    column: int

    def span(self, source: str, text: str) -> Span:
        """Where it stands, for diagnostics."""
        lines = text.splitlines()
        shown = (
            "".join(c if c.isprintable() else " " for c in lines[self.line - 1][:200])
            if self.line <= len(lines)
            else ""
        )
        end = min(self.column + self.extent.end - self.extent.start, len(shown) + 1)
        return Span(source, self.line, self.column, max(end, self.column + 1), shown)


@dataclass(frozen=True, slots=True)
class Stated:
    """Goals as written, in order, and the text that they stand in."""

    literals: tuple[Literal, ...]
    text: str
    source: str


def read_stated(text: str, source: str = "goals.json") -> Stated:
    """Goals that a person states: JSON where the text begins with a brace, else PDDL.

    Errors: E150 not JSON, or not as the schema has it; E155 no goals; E090, E092 as for PDDL.
    """
    if len(text) > MAX_CHARS:
        raise _fault("E150", f"the goals have more than {MAX_CHARS} characters", text, source, 0)
    if text.lstrip("\ufeff \t\r\n")[:1] in {"{", "["}:
        start = text.index(text.lstrip("\ufeff \t\r\n")[0])
        document, end = _decoded(text, start, source)
        if text[end:].strip():
            raise _fault("E150", "there is text after the end of the JSON", text, source, end)
        return _goals(document, text, start, source)
    return _pddl(text, source)


def read_reply(text: str, source: str = "reply.json") -> Stated | Question:
    """The JSON of a model's reply, in a fence or with words around it: its goals, or its question.

    Errors: E150 no JSON in it, or not as asked for; E151 it stops in the middle; E155 no goals.
    """
    if len(text) > MAX_CHARS:
        raise _fault("E150", f"the reply has more than {MAX_CHARS} characters", text, source, 0)
    start = text.find("{")
    if start < 0:
        raise _fault("E150", "there is no JSON in the reply", text, source, 0)
    document, end = _decoded(text, start, source, whole=False)
    if isinstance(document, dict) and isinstance(document.get("question"), str):
        if document.get("goals"):
            raise _fault("E150", "the reply asks back and states goals", text, source, start)
        said = clean(document["question"], 1000)
        if not re.search(r"\w", said):
            raise _fault("E150", "the reply asks a question without words", text, source, start)
        named = document.get("candidates")
        names = tuple(clean(str(n)) for n in named[:50]) if isinstance(named, list) else ()
        return Question(said, start, end, text.count("\n", 0, start) + 1, names)
    return _goals(document, text, start, source)


def _fault(code: str, title: str, text: str, source: str, at: int, hint: str = "") -> LlmbtError:
    line = text.count("\n", 0, at) + 1
    column = at - (text.rfind("\n", 0, at) + 1) + 1
    shown = text.split("\n")[line - 1][:200]
    shown = "".join(c if c.isprintable() else " " for c in shown)
    hint = hint or 'as {"goals": [{"name": "On", "args": ["object_1", "position_12"]}]}'
    span = Span(source, line, column, column + 1, shown) if column <= len(shown) + 1 else Span(source, line)
    return LlmbtError(Diagnostic(code, title, span, help=hint))


class _TwiceError(ValueError):
    """A key that is there twice: which of the two is meant is not ours to say."""


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise _TwiceError(key)
        found[key] = value
    return found


def _decoded(text: str, start: int, source: str, *, whole: bool = True) -> tuple[Any, int]:
    try:
        return json.JSONDecoder(object_pairs_hook=_once).raw_decode(text, start)
    except _TwiceError as wrong:
        raise _fault("E150", f"the JSON has the key `{clean(str(wrong), 40)}` twice", text, source, start) from None
    except json.JSONDecodeError as wrong:
        if not whole and not text[wrong.pos :].strip("` \r\n"):
            raise _fault("E151", "the reply's JSON stops in the middle", text, source, len(text.rstrip()) - 1) from None
        raise _fault("E150", f"not JSON: {wrong.msg}", text, source, wrong.pos) from None
    except (RecursionError, ValueError):
        raise _fault(
            "E150", "not JSON that can be read: nested too deep, or a number too long", text, source, start
        ) from None


def _goals(document: Any, text: str, start: int, source: str) -> Stated:
    if not isinstance(document, dict):
        raise _fault("E150", "the JSON is no object with `goals`", text, source, start)
    if document.get("schema_version", 1) != 1:
        raise _fault("E150", f"schema_version is {document['schema_version']!r}, and 1 is known", text, source, start)
    strange = [k for k in document if k not in _TOP_KEYS]
    if strange or not isinstance(document.get("goals"), list):
        what = f"`{clean(strange[0])}` is not known here" if strange else "`goals` is no list"
        raise _fault("E150", what, text, source, start)
    if not document["goals"]:
        raise _fault("E155", "there are no goals", text, source, start)
    if len(document["goals"]) > MAX_GOALS:
        raise _fault("E150", f"there are more than {MAX_GOALS} goals", text, source, start)
    places = _places(text, start, len(document["goals"]))
    literals = tuple(_literal(g, text, at, source) for g, at in zip(document["goals"], places, strict=True))
    return Stated(literals, text, source)


def _places(text: str, start: int, count: int) -> list[Extent]:
    """Where each goal stands: the elements of the list after the key `goals`."""
    key = re.compile(r'"goals"\s*:\s*\[').search(text, start)
    if key is None:  # the key is written with escapes
        return [Extent(start, start + 1)] * count
    decoder, at, found = json.JSONDecoder(), key.end(), []
    for _ in range(count):
        at = next(i for i in range(at, len(text)) if text[i] not in " \t\r\n,")
        _, end = decoder.raw_decode(text, at)
        found.append(Extent(at, end))
        at = end
    return found


def _literal(goal: Any, text: str, at: Extent, source: str) -> Literal:
    def wrong(what: str) -> LlmbtError:
        return _fault("E150", what, text, source, at.start)

    if not isinstance(goal, dict):
        raise wrong("a goal is an object with `name` and `args`")
    strange = [k for k in goal if k not in _GOAL_KEYS]
    if strange:
        raise wrong(f"`{clean(strange[0])}` is not known in a goal")
    name, args, negated = goal.get("name"), goal.get("args"), goal.get("negated", False)
    if not isinstance(name, str) or not isinstance(args, list) or not all(isinstance(a, str) for a in args):
        raise wrong("a goal has a `name`, a text, and `args`, a list of texts")
    if len(args) > MAX_ARGS or not isinstance(negated, bool):
        raise wrong("`negated` is true or false" if len(args) <= MAX_ARGS else f"a goal has at most {MAX_ARGS} args")
    line = text.count("\n", 0, at.start) + 1
    column = at.start - (text.rfind("\n", 0, at.start) + 1) + 1
    return Literal(clean(name), tuple(clean(a, 200) for a in args), negated, at, line, column)


# -- PDDL ----------------------------------------------------------------------------------------------------------


def _pddl(text: str, source: str) -> Stated:
    """A goal by itself, `(:goal ...)`, or a whole problem, of which nothing but the goal is read."""
    where, found = lists(text, source)
    if found.head == "define":
        inner = next((i for i in found.items if isinstance(i, Group) and i.head == ":goal"), None)
        if inner is None:
            raise where.fault("E155", "the problem states no goal", found)
        found = inner
    if found.head == ":goal":
        body = found.items[1] if len(found.items) == 2 else None
        if not isinstance(body, Group):
            raise where.fault("E090", "`:goal` takes one formula", found)
        found = body
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    literals = tuple(_formula(found, where, starts, negated=False))
    if not literals:
        raise where.fault("E155", "there are no goals", found)
    return Stated(literals, text, source)


def _formula(item: Item, where: Source, starts: list[int], *, negated: bool) -> list[Literal]:
    if not isinstance(item, Group):
        raise where.fault("E090", "expected a formula in parentheses", item)
    if item.head == "and" and not negated:
        return [x for i in item.items[1:] for x in _formula(i, where, starts, negated=False)]
    if item.head == "not" and not negated and len(item.items) == 2:
        return _formula(item.items[1], where, starts, negated=True)
    if item.head in {
        "or",
        "imply",
        "forall",
        "exists",
        "when",
        "and",
        "not",
        "=",
        "preference",
        "",
        ">=",
        "<=",
        ">",
        "<",
    }:
        what = f"`{item.head}` is not supported in a goal" if item.head else "a formula begins with a name"
        raise where.fault("E092", what, item, "give a conjunction of literals: (and (on a b) (not (holding a)))")
    words = [i for i in item.items if isinstance(i, Word)]
    if len(words) != len(item.items):
        raise where.fault("E090", "a literal is a name with its arguments", item)
    if len(words) - 1 > MAX_ARGS:
        raise where.fault("E090", f"a literal has at most {MAX_ARGS} arguments", item)
    at = starts[item.line - 1] + item.column - 1
    end = starts[words[-1].line - 1] + words[-1].column - 1 + len(words[-1].text) + 1
    texts = [clean(w.text, 200) for w in words]
    return [Literal(texts[0], tuple(texts[1:]), negated, Extent(at, end), item.line, item.column)]
