"""What a request leaves open, and a reply decided without asking; what it names, and the scene does not have.

Words alone, no model: only what is plain is told. A definite singular ("the green block") that fits several objects, of
which the goals take one; a name with a number that the map does not have; a colour that nothing in it has.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import replace
from itertools import pairwise

from llmbt_atl.library import Library
from llmbt_compiler.checking.beyond import beyond
from llmbt_compiler.checking.choices import left_open
from llmbt_compiler.checking.complaints import lacks, several, too_few
from llmbt_compiler.checking.doubts import doubted
from llmbt_compiler.checking.enough import not_enough
from llmbt_compiler.checking.levels import levels_from
from llmbt_compiler.checking.misnamed import misnamed
from llmbt_compiler.checking.numbers import is_noun, named_by_number, numbered
from llmbt_compiler.checking.pairs import half_numbered, the_other
from llmbt_compiler.checking.passed import passed_over, short_of_all
from llmbt_compiler.checking.points import OpenPoint
from llmbt_compiler.checking.referring import Meant, meant_objects, place_named, told_apart
from llmbt_compiler.checking.sentences import ENDS, one_line, sentence_at, sentences, span_of
from llmbt_compiler.checking.sides import beside, sideways
from llmbt_compiler.checking.spots import meant_places
from llmbt_compiler.checking.unclear import unclear_names
from llmbt_compiler.parsing import Goal, ParseResult
from llmbt_compiler.parsing.mentions import mentioned_in, mentions_in
from llmbt_compiler.parsing.model import Extent
from llmbt_compiler.parsing.names import Fault, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.space.reading import name_end
from llmbt_compiler.parsing.words import Token, lexicon, singulars, tokens
from llmbt_ir.diagnostics import Diagnostic, Severity
from llmbt_ir.scene import COLOURS
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["VERBS", "lacking", "open_points"]

_MOVING = frozenset({"move", "put", "place", "shift", "relocate", "transfer", "stow", "remove"})
_TAKING = frozenset({"take", "bring", "get", "fetch", "give", "hand", "grab", "pick", "carry", "set"})
VERBS = _MOVING | _TAKING
"""What begins an order that brings something somewhere."""
_MUST = frozenset({"has", "must", "should", "goes", "belongs", "needs", "ought"})
_ABOUT = frozenset({"that", "which", "you", "i", "we", "with", "one", "people", "everybody", "everyone", "they", "for"})
_STANDING = frozenset({"that", "which", "thats", "is", "stands", "standing", "lies", "lying", "sits", "sitting"})
_AT = frozenset({"on", "in", "at"})
_DEFINITE = frozenset({"the", "that", "this", "my", "a", "another", "any"})
_BUT = frozenset({"not", "except", "but", "excluding", "bar", "save"})
_HUES = frozenset({*COLOURS, "gray", "violet", "cyan", "magenta", "turquoise", "gold", "golden"}) - {"wood"}


def open_points(
    request: str, parsed: ParseResult, semantic_map: SemanticMap, library: Library, said: str = ""
) -> tuple[OpenPoint, ...]:
    """E141 for each phrase of the request that fits several objects and of which the goals, or the steps as they were
    `said` (a landmark: "to the left of object 2"), take just one; E142 for each
    name in it that the scene lacks; E143 for what it names by its number, and no goal is about; E309 where it asks for
    a relation that the goals leave open. In the order of the request."""
    scene = Scene(semantic_map, library)
    line = one_line(request)
    words = _counting(tokens(line), scene)
    return (
        *_misplaced(words, line, parsed, scene),
        *_doubted(words, line, parsed.goals, scene),
        *half_numbered(words, line, parsed.goals, scene),
        *the_other(words, line, parsed.goals, scene),
        *_points(words, line, parsed.goals, scene, frozenset(mentioned_in(said, scene))),
        *map(OpenPoint, beyond(words, line, parsed.goals, scene)),
        *map(OpenPoint, misnamed(words, line, scene)),
        *unclear_names(words, line, parsed.goals, scene),
        *_not_enough(words, line, scene),
        *_spots(words, line, parsed.goals, scene),
        *_pronouns(words, line, parsed.goals, scene),
        *passed_over(words, line, parsed, scene, frozenset(mentioned_in(said, scene))),
        *short_of_all(words, line, parsed, scene),
        *_relations(words, line, parsed),
    )


def _counting(words: Sequence[Token], scene: Scene) -> tuple[Token, ...]:
    """The words without the "number" of "object number 9"."""
    stems = frozenset[str]().union(*(e.stem for e in (*scene.objects, *scene.places) if e.number is not None))
    return tuple(
        t
        for k, t in enumerate(words)
        if t.text not in {"number", "no", "nr", "num"}
        or not 0 < k < len(words) - 1
        or words[k - 1].text not in stems
        or not words[k + 1].digits
    )


def lacking(request: str, semantic_map: SemanticMap, library: Library) -> OpenPoint | None:
    """The first thing that the request names and the scene lacks, whatever is made of it: too few of a kind, a number,
    a colour, what is not where the request has it."""
    scene = Scene(semantic_map, library)
    line = one_line(request)
    words = _counting(tokens(line), scene)
    points = (
        *_misplaced(words, line, ParseResult(), scene),
        *_points(words, line, (), scene, frozenset()),
        *map(OpenPoint, beyond(words, line, (), scene)),
        *map(OpenPoint, misnamed(words, line, scene)),
        *_not_enough(words, line, scene),
    )
    return next((p for p in points if p.diagnostic.code == "E142"), None)


def _relations(words: Sequence[Token], request: str, parsed: ParseResult) -> Iterator[OpenPoint]:
    left_open = next((d for d in parsed.diagnostics if d.code == "W309"), None)
    asked = relations(words)
    if left_open is not None and asked:
        span = span_of(words[asked[0].start : asked[0].end], request)
        place = left_open.candidates[0]
        told = replace(left_open, code="E309", severity=Severity.ERROR, span=span, help=f"is {left_open.label} right?")
        yield OpenPoint(told, place)


def _doubted(words: Sequence[Token], request: str, goals: Sequence[Goal], scene: Scene) -> Iterator[OpenPoint]:
    """ "Up to 31. Or was it 33?": two of a kind, and the user does not know which."""
    about = {a for g in goals for a in g.condition.args}
    for i, pair in doubted(words, scene):
        if left_open(words, request, scene, movable=scene[pair[0]].movable):
            continue  # "chocolate or cookies, you choose"
        hit = {id_: [a for a in about if a == id_ or (not scene[id_].movable and scene.within(a, id_))] for id_ in pair}
        taken = [id_ for id_ in pair if hit[id_]]
        if len(taken) == 1:
            what = "objects" if scene[pair[0]].movable else "places"
            told = several(words[i : i + 1], request, pair, taken, what)
            yield OpenPoint(told, hit[taken[0]][0] if len(hit[taken[0]]) == 1 else None)


def _pronouns(words: Sequence[Token], request: str, goals: Sequence[Goal], scene: Scene) -> Iterator[OpenPoint]:
    """ "There is the coke, and there is the milk. Bring it to me": either may be meant, and the goals take one."""
    said_in = [(a, b) for a, b in sentences(words, ENDS | {":"}) if b - a > 1]
    clauses = [(a, b) for a, b in sentences(words, ENDS | {":", ","}) if b - a > 1]
    moved = {g.condition.args[0] for g in goals if g.condition.args}
    phrases = list(meant_objects(words, request, scene))
    for before, (a, b) in dict.fromkeys((*pairwise(said_in), *pairwise(clauses))):
        it = next(
            (i for i in range(a, b) if words[i].text == "it" and (_ordered(words, i - 1) or _ordered(words, i + 1))),
            None,
        )
        told = [t.text for t in words[before[0] : before[1]]]
        if it is None or set(told) & (VERBS | _MUST) or "and" not in told:
            continue
        marks = {k for r in relations(words) for k in range(r.end, name_end(words, r))}
        named = [(m.start, m.id) for m in mentions_in(words, scene) if scene[m.id].movable]
        named += [(p.start, p.ids[0]) for p in phrases if len(p.ids) == 1]
        ids = tuple(dict.fromkeys(i for k, i in sorted(named) if before[0] <= k < before[1] and k not in marks))
        own = [i for k, i in named if a <= k < it]
        taken = sorted(moved & set(ids))
        if len(ids) > 1 and len(taken) == 1 and not own:
            yield OpenPoint(several(words[it : it + 1], request, ids, taken), taken[0])


def _ordered(words: Sequence[Token], i: int) -> bool:
    """Whether a verb stands here that makes an order of what is beside it: "move it", "it has to go"."""
    return 0 <= i < len(words) and words[i].text in VERBS | _MUST


def _points(
    words: Sequence[Token], request: str, goals: Sequence[Goal], scene: Scene, said: frozenset[str]
) -> Iterator[OpenPoint]:
    ids = {i for i in range(len(words) - 1) if numbered(words, i, scene)}
    named = {e for i in ids if isinstance(f := named_by_number(words, i, scene), Found) for e in f.ids}
    moved = {a for g in goals for a in g.condition.args}
    own = {m.id for m in mentions_in(words, scene)}
    spoken_of = set(named)
    phrases = {m.start: m for m in meant_objects(words, request, scene)}
    among = set[str]()  # "the two blocks on the shelf ... the green one": of those two
    for i, t in enumerate(words):
        if i in ids:
            found = named_by_number(words, i, scene)
            if isinstance(found, Fault) and found.code in {"E301", "E302"}:
                yield OpenPoint(lacks(found, words[i : i + 2], request))
        if i in phrases:
            phrase = phrases[i]
            fits = tuple(f for f in _not_there_yet(phrase, goals, scene) if f not in _left_out(words, phrases, phrase))
            fits = tuple(f for f in fits if f in among) if len(among & set(fits)) == 1 else fits
            meant = (
                [f for p in phrases.values() if p.start < i for f in p.ids if f in fits]
                if _means(words, phrase)
                else []
            )
            fits = tuple(meant) or fits
            taken = (moved & set(fits)) or (said & set(fits))
            told_closer = phrase.vague and any(
                p.count > 1 and not p.vague and set(p.ids) < set(phrase.ids) for p in phrases.values()
            )
            if told_closer or (phrase.many and _there_are(words, i)):
                continue  # "a couple of things ..., so two of the green blocks"
            if len(phrase.ids) < phrase.count:
                yield OpenPoint(too_few(words[i : phrase.end], request, phrase))
            elif (
                (0 < len(taken) < len(fits) if phrase.vague else len(fits) > len(taken) == phrase.count)
                and not (
                    spoken_of & set(fits) or taken <= own or _told_later(words, phrase, tuple(phrases.values()), taken)
                )
                and not left_open(words, request, scene, movable=True)
                and not (i and words[i - 1].text in _BUT)
                and not _explained(words, phrase.end)
            ):
                if told_apart(words, i, phrase.end, taken, fits, scene):
                    spoken_of |= taken
                    continue
                told = several(words[i : phrase.end], request, fits, sorted(taken))
                yield OpenPoint(told, next(iter(taken)) if len(taken) == 1 and taken <= moved else None)
            spoken_of |= set(fits) if len(fits) == 1 else set()
            among = set(phrase.ids) if phrase.exactly and len(phrase.ids) == phrase.count else among
        foreign = _foreign(words, i, scene)
        if foreign is not None and not _if(words, i) and not _vessel(words, i, moved, scene):
            yield OpenPoint(lacks(foreign, words[i : i + 2], request))
        stands = is_noun(words, i + 1, scene) or _hue_alone(words, i)
        if t.text in _HUES | scene.colours and stands and not _if(words, i):
            parts = words[i : i + 1] if _hue_alone(words, i) else words[i : i + 2]
            hued: Found | Fault = resolve_objects(parts, scene, Talk())
            word = scene.word(t, True)
            unknown = not word.text or word.corrected
            if unknown and not (isinstance(hued, Fault) and hued.code == "E301"):  # "black" is no "block"
                title = f"nothing in the scene is `{' '.join(w.text for w in parts)}`"
                hued = Fault("E301", title, Extent(t.start, parts[-1].end), "", "")
            if isinstance(hued, Fault) and hued.code == "E301" and not _vessel(words, i, moved, scene):
                yield OpenPoint(lacks(hued, parts, request))


def _left_out(words: Sequence[Token], phrases: Mapping[int, Meant], of: Meant) -> frozenset[str]:
    """What the sentence takes out of a phrase: "a green block, only not the one in the middle"."""
    _, stop = sentence_at(words, of.start)
    out = frozenset[str]()
    for k in range(of.end, stop):
        phrase = phrases.get(k)
        before = {t.text for t in words[max(of.end, k - 2) : k]}
        if phrase is not None and len(phrase.ids) == 1 and before & _BUT:
            out |= set(phrase.ids)
    return out


def _there_are(words: Sequence[Token], i: int) -> bool:
    """ "There's a pair of yellows": what there is, and no order."""
    before = [t.text for t in words[max(0, i - 2) : i]]
    return before[-1:] == ["there"] or before in (["there", w] for w in ("is", "are", "were", "a"))


def _told_later(words: Sequence[Token], phrase: Meant, phrases: Sequence[Meant], taken: Set[str]) -> bool:
    """ "Red and green would look nice together. Put the red one next to the green one on level 1": told closer behind
    it."""
    closer = [
        p.ids for p in phrases if p.start > phrase.start and len(p.ids) == p.count and set(p.ids) < set(phrase.ids)
    ]
    meant = [set(p.ids) for p in phrases if p.start > phrase.end and _means(words, p)]
    return bool(taken) and (
        any(taken <= set(ids) for ids in closer) or any(taken == m & set(phrase.ids) for m in meant)
    )


def _means(words: Sequence[Token], phrase: Meant) -> bool:
    """ "The drink, I mean", "I'm talking about the drink"."""
    near = [t.text for t in (*words[max(0, phrase.start - 3) : phrase.start], *words[phrase.end : phrase.end + 4])]
    return bool({"mean", "meant", "meaning"} & set(near)) or ["talking", "about"] in [near[k : k + 2] for k in range(9)]


def _vessel(words: Sequence[Token], i: int, moved: set[str], scene: Scene) -> bool:
    """ "That red can on the bar", where one red thing stands there, and the goals move it: what a drink or the like
    comes in is no other name for it."""
    k = i + 2 + int(i + 2 < len(words) and words[i + 2].text in _STANDING)
    if not lexicon().is_(words[i + 1].text, "vessels") or k >= len(words) or words[k].text not in _AT | {"from"}:
        return False
    place, _ = place_named(words, k + 1, scene)
    at = {o.id: o.place for o in scene.map.objects}
    hued = [o for o in at if words[i].text in scene[o].colour and place is not None and scene.within(at[o], place)]
    return len(hued) == 1 and hued[0] in moved


def _explained(words: Sequence[Token], at: int) -> bool:
    """Whether the sentence goes on to say which one is meant, in words that are not understood here: "..., and I mean
    the one you can bite into"."""
    _, stop = sentence_at(words, at)
    said = [t.text for t in words[at : stop + 1]]
    ones = [k for k in range(len(said) - 2) if said[k : k + 2] == ["the", "one"]]
    return any(said[k - 1 : k] in (["mean"], ["meaning"], [","], ["not"]) and said[k + 2] in _ABOUT for k in ones)


