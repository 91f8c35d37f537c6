"""Frames around an order that the tagger does not know: passives ("both blocks shall be moved to level 1"), reasons
("object 1 has to sleep at position 31, so put it there"), tables, names that say the same again ("the metal box, i.e.
crate C"), and "one in each free position".
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.explained import without
from llmbt_compiler.parsing.model import Extent, LabelledStep
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Found, Talk, exactly_named
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.verbs import Shape, read_verb, shape_of
from llmbt_compiler.parsing.words import Token, lemmas, lexicon, tokens

__all__ = ["among", "as_before", "contrasted", "one_each", "passive", "renamed", "so_there", "tabled", "trimmed"]

_SHORT = 300
_NOT = ("negation", "conditional", "except")


def _things(parts: Sequence[Token], scene: Scene) -> Found | None:
    """What these words mean by themselves, spelled right and nothing chosen."""
    if not parts or not (parts[-1].word or parts[-1].number is not None):
        return None
    found = resolve_objects(parts, scene, Talk({o.id: o.place for o in scene.map.objects}))
    return found if isinstance(found, Found) and not found.corrected and not found.chosen else None


def _place(parts: Sequence[Token], scene: Scene) -> str | None:
    found = resolve_places(parts, scene, Talk()) if parts else None
    one = isinstance(found, Found) and len(found.ids) == 1 and not found.corrected and not found.vague
    return found.ids[0] if one and isinstance(found, Found) and found.ids[0] not in {ANYWHERE, ORIGIN} else None


def _instead_of(step: LabelledStep, start: int, end: int, *spans: KeywordSpan) -> LabelledStep:
    """The step with these keywords in place of all that lie between two offsets."""
    kept = [s for s in step.spans if s.end <= start or end <= s.start]
    return replace(step, spans=tuple(sorted((*kept, *spans), key=lambda s: s.start)))


# --- passives -------------------------------------------------------------------------------------------------------

_CHAIN = frozenset({
    "shall", "should", "must", "will", "may", "can", "could", "would", "has", "have", "had", "needs", "need", "is",
    "are", "to", "be", "get", "gets", "being", "then", "also", "now", "both", "all", "next", "finally", "please",
    "ought", "wants", "afterwards", "kindly", "therefore", "each", "first",
})  # fmt: skip
_BE = frozenset({"be", "get", "gets"})
_WISHING = frozenset({
    "want", "wish", "desire", "ask", "request", "demand", "insist", "like", "need", "order", "command", "prefer",
    "propose", "suggest", "recommend", "require", "see", "have", "decide", "instruct", "advise", "expect",
})  # fmt: skip
_DONE = frozenset({"left", "put", "set", "brought", "sent", "laid", "taken", "swept", "stood", "given"})
_BREAK = frozenset(
    {
        ",",
        ";",
        ":",
        ".",
        "that",
        "and",
        "then",
        "so",
        "there",
        "therefore",
        "-",
        "\u2013",
        "\u2014",
        "(",
        "please",
        "kindly",
    }
)
_LONGEST = 14


def passive(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Both blocks shall be moved to level 1", "all cups get put on the bar", "I desire that the cup be taken away",
    "to see the newspaper conveyed to the table": thing and verb, where the tagger saw them otherwise."""
    line = tokens(step.text)
    for j, t in enumerate(line if len(step.text) <= _SHORT else ()):
        if not t.text.endswith(("ed", "en")) and t.text not in _DONE:
            continue
        k = j
        while k and line[k - 1].text in _CHAIN:
            k -= 1
        wished = k == j and _wishes(line[:k])
        if not wished and _BE.isdisjoint(w.text for w in line[k:j]):
            continue
        if line[k - 1].text == "," and k > 1:
            k -= 1
        thing = _before(line, k, step, scene)
        verb = read_verb(t.text, (), scene.library) if thing is not None else None
        if thing is None or verb is None or not verb.templates or verb.corrected or not _ordered(line, thing):
            continue
        start, end = line[thing].start, line[k - 1].end if line[k - 1].text != "," else line[k - 2].end
        inside = [s for s in step.spans if s.start < t.end and start < s.end]
        told = [s.label for s in inside] == [Kind.TARGET, Kind.ACTION] and inside[1].start == t.start
        if told and inside[0].end <= t.start and not wished:
            continue
        begin = max((w.end for w in line[:thing] if w.text in {".", ";", ":"}), default=0)
        lead = any(w.text == "that" for w in line[:thing]) or wished
        target = KeywordSpan(start, end, Kind.TARGET, step.text[start:end])
        action = KeywordSpan(t.start, t.end, Kind.ACTION, t.text)
        step = _instead_of(step, begin if lead else start, t.end, target, action)
    return step


