"""Phrases that tell a thing by another: "the block next to object 5", "the one that is smaller than the red"."""

from __future__ import annotations

from collections.abc import Sequence

from llmbt_compiler.checking.comparisons import comparison
from llmbt_compiler.checking.referring.landmarks import landmark, pointed_to
from llmbt_compiler.checking.referring.lists import INDEFINITE, STANDING
from llmbt_compiler.checking.referring.model import Meant
from llmbt_compiler.checking.referring.nouns import all_of
from llmbt_compiler.checking.referring.standing import clause, goes_on, puts, standing_there
from llmbt_compiler.checking.sentences import sentence_at
from llmbt_compiler.parsing.ledger import Ledger
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.names import Fault, Found, Talk
from llmbt_compiler.parsing.scene import Scene, natural
from llmbt_compiler.parsing.space.expressions import Relation, relations
from llmbt_compiler.parsing.space.reading import name_end
from llmbt_compiler.parsing.space.world import World
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["compared", "related"]

_EVERY = frozenset({"both", "either", "any", "all", "each", "every"})
_NEIGHBOURS = frozenset({"neighbour", "neighbor", "neighbours", "neighbors"})


def related(
    words: Sequence[Token], start: int, end: int, line: str, scene: Scene, where: dict[str, str | None]
) -> Meant | None:
    """ "The block next to object 5", where the relation tells which one; None where it says where it is to go."""
    begin = end
    while begin < len(words) and words[begin].text in STANDING:
        begin += 1
    by = _by_neighbour(words, start, end, line, scene, where)
    if by is not None:
        return by
    of = next((r for r in relations(words) if end <= r.start <= begin), None)
    stop = name_end(words, of) if of is not None else begin
    if of is None or not (begin > end or goes_on(words, start, stop) or _destined(words, start, scene)):
        return None
    it = pointed_to(words, of.end, scene)
    if (stop == of.end and not of.owner and it is None) or (it is not None and puts(words, start)):
        return None  # "a red thing behind", "put the red one right next to it"
    world = World(scene, Ledger(dict(where)), where, Talk(where), line)
    phrase = [t for t in words[start:end] if t.text != "one"]
    pool = world.every(phrase, True)
    mark = (it or landmark(words, of.end, scene)) if of.name != "between" else None
    some = mark is not None and words[mark.start].text in INDEFINITE
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


def _destined(words: Sequence[Token], start: int, scene: Scene) -> bool:
    """Whether its sentence has named one position before, so that what follows can only tell which thing goes there."""
    begin, _ = sentence_at(words, start)
    return any(begin <= m.start < start and scene.single(m.id) for m in mentions_in(words, scene))


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


def compared(
    words: Sequence[Token], start: int, end: int, line: str, scene: Scene, where: dict[str, str | None]
) -> Meant | None:
    """ "The block that is smaller than object 1": what compares so with one thing that is named, or nothing."""
    begin = end + 2 * ([t.text for t in words[end : end + 2]] == [",", "one"])
    begin += int(words[begin : begin + 1] != () and words[begin : begin + 1][0].text == "," and begin == end)
    while begin < len(words) and words[begin].text in STANDING:
        begin += 1
    of = comparison(words, begin)
    mark = _marks(words, of.mark, scene, where) if of is not None else None
    phrase = [t for t in words[start:end] if t.text not in {"one", "thing"}]
    if of is None or mark is None or not mark.ids or any(t.text in lexicon().sizes for t in phrase):
        return None
    pool = World(scene, Ledger(dict(where)), where, Talk(where), line).every(phrase, True) if phrase else None
    if isinstance(pool, Fault):
        return None
    joined = [t.text for t in words[mark.end : mark.end + 1]] in (["and"], ["but"])
    if joined and _qualified(words, mark.end + 1, scene):
        return None
    every = pool[0] if pool is not None else [e.id for e in scene.objects]
    ids = tuple(i for i in every if all(i in of.among(every, m, scene) for m in mark.ids))
    told = clause(words, mark.end)
    there, stop = standing_there(words, mark.end, ids, scene, where) if told else (ids, mark.end)
    return Meant(start, stop, tuple(sorted(there, key=natural)), stop=stop)


def _marks(words: Sequence[Token], at: int, scene: Scene, where: dict[str, str | None]) -> Meant | None:
    """What is compared with: one thing, or all of several ("than both yellows", "than either of the greens")."""
    of_all = at < len(words) and words[at].text in _EVERY
    first = at + 1 + int(of_all and [t.text for t in words[at + 1 : at + 2]] == ["of"]) if of_all else at
    while of_all and first < len(words) and lexicon().is_(words[first].text, "articles"):
        first += 1
    for stop in (first + 2, first + 1) if of_all else ():
        found = all_of(words[first:stop], scene, where) if first < stop <= len(words) else None
        if isinstance(found, Found) and not found.corrected:
            return Meant(at, stop, found.ids, len(found.ids))
    mark = landmark(words, at, scene)
    return mark if mark is not None and len(mark.ids) == 1 else None


def _qualified(words: Sequence[Token], at: int, scene: Scene) -> bool:
    """ "... and not yellow", "... but green": more that tells which one."""
    return at < len(words) and (words[at].text in scene.colours or lexicon().is_(words[at].text, "negation"))
