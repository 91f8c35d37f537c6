"""Sentences whose form says what goes where without a verb that tells anybody to put it there: "object 1 goes to
position 11", "level 1: object 2", "could I have the apple?", "its place is position 14", "fill slot 2 with crate A".
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.explained import without
from llmbt_compiler.parsing.model import Extent, LabelledStep
from llmbt_compiler.parsing.names import Found, Talk, exactly_named
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.verbs import Shape, read_verb, shape_of
from llmbt_compiler.parsing.words import Token, lemmas, lexicon, tokens

__all__ = [
    "asked_for",
    "assured",
    "filled",
    "left_free",
    "let_go",
    "listed",
    "made_free",
    "once_more",
    "place_of_its_own",
    "told_as_placing",
    "wanted_by",
]

_SHORT = 300
_SURE = r"(?:(?:please\s+)?(?:make\s+sure|ensure|see\s+to\s+it)(?:\s+that)?\s+)?"
_MODAL = r"(?:(?:should|must|will|has to|have to|needs? to|is to|are to)\s+)?"
_GOES = re.compile(
    rf"\W*{_SURE}(?P<thing>[^,;:.]{{2,80}}?)\s+(?:{_MODAL}(?:then\s+|also\s+|now\s+)?(?:go|goes|belongs?|lives?|ends?(?:\s+up)?)"
    r"|(?:should|must|will|has to|have to|needs? to|is to|are to)\s+(?:come|travel|move|return))\s+"
    r"(?:(?:back|down|up|over|out|across)\s+)*(?:on|onto|to|into|in|at)\s+"
    r"(?P<place>[^,;:.]{2,80}?)(?=\s+(?:except|apart\s+from|with\s+the\s+exception)\b|[\s.!]*$)",
    re.IGNORECASE,
)
_COLON = re.compile(
    r"^\W*(?P<thing>[^,;:.]{2,60}?)\s*(?::|->|=>|→)(?!\s*from\b)\s*(?P<place>[^,;:.()→>]{2,60}?)\s*(?:\([^()]*\))?[\s.!]*$",
    re.IGNORECASE,
)
_THERE = re.compile(
    rf"\W*(?P<thing>[^,;:.]{{2,80}}?)\s+{_MODAL}(?:also\s+)?(?:go|goes|belongs?)\s+(?P<place>there)\b(?:\s+(?:too|as\s+well|also|instead))?[\s.!]*$",
    re.IGNORECASE,
)
_BE_ON = re.compile(
    rf"\W*{_SURE}(?P<thing>[^;:.]{{2,80}}?),?\s+(?:should|must|shall|has\s+to|have\s+to|needs?\s+to|is\s+to|are\s+to|ought\s+to)"
    r"\s+(?:then\s+|now\s+)?(?:be|sit|stand|lie|rest)(?:\s+(?:lying|standing|sitting))?\s+"
    r"(?:on|in|at|inside)\s+(?P<place>[^,;:.]{2,60}?)(?:\s+(?:later|now|then|afterwards|please|instead))?[\s.!]*$",
    re.IGNORECASE,
)
_TAKES = re.compile(
    rf"\W*(?:(?:now|then)\s+)?(?P<thing>[^,;:.]{{2,60}}?)\s+{_MODAL}(?:then\s+|now\s+)?takes?\s+(?P<place>its\s+(?:place|spot|position|slot))[\s.!]*$",
    re.IGNORECASE,
)
_HEADED = re.compile(r"^\W*(?P<place>[^,;:.]{2,40}?)\s*:\s*(?P<things>[^:;]{2,200}?)[\s.!]*$")
_PART = re.compile(r"(?:^|,|&|\band\b)\s*(?P<name>(?:(?!,|&|\band\b).)+?)\s*(?=,|&|\band\b|$)")
_LEAD = re.compile(
    r"^\W*(?:(?:as|since|because)\s[^,;:.]{2,80}|[^,;:.]{2,40}\sbeing\s[^,;:.]{2,40}),\s*(?=\S)", re.IGNORECASE
)
_TITLE = re.compile(r"^\W*(?P<title>[^,;:.]{3,60}):\s*(?=\S)")
_ROBOT = re.compile(r"(?:the )?(?:robot|arm|gripper|hand|manipulator|you|we)\b", re.IGNORECASE)


def listed(step: LabelledStep, scene: Scene) -> LabelledStep | None:
    """ "Level 1: object 1, object 2": a place and, behind the colon, nothing but names of things."""
    parts = [m.span() for m in re.finditer(r"[^.;\n]*[^.;\s][^.;\n]*", step.text)]
    found = [_listed(step.text, a, b, scene) for a, b in parts]
    if not found or None in found:
        return None
    spans = [s for f in found if f is not None for s in f]
    return replace(step, spans=tuple(spans), readings=()) if len(spans) > 1 else None


def _listed(text: str, start: int, end: int, scene: Scene) -> list[KeywordSpan] | None:
    m = _HEADED.match(text[start:end])
    if m is None or len(exactly_named(tokens(m["place"]), scene.places)) != 1:
        return None
    a, b = (start + i for i in m.span("place"))
    spans = [KeywordSpan(a, b, Kind.DESTINATION, m["place"])]
    for part in _PART.finditer(m["things"]):
        a, b = (start + m.start("things") + i for i in part.span("name"))
        found = resolve_objects(tokens(text, a, b), scene, Talk({o.id: o.place for o in scene.map.objects}))
        if not isinstance(found, Found) or found.corrected:
            return None
        spans.append(KeywordSpan(a, b, Kind.TARGET, part["name"]))
    return spans


def told_as_placing(step: LabelledStep, scene: Scene) -> LabelledStep:
    """A step that says where a thing goes without telling anybody to put it there ("object 1 goes to position 11",
    "position 21 gets object 3", "object 3: position 22"): its thing as target and its place as destination."""
    text = step.text
    if len(text) > _SHORT:
        return step
    taken = {s.label for s in step.spans}
    lead = _LEAD.match(text) or _titled(step)
    for pattern in (_GOES, _BE_ON, _THERE, _TAKES, _COLON):
        m = pattern.match(text, lead.end() if lead and pattern is _GOES else 0)
        if m is None or _ROBOT.match(m["thing"]):
            continue
        named = [m.span("thing"), m.span("place")]
        if pattern is _BE_ON and not _both_known(step, scene, *named):
            continue
        if any(s.label is Kind.ACTION and any(a <= s.start < b for a, b in named) for s in step.spans):
            continue
        inner = {s.label for s in step.spans if m.start("place") <= s.start}
        if pattern is _COLON and inner >= {Kind.TARGET, Kind.DESTINATION}:
            continue
        if pattern is _COLON and (Kind.ACTION in taken or not re.search(r"\d", m["place"])):
            continue
        ends = [(m.start(k), m.end(k), label) for k, label in (("thing", Kind.TARGET), ("place", Kind.DESTINATION))]
        spans = tuple(KeywordSpan(a, b, label, text[a:b]) for a, b, label in sorted(ends, key=lambda e: e[:2]))
        return replace(step, spans=spans, readings=())
    return step


def _both_known(step: LabelledStep, scene: Scene, thing: tuple[int, int], place: tuple[int, int]) -> bool:
    things = resolve_objects(tokens(step.text, *thing), scene, Talk({o.id: o.place for o in scene.map.objects}))
    there = resolve_places(tokens(step.text, *place), scene, Talk())
    return isinstance(things, Found) and isinstance(there, Found) and not things.corrected and not there.corrected


def _titled(step: LabelledStep) -> re.Match[str] | None:
    """What a step is about, before a colon: an action and no place ("Sort all the blocks: ...")."""
    m = _TITLE.match(step.text)
    kinds = {s.label for s in step.spans if m is not None and s.start < m.end()}
    return m if Kind.ACTION in kinds and kinds <= {Kind.ACTION, Kind.TARGET} else None


_WISH = re.compile(
    r"\b(?:(?:can|could|may|might)\s+(?P<who>I|we)\s+(?:please\s+|just\s+)?(?:get|have)"
    r"|(?P<who2>I|we)(?:(?:['’]d|\s+would)\s+(?:really\s+)?(?:like|love|fancy|appreciate)|\s+(?:want|need|fancy))"
    r"(?:\s+to\s+(?:have|get))?|(?P<who3>gimme))\s+(?:\w+\s+){0,2}?$",
    re.IGNORECASE,
)
_COURTESY = re.compile(r"(?:\W|please|thanks|thank you|now|then|over here)*$", re.IGNORECASE)


_HAVE = re.compile(
    r"^\W*(?:please\s+)?(?:(?:may|can|could|might)\s+(?P<who>I|we)\s+(?:please\s+)?(?:have|get)"
    r"|let\s+(?P<who2>me|us|(?:the\s+)?\w+)\s+have)\s+(?P<things>[^,;:.?!]{2,80}?)(?:,?\s+(?:please|thanks|now))*[\s.!?]*$",
    re.IGNORECASE,
)


def _to_have(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "May I have the milk?", "let the user have the coke": somebody of the map, and things of it."""
    m = _HAVE.match(step.text) if len(step.text) <= _SHORT else None
    if m is None or len(scene.persons) != 1:
        return step
    key = "who" if m["who"] else "who2"
    who = tokens(step.text, *m.span(key))
    named = exactly_named(who, scene.persons) or any(lexicon().is_(t.text, "me", "him", "users") for t in who)
    found = resolve_objects(tokens(step.text, *m.span("things")), scene, Talk())
    if not named or not isinstance(found, Found):
        return step
    ends = ((key, Kind.DESTINATION), ("things", Kind.TARGET))
    return replace(step, spans=tuple(KeywordSpan(*m.span(k), kind, m[k]) for k, kind in ends), readings=())


