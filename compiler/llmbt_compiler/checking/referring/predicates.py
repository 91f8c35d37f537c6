"""Things told by a rank that is said of them in other words than "the largest block": "whichever one is biggest", "the
yellow block that lies further left", "of all the blocks the largest", "the one right at the very back"."""

from __future__ import annotations

from collections.abc import Sequence

from llmbt_compiler.checking.referring.landmarks import landmark
from llmbt_compiler.checking.referring.lists import AT, POINTING
from llmbt_compiler.checking.referring.model import Meant
from llmbt_compiler.checking.referring.nouns import noun, plural
from llmbt_compiler.checking.referring.standing import place_named, puts, standing_there
from llmbt_compiler.checking.sentences import sentence_at
from llmbt_compiler.checking.wording import listed
from llmbt_compiler.parsing.ledger import Ledger
from llmbt_compiler.parsing.names import Fault, Found, Talk
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import Ranked, rank_of, relations
from llmbt_compiler.parsing.space.world import World
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["predicated"]

_WHICHEVER = frozenset({"whichever", "whatever", "which", "what"})
_BEING = frozenset(
    {"is", "are", "stands", "sits", "lies", "looks", "happens", "seems", "standing", "lying", "sitting", "be"}
)
_STRESSING = frozenset({
    "the", "very", "absolute", "absolutely", "by", "far", "slightly", "clearly", "to", "be", "bit", "a",
    "currently", "now", "rather", "actually", "just", "right", "directly", "much",
})  # fmt: skip
_FURTHER = frozenset(
    {"further", "farther", "more", "furthest", "farthest", "most", "nearest", "closest", "nearer", "closer"}
)
_SIDES = {"left": "left", "right": "right", "front": "front", "back": "back", "rear": "back"}
_END_NOUNS = frozenset({"end", "side", "edge", "hand", "-", "most"})
_ENDS = ("large", "small", "tall", "short", "left", "right", "front", "back")
_ALL = frozenset({"all", "both", "the", "these", "those", "my", "our", "whole", "lot", "them", "of"})
_LONGEST = 9


def predicated(words: Sequence[Token], i: int, line: str, scene: Scene, where: dict[str, str | None]) -> Meant | None:
    """What has the rank that is said of a phrase that begins right here, all of a tie; None where none is said."""
    text = words[i].text
    if text in _WHICHEVER and (text in {"whichever", "whatever"} or _asks(words, i, scene)):
        return _which(words, i, line, scene, where)
    if text not in POINTING | {"a", "an", "one"}:
        return None
    end = noun(words, i, scene) or (i + 2 if [t.text for t in words[i + 1 : i + 2]] == ["one"] else 0)
    if end:
        return _relative(words, i, end, line, scene, where) or (
            _at_the_end(words, i, end, line, scene, where) or _in_the_middle(words, i, end, line, scene, where)
            if text in POINTING
            else None
        )
    return _headless(words, i, line, scene, where)


def _asks(words: Sequence[Token], i: int, scene: Scene) -> bool:
    """ "Which block is the largest?", "what's the biggest block?"."""
    begin, _ = sentence_at(words, i)
    return i == begin and words[i].text == "which" and i + 1 < len(words) and bool(scene.word(words[i + 1], True).text)


def _which(words: Sequence[Token], i: int, line: str, scene: Scene, where: dict[str, str | None]) -> Meant | None:
    """ "Whichever of the yellow blocks on the shelf is (further left)"."""
    stop = min(len(words), i + _LONGEST)
    verb = next((k for k in range(i + 1, stop) if words[k].text in _BEING), None)
    verb = i if words[i].owner else verb  # "whatever's furthest left"
    if verb is None or any(not t.word for t in words[i + 1 : verb]):
        return None
    rank = _rank_at(words, verb + 1)
    at = next((k for k in range(i + 1, verb) if words[k].text in AT - {"of"}), verb)
    pool = _pool(words[i + 1 : at], scene, line, where)
    if rank is None and pool is not None:
        return _beside(words, i, verb + 1, pool, line, scene, where)
    if rank is None or pool is None:
        return None
    ids, _ = standing_there(words, at, pool, scene, where) if at < verb else (pool, at)
    return _there(words, i, rank[1], ids, rank[0], line, scene, where)


