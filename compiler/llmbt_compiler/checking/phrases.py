"""Noun phrases of a request, and the objects that each may mean on the map as it is at the start."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile

from llmbt_compiler.checking.comparisons import comparison
from llmbt_compiler.parsing.ledger import Ledger
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.names import Fault, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene, natural
from llmbt_compiler.parsing.space.expressions import Ranked, rank_of, relations, side_of
from llmbt_compiler.parsing.space.reading import name_end
from llmbt_compiler.parsing.space.world import World
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["MASS", "Meant", "landmark", "meant_objects", "place_named"]

_POINTING = frozenset({"the", "that", "this", "my", "your"})
_INDEFINITE = frozenset({"a", "an", "some", "one"})
_EXACTLY = frozenset({"the", "all", "these", "those", "both"})
_TELLING = frozenset({
    "left", "right", "next", "beside", "behind", "front", "between", "nearest", "closest", "near", "above", "below",
    "nearer", "closer", "farthest", "furthest", "under", "underneath", "beneath", "top", "first", "second", "third",
    "last", "other", "same", "remaining", "rest", "that", "which", "whose", "who", "with", "in", "standing", "lying",
    "sitting", "by", "over", "whichever", "nobody", "you", "i", "we",
})  # fmt: skip
_STANDING = frozenset({
    "that", "which", "is", "are", "thats", "whats", "stands", "standing", "right", "directly", "just",
    "lies", "lying", "sits", "sitting", "currently", "now", "still",
    "located", "stored", "placed", "already", "what", "waiting", "kept", "resting", "parked", "sat",
})  # fmt: skip
_CLAUSE = frozenset({
    "that", "which", "thats", "whats", "stands", "standing", "lies", "lying", "sits", "sitting", "currently", "now",
    "located", "stored", "placed", "already", "from", "off",
})  # fmt: skip
"""Words after a noun that say where a thing is, and not where it is to go."""
_LINKING = frozenset({"was", "were", "sits", "sit", "stays", "would", "could", "wants", "gets", "does", "directly", "it"})
_MODAL = frozenset({"must", "should", "has", "needs", "ought", "goes", "shall", "may", "can", "will", "belongs"})
_AT = frozenset({"on", "in", "at", "from", "of", "off"})
_ENDING = frozenset({"on", "onto", "in", "into", "at", "from", "to", "and", ",", ".", "then", "over"})
_ONTO = frozenset({"on", "onto", "in", "into", "to", "next", "beside", "between", "above", "below"})
MASS = frozenset({"cargo", "good", "everything"})
_PUTTING = frozenset({"put", "place", "set", "move", "lay", "position", "stand", "shift", "drop", "stow", "store"})
_FETCHING = frozenset({"pick", "take", "bring", "get", "fetch", "grab", "give", "hand", "want", "need", "collect"})
_OPENING = frozenset({".", ",", ";", ":", "!", "?", "and", "then"})
_EVERY = frozenset(
    tuple(p.split())
    for p in (
        "you have", "we have", "i have", "you own", "we own", "youve got", "weve got", "ive got", "you can find",
        "you can see", "there is", "available", "of all", "of them all", "of the lot", "of the whole lot", "of them",
        "in the scene", "on the map", "around",
    )
)  # fmt: skip
_USES = {"drink": "drink", "eat": "food", "snack": "snack"}
_LONGEST = 5


@dataclass(frozen=True, slots=True)
class Meant:
    """A phrase, words[start:end], and all the things that it fits. `count`: of how many of them it speaks (0: of all);
    `exactly`: it says that there are no more ("both", "all three"); `stop`: where a clause ends that tells more of it
    ("that's on the shelf"), or 0."""

    start: int
    end: int
    ids: tuple[str, ...]
    count: int = 1
    exactly: bool = False
    stop: int = 0

    @property
    def many(self) -> bool:
        """Whether it speaks of several things."""
        return self.count != 1


def meant_objects(words: Sequence[Token], line: str, scene: Scene) -> Iterator[Meant]:
    """Every phrase like "the green block", "a yellow one", "two of the drinks", "the block in the sorting area" with
    the objects that it fits; none where what stands after it may tell more than is understood here."""
    where = {o.id: o.place for o in scene.map.objects}
    before: set[str] = set()
    single: set[str] = set()
    earlier = _pointed_at(words, scene, where)
    for i, t in enumerate(words):
        before |= earlier.get(i, set())
        found = _several(words, i, scene, where) or _something(words, i, scene) or _colour_alone(words, i, scene)
        if found is not None:
            before |= set(found.ids)
            yield found
            continue
        if i and words[i - 1].text in {"any", "either"}:
            continue
        other = _other(words, i, single, scene)
        if other is not None:
            yield other
            continue
        end = _noun(words, i, scene) if t.text in _POINTING | _INDEFINITE else 0
        if end:
            found = _compared(words, i + 1, end, line, scene, where)
            if found is not None and found.ids == () and found.stop:
                yield replace(found, start=i)
                continue
            found = (
                found
                or _ranked(words, i + 1, end, line, scene, where)
                or _related(words, i + 1, end, line, scene, where)
                or _plain(words, i + 1, end, scene, where)
            )
        elif _bare(words, i, scene):
            end = _noun(words, i - 1, scene)
            found = _ranked(words, i, end, line, scene, where) or _plain(words, i, end, scene, where) if end else None
        if found is not None and found.ids and not (t.text in {"that", "this"} and before & set(found.ids)):
            yield replace(found, start=i)
            before |= set(found.ids)
            single |= set(found.ids) if len(found.ids) == 1 else set()


def _other(words: Sequence[Token], i: int, single: set[str], scene: Scene) -> Meant | None:
    """ "The other green one", where one of them has been named before: what is left of them."""
    if [t.text for t in words[i : i + 2]] != ["the", "other"] or i + 2 >= len(words):
        return None
    end = _noun((*words[: i + 1], *words[i + 2 :]), i, scene)
    phrase = [t for t in words[i + 2 : end + 1] if t.text != "one"] if end else []
    if not phrase or any(t.text in lexicon().sizes or t.text in lexicon().ordinals for t in phrase):
        return None
    found = resolve_objects((Token("all", phrase[0].start, phrase[0].start), *phrase), scene, Talk())
    left = tuple(o for o in found.ids if o not in single) if isinstance(found, Found) else ()
    known = isinstance(found, Found) and single & set(found.ids)
    return Meant(i, end + 1, left) if known and left and not _tells(words, end + 1, scene) else None


def _pointed_at(words: Sequence[Token], scene: Scene, where: dict[str, str | None]) -> dict[int, set[str]]:
    """What "that block" may point back to, by the word behind its name: a thing, what has a colour,
    what is on a place."""
    found: dict[int, set[str]] = {}
    for m in mentions_in(words, scene):
        there = {o for o, p in where.items() if scene.within(p, m.id)} if not scene[m.id].movable else {m.id}
        if scene[m.id].movable or scene.single(m.id):
            found.setdefault(m.end, set()).update(there)
    for i, t in enumerate(words):
        pointing = i > 0 and words[i - 1].text in {"that", "this"}
        if t.text in scene.colours and not pointing:
            found.setdefault(i + 1, set()).update(e.id for e in scene.objects if t.text in e.colour)
    return found


def landmark(words: Sequence[Token], at: int, scene: Scene) -> Meant | None:
    """What is named right here for something else to be next to: "object 3", "the green block on the shelf"."""
    where = {o.id: o.place for o in scene.map.objects}
    while at < len(words) and words[at].text in {"of", "to"}:
        at += 1
    if at >= len(words):
        return None
    named = next((m for m in mentions_in(words[at:], scene) if m.start <= int(words[at].text in _POINTING)), None)
    if named is not None:
        return Meant(at, at + named.end, (named.id,))
    several = _several(words, at, scene, where)
    if several is not None:
        return several
    end = _noun(words, at, scene) if words[at].text in _POINTING | _INDEFINITE else 0
    if not end:
        return None
    phrase = [t for t in words[at + 1 : end] if t.text != "one"]
    told = [t for t in phrase if t.text in lexicon().ordinals or t.text in lexicon().sizes]
    found = (
        resolve_objects((Token("all", words[at].start, words[at].start), *phrase), scene, Talk()) if phrase else None
    )
    if not isinstance(found, Found) or told:
        return None
    ids, stop = _there(words, end, found.ids, scene, where)
    return Meant(at, max(stop, end), ids)


def _something(words: Sequence[Token], i: int, scene: Scene) -> Meant | None:
    """ "Something red", "something to drink"."""
    if words[i].text != "something" or i + 1 >= len(words):
        return None
    use = words[i + 2].text if words[i + 1].text == "to" and i + 2 < len(words) else ""
    sort, end = (_USES.get(use, ""), i + 3) if use else (words[i + 1].text, i + 2)
    known = sort in lexicon().sorts or sort in lexicon().shapes or sort in scene.colours
    ids = tuple(e.id for e in scene.objects if scene.fits(e, sort)) if known else ()
    return Meant(i, end, tuple(sorted(ids, key=natural))) if ids else None


def _colour_alone(words: Sequence[Token], i: int, scene: Scene) -> Meant | None:
    """ "Yellow on position 14": one thing of that colour, since one position is named."""
    before = words[i - 1].text if i else "."
    if words[i].text not in scene.colours or not (before in _OPENING or before in _PUTTING) or i + 2 >= len(words):
        return None
    if words[i + 1].text not in _ONTO | {"at"}:
        return None
    named = next((m for m in mentions_in(words[i + 2 :], scene) if m.start == 0), None)
    if named is None or scene[named.id].movable or not scene.single(named.id):
        return None
    ids = tuple(sorted((e.id for e in scene.objects if words[i].text in e.colour), key=natural))
    return Meant(i, i + 1, ids)


def _several(words: Sequence[Token], i: int, scene: Scene, where: dict[str, str | None]) -> Meant | None:
    """ "Two of the green blocks", "both yellow ones", "all three drinks"."""
    before = words[i - 1] if i else None
    if before is not None and (
        before.text in _EXACTLY | {"any"} or before.text in lexicon().sizes or _numbers(before, scene)
    ):
        return None
    j, exactly, count = i, False, None
    while j < len(words) and (words[j].text in _EXACTLY or words[j].text in {"exactly", "just", "only", "any"}):
        exactly = exactly or words[j].text in _EXACTLY
        count = 2 if words[j].text == "both" else count
        if words[j].text == "any":
            return None
        j += 1
    one = [t.text for t in words[j : j + 2]] == ["one", "of"]
    number = words[j].number if j < len(words) else None
    if number is not None and (words[j].text != "one" or one):
        count, j = int(number) if number.isdecimal() else None, j + 1
    if count is None or not int(not one) < count < 100:
        return None
    if j < len(words) and words[j].text == "of":
        exactly = False
    while j < len(words) and words[j].text in {"of", "the", "these", "those", "my", "other"}:
        if words[j].text == "other":
            return None
        j += 1
    end = next((k + 1 for k in range(j, min(len(words), j + _LONGEST)) if _plural(words[k], scene)), 0)
    phrase = [t for t in words[j:end] if t.text != "ones"]
    if not end or any(t.text in lexicon().sizes or t.text in lexicon().ordinals or not t.word for t in phrase):
        return None
    if not phrase or rank_of(words, j, end) is not None:
        return None
    found = resolve_objects((Token("all", phrase[0].start, phrase[0].start), *phrase), scene, Talk())
    if not isinstance(found, Found) or found.corrected:
        return None
    ids, stop = _there(words, end, found.ids, scene, where)
    ids, stop = (ids, stop) if len(ids) >= count else (found.ids, end)  # it says where to
    if _tells(words, stop, scene) and words[stop].text != "with":
        return None
    listed = len(phrase) == 1 and end < len(words) and not words[end].word
    if listed and scene.word(phrase[0], True).text in lexicon().anything:
        return None  # "three things: the bread, the milk and the apple"
    return Meant(i, stop, ids, count, exactly)


def _plural(t: Token, scene: Scene) -> bool:
    if t.text == "ones":
        return True
    word = scene.word(t, True)
    return bool(word.text) and word.plural and not word.corrected


def _numbers(t: Token, scene: Scene) -> bool:
    """Whether a number after this word names something: "object 2"."""
    return any(t.text in e.stem for e in (*scene.objects, *scene.places) if e.number is not None)


def _bare(words: Sequence[Token], i: int, scene: Scene) -> bool:
    """Whether a phrase in a telegram's style begins: a colour with no article before it ("red block to level 2")."""
    before = words[i - 1].text if i else "."
    opens = before in _OPENING | {"me", "gimme"} or before in _PUTTING | _FETCHING
    ranks = words[i].text in lexicon().sizes and rank_of(words, i, i + 1) is not None
    return opens and (words[i].text in scene.colours or ranks)