def _foreign(words: Sequence[Token], i: int, scene: Scene) -> Fault | None:
    """ "The green ball", where nothing on the map is a ball: a noun that names things elsewhere."""
    if words[i].text not in _HUES | scene.colours or i + 1 >= len(words):
        return None
    lex, noun = lexicon(), words[i + 1]
    forms = set(singulars(noun.text))
    elsewhere = any(forms & group for group in lex.groups) or forms & {w for s in lex.shapes.values() for w in s}
    if not elsewhere or any(scene.word(noun, m).text for m in (True, False)):
        return None
    found = resolve_objects(words[i : i + 2], scene, Talk())
    return found if isinstance(found, Fault) and found.code == "E301" else None


def _misplaced(words: Sequence[Token], request: str, parsed: ParseResult, scene: Scene) -> Iterator[OpenPoint]:
    """ "The red block from level 2", where no such thing is: not at the start, and no step brings it there."""
    where = {o.id: o.place for o in scene.map.objects}
    for phrase in meant_objects(words, request, scene):
        begin = phrase.end
        while begin < len(words) and words[begin].text in _STANDING:
            begin += 1
        said = begin < len(words) and (words[begin].text == "from" or (begin > phrase.end and words[begin].text in _AT))
        said = said or _tells_where(words, begin, scene)
        said = said or (_there_are(words, phrase.start) and begin < len(words) and words[begin].text in _AT)
        place, stop = place_named(words, begin + 1, scene) if said else (None, begin)
        opens = sentence_at(words, phrase.start)[0]
        if place is None and opens < phrase.start and words[opens].text in {"from", "off"}:
            place, stop = place_named(words, opens + 1, scene)[0], phrase.end  # "from level 2, the yellow block"
        if place is None or not phrase.ids:
            continue
        moved = {m.place for m in parsed.moves if m.target in phrase.ids}
        there = {p for i in phrase.ids if (p := where.get(i)) is not None} | moved
        if not any(scene.within(p, place) for p in there):
            told = request[words[phrase.start].start : words[stop - 1].end]
            title = f"the request names what is not there: nothing on {place} is `{told}`"
            span = span_of(words[phrase.start : stop], request)
            yield OpenPoint(Diagnostic("E142", title, span, "not there", "say where it is", candidates=phrase.ids))