def _beside(
    words: Sequence[Token], i: int, at: int, pool: Sequence[str], line: str, scene: Scene, where: dict[str, str | None]
) -> Meant | None:
    """ "Whatever stands (next to the red block)"."""
    of = next((r for r in relations(words) if r.start == at and r.name != "between"), None)
    mark = landmark(words, of.end, scene) if of is not None else None
    if of is None or mark is None or len(mark.ids) != 1 or not scene[mark.ids[0]].movable:
        return None
    found = World(scene, Ledger(dict(where)), where, Talk(where), line).related(
        of, pool, mark.ids, words[i : mark.end], False
    )
    ids = found.ids if isinstance(found, Found) else found.candidates if found.code == "E304" else ()
    return Meant(i, mark.end, ids, stop=mark.end) if ids else None


def _relative(
    words: Sequence[Token], i: int, end: int, line: str, scene: Scene, where: dict[str, str | None]
) -> Meant | None:
    """ "The yellow block that lies (more to the left)", "the block which is (larger than all the rest)"."""
    if end + 2 >= len(words):
        return None
    led = words[end].text in {"that", "which"} and words[end + 1].text in _BEING
    at = end + 2 if led else end + int(words[end].text in {"standing", "lying", "sitting"})
    rank = _rank_at(words, at) if led or words[at].text in _FURTHER else None
    pool = _of_those(words, i, scene, line, where) if words[end - 1].text == "one" and end == i + 2 else None
    pool = pool or _pool(words[i:end], scene, line, where)
    return _there(words, i, rank[1], pool, rank[0], line, scene, where) if rank is not None and pool else None


def _there(
    words: Sequence[Token], start: int, stop: int, pool: Sequence[str], end: str, line: str, scene: Scene,
    where: dict[str, str | None],
) -> Meant | None:  # fmt: skip
    """The same, of those on a place that is named right behind it: "(whatever stands furthest left) on the bar"."""
    ids, stop = standing_there(words, stop, pool, scene, where)
    return _ranked(words, start, stop, ids, end, line, scene, where)


def _at_the_end(
    words: Sequence[Token], i: int, end: int, line: str, scene: Scene, where: dict[str, str | None]
) -> Meant | None:
    """ "The one right at the very back of the sorting area"."""
    k = end
    while k < len(words) and words[k].text in _BEING | _STRESSING | {"that", "which", "there"} - {"to", "by", "the"}:
        k += 1
    if k >= len(words) or words[k].text not in {"at", "in", "on"}:
        return None
    k += 1
    while k < len(words) and words[k].text in {"the", "very", "far"}:
        k += 1
    side = _SIDES.get(words[k].text) if k < len(words) else None
    while k + 1 < len(words) and words[k + 1].text in _END_NOUNS:
        k += 1
    if side is None or k + 2 >= len(words) or words[k + 1].text not in {"of", "in", "on"}:
        return None
    place, stop = place_named(words, k + 2, scene)
    pool = _pool(words[i:end], scene, line, where)
    if place is None or scene.single(place) or pool is None:
        return None
    ids = tuple(o for o in pool if scene.within(where.get(o), place))
    return _ranked(words, i, stop, ids, side, line, scene, where) if len(ids) > 1 else None


def _in_the_middle(
    words: Sequence[Token], i: int, end: int, line: str, scene: Scene, where: dict[str, str | None]
) -> Meant | None:
    """ "(A green block, but not) the one in the middle of the three": the middle one of those named, or of its kind."""
    k = end
    while k < len(words) and words[k].text in _BEING | {"that", "which", "right"}:
        k += 1
    if [t.text for t in words[k : k + 2]] != ["in", "the"] or puts(words, i):
        return None
    k += 2 + int([t.text for t in words[k + 2 : k + 3]] == ["very"])
    if k >= len(words) or words[k].text not in {"middle", "centre", "center"}:
        return None
    said = [t.text for t in words[k + 1 : k + 4]]
    of = next((n for n in ((1, 2), (2, 3)) if said[:1] == ["of"] and len(said) >= n[1]), None)
    number = next((t.number for t in words[k + 1 : k + 4] if said[:1] == ["of"] and t.number is not None), None)
    ends = not said or not words[k + 1].word
    if not ends and (of is None or (number is None and not {"them", "all"} & set(said))):
        return None
    hues = [t.text for t in words[:i] if t.text in scene.colours]
    one = words[end - 1].text == "one" and end == i + 2
    pool = tuple(e.id for e in scene.objects if hues and hues[-1] in e.colour) if one else None
    pool = (pool or _of_those(words, i, scene, line, where)) if one else _pool(words[i:end], scene, line, where)
    if not pool or len(pool) < 3 or (number is not None and number != str(len(pool))):
        return None
    stop = k + 1 if ends else min(len(words), k + 2 + said.index(next(s for s in said[1:] if s != "the")))
    return _ranked(words, i, stop, pool, "left", line, scene, where, rank=0)