def _noun(words: Sequence[Token], i: int, scene: Scene) -> int:
    """Where the noun phrase that begins with an article at i ends; 0 where it is none about a single object."""
    for j in range(i + 1, min(len(words), i + 1 + _LONGEST)):
        t = words[j]
        after = words[j + 1] if j + 1 < len(words) else None
        if t.text == "one" and j > i + 1:
            return j + 1
        if not t.word or lexicon().is_(t.text, "all", "both", "rest", "same") or (t.number and t.text != "one"):
            return 0
        if t.text in lexicon().ordinals or t.text in lexicon().sizes or rank_of((t,), 0, 1) is not None:
            continue
        word = scene.word(t, True)
        if not word.text or word.corrected or word.text in MASS:
            return 0
        if word.text not in scene.colours:
            if after is not None and after.text == "of" and word.text in lexicon().objects:
                return 0  # "the piece of furniture"
            return 0 if word.plural or (after is not None and after.number is not None) else j + 1
        if _alone(words, i, j, scene):
            return j + 1
    return 0


def _alone(words: Sequence[Token], i: int, j: int, scene: Scene) -> bool:
    """ "The yellow is ...", "the green's spot", "the red on level 2": a colour that no noun follows. In a text where
    the colour is a thing's name too ("orange"), or begins a list ("the red and green ones"), it is none."""
    if words[j].text.endswith("s") or words[i].text in _INDEFINITE:
        return False
    if words[j].owner or j + 1 >= len(words):
        return True
    after = words[j + 1]
    known = scene.word(after, True).text or after.text in lexicon().sizes
    joins = after.text in {"one", "and", "or", ",", "-", "but", "pair", "lot", "stuff"} and after.text != ","
    verb = after.text in _MODAL | _CLAUSE | _AT | _ONTO | _ENDING | _STANDING | _LINKING or not after.word
    return verb and not known and not joins and after.number is None