def _tells_where(words: Sequence[Token], at: int, scene: Scene) -> bool:
    """ "The red block on level 1 must go to level 3": the place behind it is where it stands, since another follows."""
    if at >= len(words) or words[at].text not in _AT:
        return False
    place, stop = place_named(words, at + 1, scene)
    modal = stop < len(words) and words[stop].text in _MUST
    k = stop + int(stop < len(words) and words[stop].text in {"down", "up", "over", "across", "back"})
    onto = (
        k < len(words) and words[k].text in {"to", "onto", "into"} and place_named(words, k + 1, scene)[0] is not None
    )
    return place is not None and (modal or onto)


def _not_there_yet(phrase: Meant, goals: Sequence[Goal], scene: Scene) -> tuple[str, ...]:
    """Of what a phrase fits, that which is not yet where the goals bring one of it: what lies in the sorting area is
    not meant by what is to be taken there."""
    to = {g.condition.args[1] for g in goals if g.condition.name == "On" and g.condition.args[0] in phrase.ids}
    where = {o.id: o.place for o in scene.map.objects}
    (place,) = to if len(to) == 1 else (None,)
    if place is None or scene.single(place):
        return phrase.ids
    moved = {g.condition.args[0] for g in goals if g.condition.name == "On"}
    left = tuple(i for i in phrase.ids if i in moved or not scene.within(where.get(i), place))
    return left if len(left) >= phrase.count else phrase.ids