def asked_for(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Could I have the apple?", "I'd like some chips": things and nothing else asked for, where the map has somebody
    to bring them to."""
    step = _to_have(step, scene)
    things = [s for s in step.spans if s.label is Kind.TARGET]
    others = [s for s in step.spans if s.label in {Kind.DESTINATION, Kind.LOCATION}]
    if not things or others or not scene.persons or len(step.text) > _SHORT:
        return step
    m = _WISH.search(step.text, 0, things[0].start)
    if m is None or not _COURTESY.match(step.text, things[-1].end):
        return step
    if any(s.label is Kind.ACTION and not m.start() <= s.start < m.end() for s in step.spans):
        return step
    a, b = next(m.span(k) for k in ("who", "who2", "who3") if m[k])
    return replace(step, spans=(KeywordSpan(a, b, Kind.DESTINATION, step.text[a:b]), *things), readings=())


_WANTS = re.compile(
    r"^\W*(?:(?:since|as|because|if)\s+)?(?:the\s+)?(?P<who>\w+)\s+(?:wants|needs|would\s+like|is\s+waiting\s+for|asked\s+for)\b",
    re.IGNORECASE,
)
_BRINGING = frozenset({"bring", "deliver", "carry", "serve", "hand", "give", "take"})


_ASKED = re.compile(
    r"^\W*(?:(?:since|as|because)\s+)?(?:the\s+)?\w+(?:\s+\w+)?\s+"
    r"(?P<what>(?:wants|wanted|needs|would\s+like|asked\s+for|asks\s+for|ordered)\b[^.;!?]{1,60}?,\s+so)\b",
    re.IGNORECASE,
)


def _for_which(step: LabelledStep) -> LabelledStep:
    """ "He asked for a snack, so deliver the chips": what was asked for is a reason where the order names a thing."""
    m = _ASKED.match(step.text)
    own = [s for s in step.spans if m is not None and s.label is Kind.TARGET and s.start >= m.end()]
    if m is None or not own or all(lexicon().is_(s.text.casefold(), "pronouns") for s in own):
        return step
    led = any(s.label is Kind.DESTINATION and s.start >= m.end() for s in step.spans)
    return without(step, Extent(*m.span() if led else m.span("what")))


def wanted_by(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "The user wants the coke, so bring it over": to the user, where no other place is named."""
    return _for_which(_to_whom(step, scene))


def _to_whom(step: LabelledStep, scene: Scene) -> LabelledStep:
    m = _WANTS.match(step.text) if len(step.text) <= _SHORT else None
    acts = [s for s in step.spans if s.label is Kind.ACTION]
    if m is None or len(acts) != 1 or not any(w in _BRINGING for w in lemmas(acts[0].text.casefold())):
        return step
    named = exactly_named(tokens(step.text, *m.span("who")), scene.persons)
    placed = any(s.label in {Kind.DESTINATION, Kind.LOCATION} for s in step.spans)
    if len(named) != 1 or placed or acts[0].start < m.end():
        return step
    who = KeywordSpan(*m.span("who"), Kind.DESTINATION, m["who"])
    return replace(step, spans=(who, *step.spans), readings=())


_OWN = re.compile(
    r"(?:\b(?P<its>its|their)|['’]s)\s+(?!current|present|original|initial|old)(?:(?:final|new|target|own)\s+)?"
    r"(?:place|spot|position|destination|slot|location|home)\s+(?:is|will be|should be|shall be)\s+"
    r"(?:(?:on|at|in)\s+)?(?:the\s+)?",
    re.IGNORECASE,
)


def place_of_its_own(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Pick up object 1; its place is position 14", "object 4's spot is position 14": where it is to go."""
    m = _OWN.search(step.text) if len(step.text) <= _SHORT else None
    told = [s for s in step.spans if s.label is Kind.DESTINATION and s.text.casefold() not in {"there", "here"}]
    if m is None or any(s.start < m.end() for s in told):
        return step
    parts = tokens(step.text, m.end())
    sizes = (n for n in range(min(len(parts), 6), 0, -1) if len(exactly_named(parts[:n], scene.places)) == 1)
    size = next(sizes, 0)
    if not size:
        return step
    a, b = parts[0].start, parts[size - 1].end
    spans = [s for s in step.spans if s.end <= a or b <= s.start]
    spans.append(KeywordSpan(a, b, Kind.DESTINATION, step.text[a:b]))
    if m["its"] and not any(s.label is Kind.TARGET and s.end <= m.start() for s in spans):
        spans.append(KeywordSpan(*m.span("its"), Kind.TARGET, m["its"]))
    return replace(step, spans=tuple(sorted(spans, key=lambda s: s.start)), readings=())


_ASSURED = re.compile(r"\b(?:make\s+sure|ensure|see\s+to\s+it)(?:\s+that)?\s+(?:the\s+)?[`'\"*]*$", re.IGNORECASE)
_IS_DONE = re.compile(
    r"[`'\"*]*\s+(?:is|are|gets?|be|will\s+be)\s+(?P<done>\w+ed|put|set|brought|laid)\b(?:\s+\w+ly)?"
    r"(?P<to>\s+(?:back\s+)?(?:on|onto|to|into|in|inside|at)\s+(?:the\s+)?[`'\"*]*)?",
    re.IGNORECASE,
)


_GOES_SAID = frozenset({"goes", "go", "ends", "end", "belongs", "belong", "comes", "come"})


def assured(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Ensure that parcel 18 is placed in A4", "make sure slot A2 gets emptied": what is to be done is an order."""
    for thing, verb_of in zip(step.spans, step.spans[1:], strict=False):
        lead = _ASSURED.search(step.text[: thing.start])
        goes = verb_of.text.casefold() in _GOES_SAID and not step.text[thing.end : verb_of.start].strip(" `*\"'")
        if thing.label is Kind.TARGET and verb_of.label is Kind.ACTION and lead is not None and goes:
            return replace(step, spans=tuple(s for s in step.spans if not lead.start() <= s.start < thing.start))
    for thing in (s for s in step.spans if s.label is Kind.TARGET):
        lead, m = _ASSURED.search(step.text[: thing.start]), _IS_DONE.match(step.text, thing.end)
        if lead is None or m is None:
            continue
        verb = read_verb(m["done"].casefold(), (), scene.library)
        shapes = {shape_of(t, scene.library) for t in verb.templates[:1]}
        parts = tokens(step.text, m.end()) if m["to"] else ()
        sizes = (n for n in range(min(len(parts), 6), 0, -1) if len(exactly_named(parts[:n], scene.places)) == 1)
        size = next(sizes, 0)
        if verb.corrected or not (shapes == {Shape.FREE} or (shapes == {Shape.PLACE} and size)):
            continue
        spans = [s for s in step.spans if not (lead.start() <= s.start < thing.start and s.label is Kind.ACTION)]
        spans = [s for s in spans if s.end <= thing.end or s.start >= m.end("done")]
        spans.append(KeywordSpan(*m.span("done"), Kind.ACTION, m["done"]))
        if size and shapes == {Shape.PLACE}:
            a, b = parts[0].start, parts[size - 1].end
            spans = [s for s in spans if s.end <= a or b <= s.start]
            spans.append(KeywordSpan(a, b, Kind.DESTINATION, step.text[a:b]))
        return replace(step, spans=tuple(sorted(spans, key=lambda s: s.start)), readings=())
    return step


_FILLING = frozenset(
    {"fill", "load", "stock", "occupy", "supply", "populate", "equip", "provide", "present", "furnish"}
)


_FILLED = re.compile(r"\s+(?P<place>[^,;:.!?]{2,60}?)\s+with\s+(?:the\s+)?(?P<thing>[^,;:.!?]{1,60})", re.IGNORECASE)


_LEFT_FREE = re.compile(
    r"\w+\s+(?:(?:that|which)\s+)?(?:it|this|that)\s+(?:leaves|left|has\s+left|vacates|vacated|frees|freed)"
    r"(?:\s+(?:behind|empty|free|vacant))?\b|"
    r"(?:(?:now\s+|newly\s+)?(?:vacated|emptied|freed|empty|vacant|free)\s+\w+"
    r"|\w+\s+(?:that|which)\s+(?:(?:this|that|it)\s+)?(?:leaves|left|has\s+(?:become|been\s+left)|became|is\s+(?:now|left))\s+"
    r"(?:empty|free|vacant))\b",
    re.IGNORECASE,
)


def left_free(step: LabelledStep) -> LabelledStep:
    """ "In the position that has become free": the destination with the words that tell which it is."""

    def whole(s: KeywordSpan) -> KeywordSpan:
        m = _LEFT_FREE.match(step.text, s.start) if s.label is Kind.DESTINATION else None
        if m is None or m.end() <= s.end or any(s.end <= o.start < m.end() for o in step.spans):
            return s
        return replace(s, end=m.end(), text=step.text[s.start : m.end()])

    return replace(step, spans=tuple(whole(s) for s in step.spans))


def filled(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Fill slot 2 with crate A", "fill the vacated slot with it": the place is no target, and what follows "with"
    is."""
    places = [t for t in scene.library.templates.values() if shape_of(t, scene.library) is Shape.PLACE and t.verbs]
    for verb in step.spans if places else ():
        fills = verb.label is Kind.ACTION and any(w in _FILLING for w in lemmas(verb.text.casefold()))
        m = _FILLED.match(step.text, verb.end) if fills else None
        if m is None or not _holds(tokens(step.text, *m.span("place")), scene):
            continue
        inside = [s for s in step.spans if m.start() <= s.start < m.end()]
        if any(s.label is Kind.ACTION for s in inside):
            continue
        kept = [s for s in step.spans if s is not verb and s not in inside]
        put = min(places, key=lambda t: "_" in t.name).verbs[0]
        kept += [replace(verb, text=str(put)), *(KeywordSpan(*m.span(k), kind, m[k]) for k, kind in _INTO)]
        return replace(step, spans=tuple(sorted(kept, key=lambda s: s.start)), readings=())
    return step


_INTO = (("place", Kind.DESTINATION), ("thing", Kind.TARGET))


def _holds(parts: Sequence[Token], scene: Scene) -> bool:
    """Whether words name a place, or describe one by its noun ("the vacated slot"); "the cup" is filled otherwise."""
    said = " ".join(t.text for t in parts)
    if len(exactly_named(parts, scene.places)) == 1:
        return True
    own = any(lexicon().is_(t.text, "back_to") or t.text in {"its", "their"} for t in parts)
    if own or all(lexicon().is_(t.text, "articles", "vacant") or t.text in lexicon().places for t in parts):
        return False  # whose it was, or which of them, the thing that comes there does not tell
    if any(_LEFT_FREE.fullmatch(text) for text in (said, said.removeprefix("the "))):
        return True
    place = resolve_places(parts, scene, Talk())
    known = isinstance(place, Found) and not place.corrected
    nouns = any(t.text in lexicon().places for t in parts)
    return (known or nouns) and not isinstance(resolve_objects(parts, scene, Talk()), Found)


_MADE = re.compile(
    r"\b(?P<verb>make|set|get)\s+(?:the\s+)?(?P<place>[^,;:.]{2,40}?)\s+(?:free|empty|available|vacant)\b(?!\s+for)",
    re.IGNORECASE,
)


_ROOM = re.compile(
    r"\b(?P<verb>make|create|get)\s+(?:some\s+)?(?:room|space)\s+(?:on|in|at)\s+(?:the\s+)?(?P<place>[^,;:.]{2,40}?)(?=\s*[.!]?\s*$)",
    re.IGNORECASE,
)


def made_free(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Make slot A2 free" clears it, where the library can."""
    m = (_MADE.search(step.text) or _ROOM.search(step.text)) if len(step.text) <= _SHORT else None
    if m is None or len(exactly_named(tokens(step.text, *m.span("place")), scene.places)) != 1:
        return step
    frees = [t for t in scene.library.templates.values() if shape_of(t, scene.library) is Shape.FREE and t.verbs]
    if not frees:
        return step
    kept = [s for s in step.spans if s.end <= m.start() or m.end() <= s.start]
    kept.append(KeywordSpan(*m.span("verb"), Kind.ACTION, str(frees[0].verbs[0])))
    kept.append(KeywordSpan(*m.span("place"), Kind.TARGET, m["place"]))
    return replace(step, spans=tuple(sorted(kept, key=lambda s: s.start)), readings=())


_LET_GO = re.compile(r"\b(?P<let>let)(?:\s+(?:it|them|the\s+\w+))?\s+go\b", re.IGNORECASE)


def let_go(step: LabelledStep) -> LabelledStep:
    """ "... and let go" is an action, whether or not it was labelled."""
    m = _LET_GO.search(step.text) if len(step.text) <= _SHORT else None
    if m is None or any(s.start <= m.start("let") < s.end for s in step.spans):
        return step
    free = {"not", "never", "dont", "without"}.isdisjoint(t.text for t in tokens(step.text, 0, m.start())[-3:])
    conditional = any(lexicon().is_(t.text, "conditional", "subordinate") for t in tokens(step.text, 0, m.start())[-4:])
    if not free or conditional:
        return step
    spans = sorted((*step.spans, KeywordSpan(*m.span("let"), Kind.ACTION, m["let"])), key=lambda s: s.start)
    return replace(step, spans=tuple(spans), readings=())


_DO = r"(?:perform|do|carry\s+out|execute|follow|apply|use|go\s+through|run\s+through|take|complete|repeat)"
_STEPS = (
    r"(?:actions?|steps?|procedures?|process|operations?|sequence|routine|moves?|thing|approach|treatment|pattern|rule)"
)
_AGAIN = tuple(
    re.compile(
        pattern + r"(?P<things>[^,;:.!?]{2,80}?)(?:,?\s+(?:again|too|as\s+well|also|now|please|likewise))*[\s.!]*$",
        re.IGNORECASE,
    )
    for pattern in (
        rf"\b(?P<verb>{_DO})\s+(?:exactly\s+)?(?:(?:these|those|this|that|the|all)\s+)*(?:same\s+|above\s+|previous\s+)*{_STEPS}\s+"
        r"(?:again\s+|once\s+more\s+|over\s+)?(?:for|with|on|to)\s+",
        rf"^\W*(?:and\s+)?(?P<verb>that|this|the\s+same|it|likewise|(?:the\s+)?same\s+{_STEPS})\s+(?:also\s+)?(?:goes|applies|holds|is\s+(?:true|valid)|counts)\s+"
        r"(?:again\s+)?(?:for|to|with)\s+",
    )
)
_ALIKE = re.compile(
    r"^\W*(?:and\s+)?(?:please\s+)?(?P<verb>handle|treat|process|deal\s+with|proceed\s+with)\s+(?P<things>[^,;:.!?]{2,80}?)\s+"
    r"(?:in\s+)?(?:(?:exactly\s+)?the\s+same(?:\s+(?:way|manner|fashion))?|likewise|similarly|accordingly|identically|this\s+way)[\s.!]*$",
    re.IGNORECASE,
)


def once_more(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Perform these actions again for the coke", "that goes for the blue cup", "treat object 4 the same way"."""
    for pattern in (*_AGAIN, _ALIKE):
        m = pattern.search(step.text) if len(step.text) <= _SHORT else None
        if m is None or any(lexicon().is_(t.text, "negation", "conditional") for t in tokens(step.text, 0, m.end())):
            continue
        found = resolve_objects(
            tokens(step.text, *m.span("things")), scene, Talk({o.id: o.place for o in scene.map.objects})
        )
        if found.corrected if isinstance(found, Found) else found.code != "E304":
            continue  # "the other yellow block": which, what was done before tells
        spans = (
            KeywordSpan(*m.span("verb"), Kind.ACTION, "repeat"),
            KeywordSpan(*m.span("things"), Kind.TARGET, m["things"]),
        )
        return replace(step, spans=spans, readings=())
    return step