def _compared(
    words: Sequence[Token], start: int, end: int, line: str, scene: Scene, where: dict[str, str | None]
) -> Meant | None:
    """ "The block that is smaller than object 1": what compares so with one thing that is named, or nothing."""
    begin = end
    while begin < len(words) and words[begin].text in _STANDING:
        begin += 1
    of = comparison(words, begin)
    mark = landmark(words, of.mark, scene) if of is not None else None
    phrase = [t for t in words[start:end] if t.text not in {"one", "thing"}]
    if of is None or mark is None or len(mark.ids) != 1 or any(t.text in lexicon().sizes for t in phrase):
        return None
    pool = World(scene, Ledger(dict(where)), where, Talk(where), line).every(phrase, True) if phrase else None
    if isinstance(pool, Fault):
        return None
    joined = [t.text for t in words[mark.end : mark.end + 1]] in (["and"], ["but"])
    if joined and _qualified(words, mark.end + 1, scene):
        return None
    every = pool[0] if pool is not None else [e.id for e in scene.objects]
    ids = of.among(every, mark.ids[0], scene)
    told = _clause(words, mark.end)
    there, stop = _there(words, mark.end, ids, scene, where) if told else (ids, mark.end)
    return Meant(start, stop, tuple(sorted(there, key=natural)), stop=stop)