def _wishes(words: Sequence[Token]) -> bool:
    return any(w in _WISHING for t in words for w in lemmas(t.text))


def _before(line: Sequence[Token], k: int, step: LabelledStep, scene: Scene) -> int | None:
    """Where the thing begins that ends right before token `k`: what the tagger took for one, or the longest noun phrase
    behind a mark or a conjunction that names things."""
    end = line[k - 1].start if k and line[k - 1].text == "," else line[k].start
    for s in step.spans:
        if s.label is not Kind.TARGET or s.end > end or step.text[s.end : end].strip(" ,`*\"'"):
            continue
        first = next((i for i, t in enumerate(line) if t.start >= s.start), 0)
        if _things(tokens(step.text, s.start, s.end), scene) is not None:
            while (
                first
                and lexicon().is_(line[first - 1].text, "articles", "all", "both")
                and line[first - 1].text != "that"
            ):
                first -= 1
            return first
    stop = k - 1 if k and line[k - 1].text == "," else k
    for i in range(max(0, stop - _LONGEST), stop):
        heads = i == 0 or line[i - 1].text in _BREAK or any(w in _WISHING for w in lemmas(line[i - 1].text))
        if heads and _things(line[i:stop], scene) is not None:
            return i
    return None


def _ordered(line: Sequence[Token], thing: int) -> bool:
    """Whether what stands before the thing leaves it an order: no condition, and "that" only behind a wish."""
    begin = max((i + 1 for i in range(thing) if line[i].text in {".", ";", ":"}), default=0)
    lead = line[begin:thing]
    lex = lexicon()
    if any(
        lex.is_(t.text, *_NOT) or t.text in {"when", "once", "after", "before", "until", "because", "whether"}
        for t in lead
    ):
        polite = any(a.text == "if" and b.text in {"you", "we"} for a, b in pairwise(lead))
        if not polite:
            return False
    return all(t.text != "that" for t in lead) or _wishes(lead)


# --- reasons --------------------------------------------------------------------------------------------------------

_SO = re.compile(
    r"\s*(?:[,;.]|\s[-\u2013\u2014])\s*(?:and\s+)?(?:so|then|hence|therefore|thus)?,?\s*(?:please|just|kindly|now)?\s*"
    r"(?P<verb>[a-z]+)\s+(?P<it>it|them)\s+(?:(?:right|over|up|down|back|in|on)\s+)?there\b",
    re.IGNORECASE,
)
_TAIL = frozenset(
    {"tonight", "today", "now", "too", "again", "please", "tomorrow", "best", "instead", "later", "anyway"}
)
_PAST = frozenset({"was", "were", "stood", "had", "came", "nothing", "no", "cannot", "cant"})