def _hue_alone(words: Sequence[Token], i: int) -> bool:
    """ "The blue one", "that blue one": a colour that stands for a thing."""
    after = words[i + 1].text if i + 1 < len(words) else ""
    return i > 0 and words[i - 1].text in _DEFINITE and after in {"one", "ones"}


def _if(words: Sequence[Token], i: int) -> bool:
    return any(lexicon().is_(t.text, "conditional") for t in words[:i])


def _spots(words: Sequence[Token], request: str, goals: Sequence[Goal], scene: Scene) -> Iterator[OpenPoint]:
    """Phrases for places that fit several, of which the goals take one."""
    if left_open(words, request, scene, movable=False):
        return
    placed = [g.condition.args for g in goals if g.condition.name == "On" and not g.condition.negated]
    about = tuple(dict.fromkeys(a[0] for a in placed))
    where = {o.id: o.place for o in scene.map.objects}
    for phrase in meant_places(words, request, scene, about):
        begin, end = sentence_at(words, phrase.start)
        way = levels_from(words[begin:end], where.get(about[0]), scene) if len(about) == 1 else ()
        ids = tuple(i for i in phrase.ids if any(scene.within(i, level) for level in way))
        ids = ids or phrase.ids
        hit = {c: [a for a in placed if scene.within(a[1], c)] for c in ids}
        taken = [c for c, found in hit.items() if found]
        if len(ids) > 1 and len(taken) == 1:
            told = several(words[phrase.start : phrase.end], request, ids, taken, "places")
            yield OpenPoint(told, hit[taken[0]][0][1] if len(hit[taken[0]]) == 1 else None)
    read = (*meant_places(words, request, scene, about), *meant_objects(words, request, scene))
    for phrase, place in (*beside(words, read, placed, scene), *sideways(words, placed, scene)):
        told = several(words[phrase.start : phrase.end], request, phrase.ids, [place], "places")
        yield OpenPoint(told, place)


def _not_enough(words: Sequence[Token], request: str, scene: Scene) -> Iterator[OpenPoint]:
    """ "Another coke", where there is one."""
    for far in not_enough(words, tuple(meant_objects(words, request, scene)), scene):
        if _if(words, far.start):
            continue
        said = request[words[far.start].start : words[far.end - 1].end]
        title = f"the request names what is not there: `{said}`, and {far.there}"
        span = span_of(words[far.start : far.end], request)
        yield OpenPoint(Diagnostic("E142", title, span, "not there", "say another", candidates=far.candidates))