def _qualified(words: Sequence[Token], at: int, scene: Scene) -> bool:
    """ "... and not yellow", "... but green": more that tells which one."""
    return at < len(words) and (words[at].text in scene.colours or lexicon().is_(words[at].text, "negation"))


def _clause(words: Sequence[Token], at: int) -> bool:
    """Whether a clause on where a thing stands begins right here: "that's on", "standing on", "from"."""
    return at < len(words) and (words[at].text in _CLAUSE or [t.text for t in words[at : at + 2]] == ["what", "is"])


def _ranked(
    words: Sequence[Token], start: int, end: int, line: str, scene: Scene, where: dict[str, str | None]
) -> Meant | None:
    """ "The second largest block", "the yellow block at the back": what has the rank, all of a tie."""
    of = rank_of(words, start, end) or _side(words, start, end, scene, where)
    if of is None:
        return None
    if (
        of.stop > end
        and [t.text for t in words[of.stop : of.stop + 1]] != ["of"]
        and not any(t.text in _ONTO for t in words[of.stop :])
    ):
        return None  # "put the red block on the right": it says where to
    world = World(scene, Ledger(dict(where)), where, Talk(where), line)
    pool = world.every(of.core, True)
    if isinstance(pool, Fault):
        return Meant(start, of.stop, ())
    ids, stop = _there(words, _all_there_is(words, of.stop), pool[0], scene, where)
    if not ids or _tells(words, stop, scene):
        return Meant(start, stop, ())
    found = world.ranked(of, True, ids, words[start : of.stop], False)
    hit = found.ids if isinstance(found, Found) else (found.candidates if found.code == "E304" else ())
    return Meant(start, of.stop, hit)


