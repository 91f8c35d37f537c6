"""What a step names outside its keywords: said on the side, or missed by the tagger. The first is what "it" may mean,
the second must not be lost silently.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise, takewhile

from llmbt_compiler.parsing.model import Extent, LabelledStep
from llmbt_compiler.parsing.names import exactly_named
from llmbt_compiler.parsing.scene import Entity, Scene
from llmbt_compiler.parsing.words import Token, lexicon, tokens

__all__ = ["done_before", "goes_unread", "in_passing", "mentioned", "mentions", "restrictions", "unread"]

_MARKS = frozenset({",", ".", ";", ":"})
_RESTRICTION = re.compile(
    r"\b(?:no two|(?:(?:no|not|never) more than|at most) (?:one|two|three|four|five|\d))\s+"
    r"(?!(?:cm|mm|m|metres?|meters?|s|seconds?|minutes?|times?|degrees?|newtons?|per)\b)[a-z][^,;.]*",
    re.IGNORECASE,
)
_PASSING = frozenset({"past", "via", "across", "along", "beyond"})
_GREETING = frozenset({"thank", "greet", "welcome"})
_RANKS = frozenset({"middle", "leftmost", "rightmost", "central"})
_ASIDE = ("subordinate", "negation", "stative")


def mentions(parts: Sequence[Token], scene: Scene) -> Iterator[tuple[Token, Token]]:
    """Where a text spells the id or the name of a thing of the map: the first and the last token of each, the longest
    names first, none in another."""
    names = scene.spelled
    parts = [t for t in parts if t.text != "-"]  # "the 8-dram vial"
    longest = max((len(n) for n in names), default=0)
    keys = [t.number if t.number is not None else t.text for t in parts]
    i = 0
    while i < len(parts):
        size = next((n for n in range(min(longest, len(parts) - i), 0, -1) if tuple(keys[i : i + n]) in names), 0)
        if size:
            yield parts[i], parts[i + size - 1]
        i += size or 1


def _free(step: LabelledStep, first: Token, last: Token) -> bool:
    return not any(s.start < last.end and first.start < s.end for s in step.spans)


def mentioned(step: LabelledStep, scene: Scene, pool: Sequence[Entity]) -> tuple[str, ...]:
    """The things of `pool` that a step names outside its keywords."""
    parts = tokens(step.text)
    names = [
        [t for t in parts if first.start <= t.start <= last.start]
        for first, last in mentions(parts, scene)
        if _free(step, first, last)
    ]
    return tuple(dict.fromkeys(e.id for n in names for e in exactly_named(n, pool)))


def unread(step: LabelledStep, scene: Scene, used: Sequence[Extent]) -> tuple[Extent, ...]:
    """Where a step names things outside its keywords and outside what was `used` beside them, and not in passing."""
    parts = tokens(step.text)
    found: list[Extent] = []
    for first, last in (*mentions(parts, scene), *_described(parts, scene)):
        extent = Extent(first.start, last.end)
        known = any(u.start < extent.end and extent.start < u.end for u in (*used, *found))
        aside = in_passing(parts, first, step, used) and not _waiting(parts, first, last, scene)
        if _free(step, first, last) and not known and not aside:
            found.append(extent)
    return tuple(sorted(found))


_SAID_TO_GO = re.compile(
    r"\b(?:it|they)\s+(?:(?:should|must|shall|can|will|has\s+to|have\s+to|needs?\s+to|is\s+to)\s+)?(?:then\s+|now\s+)?(?:goes|go|belongs?|comes?)\s+"
    r"(?:(?:back|up|down|over)\s+)?(?:on|onto|to|into|in)\s+(?P<place>(?:the\s+)?\w+(?:\s+\d+)?)\b",
    re.IGNORECASE,
)


def goes_unread(step: LabelledStep, scene: Scene) -> Iterator[Extent]:
    """Where a step says of a thing, in no keywords, that it goes to a place: "..., and it goes to 34"."""
    for m in _SAID_TO_GO.finditer(step.text):
        if any(s.start < m.end() and m.start() < s.end for s in step.spans):
            continue
        parts = tokens(step.text, *m.span("place"))
        numbers = {e.number for e in scene.places}
        if exactly_named(parts, scene.places) or parts[-1].number in numbers - {None}:
            yield Extent(*m.span())


def _waiting(parts: Sequence[Token], first: Token, last: Token, scene: Scene) -> bool:
    """Whether a place is named that is said to await something: "..., where position 24 is waiting for it"."""
    before = [t.text for t in parts if t.end <= first.start and not lexicon().is_(t.text, "articles")][-1:]
    after = [t.text for t in parts if t.start >= last.end][:2]
    named = exactly_named([t for t in parts if first.start <= t.start <= last.start], scene.places)
    return bool(named) and before == ["where"] and after[:1] == ["is"] and not _AWAITING.isdisjoint(after)


_AWAITING = frozenset(
    {"waiting", "ready", "reserved", "free", "empty", "available", "vacant", "kept", "open", "prepared"}
)
_DONE = re.compile(
    r"\b(?:after|once\s+you\s+(?:have|are\s+done))\s+(?P<verb>\w+(?:ing|ed))\b(?P<rest>[^,;.]*)", re.IGNORECASE
)


def done_before(step: LabelledStep, scene: Scene) -> Iterator[tuple[Extent, str, str]]:
    """Where a step says that a thing has been brought to a place before ("after placing object 1 on position 11"), in
    words that are no keywords; with the thing and the place."""
    for m in _DONE.finditer(step.text):
        if any(m.start() < s.end and s.start < m.end() for s in step.spans):
            continue
        named = [
            [t for t in tokens(step.text, *m.span("rest")) if first.start <= t.start <= last.start]
            for first, last in mentions(tokens(step.text, *m.span("rest")), scene)
        ]
        things = [e.id for n in named for e in exactly_named(n, scene.objects)]
        places = [e.id for n in named for e in exactly_named(n, scene.places)]
        if len(things) == len(places) == 1:
            yield Extent(*m.span()), things[0], places[0]


def restrictions(step: LabelledStep) -> tuple[Extent, ...]:
    """Where a step says how many things may be alike or together ("no two different shapes on the same level"): a
    conjunction of goals has no word for that, and must not be taken for one that has."""
    return tuple(Extent(*m.span()) for m in _RESTRICTION.finditer(step.text))


def _described(parts: Sequence[Token], scene: Scene) -> Iterator[tuple[Token, Token]]:
    """ "The green ones", "slot 2", "the second position": no names, but nothing else than things of the map."""
    lex = lexicon()
    for t in parts:
        if t.text in {"ones", "former", "latter"} or t.text in scene.colours:
            yield t, t
    for a, b in pairwise(parts):
        if a.text in {"far", "very"} and b.text in {"left", "right"}:
            yield a, b
        place = b.text in scene.generic(False) or b.text in scene.vocabulary(False)
        if (a.word and a.text in scene.generic(False) and b.digits) or (
            place and a.text in lex.ordinals.keys() | _RANKS
        ):
            yield a, b


def in_passing(
    parts: Sequence[Token], first: Token, step: LabelledStep, used: Sequence[Extent] = (), *, narrowing: bool = True
) -> bool:
    """Whether a name that begins at `first`, outside the keywords, stands where a step speaks of other things: in a
    parenthesis, in a clause of its own ("because", "which", "without"), or (`narrowing`) right behind a keyword that it
    narrows down ("position 12 on shelf level 1")."""
    lex = lexicon()
    opened = sum((t.text in {"(", "["}) - (t.text in {")", "]"}) for t in parts if t.start < first.start)
    if opened > 0:
        return True
    ends = [e for e in (*(s.end for s in step.spans), *(u.end for u in used)) if e <= first.start]
    before = [t for t in parts if max(ends, default=0) <= t.start < first.start]
    inner = bool(ends) and bool(before) and lex.is_(before[0].text, "inner")
    marks = any(t.text in _MARKS or lex.is_(t.text, "joints") for t in before)
    after = takewhile(lambda t: t.text not in _MARKS, (t for t in parts if t.start > first.start))
    told = any(lex.is_(t.text, "stative") for t in after) if not ends else False
    if [t.text for t in before[:2]] == ["back", "with"]:  # "come back with the milk"
        return False
    by = next((t.text for t in reversed(before) if not lex.is_(t.text, "articles")), "")
    if by in _PASSING or (not ends and by in _GREETING):
        return True
    later = [i for i, (a, b) in enumerate(pairwise(before)) if a.text == "after" and b.text in {"that", "this"}]
    aside = any(lex.is_(t.text, *_ASIDE) for t in (before[later[-1] + 2 :] if later else before))  # "after that, ..."
    return (narrowing and inner and not marks) or told or aside
