"""Noun phrases of a request, and the objects that each may mean on the map as it is at the start."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile

from llmbt_compiler.checking.comparisons import comparison
from llmbt_compiler.checking.sentences import sentence_at
from llmbt_compiler.checking.telling import along, entered, hearsay, uncheckable
from llmbt_compiler.parsing.ledger import Ledger
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.names import Fault, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene, natural
from llmbt_compiler.parsing.space.expressions import Ranked, Relation, rank_of, relations, side_of
from llmbt_compiler.parsing.space.reading import name_end
from llmbt_compiler.parsing.space.world import World
from llmbt_compiler.parsing.words import Token, lexicon, singulars

__all__ = ["MASS", "Meant", "landmark", "meant_objects", "place_named"]

_POINTING = frozenset({"the", "that", "this", "my", "your", "her", "his", "our", "their"})
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
_MODAL = frozenset({"must", "should", "has", "needs", "ought", "goes", "shall", "may", "can", "will", "belongs"})
_AT = frozenset({"on", "in", "at", "from", "of", "off"})
_DOWN = frozenset({"down", "up", "over", "out", "back"})
_ENDING = frozenset({"on", "onto", "in", "into", "at", "from", "to", "and", ",", ".", "then", "over"})
_ONTO = frozenset({"on", "onto", "in", "into", "to", "next", "beside", "between", "above", "below"})
MASS = frozenset({"cargo", "good", "everything", "stuff"})
_PUTTING = frozenset({"put", "place", "set", "move", "lay", "position", "stand", "shift", "drop", "stow", "store"})
_FETCHING = frozenset({"pick", "take", "bring", "get", "fetch", "grab", "give", "hand", "want", "need", "collect"})
_OPENING = frozenset({".", ",", ";", ":", "!", "?", "and", "then"})
_OTHERS = frozenset({"they", "theyre", "she", "shes", "he", "hes", "theyve", "theyll", "somebody", "someone"})
"""Who else wants or does something: what is said of them orders nothing."""
_EVERY = frozenset(
    tuple(p.split())
    for p in (
        "you have", "we have", "i have", "you own", "we own", "youve got", "weve got", "ive got", "you can find",
        "you can see", "there is", "available", "of all", "of them all", "of the lot", "of the whole lot", "of them",
        "in the scene", "on the map", "around",
    )
)  # fmt: skip
_NOUNS = frozenset({
    "one", "ones", "pair", "couple", "neighbour", "neighbor", "trio", "half", "side", "part", "kind", "sort", "lot",
    "already", "there", "friend", "twin", "brother",
})  # fmt: skip
"""Words after a colour by which it is no noun, or told by more."""
_VAGUE = frozenset(
    tuple(p.split())
    for p in (
        "a few", "some", "several", "a couple of", "a handful of", "most of", "half of", "half", "a bunch of",
        "many of", "one or two", "two or three", "a pair of", "part of", "a number of",
    )
)  # fmt: skip
_STRESSING = frozenset({"very", "absolute", "absolutely", "single", "actual"})
_WHICHEVER = frozenset({"whichever", "whatever", "which"})
_IN_NOUN = _AT | {"that", "there"}
_NEIGHBOURS = frozenset({"neighbour", "neighbor", "neighbours", "neighbors"})
_USES = {"drink": "drink", "eat": "food", "snack": "snack"}
_LONGEST = 5


@dataclass(frozen=True, slots=True)
class Meant:
    """A phrase, words[start:end], and all the things that it fits. `count`: of how many of them it speaks (0: of all);
    `exactly`: it says that there are no more ("both", "all three"); `stop`: where a clause ends that tells more of it
    ("that's on the shelf"), or 0; `vague`: of how many it speaks is not said ("a few of the greens")."""

    start: int
    end: int
    ids: tuple[str, ...]
    count: int = 1
    exactly: bool = False
    stop: int = 0
    vague: bool = False

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
    group: tuple[str, ...] = ()
    for i, t in enumerate(words):
        before |= earlier.get(i, set())
        found = (
            _several(words, i, scene, where)
            or _some_of(words, i, scene, where)
            or _something(words, i, scene)
            or _something_compared(words, i, line, scene, where)
            or _told_alone(words, i, scene)
            or _one_there(words, i, scene, where, group)
            or _colour_alone(words, i, scene)
        )
        if found is not None:
            before |= set(found.ids)
            group = found.ids if len(found.ids) == found.count else group
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
                or _ranked(words, i + 1, end, line, scene, where, group)
                or _related(words, i + 1, end, line, scene, where)
                or _plain(words, i + 1, end, scene, where)
            )
            if found is not None and entered(words, i):
                found = None
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
    several = _several(words, at, scene, where) or _one_there(words, at, scene, where)
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


def _something_compared(
    words: Sequence[Token], i: int, line: str, scene: Scene, where: dict[str, str | None]
) -> Meant | None:
    """ "Something bigger than object 1", "one that's smaller than the red"."""
    if words[i].text not in {"something", "one"} or (words[i].text == "one" and i and words[i - 1].text != ","):
        return None
    found = _compared(words, i + 1, i + 1, line, scene, where)
    return replace(found, start=i) if found is not None and found.ids else None


def _told_alone(words: Sequence[Token], i: int, scene: Scene) -> Meant | None:
    """ "The one that Marta wants", "whatever Tom ordered": it may be anything."""
    one = words[i].text in _POINTING and [t.text for t in words[i + 1 : i + 2]] == ["one"]
    any_ = words[i].text in {"whatever", "what"} and i + 1 < len(words) and words[i + 1].text != "you"
    end = i + 2 if one else i + 1
    before = words[:i]
    if not (one or any_) or any(t.text in scene.colours for t in before):
        return None
    if not uncheckable(words, end, scene, opened=any_) or any(scene[m.id].movable for m in mentions_in(before, scene)):
        return None
    return Meant(i, end, tuple(sorted((e.id for e in scene.objects), key=natural)))


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
    if exactly and j < len(words) and words[j].text in _AT:  # "those two on the shelf"
        there, stop = _there(words, j, [e.id for e in scene.objects], scene, where)
        return Meant(i, stop, there, count, exactly) if len(there) == count else None
    end = next((k + 1 for k in range(j, min(len(words), j + _LONGEST)) if _plural(words[k], scene)), 0)
    phrase = [t for t in words[j:end] if t.text != "ones"]
    if not end or any(t.text in lexicon().sizes or t.text in lexicon().ordinals or not t.word for t in phrase):
        return None
    if not phrase or rank_of(words, j, end) is not None:
        return None
    found = _all_of(phrase, scene, where)
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


def _some_of(words: Sequence[Token], i: int, scene: Scene, where: dict[str, str | None]) -> Meant | None:
    """ "A few of these blocks", "some of the greens", "a couple of drinks": which, and how many?"""
    said = [t.text for t in words[i : i + 4]]
    size = max((len(p) for p in _VAGUE if tuple(said[: len(p)]) == p), default=0)
    j = i + size
    while size and j < len(words) and words[j].text in {"of", "the", "these", "those", "my", "our", "more"}:
        j += 1
    end = next((k + 1 for k in range(j, min(len(words), j + 3)) if _plural(words[k], scene)), 0) if size else 0
    phrase = [t for t in words[j:end] if t.text != "ones"]
    if not phrase or any(not t.word for t in phrase) or rank_of(words, j, end) is not None:
        return None
    found = resolve_objects((Token("all", phrase[0].start, phrase[0].start), *phrase), scene, Talk())
    if not isinstance(found, Found) or found.corrected:
        return None
    ids, stop = _there(words, end, found.ids, scene, where)
    return Meant(i, stop, ids, 0, vague=True)


def _one_there(
    words: Sequence[Token], i: int, scene: Scene, where: dict[str, str | None], group: Sequence[str] = ()
) -> Meant | None:
    """ "The one on level 1", "that one in the sorting area": what stands there, of those named before."""
    if words[i].text not in _POINTING or [t.text for t in words[i + 1 : i + 2]] != ["one"]:
        return None
    ids, stop = _there(words, i + 2, [e.id for e in scene.objects], scene, where)
    if stop == i + 2 or _puts(words, i) or _tells(words, stop, scene):
        return None
    named = {o for t in words[:i] for o in where if t.text in scene[o].colour} if not group else set(group)
    return Meant(i, stop, tuple(o for o in ids if o in named) or tuple(ids), stop=stop)


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
        if t.text in _STRESSING and after is not None and rank_of((after,), 0, 1) is not None:
            continue
        if hearsay(words, j, scene):
            continue
        word = scene.word(t, True)
        if not word.text or word.corrected or {word.text, t.text} & MASS:
            return 0
        if word.text in scene.colours:
            if _is_all(t, after, word.plural, scene):
                return j + 1
        else:
            if after is not None and after.text == "of" and word.text in lexicon().objects:
                return 0  # "the piece of furniture"
            return 0 if word.plural or (after is not None and after.number is not None) else j + 1
    return 0


def _is_all(colour: Token, after: Token | None, plural: bool, scene: Scene) -> bool:
    """Whether a colour is a noun itself: "the yellow, please", "smallest green and the red"."""
    if plural or colour.owner:
        return False
    if after is None or not (after.word or after.number is not None):
        return True
    if lexicon().is_(after.text, "joints", "at", "onto", "from"):
        return True
    noun = any(scene.word(after, m).text for m in (True, False)) or after.text in _NOUNS
    forms = {*singulars(after.text)}
    noun = noun or any(forms & g for g in (*lexicon().groups, *map(frozenset, lexicon().shapes.values())))
    return not (noun or after.text in lexicon().ordinals or after.text in lexicon().sizes or after.digits)


def _compared(
    words: Sequence[Token], start: int, end: int, line: str, scene: Scene, where: dict[str, str | None]
) -> Meant | None:
    """ "The block that is smaller than object 1": what compares so with one thing that is named, or nothing."""
    begin = end + 2 * ([t.text for t in words[end : end + 2]] == [",", "one"])
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
    words: Sequence[Token],
    start: int,
    end: int,
    line: str,
    scene: Scene,
    where: dict[str, str | None],
    group: Sequence[str] = (),
) -> Meant | None:
    """ "The second largest block", "the yellow block at the back": what has the rank, all of a tie. "The middle one" is
    one of the `group` that was named before."""
    of = rank_of(words, start, end) or _of_one(words, start, end) or _side(words, start, end, scene, where)
    if of is None:
        return None
    if (
        of.stop > end
        and [t.text for t in words[of.stop : of.stop + 1]] != ["of"]
        and not any(t.text in _ONTO for t in words[of.stop :])
    ):
        return None  # "put the red block on the right": it says where to
    world = World(scene, Ledger(dict(where)), where, Talk(where), line)
    core = [t for t in of.core if t.text != "one" and t.text not in _STRESSING]
    if not core and not group:
        told = _predicated(words, start, scene, where)
        group = told or group
    if not core and not group and _of_some(words, start, of.stop, scene):
        return Meant(start, of.stop, ())
    pool = world.every(core, True) if core else (tuple(group) or tuple(e.id for e in scene.objects),)
    if isinstance(pool, Fault):
        return Meant(start, of.stop, ())
    ids, stop = _there(words, _all_there_is(words, of.stop), pool[0], scene, where)
    if not ids or _tells(words, stop, scene):
        return Meant(start, stop, ())
    found = world.ranked(replace(of, core=tuple(core)), True, ids, words[start : of.stop], False)
    hit = found.ids if isinstance(found, Found) else (found.candidates if found.code == "E304" else ())
    return Meant(start, of.stop, hit)


def _predicated(words: Sequence[Token], start: int, scene: Scene, where: dict[str, str | None]) -> tuple[str, ...]:
    """ "Whichever item on the table is (the rightmost one)": of what a rank is said."""
    begin, _ = sentence_at(words, start)
    led = start - 2 > begin and words[start - 1].text == "the" and words[start - 2].text in {"is", "are"}
    which = next((k for k in range(begin, start - 2) if words[k].text in _WHICHEVER), None) if led else None
    end = next((k + 1 for k in range((which or 0) + 1, start - 2) if words[k].text in _IN_NOUN), start - 2)
    phrase = words[which + 1 : end - int(end < start - 2)] if which is not None else ()
    if not phrase:
        return ()
    found = resolve_objects((Token("all", phrase[0].start, phrase[0].start), *phrase), scene, Talk())
    if not isinstance(found, Found):
        return ()
    return _there(words, end - int(end < start - 2), found.ids, scene, where)[0]


def _of_one(words: Sequence[Token], start: int, end: int) -> Ranked | None:
    """ "The biggest one": its "one" counts nothing."""
    of = rank_of(words, start, end - 1) if words[end - 1].text == "one" and end - 1 > start else None
    return replace(of, stop=end) if of is not None and of.stop == end - 1 else None


def _of_some(words: Sequence[Token], start: int, stop: int, scene: Scene) -> bool:
    """Whether "the bigger one" is one of things that are named elsewhere: "of the greens", "one of the two"."""
    two = any(t.text.endswith("er") for t in words[start:stop])
    of = stop < len(words) and words[stop].text == "of"
    of = of and _all_there_is(words, stop) == stop
    pair = any(t.text == "pair" or (t.word and len(t.text) > 3 and _plural(t, scene)) for t in words[:start])
    return two or of or pair


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
    by = _by_neighbour(words, start, end, line, scene, where)
    if by is not None:
        return by
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


def _by_neighbour(
    words: Sequence[Token], start: int, end: int, line: str, scene: Scene, where: dict[str, str | None]
) -> Meant | None:
    """ "The green block with a yellow neighbour", "that has the red one as its neighbour", or beside it."""
    told = [t.text for t in words[end : end + 2]]
    whose = len(told) == 2 and told[0] == "whose" and told[1] in _NEIGHBOURS
    at = (
        end + 3
        if whose
        else end + 1
        if told[:1] == ["with"]
        else end + 2
        if told in (["that", "has"], ["which", "has"])
        else 0
    )
    if not at:
        return None
    noun = next((k for k in range(at + 1, min(len(words), at + 8)) if words[k].text in _NEIGHBOURS), None)
    mark = landmark(words, at, scene)
    ids: tuple[str, ...] = ()
    stop = at
    world = World(scene, Ledger(dict(where)), where, Talk(where), line)
    if whose:
        every = world.every(words[at : at + 1], True) if at < len(words) else None
        plain = isinstance(every, tuple) and words[at].text in scene.colours
        ids = mark.ids if mark is not None else every[0] if isinstance(every, tuple) and plain else ()
        stop = mark.end if mark is not None else at + 1
    elif mark is not None:
        of = next((r for r in relations(words) if r.start == mark.end and r.name == "next"), None)
        behind = of is not None and (bool(of.owner) or [t.text for t in words[of.end : of.end + 1]] == ["it"])
        as_its = noun is not None and mark.end < noun and words[mark.end].text in {"as", "for"}
        if of is not None and behind:
            ids, stop = mark.ids, of.end + int(not of.owner)
        elif noun is not None and as_its:
            ids, stop = mark.ids, noun + 1
    elif noun is not None:
        core = [t for t in words[at:noun] if not lexicon().is_(t.text, "articles")]
        every = world.every(core, True) if core else None
        ids, stop = (every[0], noun + 1) if isinstance(every, tuple) else ((), at)
    pool = world.every([t for t in words[start:end] if t.text != "one"], True) if ids else None
    if not isinstance(pool, tuple):
        return None
    near: dict[str, None] = {}
    for each in ids:
        found = world.related(Relation("next", end, stop), pool[0], (each,), words[start:stop], False)
        near |= dict.fromkeys(
            found.ids if isinstance(found, Found) else found.candidates if found.code == "E304" else ()
        )
    return Meant(start, stop, tuple(sorted(near, key=natural)))


def _goes_on(words: Sequence[Token], start: int, stop: int) -> bool:
    """Whether another place is named after a relation, or the verb before it puts nothing anywhere."""
    after = list(takewhile(lambda t: t.text not in {".", ";", "!", "?"}, words[stop:]))
    said = _verbs(words[:start])
    others = any(t.text in _OTHERS for t in words[sentence_at(words, start)[0] : start])
    aside = any(t.text in {"over", "along", "sideways"} for t in after)
    return aside or any(t.text in _ONTO for t in after) or bool(said and said[-1] in _FETCHING) or others


def _plain(words: Sequence[Token], start: int, end: int, scene: Scene, where: dict[str, str | None]) -> Meant | None:
    felt = [t for k, t in enumerate(words[start:end], start) if hearsay(words, k, scene)]
    phrase = [t for t in words[start:end] if t.text != "one" and t not in felt]
    named = mentions_in(words[:start], scene) or any(t.text in scene.colours for t in words[:start])
    if not phrase and felt and not named:
        phrase = [Token("object", words[start].start, words[start].start)]
    if not phrase or _parenthesis(words, end):
        return None
    if any(t.text in lexicon().sizes for t in phrase):  # "the big yellow block", of two
        most = _most(phrase, words, start, end, scene, where)
        if most:
            return Meant(start, end, most)
        sized = resolve_objects(phrase, scene, Talk())
        plain = isinstance(sized, Found) and not sized.chosen
        return Meant(start, end, sized.ids) if plain and isinstance(sized, Found) else None
    if any(t.text in lexicon().ordinals or t.text in _TELLING for t in phrase):
        return None
    found = _all_of(phrase, scene, where)
    if not isinstance(found, Found):
        return None
    ids, stop = _there(words, end, _from_before(words, start, found.ids, scene, where), scene, where)
    told = stop if stop > end and _clause(words, end) else 0
    if stop > end and not told and _puts(words, start) and not _goes_on(words, start, stop):
        ids = found.ids  # "put the green block on the shelf": it says where to
    if stop == end and _elsewhere(words, end, scene):
        return Meant(start, end, ids)
    return None if _tells(words, stop, scene) else Meant(start, end, ids, stop=told)


def _most(
    phrase: Sequence[Token], words: Sequence[Token], start: int, end: int, scene: Scene, where: dict[str, str | None]
) -> tuple[str, ...]:
    """ "The large block", of several sizes: the largest, all of a tie; none where it is said by more than that."""
    sizes = [t for t in phrase if t.text in lexicon().sizes]
    core = tuple(t for t in phrase if t not in sizes)
    end_of = {"large": "large", "big": "large", "small": "small", "little": "small", "tiny": "small"}
    if len(sizes) != 1 or sizes[0].text not in end_of or _tells(words, end, scene):
        return ()
    world = World(scene, Ledger(dict(where)), where, Talk(where), "")
    pool = world.every(core, True) if core else (tuple(e.id for e in scene.objects), False)
    if isinstance(pool, Fault) or len(pool[0]) < 2:
        return ()
    ids, _ = _there(words, end, pool[0], scene, where)
    found = world.ranked(Ranked(core, end_of[sizes[0].text], 1, end), True, ids, words[start:end], False)
    return found.ids if isinstance(found, Found) else (found.candidates if found.code == "E304" else ())


def _from_before(
    words: Sequence[Token], start: int, ids: Sequence[str], scene: Scene, where: dict[str, str | None]
) -> tuple[str, ...]:
    """ "From the bar, take the box": of those, what stands there."""
    begin = sentence_at(words, start)[0]
    led = begin < start and words[begin].text in {"from", "off"}
    place = place_named(words, begin + 1, scene)[0] if led else None
    there = tuple(i for i in ids if place is not None and scene.within(where.get(i), place))
    return there or tuple(ids)


def _all_of(phrase: Sequence[Token], scene: Scene, where: dict[str, str | None]) -> Found | Fault:
    """All that a noun phrase fits; a place before the noun tells where it stands ("the shelf blocks")."""
    found = resolve_objects((Token("all", phrase[0].start, phrase[0].start), *phrase), scene, Talk())
    place = resolve_places(phrase[:-1], scene, Talk()) if isinstance(found, Fault) and len(phrase) > 1 else None
    if not isinstance(place, Found) or len(place.ids) != 1 or place.ids[0] not in {p.id for p in scene.places}:
        return found
    all_ = resolve_objects((Token("all", phrase[-1].start, phrase[-1].start), phrase[-1]), scene, Talk())
    if not isinstance(all_, Found):
        return all_
    there = tuple(o for o in all_.ids if scene.within(where.get(o), place.ids[0]))
    return replace(all_, ids=there) if there else found


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
    if begin + 1 < len(words) and words[begin].text in _DOWN and words[begin + 1].text in _AT:
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
    if along(words, at):
        return True
    if at >= len(words) or words[at].text not in _TELLING or uncheckable(words, at, scene):
        return False
    if words[at].text == "with":  # "swap the red block with the white one"
        return not (at + 1 < len(words) and words[at + 1].text in _POINTING and _noun(words, at + 1, scene))
    if any(r.start == at for r in relations(words)):
        return False  # it says where to
    if words[at].text in {"that", "which"} and at + 1 < len(words) and words[at + 1].text in _MODAL:
        # "the green one that must go to level 2" does not tell, "that has a red neighbour" does
        return words[at + 1].text == "has" and [t.text for t in words[at + 2 : at + 3]] != ["to"]
    if words[at].text == "in":  # "in the sorting area", which is a destination; "in front", which tells
        return at + 1 < len(words) and words[at + 1].text in {"front", "between"}
    return words[at].text != "over"