def _all_there_is(words: Sequence[Token], at: int) -> int:
    """Where words end that take nothing away: "the biggest block (you have, there is, of all)"."""
    said = [t.text for t in words[at : at + 4]]
    return at + max((len(p) for p in _EVERY if tuple(said[: len(p)]) == p), default=0)


def _side(words: Sequence[Token], start: int, end: int, scene: Scene, where: dict[str, str | None]) -> Ranked | None:
    """ "The block at the very back of the sorting area": of those that stand there."""
    of = side_of(words, start, end)
    if of is None:
        return None
    ids, stop = _there(words, of.stop - 1, [e.id for e in scene.objects], scene, where)
    core = tuple(t for t in of.core if t.text != "one")
    return replace(of, core=core, stop=of.stop - 1) if ids and stop >= of.stop else None


def _related(
    words: Sequence[Token], start: int, end: int, line: str, scene: Scene, where: dict[str, str | None]
) -> Meant | None:
    """ "The block next to object 5", where the relation tells which one; None where it says where it is to go."""
    begin = end
    while begin < len(words) and words[begin].text in _STANDING:
        begin += 1
    of = next((r for r in relations(words) if r.start == begin), None)
    stop = name_end(words, of) if of is not None else begin
    if of is None or not (begin > end or _goes_on(words, start, stop)):
        return None
    world = World(scene, Ledger(dict(where)), where, Talk(where), line)
    phrase = [t for t in words[start:end] if t.text != "one"]
    pool = world.every(phrase, True)
    mark = landmark(words, of.end, scene) if of.name != "between" else None
    some = mark is not None and words[mark.start].text in _INDEFINITE
    marks = world.landmark(words[of.end : stop]) if stop > of.end else None
    if mark is not None and (some or len(mark.ids) == 1):
        marks, stop = Found(mark.ids), mark.end
    if isinstance(pool, Fault) or not isinstance(marks, Found):
        return Meant(start, stop, ())
    ids: dict[str, None] = {}
    for each in [(m,) for m in marks.ids] if some else [marks.ids]:  # "next to a yellow one": to any of them
        found = world.related(of, pool[0], each, words[start:stop], False)
        near = found.ids if isinstance(found, Found) else (found.candidates if found.code == "E304" else ())
        ids |= dict.fromkeys(near)
    return Meant(start, stop, tuple(sorted(ids, key=natural)))


def _goes_on(words: Sequence[Token], start: int, stop: int) -> bool:
    """Whether another place is named after a relation, or the verb before it puts nothing anywhere."""
    after = list(takewhile(lambda t: t.text not in {".", ";", "!", "?"}, words[stop:]))
    said = _verbs(words[:start])
    return any(t.text in _ONTO for t in after) or bool(said and said[-1] in _FETCHING)


