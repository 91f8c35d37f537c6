"""A last reading for a step that no form fits: put plainly ("put object 2 on position 34"), where all it says is which
thing and which place, and every other word only says that the one goes to the other.

Nothing is read so in a question, under a condition, a reason, a negation, an exception or in the past: a word that is
not known to be about going somewhere is enough to leave the step as it is.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby, pairwise

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.model import LabelledStep
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.rewording import reworded
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.statements import STATIVE, states_a_fact
from llmbt_compiler.parsing.verbs import Shape, read_verb, shape_of, travel_template
from llmbt_compiler.parsing.words import Token, lexicon, tokens

__all__ = ["gist"]

_LONGEST = 60
_NP = 9
_BELONGING = frozenset({
    "goes", "go", "going", "belong", "belongs", "end", "ends", "be", "is", "are", "up", "find", "finds",
    "receive", "receives", "accommodate", "house", "host", "occupy", "occupies", "fill", "fills",
    "filled", "waits", "waiting", "reserved", "destined", "meant", "intended", "bound", "headed", "heading",
    "home", "stop", "destination", "target", "due", "set", "aside", "earmarked", "designated", "assigned",
    "allocated", "wanted", "needed", "needs", "need", "want", "wants", "like", "see", "have", "get", "gets",
    "getting", "make", "sure", "arrive", "arrives", "arriving", "land", "lands", "come", "comes", "do", "let",
    "moved", "made", "given", "follow", "follows", "join", "joins", "turn", "reach", "reaching", "reached",
    "release", "releasing", "lower", "lowering", "gently", "takes", "take", "supposed", "expected", "required",
    "ready", "spot", "place", "seat", "sees", "it", "they", "travel", "travels", "sit", "live", "lives", "stay",
    "rest", "spend", "change", "over", "across",
})  # fmt: skip
"""What may be said of a thing, a place or who acts, where the one is to come to the other."""
_PLAIN = frozenset({
    "the", "a", "an", "this", "that", "thats", "which", "where", "what", "its", "i", "id", "we", "wed", "you",
    "your", "to", "in", "on", "onto", "into", "at", "for", "of", "with", "there", "here", "and", "then", "so",
    "as", "please", "now", "next", "first", "finally", "lastly", "afterwards", "also", "too", "should", "shall",
    "must", "would", "will", "may", "can", "could", "ought", "kindly", "just", "simply", "down", "straight",
    "right", "directly", "carefully", "slowly", "safely", "immediately", "turn", "all", "both", "one", "place",
    "correct", "proper", "new", "final", "itll", "theyll", "ill", "well", "youll", "is", "been", "respectively",
    "each", "thereupon", "stead", "toward", "towards", "over", "along", "by", "accordingly", "exactly",
    "precisely", "really", "only", "job", "task", "ok", "okay", "alright", "up", "back", "out", "off", "way",
    "spot", "slot", "position", "convey", "my", "kind", "good", "instead", "suits", "suit", "better", "best",
    "enough", "obliged", "grateful", "appreciate", "pleased", "glad", "happy", "help", "through",
})  # fmt: skip
_ASIDE = re.compile(
    r"(?:,|\s[-\u2013\u2014])\s*(?:wherever\b[^,;.:]*|(?:one|two|three|four|five|six)\s+in\s+number|the\s+(?:rest|others?)\s+being\b[^,;.:]*?"
    r"|(?:starting|beginning)\s+(?:from|with|at)\s+(?:its|the|their)\s+(?:first|lowest|left)[^,;.:]*"
    r"|as\s+(?:you\s+(?:know|can\s+see)|I\s+said|mentioned|agreed|always|usual|planned|promised|it\s+happens)[^,;.:]*"
    r"|whatever\s+(?:its|their|the)\b[^,;.:]*)\s*(?:,|(?=[.;:!])|\s[-\u2013\u2014](?=\s)|$)"
    r"|^\s*(?:minding|mind|watching|avoiding|heeding|taking\s+care|being\s+careful|without\s+(?:hurry|haste|rush))\b[^,;.:]*,"
    r"|^\W*(?:(?:on\s+second\s+thoughts?|actually|oh|ah|sorry|no|wait|hang\s+on|hold\s+on|correction)\s*[,:\u2013\u2014-]\s*)+"
    r"|,\s*not\s+(?:(?:on|to|in|onto|into)\s+)?(?:the\s+)?(?:\w+\s+)?(?:\w+)\s*(?:,|(?=[.;:!]|$))|\bin\s+(?:its|their|his|her)\s+(?:stead|turn)\b"
    r"|\bat\s+your\s+(?:earliest\s+)?convenience\b|\bI\s+(?:should|would|['\u2019]d)\s+be\s+(?:most|very|really|so|ever\s+so)?\s*"
    r"(?:obliged|grateful|glad|pleased|happy|thankful)\s+if\b|\bif\s+you\s+(?:would|could|will)(?:\s+be\s+so\s+\w+)?\b",
    re.IGNORECASE,
)
"""Says nothing of what goes where."""
_MARKS = frozenset({",", ".", ":", ";", "-", "–", "—", "!", "*", "`", '"', "(", ")"})
_GRIP = frozenset({"grip", "grasp", "pickup"})
_GRIPPING = _GRIP | _MARKS | frozenset({
    "a", "the", "on", "of", "firm", "good", "secure", "safe", "tight", "first", "then", "now", "next", "with", "please",
    "and", "careful", "gentle", "steady", "for", "finally",
})  # fmt: skip
_SOURCE = frozenset({"from", "off", "out"})
_AROUND = frozenset({"over", "across", "along", "through", "by", "with", "of", "up", "than", "like", "and"})
_GOAL = frozenset({"to", "into", "onto", "on", "in", "at", "for", "toward", "towards", "inside", "upon"})
_TO = frozenset({"to", "into", "onto", "for", "toward", "towards"})
_REFERRING = frozenset({"it", "them", "they", "both"})
_POLITE = re.compile(r"^\W*(?:please\s+)?(?:could|would|can|will|might|may)\b", re.IGNORECASE)
_MAYBE = frozenset({"may", "might", "could", "can", "would"})
_TRAVELLING = frozenset(
    {"over", "back", "off", "on", "please", "now", "next", "then", "to", "the", "and", "first", "go"}
)


@dataclass(frozen=True, slots=True)
class _Named:
    """What words[start:end] name: things, or places with the word that leads to them."""

    start: int
    end: int
    ids: tuple[str, ...]
    thing: bool
    lead: str = ""


def gist(step: LabelledStep, scene: Scene, talk: Talk) -> LabelledStep | None:
    """The step put plainly; None where it says more, or less."""
    begun = tokens(step.text)[:2]
    if begun and _idle(begun[0].text, scene) and (len(begun) == 1 or begun[1].text not in _MARKS):
        return None
    text = reworded(replace(step, spans=(), readings=())).text
    step = replace(step, text=_ASIDE.sub(lambda m: (" " if m.start() == 0 else ",").ljust(len(m[0])), text))
    line = tokens(step.text)
    if not line or len(line) > _LONGEST or (line[-1].text == "?" and not _POLITE.match(step.text)):
        return None
    if _idle(line[0].text, scene) or _stops(line):
        return None
    named = _named(line, scene, talk)
    free = [t for i, t in enumerate(line) if not any(n.start <= i < n.end for n in named) and t.text != "?"]
    said = {t.text for t in free}
    if (
        states_a_fact(step.text)
        or "been" in said
        or said & STATIVE
        or (said & _MAYBE and not said & {"you", "we", "i"})
    ):
        return None  # what is so, or may be
    if len(named) == 1 and named[0].thing and said & _GRIP and said <= _GRIPPING:
        return _written(step, [("pick", _cut(step, line, named[0]), "")])
    if not all(_says_nothing_else(t, scene) for t in free):
        return None
    if any(n.thing and n.lead in _COUNTING for n in named) or _there_first(line, named):
        return None
    if any(r.name == "next" and any(n.start >= r.end for n in named) for r in relations(line)):
        return None  # beside a place is not on it
    if any(n.thing and _related(line[n.end : n.end + 2]) for n in named):
        return None
    orders = _going(step, line, named, free, scene)
    if not orders and _about_placing(free, scene):
        told = _without_heading(named)
        orders = _to_one_place(step, line, told, free, scene, talk) or _in_pairs(step, line, told, free, scene)
    return _written(step, orders) if orders else None


_Orders = Sequence[tuple[str, str, str]]


_COUNTING = frozenset({"both", "all", "each", "one", "every"})
_WAYS = frozenset({"go", "drive", "walk", "head", "travel", "navigate", "run", "roll", "proceed", "going", "come"})


def _there_first(line: Sequence[Token], named: Sequence[_Named]) -> bool:
    """ "Go to position 24, pick up the ball and put it down": a way, and no word of where the thing goes."""
    said = [t.text for t in line[: named[0].start]] if named else []
    return bool(named) and not named[0].thing and not _WAYS.isdisjoint(said)


def _going(
    step: LabelledStep, line: Sequence[Token], named: Sequence[_Named], free: Sequence[Token], scene: Scene
) -> _Orders:
    """ "Over to the bar": a way, where the robot can go."""
    if len(named) != 1 or named[0].thing or named[0].lead not in _TO or travel_template(scene.library) is None:
        return ()
    begun = line[0].text in {"to", "over", "back", "off"}
    plain = begun and all(t.text in _TRAVELLING | _MARKS for t in free)
    return (("go", "", _cut(step, line, named[0])),) if plain else ()


def _to_one_place(
    step: LabelledStep,
    line: Sequence[Token],
    named: Sequence[_Named],
    free: Sequence[Token],
    scene: Scene,
    talk: Talk,
) -> _Orders:
    """One thing, or one list of things, or "it", and one place."""
    things, places = _parted(named, scene)
    pointed = [t for t in free if t.text in {"it", "them"}]
    if len({t.text for t in pointed}) > 1 or len({n.ids for n in places}) > 1:
        return ()
    if any(n.lead in _AROUND for n in places[:1]):
        return ()
    whole = _one_list(line, things)
    if things and (whole is None or any(free[0] is not t and t.start < line[whole[0]].start for t in pointed)):
        return ()
    words = step.text[line[whole[0]].start : line[whole[1] - 1].end] if whole else "".join(t.text for t in pointed[:1])
    if not places:
        there = bool(things) and talk.place is not None and any(t.text == "there" for t in free)
        return (("put", words, "there"),) if there else ()
    if not words or any(scene.within(talk.where.get(i), places[0].ids[0]) for n in things for i in n.ids):
        return ()
    return (("put", words, _cut(step, line, places[0])),)


def _in_pairs(
    step: LabelledStep, line: Sequence[Token], named: Sequence[_Named], free: Sequence[Token], scene: Scene
) -> _Orders:
    """Things and places in turn, or as many places as things."""
    if any(t.text in {"it", "them"} for t in free):
        return ()
    named = [n for n in named if n.lead not in _SOURCE]
    things, places = _parted(named, scene)
    moved = [i for n in things for i in n.ids]
    turns = [kind for kind, _ in groupby(n.thing for n in named)]
    if any(scene.within(o.place, p) for o in scene.map.objects if o.id in moved for n in places for p in n.ids):
        return ()  # "reach for the tea on the table": it is there
    if len(turns) == len(named) == 2 * len(places) and len(things) == len(places) and len(set(moved)) == len(moved):
        pairs = [(a, b) if a.thing else (b, a) for a, b in zip(named[::2], named[1::2], strict=True)]
        if all(b.lead in _GOAL for _, b in pairs) and len(pairs) > 1:
            return tuple(("put", _cut(step, line, a), _cut(step, line, b)) for a, b in pairs)
    ends = [i for n in places for i in n.ids]
    told = any(t.text == "respectively" for t in free) or all(n.lead in {*_GOAL, "and", ","} for n in places)
    if len(turns) == 2 and told and len(moved) == len(set(moved)) == len(ends) == len(set(ends)):
        return tuple(("put", thing, place) for thing, place in zip(moved, ends, strict=True))
    return ()


def _parted(named: Sequence[_Named], scene: Scene) -> tuple[list[_Named], list[_Named]]:
    """Things, and the places that they do not come from."""
    there = [n for n in named if n.lead not in _SOURCE]
    return [n for n in there if n.thing], _narrowest([n for n in there if not n.thing], scene)


def _without_heading(named: Sequence[_Named]) -> Sequence[_Named]:
    """ "(Off the bar come) the tea and the juice: the tea ..., the juice ..." without what is told of one by one."""
    first = next((i for i, n in enumerate(named) if n.thing), 0)
    later = [i for n in named[first + 1 :] if n.thing for i in n.ids]
    listed = named and len(named[first].ids) > 1 and sorted(later) == sorted(named[first].ids)
    return [*named[:first], *named[first + 1 :]] if listed else named


def _idle(word: str, scene: Scene) -> bool:
    """Whether a step begins with what changes nothing."""
    verb = read_verb(word, (), scene.library)
    idle = verb.is_("idle", "own", "refraining", "checking", "leaving")
    return word == verb.lemma and not verb.corrected and idle


def _related(after: Sequence[Token]) -> bool:
    """Whether a relative clause follows a thing that tells which it is, and not what is to be done with it."""
    said = [t.text for t in after]
    return said[:1] in (["that"], ["which"], ["who"]) and said[1:] != [] and said[1] not in _WISHED


_WISHED = frozenset(
    {"i", "id", "we", "wed", "you", "should", "must", "shall", "needs", "goes", "belongs", "ought", "has"}
)


def _stops(line: Sequence[Token]) -> bool:
    """Whether something is to be stopped, and no stop is spoken of."""
    return any(t.text == "stop" and (not i or line[i - 1].text not in _STOPS) for i, t in enumerate(line))


_STOPS = frozenset({"next", "first", "last", "final", "only", "the", "one"})


def _cut(step: LabelledStep, line: Sequence[Token], n: _Named) -> str:
    return step.text[line[n.start].start : line[n.end - 1].end]


def _written(step: LabelledStep, orders: Sequence[tuple[str, str, str]]) -> LabelledStep:
    """The step in these words: a verb, a thing, a place."""
    text, spans = "", list[KeywordSpan]()
    for verb, thing, place in orders:
        text += "; " if text else ""
        for lead, word, kind in (("", verb, Kind.ACTION), (" ", thing, Kind.TARGET), (" to ", place, Kind.DESTINATION)):
            if word:
                text += lead
                spans.append(KeywordSpan(len(text), len(text) + len(word), kind, word))
                text += word
    return replace(step, text=text + ".", spans=tuple(spans), readings=(), confidence=1.0, runs=())


def _one_list(line: Sequence[Token], things: Sequence[_Named]) -> tuple[int, int] | None:
    """From where to where the things are named, where that is one list, or the same thing twice."""
    if not things:
        return None
    if len({n.ids for n in things}) == 1:
        return things[0].start, things[0].end
    for a, b in pairwise(things):
        between = {t.text for t in line[a.end : b.start]}
        if not between <= {",", "and", "as", "well", "plus"} or not between:
            return None
    return things[0].start, things[-1].end


def _narrowest(places: Sequence[_Named], scene: Scene) -> list[_Named]:
    """Without those that only say where another lies."""
    out: list[_Named] = []
    for n in places:
        inner = (
            o
            for o in places
            if o.ids != n.ids and len(o.ids) == len(n.ids) == 1 and {ANYWHERE, ORIGIN}.isdisjoint((*o.ids, *n.ids))
        )
        if not any(scene.within(o.ids[0], n.ids[0]) for o in inner):
            out.append(n)
    return out


def _says_nothing_else(t: Token, scene: Scene) -> bool:
    if t.text in _MARKS | _PLAIN | _BELONGING | _REFERRING:
        return True
    if lexicon().is_(t.text, "talk") or t.text in {"placement", "heading", "object", "objects"}:
        return True
    if not t.word or t.number is not None or lexicon().is_(t.text, "negation", "conditional", "except", "unreal"):
        return False
    return _placing(t.text, scene)


def _placing(word: str, scene: Scene) -> bool:
    verb = read_verb(word, (), scene.library)
    if verb.corrected or verb.is_("idle", "refraining", "checking", "exchange"):
        return False
    return any(shape_of(t, scene.library) in {Shape.PLACE, Shape.PICK} for t in verb.templates)


def _about_placing(free: Sequence[Token], scene: Scene) -> bool:
    return any(t.text in _BELONGING - {"is", "are", "it", "they", "over"} or _placing(t.text, scene) for t in free)


def _named(line: Sequence[Token], scene: Scene, talk: Talk) -> list[_Named]:
    """What the step names: the longest phrases that the map has one sense for."""
    out: list[_Named] = []
    i = 0
    while i < len(line):
        hit = None
        for end in range(min(i + _NP, len(line)), i, -1):
            hit = _of(line, i, end, scene, talk)
            if hit is not None:
                break
        if hit is not None:
            out.append(hit)
        i = hit.end if hit is not None else i + 1
    return out


def _of(line: Sequence[Token], start: int, end: int, scene: Scene, talk: Talk) -> _Named | None:
    words = line[start:end]
    if any(t.text in _MARKS - {"-", ","} for t in words) or {words[0].text, words[-1].text} & {"-", ","}:
        return None
    lead = line[start - 1].text if start else ""
    if len(words) == 1 and lexicon().is_(words[0].text, "me", "him"):
        return _person(words[0], line[end].text if end < len(line) else "", start, lead, scene)
    for thing in (True, False):
        if not all(_fits(t, words, k, scene, thing) for k, t in enumerate(words)):
            continue
        if thing and (
            (words[0].text != "both" and lexicon().is_(words[0].text, *_POINTING)) or words[-1].text in scene.colours
        ):
            continue
        level = [t for t in words if t.text != ","]  # "third slot, top level"
        if len(level) < len(words) and (thing or words[0].text not in lexicon().ordinals):
            continue
        found = (resolve_objects if thing else resolve_places)(level, scene, talk)
        if isinstance(found, Found) and not found.corrected and not (thing and {ANYWHERE, ORIGIN} & set(found.ids)):
            return _Named(start, end, found.ids, thing, lead)
    return None


def _person(word: Token, after: str, start: int, lead: str, scene: Scene) -> _Named | None:
    """ "To her", "for me", "(see that) he gets": not who acts."""
    gets = word.text in {"he", "she"} and after in {"gets", "receives", "has"}
    given = lead in _TO and word.text not in {"i", "we", "he", "she", "them"}
    found = resolve_places((word,), scene, Talk()) if gets or given else None
    return _Named(start, start + 1, found.ids, False, "to") if isinstance(found, Found) else None


_POINTING = ("pronouns", "plural_pronouns", "there", "me", "him")
_INSIDE = frozenset({"of", "on", "in", "and", "the"})


def _fits(t: Token, words: Sequence[Token], k: int, scene: Scene, thing: bool) -> bool:
    """Whether a word may belong to the name of a thing, or of a place."""
    lex = lexicon()
    if t.number is not None:
        return len(words) > 1
    edge = k in {0, len(words) - 1}
    if t.text in {"what", "whatever"} or (k and t.text in {"that", "which"}):
        return False
    if lex.is_(t.text, "articles", "all", "rest", "both", "vacant") or t.text in lex.ordinals or t.text in lex.sizes:
        return k < len(words) - 1 or t.text in {"rest", "others"}
    if lex.is_(t.text, "top", "bottom", "middle", "last"):
        return k < len(words) - 1
    between = not edge and words[k - 1].number is not None and words[k + 1].number is not None
    if (not edge and (t.text in _INSIDE | {"-"} or (t.text == "," and not thing))) or (
        between and lex.is_(t.text, "ranges")
    ):
        return True
    if lex.is_(t.text, "me", "him"):
        return False
    if len(t.text) == 1 and t.word and k == len(words) - 1 and k:
        return True
    word = scene.word(t, thing)
    return bool(word.text) and not word.corrected
