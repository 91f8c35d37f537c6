"""Two things named together of which one is meant, and a place of whose number a part is said."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from llmbt_compiler.checking.complaints import several
from llmbt_compiler.checking.points import OpenPoint
from llmbt_compiler.checking.sentences import ENDS
from llmbt_compiler.parsing import Goal
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.scene import Scene, natural
from llmbt_compiler.parsing.space.expressions import rank_of
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["half_numbered", "the_other"]

_JOINING = frozenset({"and", ",", "&", "or"})
_GOES_ON = frozenset({
    "was", "is", "goes", "should", "must", "has", "may", "can", "gets", "belongs", "to", "on", "onto", "into", "needs",
    "moves", "leaves", "will", "shall", "would", "wants",
})  # fmt: skip
_TELLING = frozenset(
    {"former", "latter", "left", "right", "front", "back", "the", "that", "this", "which", "whichever"}
)
_SOME = frozenset({"something", "whatever", "odd", "someth", "whatsit", "ish"})


def the_other(words: Sequence[Token], request: str, goals: Sequence[Goal], scene: Scene) -> Iterator[OpenPoint]:
    """ "Objects 5 and 6 are here, only one of them stays. The other goes on 21": which of the two goes?"""
    moved = {g.condition.args[0] for g in goals if g.condition.args}
    named = tuple(m for m in mentions_in(words, scene) if scene[m.id].movable)
    for i in range(len(words) - 2):
        if [t.text for t in words[i : i + 2]] != ["the", "other"] or words[i + 2].text not in _GOES_ON:
            continue
        before = list(dict.fromkeys(m for m in named if m.start < i))
        pair = tuple(dict.fromkeys(m.id for m in before))
        taken = sorted(moved & set(pair))
        if len(before) != 2 or len(pair) != 2 or len(taken) != 1 or any(m.id in pair for m in named if m.start > i):
            continue
        joint = {t.text for t in words[before[0].end : before[1].start]}
        between = words[before[1].end : i]
        if joint & _JOINING and not joint & ENDS and _leaves_open(between, scene):
            yield OpenPoint(several(words[i : i + 2], request, pair, taken), taken[0])


def _leaves_open(between: Sequence[Token], scene: Scene) -> bool:
    """ "Only one of the pair stays": one, and nothing that tells which."""
    one = [k for k, t in enumerate(between) if t.text == "one"]
    told = any(t.text in scene.colours or t.text in lexicon().sizes or t.text in lexicon().ordinals for t in between)
    told = told or any(rank_of((t,), 0, 1) is not None for t in between)
    return bool(one) and not told and all(not k or between[k - 1].text not in _TELLING for k in one)


def half_numbered(words: Sequence[Token], request: str, goals: Sequence[Goal], scene: Scene) -> Iterator[OpenPoint]:
    """ "Position two-something", "somewhere in the twenties of the positions": places whose numbers begin so."""
    held = {o.place for o in scene.map.objects}
    placed = {g.condition.args[1] for g in goals if len(g.condition.args) > 1}
    for i in range(len(words) - 2):
        number = words[i + 1].number
        noun = scene.word(words[i], False).text
        kind = [p for p in scene.places if noun and p.number is not None and scene.fits(p, noun)]
        if number is None or not number.isdecimal() or not kind:
            continue
        k = i + 2 + int(words[i + 2].text in {"-", "point", "and"})
        if k >= len(words) or words[k].text not in _SOME:
            continue
        digits = number[0] if len(number) == 2 and number.endswith("0") else number
        ids = sorted((p.id for p in kind if _begins(p.number, digits)), key=natural)
        free = tuple(p for p in ids if p not in held)
        taken = sorted(placed & set(free))
        if len(free) > 1 and len(taken) == 1:
            yield OpenPoint(several(words[i : k + 1], request, free, taken, "places"), taken[0])


def _begins(number: str | None, digits: str) -> bool:
    return number is not None and number.startswith(digits) and len(number) > len(digits)