def _plain(words: Sequence[Token], start: int, end: int, scene: Scene, where: dict[str, str | None]) -> Meant | None:
    phrase = [t for t in words[start:end] if t.text != "one"]
    if not phrase or _parenthesis(words, end):
        return None
    if any(t.text in lexicon().sizes for t in phrase):  # "the big yellow block", of two
        sized = resolve_objects(phrase, scene, Talk())
        plain = isinstance(sized, Found) and not sized.chosen
        return Meant(start, end, sized.ids) if plain and isinstance(sized, Found) else None
    if any(t.text in lexicon().ordinals or t.text in _TELLING for t in phrase):
        return None
    every = (Token("all", phrase[0].start, phrase[0].start), *phrase)
    found = resolve_objects(every, scene, Talk())
    if not isinstance(found, Found):
        return None
    ids, stop = _there(words, end, found.ids, scene, where)
    told = stop if stop > end and _clause(words, end) else 0
    if stop > end and not told and _puts(words, start) and not _goes_on(words, start, stop):
        ids = found.ids  # "put the green block on the shelf": it says where to
    if stop == end and _elsewhere(words, end, scene):
        return Meant(start, end, ids)
    return None if _tells(words, stop, scene) else Meant(start, end, ids, stop=told)


def _puts(words: Sequence[Token], start: int) -> bool:
    """Whether the last verb before a phrase puts it somewhere, and not something else next to it."""
    if any(start - 2 < r.end <= start for r in relations(words)):
        return False
    said = _verbs(words[:start])
    return bool(said) and said[-1] in _PUTTING


def _verbs(words: Sequence[Token]) -> list[str]:
    """The verbs that put or fetch; "position 12" has none."""
    after = [*(t.number for t in words[1:]), None]
    return [t.text for t, n in zip(words, after, strict=False) if n is None and t.text in _PUTTING | _FETCHING]


def _elsewhere(words: Sequence[Token], end: int, scene: Scene) -> bool:
    """Whether a clause right behind a phrase names a place, where nothing of the kind is: "that is on the shelf"."""
    begin = end
    while begin < len(words) and words[begin].text in _STANDING:
        begin += 1
    led = end < begin < len(words) and _clause(words, end) and words[begin].text in {"on", "in", "at"}
    return led and place_named(words, begin + 1, scene)[0] is not None


def _parenthesis(words: Sequence[Token], at: int) -> bool:
    return at < len(words) and words[at].text == "("


def _there(
    words: Sequence[Token], at: int, ids: Sequence[str], scene: Scene, where: dict[str, str | None]
) -> tuple[tuple[str, ...], int]:
    """Those on the place that is named after the phrase, if some of them are there; and where those words end."""
    begin = at
    while begin < len(words) and words[begin].text in _STANDING:
        begin += 1
    rest = words[begin:]
    if rest and rest[0].text in _AT:
        end = next((k for k, t in enumerate(rest[1:]) if t.text in _ENDING), len(rest) - 1)
        for length in range(min(6, end), 0, -1):
            place = resolve_places(rest[1 : 1 + length], scene, Talk())
            if isinstance(place, Found) and len(place.ids) == 1 and place.ids[0] in {p.id for p in scene.places}:
                there = tuple(o for o in ids if scene.within(where.get(o), place.ids[0]))
                if there:
                    return there, begin + 1 + length
    return tuple(ids), at


def place_named(words: Sequence[Token], at: int, scene: Scene) -> tuple[str | None, int]:
    """The one place that is named right here by words that name nothing else, and where they end."""
    limit = next((k for k in range(at, len(words)) if words[k].text in _ENDING), len(words))
    for length in range(min(6, limit - at), 0, -1):
        found = resolve_places(words[at : at + length], scene, Talk())
        if isinstance(found, Found) and len(found.ids) == 1 and found.ids[0] in {p.id for p in scene.places}:
            return found.ids[0], at + length
    return None, at


def _tells(words: Sequence[Token], at: int, scene: Scene) -> bool:
    """Whether what stands right after a phrase may tell which one is meant, in words that are not understood here."""
    if at >= len(words) or words[at].text not in _TELLING:
        return False
    if words[at].text == "with":  # "swap the red block with the white one"
        return not (at + 1 < len(words) and words[at + 1].text in _POINTING and _noun(words, at + 1, scene))
    if any(r.start == at for r in relations(words)):
        return False  # it says where to
    if words[at].text in {"that", "which"} and at + 1 < len(words) and words[at + 1].text in _MODAL:
        return False  # "the green one that must go to level 2"
    if words[at].text == "in":  # "in the sorting area", which is a destination; "in front", which tells
        return at + 1 < len(words) and words[at + 1].text in {"front", "between"}
    return words[at].text != "over"