def _headless(words: Sequence[Token], i: int, line: str, scene: Scene, where: dict[str, str | None]) -> Meant | None:
    """ "Of all the blocks (the largest)", "the biggest of the greens": of all that are named beside it."""
    if words[i].text != "the" or i + 1 >= len(words) or not words[i + 1].text.endswith("est"):
        return None
    rank = _rank_at(words, i + 1)
    if rank is None or rank[1] != i + 2:
        return None
    short = (*words[: i + 1], *words[i + 2 :])
    end = noun(short, i, scene)
    if end and rank_of(words, i + 1, i + 2) is None:  # "the bulkiest block"
        ids, _ = standing_there(words, end + 1, _pool(short[i:end], scene, line, where) or (), scene, where)
        return _ranked(words, i, end + 1, ids, rank[0], line, scene, where)
    after = words[i + 2].text if i + 2 < len(words) else "."
    if after == "of":
        return None
    if scene.word(words[min(i + 2, len(words) - 1)], True).text:
        return None
    pool = _of_those(words, i, scene, line, where)
    return _ranked(words, i, i + 2, pool, rank[0], line, scene, where) if pool else None


def _of_those(
    words: Sequence[Token], i: int, scene: Scene, line: str, where: dict[str, str | None]
) -> tuple[str, ...] | None:
    """ "Of the drinks I'd like (the one standing furthest back)": those that its sentence begins with."""
    begin, _ = sentence_at(words, i)
    if words[begin].text not in {"of", "among", "amongst", "from"}:
        return None
    stop = next((k + 1 for k in range(begin + 1, min(i, begin + 6)) if plural(words[k], scene)), 0)
    return _pool(words[begin + 1 : stop], scene, line, where) if stop else None


def _rank_at(words: Sequence[Token], at: int) -> tuple[str, int] | None:
    """The end of an order that is named right here, and where its words end."""
    while at < len(words) and words[at].text in _STRESSING:
        at += 1
    if at >= len(words):
        return None
    text = words[at].text
    for end in _ENDS:
        if text in listed("ranks", end):
            return _than_all(words, at + 1, end)
    if text not in _FURTHER:
        return None
    k = at + 1
    while k < len(words) and words[k].text in {"to", "the", "towards", "toward", "at", "on"}:
        k += 1
    if k < len(words) and text in {"nearest", "closest", "nearer", "closer"} and words[k].text in {"me", "you", "us"}:
        return "near", k + 1
    side = _SIDES.get(words[k].text) if k < len(words) else None
    while k + 1 < len(words) and words[k + 1].text in _END_NOUNS:
        k += 1
    of = k + 1 < len(words) and words[k + 1].text == "of" and words[k].text not in {"edge", "end"}
    return (side, k + 1) if side is not None and not of else None


def _than_all(words: Sequence[Token], at: int, end: str) -> tuple[str, int] | None:
    """ "(Larger) than all the rest", "than any other": as good as a superlative; "than object 2" is none."""
    said = [t.text for t in words[at : at + 5]]
    if said[:1] == ["than"]:
        some = next((k for k, w in enumerate(said) if w in {"rest", "others", "other"}), None)
        return (end, at + some + 1) if some is not None and {"all", "any", "every", "the"} & set(said[:some]) else None
    return end, at


def _pool(parts: Sequence[Token], scene: Scene, line: str, where: dict[str, str | None]) -> tuple[str, ...] | None:
    """All that a phrase may mean."""
    core = [
        t
        for t in parts
        if t.text not in _ALL | {"one", "ones", "two", "pair"} and not lexicon().is_(t.text, "articles")
    ]
    if any(t.text in {"other", "others", "rest"} for t in core):
        return None
    found = World(scene, Ledger(dict(where)), where, Talk(where), line).every(core, True)
    return None if isinstance(found, Fault) else found[0]


def _ranked(
    words: Sequence[Token], start: int, stop: int, pool: Sequence[str], end: str, line: str, scene: Scene,
    where: dict[str, str | None], rank: int = 1,
) -> Meant | None:  # fmt: skip
    if not pool:
        return None
    world = World(scene, Ledger(dict(where)), where, Talk(where), line)
    found = world.ranked(Ranked((), end, rank, stop), True, pool, words[start:stop], False)
    ids = found.ids if isinstance(found, Found) else found.candidates if found.code == "E304" else ()
    return Meant(start, stop, ids, stop=stop) if ids else None
