"""Orders told as wishes or duties of the thing: "I'd like the drum to end up on the pallet", "the two cylinders have to
come down to level 1", "this block belongs on level 2, so put it there", "for object 3, use position 23"."""

from __future__ import annotations

import re
from dataclasses import replace

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.model import LabelledStep
from llmbt_compiler.parsing.names import Fault, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.verbs import read_verb
from llmbt_compiler.parsing.words import lexicon, tokens

__all__ = ["wished"]

_SHORT = 300
_ON = r"(?:back\s+|up\s+|down\s+|over\s+|out\s+|away\s+)*(?P<on>on|onto|to|into|in|inside|at|upon)\s+"
_THING = r"(?P<thing>(?:(?!\b(?:not|never|if|unless)\b)[^,;:.]){2,80}?)"
_PLACE = r"(?P<place>[^,;:.]{1,60}?)"
_END = (
    r"(?:,?\s+(?:please|thanks|now|tonight|today|eventually|in\s+the\s+end|at\s+the\s+end|from\s+now\s+on))*[\s.!?]*$"
)
_ADVERB = (
    r"(?:(?:both|all|each|also|now|then|next|really|definitely|still|ideally|finally|please|only|just|therefore)\s+)*"
)
_BEING = (
    r"(?:be|end\s+up|wind\s+up|land|go|come|move|travel|head|live|sleep|sit|stand|rest|reside|lie|get|belong|find\s+(?:its|their)"
    r"\s+(?:place|way|home))"
)
_MODAL = (
    r"(?:should|shall|must|ought\s+to|(?:has|have)\s+(?:got\s+)?to|needs?\s+to|wants?\s+to|(?:is|are)\s+(?:supposed\s+|meant\s+|due\s+|"
    r"intended\s+|going\s+)?to|will\s+have\s+to|would\s+like\s+to|would\s+(?:best|better)|deserves?\s+to|had\s+better)"
)
_WANT = (
    r"(?:(?:I|we|he|she|they|(?:the\s+|our\s+|my\s+)?\w+)(?:['’]d|\s+would)\s+(?:really\s+|very\s+much\s+|also\s+)*(?:like|love|prefer|appreciate)"
    r"|(?:I|we|he|she|they|(?:the\s+|our\s+|my\s+)?\w+)\s+(?:really\s+|also\s+|now\s+)*(?:want|need|require|prefer|desire|wish|request|demand|ask)s?"
    r"|what\s+(?:I|we)\s+(?:want|need)\s+is|it\s+is\s+(?:requested|required|desired|necessary|important|essential))"
)
_FORMS = tuple(
    re.compile(pattern + _END, re.IGNORECASE)
    for pattern in (
        rf"\W*(?:(?:now|then|next|please|and)\s*,?\s+)?{_WANT}\s+(?:for\s+|that\s+|to\s+(?:have|see|get)\s+)?{_THING}\s+"
        rf"(?:(?:to\s+)?(?:be|{_BEING})\s+)?(?:(?:placed|put|moved|stored|set|brought|taken|kept|positioned|located|standing)\s+)?{_ON}{_PLACE}",
        rf"\W*(?:(?:now|then|next|finally)\s*,?\s+)?{_THING}\s+{_ADVERB}{_MODAL}\s+{_ADVERB}{_BEING}\s+{_ADVERB}{_ON}{_PLACE}",
        rf"\W*{_THING}\s+(?:belongs?|goes|go)\s+{_ON}{_PLACE}",
        rf"\W*{_THING}\s+deserves?\s+{_PLACE}",
    )
)
_RESUMED = re.compile(
    r"\s*[,;.:]\s*(?:(?:so|and|therefore|thus|hence|then|please|kindly|now)\s*,?\s+)*(?P<verb>\w+)\s+(?:it|them|this|that|these)\s+"
    r"(?:up\s+|down\s+|back\s+|over\s+)?(?:in\s+|onto\s+|on\s+)?there(?:\s*,?\s*please)?[\s.!]*$",
    re.IGNORECASE,
)
_LEAD = re.compile(r"^\W*(?:[^,;:.]{2,40}\sbeing\s[^,;:.]{2,40}),\s*(?=\S)", re.IGNORECASE)
_USE = tuple(
    re.compile(pattern, re.IGNORECASE)
    for pattern in (
        r"\W*(?:please\s+)?for\s+(?P<thing>[^,;:.]{2,60}?),?\s+(?:please\s+)?(?:use|take|choose|pick|select)\s+(?P<place>[^,;:.]{2,60}?)[\s.!]*$",
        r"\W*(?:please\s+)?(?:use|choose|assign|allocate|allot|designate|dedicate)\s+(?P<place>[^,;:.]{2,60}?)\s+(?:for|to)\s+(?P<thing>[^,;:.]{2,60}?)[\s.!]*$",
        r"\W*(?:please\s+)?(?:reserve|use|keep)\s+(?P<place>[^,;:.]{2,60}?)\s+for\s+(?P<thing>[^,;:.]{2,60}?)\s+and\s+\w+\s+(?:it|them)\s+(?:in\s+|on\s+)?there[\s.!]*$",
    )
)
_NOT_BUT = re.compile(
    r"\W*(?:please\s+)?(?:do\s+not|don['’]t|never)\s+(?P<verb>\w+)\s+(?P<thing>[^,;:.]{2,60}?)\s+(?:on|onto|to|into|in|at)\s+[^,;:.]{2,60}?,?\s+"
    r"but\s+(?:rather\s+|instead\s+)?(?:on|onto|to|into|in|at)\s+(?P<place>[^,;:.]{2,60}?)(?:\s+instead)?[\s.!]*$",
    re.IGNORECASE,
)


