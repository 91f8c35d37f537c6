"""Phrases that rank: "the second largest block", "the yellow one at the back"."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from llmbt_compiler.checking.referring.lists import AT, ONTO, STRESSING
from llmbt_compiler.checking.referring.model import Meant
from llmbt_compiler.checking.referring.nouns import all_of, plural
from llmbt_compiler.checking.referring.standing import puts, standing_there, tells
from llmbt_compiler.checking.sentences import ENDS, sentence_at
from llmbt_compiler.parsing.ledger import Ledger
from llmbt_compiler.parsing.names import Fault, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import Ranked, rank_of, side_of
from llmbt_compiler.parsing.space.world import World
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["most", "ranked"]

_EVERY = frozenset(
    tuple(p.split())
    for p in (
        "you have", "we have", "i have", "you own", "we own", "youve got", "weve got", "ive got", "you can find",
        "you can see", "there is", "available", "of all", "of them all", "of the lot", "of the whole lot", "of them",
        "in the scene", "on the map", "around",
    )
)  # fmt: skip
_WHICHEVER = frozenset({"whichever", "whatever", "which"})
_SIDES = {"back": "back", "front": "front", "left": "left", "right": "right", "rear": "back"}
_IN_NOUN = AT | {"that", "there"}


def ranked(
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
        and not any(t.text in ONTO for t in words[of.stop :])
    ):
        of = _at_a_side(words, start, end)
        if of is None:
            return None  # "put the red block on the right": it says where to
    world = World(scene, Ledger(dict(where)), where, Talk(where), line)
    core = [t for t in of.core if t.text != "one" and t.text not in STRESSING]
    if not core and not group:
        told = _predicated(words, start, scene, where)
        group = told or group or _group_before(words, start, scene, where)
    stop_of = of.stop
    if not core and [t.text for t in words[of.stop : of.stop + 1]] == ["of"]:
        group, stop_of = _group_behind(words, of.stop + 1, scene, where)
    if not core and not group and _of_some(words, start, of.stop, scene):
        return Meant(start, of.stop, ())
    pool = world.every(core, True) if core else (tuple(group) or tuple(e.id for e in scene.objects),)
    if isinstance(pool, Fault):
        return Meant(start, of.stop, ())
    ids, stop = standing_there(words, max(_all_there_is(words, of.stop), stop_of), pool[0], scene, where)
    if not ids or tells(words, stop, scene):
        return Meant(start, stop, ())
    found = world.ranked(replace(of, core=tuple(core)), True, ids, words[start : of.stop], False)
    hit = found.ids if isinstance(found, Found) else (found.candidates if found.code == "E304" else ())
    return Meant(start, of.stop, hit)


def _group_behind(
    words: Sequence[Token], at: int, scene: Scene, where: dict[str, str | None]
) -> tuple[tuple[str, ...], int]:
    """ "The left one of (the greens lying in the sorting area)": the group, where it is plain, and where it ends."""
    while at < len(words) and lexicon().is_(words[at].text, "articles"):
        at += 1
    for end in (at + 2, at + 1):
        if end > len(words) or not plural(words[end - 1], scene) or rank_of(words, at, end) is not None:
            continue
        found = all_of(words[at:end], scene, where)
        if isinstance(found, Found) and not found.corrected:
            return standing_there(words, end, found.ids, scene, where)
    return (), at


def _group_before(words: Sequence[Token], start: int, scene: Scene, where: dict[str, str | None]) -> tuple[str, ...]:
    """ "Of the blocks in the sorting area, set (the biggest) on level 2"."""
    begin, _ = sentence_at(words, start)
    led = begin < start and words[begin].text in {"of", "among", "amongst", "from"}
    group, stop = _group_behind(words, begin + 1, scene, where) if led else ((), begin)
    return group if stop <= start else ()


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
    return standing_there(words, end - int(end < start - 2), found.ids, scene, where)[0]


def _of_one(words: Sequence[Token], start: int, end: int) -> Ranked | None:
    """ "The biggest one": its "one" counts nothing."""
    of = rank_of(words, start, end - 1) if words[end - 1].text == "one" and end - 1 > start else None
    return replace(of, stop=end) if of is not None and of.stop == end - 1 else None


def _of_some(words: Sequence[Token], start: int, stop: int, scene: Scene) -> bool:
    """Whether "the bigger one" is one of things that are named elsewhere: "of the greens", "one of the two"."""
    two = any(t.text.endswith("er") for t in words[start:stop])
    of = stop < len(words) and words[stop].text == "of"
    of = of and _all_there_is(words, stop) == stop
    pair = any(t.text == "pair" or (t.word and len(t.text) > 3 and plural(t, scene)) for t in words[:start])
    return two or of or pair


def _all_there_is(words: Sequence[Token], at: int) -> int:
    """Where words end that take nothing away: "the biggest block (you have, there is, of all)"."""
    said = [t.text for t in words[at : at + 4]]
    return at + max((len(p) for p in _EVERY if tuple(said[: len(p)]) == p), default=0)


def _side(words: Sequence[Token], start: int, end: int, scene: Scene, where: dict[str, str | None]) -> Ranked | None:
    """ "The block at the very back of the sorting area": of those that stand there; "the yellow at the back"."""
    of = side_of(words, start, end)
    if of is None:
        return _at_a_side(words, start, end)
    ids, stop = standing_there(words, of.stop - 1, [e.id for e in scene.objects], scene, where)
    core = tuple(t for t in of.core if t.text != "one")
    return replace(of, core=core, stop=of.stop - 1) if ids and stop >= of.stop else None


def _at_a_side(words: Sequence[Token], start: int, end: int) -> Ranked | None:
    """ "I mean the yellow at the back", where nothing is put."""
    said = [t.text for t in words[end : end + 4]]
    if said[:2] not in (["at", "the"], ["in", "the"], ["on", "the"]) or puts(words, start):
        return None
    k = 3 if said[2:3] in (["very"], ["far"]) else 2
    side = _SIDES.get(said[k] if k < len(said) else "")
    after = words[end + k + 1].text if end + k + 1 < len(words) else "."
    core = tuple(t for t in words[start:end] if t.text != "one")
    return Ranked(core, side, 1, end) if side is not None and after in ENDS | {","} else None


def most(
    phrase: Sequence[Token], words: Sequence[Token], start: int, end: int, scene: Scene, where: dict[str, str | None]
) -> tuple[str, ...]:
    """ "The large block", of several sizes: the largest, all of a tie; none where it is said by more than that."""
    sizes = [t for t in phrase if t.text in lexicon().sizes]
    core = tuple(t for t in phrase if t not in sizes)
    end_of = {"large": "large", "big": "large", "small": "small", "little": "small", "tiny": "small"}
    if len(sizes) != 1 or sizes[0].text not in end_of or tells(words, end, scene):
        return ()
    world = World(scene, Ledger(dict(where)), where, Talk(where), "")
    pool = world.every(core, True) if core else (tuple(e.id for e in scene.objects), False)
    if isinstance(pool, Fault) or len(pool[0]) < 2:
        return ()
    ids, _ = standing_there(words, end, pool[0], scene, where)
    found = world.ranked(Ranked(core, end_of[sizes[0].text], 1, end), True, ids, words[start:end], False)
    return found.ids if isinstance(found, Found) else (found.candidates if found.code == "E304" else ())