def so_there(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "The ball has to sleep at position 31, so put it there": whatever is said of a thing and a place."""
    m = _SO.search(step.text) if len(step.text) <= _SHORT else None
    lead = tokens(step.text, 0, m.start()) if m is not None else ()
    if m is None or len(lead) < 3:
        return step
    verb = read_verb(m["verb"].casefold(), (), scene.library)
    placing = any(shape_of(t, scene.library) is Shape.PLACE for t in verb.templates)
    lex = lexicon()
    if not placing or verb.is_("leaving") or any(lex.is_(t.text, *_NOT) or t.text in _PAST for t in lead):
        return step
    sizes = [n for n in range(len(lead) - 1, 0, -1) if lead[n].word and _things(lead[:n], scene) is not None]
    last = len(lead)
    while last > 1 and lead[last - 1].text in _TAIL:
        last -= 1
    begins = [b for b in range(max(0, last - 6), last) if _place(lead[b:last], scene) is not None]
    thing, place = (0, 0), (0, 0)
    if sizes and begins and begins[0] > sizes[0]:
        thing, place = (lead[0].start, lead[sizes[0] - 1].end), (lead[begins[0]].start, lead[last - 1].end)
    else:  # "position 31 is reserved for the red block, so put it there"
        at = next((i for i, t in enumerate(lead) if t.text == "for" and i), 0)
        ends = [n for n in range(at, 0, -1) if _place(lead[:n], scene) is not None] if at else []
        if not ends or _things(lead[at + 1 : last], scene) is None:
            return step
        thing, place = (lead[at + 1].start, lead[last - 1].end), (lead[0].start, lead[ends[0] - 1].end)
    spans = [
        KeywordSpan(*e, kind, step.text[e[0] : e[1]]) for e, kind in ((thing, Kind.TARGET), (place, Kind.DESTINATION))
    ]
    spans.append(KeywordSpan(*m.span("verb"), Kind.ACTION, m["verb"]))
    return _instead_of(step, 0, m.end(), *sorted(spans, key=lambda s: s.start))


# --- tables ---------------------------------------------------------------------------------------------------------

_ROWS = re.compile(r"^(?P<head>[^:|]{2,60}:\s*)?(?P<rows>[^:]+)$", re.DOTALL)
_CELLS = re.compile(
    r"\s*(?:[-*\u2022]\s+|and\s+|then\s+)*\|?\s*(?P<thing>[^|]{1,40}?)\s*"
    r"(?:\||->|=>|\u2192|\s(?:(?:goes|go|should\s+go|belongs|comes)\s+)?(?:in|on|at|to|into|onto)\s)\s*"
    r"(?P<place>[^|]{1,40}?)\s*\|?\s*",
    re.IGNORECASE,
)
_COMMA = re.compile(r",\s*(?:and\s+)?|\s+and\s+", re.IGNORECASE)
_ONE_OF = re.compile(
    r"(?:the\s+)?(?:one|former|latter|other)|the\s+\w+\s+one|the\s+(?:first|second|third)", re.IGNORECASE
)


def tabled(step: LabelledStep, scene: Scene) -> LabelledStep | None:
    """ "As in this table: object 3 | position 14; object 5 | position 24", "load these in turn: object 2 in position
    13, object 4 in 14", "take the milk and the coke: the former to the desk, the latter to the bar": rows of a thing
    and a place each; None for anything else."""
    m = _ROWS.match(step.text.strip(" .!")) if len(step.text) <= _SHORT else None
    at = len(step.text) - len(step.text.lstrip(" .!"))
    if m is None or not (m["head"] or "|" in m["rows"]):
        return None
    begin = at + m.start("rows")
    said = [s for s in step.spans if s.label is Kind.TARGET and s.end <= begin and not _points(s)]
    several = [s for s in said if _things(tokens(step.text, s.start, s.end), scene) is not None]
    if any(lexicon().is_(t.text, *_NOT) for t in tokens(m["head"] or "")):
        return None
    mark = next((re.compile(k) for k in (";", "\n") if k in m["rows"]), _COMMA)
    spans: list[KeywordSpan] = []
    noun: tuple[Token, ...] = ()
    edges = [begin, *(begin + e for c in mark.finditer(m["rows"]) for e in c.span()), begin + len(m["rows"])]
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        cells = _CELLS.fullmatch(step.text, start, end)
        if cells is None:
            return None
        thing, place = cells.span("thing"), cells.span("place")
        parts = tokens(step.text, *place)
        short = len(parts) == 1 and parts[0].digits
        noun = noun if short else parts[:-1]
        known = _ONE_OF.fullmatch(cells["thing"]) if several else _things(tokens(step.text, *thing), scene)
        if not known or _place((*noun, *parts) if short else parts, scene) is None:
            return None
        spans.append(KeywordSpan(*thing, Kind.TARGET, step.text[thing[0] : thing[1]]))
        spans.append(KeywordSpan(*place, Kind.DESTINATION, step.text[place[0] : place[1]]))
    if len(spans) < 3:
        return None
    if several:
        return replace(step, spans=(*(s for s in step.spans if s.end <= begin), *spans), readings=())
    around = exactly_named(tokens(m["head"] or "")[:-1], scene.places)  # "rack A: parcel 17 in slot A3, ..."
    ends = [_place(tokens(s.text), scene) for s in spans if s.label is Kind.DESTINATION]
    if around and not all(scene.within(p, around[0].id) for p in ends):
        return None
    return replace(without(step, Extent(0, begin)) if around else step, spans=tuple(spans), readings=())


def _points(span: KeywordSpan) -> bool:
    return lexicon().is_(span.text.casefold(), "pronouns", "plural_pronouns")


# --- the same again -------------------------------------------------------------------------------------------------

_AGAIN = re.compile(
    r"\s*[,(\u2013\u2014-]?\s*\b(?P<link>i\.\s?e\.?|ie|that\s+is(?:\s+to\s+say)?|in\s+other\s+words|namely|viz\.?|aka|"
    r"also\s+known\s+as|meaning|I\s+mean|or\s+rather)(?:,|:)?\s+(?P<name>(?:the\s+)?[^,;:.()\u2013\u2014]{1,40}?)\s*(?P<close>[,)\u2013\u2014]|(?=[.;:!]|$))",
    re.IGNORECASE,
)


_APPOSED = re.compile(
    r"(?:\s+next\s+in\s+(?:line|number|order|sequence|the\s+row))?\s*,\s*(?P<name>(?:the\s+)?[^,;:.()\u2013\u2014]{1,40}?)\s*"
    r"(?P<close>,(?!\s*and\b)|(?=[.;:!]|$)|(?=\s(?:on|onto|to|into|in|at)\s))",
    re.IGNORECASE,
)


def _apposed(step: LabelledStep, scene: Scene) -> re.Match[str] | None:
    """ "The next green block, object 2": a name of its own behind what may be said of it."""
    for s in step.spans if len(step.text) <= _SHORT else ():
        m = _APPOSED.match(step.text, s.end) if s.label in {Kind.TARGET, Kind.DESTINATION} else None
        if m is None:
            continue
        movable = s.label is Kind.TARGET
        said, name = tokens(step.text, s.start, s.end), tokens(step.text, *m.span("name"))
        taken = [o for o in step.spans if m.start("name") <= o.start < m.end("name")]
        alike = all(o.label is s.label for o in taken)
        numbered = bool(name) and name[-1].number is not None and not any(t.number is not None for t in said)
        if alike and numbered and len(exactly_named(name, scene.pool(movable))) == 1 and len(said) < 6:
            return m
    return None


def renamed(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "The metal box, i.e. crate C,": the second name is the one that counts, where the first may be said of it."""
    m = _AGAIN.search(step.text) if len(step.text) <= _SHORT else None
    m = m or _apposed(step, scene)
    before = max((s for s in step.spans if m is not None and s.end <= m.start()), key=lambda s: s.end, default=None)
    if m is None or before is None or before.label is Kind.ACTION or step.text[before.end : m.start()].strip(" `*"):
        return step
    movable = before.label is Kind.TARGET
    name = tokens(step.text, *m.span("name"))
    named = exactly_named(name, scene.pool(movable))
    if len(named) != 1:
        return step
    said = tokens(step.text, before.start, before.end)
    resolve = resolve_objects if movable else resolve_places
    found = resolve(said, scene, Talk())
    able = found.ids if isinstance(found, Found) else found.candidates
    if isinstance(found, Found) and found.chosen and all(scene.fits(named[0], w) for w in found.words):
        able = (named[0].id,)  # "the next green block, object 2"
    colours = {t.text for t in said} & scene.colours
    if (able and named[0].id not in able) or not colours <= named[0].words:
        return step
    a, b = m.span("name")
    step = _instead_of(step, before.start, b, replace(before, start=a, end=b, text=m["name"]))
    text = (
        step.text[: before.start]
        + " " * (a - before.start)
        + step.text[a:b]
        + " " * (m.end() - b)
        + step.text[m.end() :]
    )
    return replace(step, text=text)


# --- several things -------------------------------------------------------------------------------------------------

_AMONG = re.compile(
    r"^\W*(?:there\s+are\s+(?P<there>[^,;:.]{2,50})[,;.]\s|(?:out\s+)?(?:of|from|among|amongst|between)\s+(?:all\s+)?(?P<set>(?:the|these|those)\s+[^,;:.]{2,50}),\s)",
    re.IGNORECASE,
)


def among(step: LabelledStep, scene: Scene) -> tuple[tuple[str, ...], Extent] | None:
    """ "Of the two balls, place the smaller one ...": what is chosen from, and where that is said."""
    m = _AMONG.match(step.text) if len(step.text) <= _SHORT else None
    found = _things(tokens(step.text, *m.span("there" if m["there"] else "set")), scene) if m is not None else None
    return (found.ids, Extent(0, m.end())) if m is not None and found is not None and len(found.ids) > 1 else None


_CONTRAST = re.compile(
    r"\s*,?\s*(?P<link>but|and|while|whereas|yet)\s+(?P<thing>[^,;:.]{2,50}?)\s+(?:(?:goes|go|belongs?)\s+)?(?P<to>to|onto|into|on|in|at)\s+(?P<place>[^,;:.]{2,40}?)"
    r"(?=\s*(?:[,;.!]|$))",
    re.IGNORECASE,
)


def contrasted(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "The apple to the side table, but the chips to the bar": another thing and its place behind a place."""
    for s in step.spans if len(step.text) <= _SHORT else ():
        m = _CONTRAST.match(step.text, s.end) if s.label is Kind.DESTINATION else None
        if m is None or (m["link"].casefold() == "and" and m["to"].casefold() in {"on", "in", "at"}):
            continue
        spans = tuple(
            KeywordSpan(*m.span(k), kind, m[k]) for k, kind in (("thing", Kind.TARGET), ("place", Kind.DESTINATION))
        )
        inside = [o.label for o in step.spans if m.start("thing") <= o.start < m.end()]
        known = _things(tokens(step.text, *m.span("thing")), scene) is not None
        if Kind.ACTION in inside or inside == [Kind.TARGET, Kind.DESTINATION] or not known:
            continue
        if _place(tokens(step.text, *m.span("place")), scene) is not None:
            return _instead_of(step, m.start("thing"), m.end(), *spans)
    return step


_AS_BEFORE = re.compile(
    r"^\W*(?:(?:and|also|finally)\s+)?(?:the\s+same|that|this|likewise)\s+(?:also\s+)?"
    r"(?P<goes>goes|applies|holds|counts|is\s+true|is\s+valid)(?:\s+true)?\s+(?:for|to|of)\s+"
    r"(?P<things>[^;:.!?]{2,60}?)(?:,?\s+(?:as\s+well|too|also|please))*[\s.!]*$",
    re.IGNORECASE,
)


def as_before(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "That goes for the blue cup as well": the same again."""
    m = _AS_BEFORE.match(step.text) if len(step.text) <= _SHORT else None
    if m is None or _things(tokens(step.text, *m.span("things")), scene) is None:
        return step
    a, b = m.span("things")
    spans = (KeywordSpan(*m.span("goes"), Kind.ACTION, "repeat"), KeywordSpan(a, b, Kind.TARGET, m["things"]))
    return replace(step, spans=spans, readings=())


# --- words that say nothing -----------------------------------------------------------------------------------------

_ONE_EACH = re.compile(
    r",?\s*\b(?:one|each|1)\s+(?:(?:each\s+)?(?:in|on|at|to|into|onto)\s+(?:each|every|an?|its\s+own|the|one)|per|for\s+each)\s+"
    r"(?:(?:free|empty|available|vacant|separate|different|own|single)\s+)*(?:position|slot|spot|place)\b(?:\s+there)?",
    re.IGNORECASE,
)


_ALL_OF_THEM = re.compile(r",\s*(?:both|all(?:\s+\w+)?)\s+of\s+(?:them|these|those)\s*,", re.IGNORECASE)


_IN_ORDER = re.compile(
    r"\b(?P<first>first),?\s+(?:and|then)\s+(?:then\s+)?[^,;:.]{2,40}?\s(?P<then>after(?:\s+(?:it|that))?|afterwards|second|next)[\s.!]*$",
    re.IGNORECASE,
)


def one_each(step: LabelledStep) -> LabelledStep:
    """ "Put the two balls on level 1, one in each free position": how places are filled anyway."""
    all_ = _ALL_OF_THEM.search(step.text) if len(step.text) <= _SHORT else None
    if all_ is not None and any(s.label is Kind.TARGET and s.end == all_.start() for s in step.spans):
        step = without(step, Extent(*all_.span()))
    order = _IN_ORDER.search(step.text) if len(step.text) <= _SHORT else None
    for key in ("first", "then") if order is not None else ():
        step = without(step, Extent(*order.span(key))) if order is not None else step
    m = _ONE_EACH.search(step.text) if len(step.text) <= _SHORT else None
    if m is None or not any(s.label is Kind.DESTINATION and s.end <= m.start() for s in step.spans):
        return step
    return without(step, Extent(*m.span()))


def trimmed(step: LabelledStep) -> LabelledStep:
    """ "The coke and the red cup both on the table": a target without the "both" behind its name."""

    def trim(s: KeywordSpan) -> KeywordSpan:
        parts = tokens(step.text, s.start, s.end) if s.label is Kind.TARGET else ()
        if len(parts) < 2 or parts[-1].text not in {"both", "each", "too", "likewise"}:
            return s
        return replace(s, end=parts[-2].end, text=step.text[s.start : parts[-2].end])

    return replace(step, spans=tuple(trim(s) for s in step.spans))