def wished(step: LabelledStep, scene: Scene) -> LabelledStep:
    """The thing as target and the place as destination, where a step says so in the form of a wish or a duty."""
    if len(step.text) > _SHORT:
        return step
    for pattern in (*_USE, _NOT_BUT):
        m = pattern.match(step.text)
        if m is not None and _known(step, scene, m):
            return _told(step, m)
    text = step.text
    resumed = _RESUMED.search(text)
    if resumed is not None and not read_verb(resumed["verb"].casefold(), (), scene.library).templates:
        resumed = None
    cut = text[: resumed.start()] if resumed is not None else text
    lead = _LEAD.match(cut) if resumed is not None or _LEAD.match(cut) else None
    for i, pattern in enumerate(_FORMS):
        if i > 1 and resumed is None:
            break
        m = pattern.match(cut, lead.end() if lead else 0)
        if m is not None and _plain(m["thing"]) and _known(step, scene, m):
            return _told(step, m)
    return step


def _plain(thing: str) -> bool:
    """Whether the words for the thing are no pronoun, and hold no clause of their own."""
    parts = tokens(thing)
    lex = lexicon()
    pointing = all(lex.is_(t.text, "pronouns", "plural_pronouns", "articles", "me") for t in parts)
    return not pointing and not any(
        lex.is_(t.text, "negation", "conditional") or t.text in {"to", "because", "when"} for t in parts
    )


def _known(step: LabelledStep, scene: Scene, m: re.Match[str]) -> bool:
    """Whether the words name things and a place of the map, or several that fit: then which is asked."""
    things, place = tokens(step.text, *m.span("thing")), tokens(step.text, *m.span("place"))
    if not things or not place:
        return False
    found = resolve_objects(things, scene, Talk({o.id: o.place for o in scene.map.objects}))
    where = resolve_places(place, scene, Talk())
    if isinstance(found, Fault) and found.code != "E304":
        return False
    return isinstance(where, Found) and len(where.ids) == 1 and not where.corrected


def _told(step: LabelledStep, m: re.Match[str]) -> LabelledStep:
    ends = sorted((*m.span(k), kind) for k, kind in (("thing", Kind.TARGET), ("place", Kind.DESTINATION)))
    return replace(step, spans=tuple(KeywordSpan(a, b, kind, step.text[a:b]) for a, b, kind in ends), readings=())
