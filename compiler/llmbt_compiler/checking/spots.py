"""Place phrases of a request, and the places that each may mean on the map as it is at the start.

"The leftmost position of the shelf" (every level has one), "the empty spot next to object 3", "the other level", "the
piece of furniture with nothing on it". A phrase that only names a container ("level 2"), or leaves the choice open ("a
free position on level 2"), is none.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from llmbt_compiler.checking.referring import Meant, landmark
from llmbt_compiler.checking.sentences import sentence_at
from llmbt_compiler.parsing.ledger import Ledger
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Found, Talk
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene, natural
from llmbt_compiler.parsing.space.expressions import Ranked, Relation, rank_of, relations
from llmbt_compiler.parsing.space.world import Wanted, World
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["meant_places"]

_POINTING = frozenset({"the", "that", "its", "my", "our"})
_ENDS = frozenset({"end", "corner", "edge"})
_OUTER = frozenset({"outermost", "outer", "outside"})
_SURFACES = frozenset({"furniture", "surface"})
_SIDES = frozenset({"left", "right", "middle", "centre", "center"})
_HOLES = frozenset({"gap", "space", "hole", "place"})
_MARKING = frozenset({"far", "very", "-", "hand", "most", "only", "piece", "of", "furthest", "extreme"})
_STANDING = frozenset({
    "that", "which", "thats", "is", "stands", "lies", "sits", "currently", "now", "still", "already", "has", "are",
    "directly", "right", "immediately", "just", "up", "down", "there", "with",
})  # fmt: skip
_HAVING = frozenset({
    "with", "that", "which", "is", "thats", "has", "got", "only", "just", "holds", "holding", "a", "an", "exactly",
    "still", "so", "far", "currently",
})  # fmt: skip
_LED = frozenset({"please", "and", "then", "where", "for", "left", "right", "with"})
_IN = frozenset({"of", "on", "in", "at", "from"})
_POSSIBLE = frozenset({"possible", "can", "will", "goes", "go"})
_LONGEST = 7
_UNUSED = tuple(
    tuple(p.split())
    for p in (
        "nobody has", "no one has", "nobodys", "not taken", "isnt taken", "not occupied", "isnt occupied", "not used",
        "isnt used", "not in use", "isnt in use", "going spare", "going begging", "nobody is using", "nobody uses",
        "nothing has", "no block has", "still to be had", "has nothing", "untaken", "unused", "not yet taken",
    )
)  # fmt: skip
"""Says of a place that nothing stands there."""


@dataclass(frozen=True, slots=True)
class _Read:
    """A phrase as far as it is read: words[start:end] up to its noun, and what follows it."""

    start: int
    end: int
    stop: int
    pool: tuple[str, ...]
    rank: Ranked | None = None
    relation: Relation | None = None
    marks: tuple[str, ...] = ()
    container: str | None = None
    vacant: bool = False
    other: bool = False
    outer: bool = False
    level: str = ""
    held: int | None = None


def meant_places(words: Sequence[Token], line: str, scene: Scene, about: Sequence[str] = ()) -> Iterator[Meant]:
    """Every phrase for a place that needs the map to be understood, with the places that it fits; `about` is what may
    be moved there, for "the other level"."""
    where = {o.id: o.place for o in scene.map.objects}
    at = 0
    for i in range(len(words)):
        if i < at:
            continue
        extreme = _extreme(words, i, line, scene, where)
        if extreme is not None:
            yield extreme
            at = extreme.stop
            continue
        read = _read(words, i, scene)
        ids = _fits(read, words, line, scene, where, about) if read is not None else ()
        if read is not None and ids:
            yield Meant(i, read.stop, ids)
            at = read.stop


# -- reading -------------------------------------------------------------------------------------------------------


def _read(words: Sequence[Token], i: int, scene: Scene) -> _Read | None:
    bare = _ranks(words[i]) or _bare_side(words, i)
    told = _told_by_count(words, i, scene)
    if told is not None:
        return told
    other = _other_one(words, i, scene)
    if other:
        return _Read(i, i + 3, i + 3, other, other=True)
    begins = words[i].text in _POINTING or bare or _an_end(words, i)
    end = _head(words, i if bare else i + 1, scene) if begins else 0
    if not end or [t.text for t in words[max(0, i - 1) : i + 2]] == ["in", "the", "end"]:
        return None
    noun = words[end - 1]
    first = i if bare else i + 1
    inside = words[first : end - 1]
    read = _Read(
        i,
        end,
        end,
        _pool(noun, scene),
        rank=rank_of(words, first, end),
        vacant=any(lexicon().is_(t.text, "vacant") for t in inside),
        other=any(t.text == "other" for t in inside),
        outer=noun.text in _ENDS or any(t.text in _OUTER | _ENDS for t in inside),
        level=next((n for t in inside for n in ("top", "bottom") if lexicon().is_(t.text, n)), ""),
    )
    if read.rank is not None and read.rank.stop > end:
        read = replace(read, end=read.rank.stop, stop=read.rank.stop)
    return _after(read, words, scene)


def _told_by_count(words: Sequence[Token], i: int, scene: Scene) -> _Read | None:
    """ "(That level,) the one that's only got a single block on it": of the kind of place that was named last."""
    if [t.text for t in words[i : i + 2]] != ["the", "one"]:
        return None
    held = _holding(words, i + 2, scene)
    begin, _ = sentence_at(words, i)
    noun = next((k for k in range(i - 1, begin - 1, -1) if _noun(words[k], scene)), None)
    if held is None or noun is None or words[noun + 1].number is not None:
        return None
    return _Read(i, held[1], held[1], _pool(words[noun], scene), held=held[0])


def _holding(words: Sequence[Token], at: int, scene: Scene) -> tuple[int, int] | None:
    """ "(The level) with just one block on it", "that has two things on it": how many, and where it ends."""
    k = at
    while k < len(words) and words[k].text in _HAVING:
        k += 1
    only = any(t.text in {"a", "an"} for t in words[at:k])
    if k == at or k >= len(words) or not {"with", "has", "got", "holds", "holding"} & {t.text for t in words[at:k]}:
        return None
    number = words[k].number
    single = words[k].text in {"single", "lone", "solitary"}
    count = 1 if single or (only and number is None) else int(number) if number and number.isdecimal() else 0
    k += int(single or number is not None)
    if not count or k >= len(words) or not scene.word(words[k], True).text or words[k].text in scene.colours:
        return None
    k += 1
    stop = k
    while stop < len(words) and words[stop].text in {"on", "in", "it", "there", "standing", "already", "so", "far"}:
        stop += 1
    return (count, stop) if {"it", "there"} & {t.text for t in words[k:stop]} else None


def _other_one(words: Sequence[Token], i: int, scene: Scene) -> tuple[str, ...]:
    """ "(Red is on the wrong level, put it on) the other one": the places of the kind that was spoken of last."""
    if [t.text for t in words[i : i + 3]] != ["the", "other", "one"] or i < 3:
        return ()
    right = [t.text for t in words[i + 3 : i + 5]] in (["is", "right"], ["is", "correct"])
    if words[i - 1].text not in {"on", "to", "onto", "into", "in"} and not right:
        return ()
    noun = next((k for k in range(i - 1, -1, -1) if _noun(words[k], scene) and k + 1 < len(words)), None)
    if noun is None or words[noun + 1].number is not None or words[noun].text in _ENDS | _SURFACES | _HOLES:
        return ()
    return _pool(words[noun], scene)


def _extreme(words: Sequence[Token], i: int, line: str, scene: Scene, where: dict[str, str | None]) -> Meant | None:
    """ "All the way to the left", "as far right as possible": the end of each row, or of the level that is named."""
    said = [t.text for t in words[i : i + 8]]
    way = said[:3] == ["all", "the", "way"] and set(said[3:5]) <= {"to", "the", "over", "on", "at"}
    said_on = [t.text for t in words[i : i + 14]]
    far = said[:2] == ["as", "far"] and "as" in said_on[2:] and bool(_POSSIBLE & set(said_on[3:]))
    side = next((k for k, w in enumerate(said[2:6], 2) if w in {"left", "right"}), None) if way or far else None
    if side is None or said[side + 1 : side + 2] in (["of"], ["hand"]):
        return None
    stop = i + side + 1
    while far and stop < len(words) and words[stop].text in _POSSIBLE | {"as", "it", "you"}:
        stop += 1
    pool = tuple(p.id for p in scene.places if scene.single(p.id) and not p.person)
    read = _Read(i, stop, stop, pool)
    level = _named_level(read, words, scene)
    if level == ANYWHERE:
        return None
    pool = tuple(p for p in pool if level is None or scene.within(p, level))
    ends = World(scene, Ledger(dict(where)), where, Talk(where), line).ends(pool, said[side], 1)
    return Meant(i, stop, ends, stop=stop) if ends else None


def _an_end(words: Sequence[Token], i: int) -> bool:
    """ "At one end of level 2", "in a corner": which of them?"""
    after = [t.text for t in words[i + 1 : i + 5]]
    return words[i].text in {"a", "an", "one"} and (set(after[:1]) <= _ENDS | _OUTER or bool(_SURFACES & set(after)))


def _bare_side(words: Sequence[Token], i: int) -> bool:
    """ "Red block -> right end of shelf": a side without an article, after a mark or "to"."""
    before = words[i - 1] if i else None
    opens = before is not None and (not before.word or before.text in {"to", "on", "onto", "at", "in"})
    return opens and words[i].text in {"left", "right", "far"} and before is not None and before.number is None


def _ranks(t: Token) -> bool:
    return t.text in _OUTER or t.text in {"leftmost", "rightmost"}


def _head(words: Sequence[Token], first: int, scene: Scene) -> int:
    """Where a noun for places ends that only ranks, sides and the like stand before; 0 where there is none."""
    for j in range(first, min(len(words), first + _LONGEST)):
        t = words[j]
        after = words[j + 1] if j + 1 < len(words) else None
        if t.text in _SIDES and after is not None and after.text == "of" and j + 2 < len(words):
            return j + 1 if _container(words, j + 2, scene)[0] else 0
        if _noun(t, scene) and not (after is not None and (after.number is not None or _noun(after, scene))):
            return j + 1
        small = t.text in {*lexicon().ordinals, *_MARKING, *_OUTER, *_ENDS, *_SIDES, "other", "front", "back", "rear"}
        ranked = _ranks(t) or lexicon().is_(t.text, "vacant", "top", "bottom", "middle")
        if not (small or ranked or t.digits or t.glued):
            return 0
    return 0


def _noun(t: Token, scene: Scene) -> bool:
    if t.text in _ENDS | _SURFACES | _HOLES | scene.generic(False):
        return True
    return t.word and t.text in scene.vocabulary(False) and not lexicon().is_(t.text, "articles")


def _pool(noun: Token, scene: Scene) -> tuple[str, ...]:
    singles = tuple(p.id for p in scene.places if scene.single(p.id) and not p.person)
    open_ = tuple(p.id for p in scene.places if not p.person and not any(scene.map.containers(p.id)))
    if noun.text in _SIDES | _ENDS | _HOLES | scene.generic(False):
        return singles or open_
    if noun.text in _SURFACES:
        return open_ if not singles else ()
    fits = [p.id for p in scene.places if scene.fits(p, noun.text)]
    inner = (i for i in fits if not any(o != i and scene.within(o, i) for o in fits))  # of a well's wells the wells
    return tuple(sorted(inner, key=natural))


def _after(read: _Read, words: Sequence[Token], scene: Scene) -> _Read | None:
    """What stands behind the noun: a relation with its landmark, a container, that it is free."""
    at = read.end
    while at < len(words):
        begin = at
        held = _holding(words, begin, scene)
        if held is not None and read.held is None:
            read, at = replace(read, held=held[0], stop=held[1]), held[1]
            continue
        nothing = _nothing(words, begin)
        while begin < len(words) and words[begin].text in _STANDING and not nothing:
            if _relation(words, begin, scene):
                break
            begin += 1
            nothing = _nothing(words, begin)
        if nothing:
            read, at = replace(read, vacant=True, stop=nothing), nothing
            continue
        relation = _relation(words, begin, scene)
        if relation is not None and read.relation is None:
            ids, stop = _marks(words, relation, scene)
            if not ids:
                return None
            read, at = replace(read, relation=relation, marks=ids, stop=stop), stop
            continue
        if begin < len(words) and words[begin].text in _IN and read.container is None:
            container, stop = _container(words, begin + 1, scene)
            if not container:
                break
            read, at = replace(read, container=container, stop=stop), stop
            continue
        break
    return read


def _nothing(words: Sequence[Token], at: int) -> int:
    """ "Nothing on it", "free", "empty", right here: where it ends."""
    said = [t.text for t in words[at : at + 4]]
    unused = next((p for p in _UNUSED if tuple(said[: len(p)]) == p), ())
    if unused:
        return at + len(unused)
    if at < len(words) and words[at].text == "nothing":
        end = at + 1
        while end < len(words) and words[end].text in {"is", "on", "in", "it", "yet", "at", "all", "there", "standing"}:
            end += 1
        return end
    return at + 1 if at < len(words) and lexicon().is_(words[at].text, "vacant") else 0


def _relation(words: Sequence[Token], at: int, scene: Scene) -> Relation | None:
    """The relation that begins here; "to the left well" is none."""
    found = next((r for r in relations(words) if r.start == at), None)
    bare = found is not None and words[found.end - 1].text in _SIDES and found.end < len(words)
    return None if found is not None and bare and _noun(words[found.end], scene) else found


def _marks(words: Sequence[Token], relation: Relation, scene: Scene) -> tuple[tuple[str, ...], int]:
    """The landmarks of a relation and where they end; none where they are not plain."""
    if relation.owner:
        return (), relation.end
    first = landmark(words, relation.end, scene)
    if first is None or len(first.ids) != (2 if relation.name == "between" and first.many else 1):
        return (), relation.end
    if relation.name != "between" or first.many:
        return first.ids, first.end
    if first.end >= len(words) or words[first.end].text != "and":
        return (), relation.end
    second = landmark(words, first.end + 1, scene)
    if second is None or len(second.ids) != 1:
        return (), relation.end
    return (*first.ids, *second.ids), second.end


def _container(words: Sequence[Token], at: int, scene: Scene) -> tuple[str | None, int]:
    """The place with others in it that is named right here, and where its name ends."""
    for length in range(min(6, len(words) - at), 0, -1):
        parts = words[at : at + length]
        if any(not (t.word or t.number is not None) for t in parts):
            continue
        found = resolve_places(parts, scene, Talk())
        if isinstance(found, Found) and len(found.ids) == 1 and not {ANYWHERE, ORIGIN} & set(found.ids):
            return (None, at) if scene.single(found.ids[0]) else (found.ids[0], at + length)
    return None, at


# -- what it fits --------------------------------------------------------------------------------------------------


def _fits(
    read: _Read,
    words: Sequence[Token],
    line: str,
    scene: Scene,
    where: dict[str, str | None],
    about: Sequence[str],
) -> tuple[str, ...]:
    pool = read.pool
    taken = {p for p in where.values() if p is not None}
    container = read.container or (_named_level(read, words, scene) if _needs_level(read, scene) else None)
    if container == ANYWHERE:
        return ()
    if container is not None:
        pool = tuple(p for p in pool if scene.within(p, container) and p != container)
    if read.vacant:
        pool = tuple(p for p in pool if not any(scene.within(t, p) for t in taken))
    if read.other:
        here = {where.get(o) for o in about}
        around = {p for p in pool if any(h is not None and scene.within(h, p) for h in here)}
        return tuple(p for p in pool if p not in around) if len(about) == 1 and around else ()
    if read.level and any(scene.single(p) for p in pool):
        pool = _at_level(pool, read.level, scene)
    world = World(scene, Ledger(dict(where)), where, Talk(where), line)
    if read.relation is not None:
        wanted = Wanted(1, read.vacant or container is not None, True, container)
        found = world.spots(read.relation, read.marks, wanted, words[read.start : read.stop])
        ids = found.ids if isinstance(found, Found) else (found.candidates if found.code == "E304" else ())
        return tuple(i for i in ids if i in pool)
    if not all(scene.single(p) for p in pool) or not pool:
        if read.held is not None:
            return tuple(p for p in pool if sum(scene.within(w, p) for w in where.values()) == read.held)
        return pool if read.vacant and read.rank is None and not read.level else ()
    if read.outer and (read.rank is None or read.rank.plain) and _side(read, words) is None:
        ends = (*world.ends(pool, "left", 1), *world.ends(pool, "right", 1))
        return tuple(sorted(dict.fromkeys(ends), key=natural))
    if read.rank is not None:
        return world.ends(pool, read.rank.end, read.rank.rank)
    roomy = words[read.end - 1].text in {"space", "place"}  # "the free space on level 2" is any of it
    return pool if (read.vacant and not roomy) or read.level else ()


def _side(read: _Read, words: Sequence[Token]) -> str | None:
    said = [t.text for t in words[read.start : read.stop]]
    return next((s for s in ("left", "right", "leftmost", "rightmost") if s in said), None)


def _needs_level(read: _Read, scene: Scene) -> bool:
    return any(scene.single(p) for p in read.pool) and read.relation is None


def _named_level(read: _Read, words: Sequence[Token], scene: Scene) -> str | None:
    """The container that the sentence names beside the phrase ("level 2, middle slot"); ANYWHERE where it points to one
    ("that level")."""
    lo, _ = sentence_at(words, read.start)
    _, hi = sentence_at(words, read.stop)
    found = _levels(read, words, lo, hi, scene)
    if not found and lo:
        found = _levels(read, words, 0, hi, scene)  # "Red. Level 3. The end slot."
    return next(iter(found), None) if len(found) <= 1 else ANYWHERE


def _levels(read: _Read, words: Sequence[Token], lo: int, hi: int, scene: Scene) -> tuple[str, ...]:
    found: dict[str, None] = {}
    for k in (*range(lo, read.start), *range(read.stop, hi)):
        if words[k].text in {"same", "that", "this"} and k + 1 < hi and words[k + 1].text in scene.vocabulary(False):
            return (ANYWHERE,)
        container, _ = _container(words, k, scene) if words[k].word else (None, k)
        if container is not None and any(scene.single(p.id) for p in scene.map.inside(container)):
            deeper = any(scene.map.inside(p.id) for p in scene.map.inside(container))
            if not deeper:
                found[container] = None
    found |= dict.fromkeys(_at_very(read, words, lo, hi, scene)) if not found else {}
    return tuple(found)


def _at_very(read: _Read, words: Sequence[Token], lo: int, hi: int, scene: Scene) -> Iterator[str]:
    """ "Up top", "to the very top", "right at the bottom": the level, where no noun follows."""
    rows = scene.upwards(c for p in read.pool for c in tuple(scene.map.containers(p))[:1])
    for k in (*range(lo, read.start), *range(read.stop, hi)):
        after = words[k + 1] if k + 1 < len(words) else None
        alone = after is None or not (after.word or after.number is not None) or after.text in _LED | _IN
        led = k > lo and words[k - 1].text in {"the", "very", "up", "on", "at"}
        if words[k].text in {"top", "bottom"} and alone and led and len(rows) > 1:
            yield rows[-1] if words[k].text == "top" else rows[0]


def _at_level(pool: Sequence[str], level: str, scene: Scene) -> tuple[str, ...]:
    rows = scene.upwards(c for p in pool for c in tuple(scene.map.containers(p))[:1])
    row = rows[-1] if level == "top" else rows[0]
    return tuple(p for p in pool if scene.within(p, row)) if len(rows) > 1 else tuple(pool)
