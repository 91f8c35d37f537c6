"""Phrases without a relation or a rank: "the green block", "something red", "whatever Tom ordered"."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from llmbt_compiler.checking.referring.lists import ONTO, OPENING, POINTING, PUTTING, TELLING
from llmbt_compiler.checking.referring.model import Meant
from llmbt_compiler.checking.referring.nouns import all_of, parenthesis
from llmbt_compiler.checking.referring.ranks import most
from llmbt_compiler.checking.referring.relative import compared
from llmbt_compiler.checking.referring.standing import (
    clause,
    elsewhere,
    from_before,
    goes_on,
    puts,
    standing_there,
    tells,
)
from llmbt_compiler.checking.telling import hearsay, uncheckable
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.names import Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.scene import Scene, natural
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["colour_alone", "felt_alone", "plain", "something", "something_compared", "told_alone"]

_VERBAL = frozenset({"has", "must", "should", "goes", "is", "needs", "belongs", "ought", "shall", "wants", "please"})
_USES = {"drink": "drink", "eat": "food", "snack": "snack"}


def plain(words: Sequence[Token], start: int, end: int, scene: Scene, where: dict[str, str | None]) -> Meant | None:
    felt = [t for k, t in enumerate(words[start:end], start) if hearsay(words, k, scene)]
    phrase = [t for t in words[start:end] if t.text != "one" and t not in felt]
    named = mentions_in(words[:start], scene) or any(t.text in scene.colours for t in words[:start])
    if not phrase and felt and not named:
        phrase = [Token("object", words[start].start, words[start].start)]
    if not phrase or parenthesis(words, end):
        return None
    if any(t.text in lexicon().sizes for t in phrase):  # "the big yellow block", of two
        best = most(phrase, words, start, end, scene, where)
        if best:
            return Meant(start, end, best)
        sized = resolve_objects(phrase, scene, Talk())
        plain = isinstance(sized, Found) and not sized.chosen
        return Meant(start, end, sized.ids) if plain and isinstance(sized, Found) else None
    if any(t.text in lexicon().ordinals or t.text in TELLING for t in phrase):
        return None
    found = all_of(phrase, scene, where)
    if not isinstance(found, Found):
        return None
    ids, stop = standing_there(words, end, from_before(words, start, found.ids, scene, where), scene, where)
    told = stop if stop > end and clause(words, end) else 0
    if stop > end and not told and puts(words, start) and not goes_on(words, start, stop):
        ids = found.ids  # "put the green block on the shelf": it says where to
    if stop == end and elsewhere(words, end, scene):
        return Meant(start, end, ids)
    return None if tells(words, stop, scene) else Meant(start, end, ids, stop=told)


def something(words: Sequence[Token], i: int, scene: Scene) -> Meant | None:
    """ "Something red", "something to drink"."""
    if words[i].text != "something" or i + 1 >= len(words):
        return None
    use = words[i + 2].text if words[i + 1].text == "to" and i + 2 < len(words) else ""
    sort, end = (_USES.get(use, ""), i + 3) if use else (words[i + 1].text, i + 2)
    known = sort in lexicon().sorts or sort in lexicon().shapes or sort in scene.colours
    ids = tuple(e.id for e in scene.objects if scene.fits(e, sort)) if known else ()
    return Meant(i, end, tuple(sorted(ids, key=natural))) if ids else None


def something_compared(
    words: Sequence[Token], i: int, line: str, scene: Scene, where: dict[str, str | None]
) -> Meant | None:
    """ "Something bigger than object 1", "one that's smaller than the red"."""
    if words[i].text not in {"something", "one"} or (words[i].text == "one" and i and words[i - 1].text != ","):
        return None
    found = compared(words, i + 1, i + 1, line, scene, where)
    return replace(found, start=i) if found is not None and (found.ids or found.stop) else None


def told_alone(words: Sequence[Token], i: int, scene: Scene) -> Meant | None:
    """ "The one that Marta wants", "whatever Tom ordered": it may be anything."""
    one = words[i].text in POINTING and [t.text for t in words[i + 1 : i + 2]] == ["one"]
    if [t.text for t in words[max(0, i - 2) : i + 2]] in (
        ["you", "know", "which", "one"],
        ["you", "remember", "which", "one"],
    ):
        return Meant(i, i + 2, tuple(sorted((e.id for e in scene.objects), key=natural)))
    any_ = words[i].text in {"whatever", "what"} and i + 1 < len(words) and words[i + 1].text != "you"
    end = i + 2 if one else i + 1
    before = words[:i]
    if not (one or any_) or any(t.text in scene.colours for t in before):
        return None
    if not uncheckable(words, end, scene, opened=any_) or any(scene[m.id].movable for m in mentions_in(before, scene)):
        return None
    return Meant(i, end, tuple(sorted((e.id for e in scene.objects), key=natural)))


def felt_alone(words: Sequence[Token], i: int, scene: Scene, group: Sequence[str]) -> Meant | None:
    """ "The heavier has to go": one of those named before, or of all, told by what no map says."""
    if words[i].text not in POINTING or i + 2 >= len(words) or not hearsay(words, i + 1, scene):
        return None
    after = words[i + 2]
    if after.word and after.text not in _VERBAL and not lexicon().is_(after.text, "onto"):
        return None
    return Meant(i, i + 2, tuple(group) or tuple(sorted((e.id for e in scene.objects), key=natural)))


def colour_alone(words: Sequence[Token], i: int, scene: Scene) -> Meant | None:
    """ "Yellow on position 14": one thing of that colour, since one position is named."""
    before = words[i - 1].text if i else "."
    if words[i].text not in scene.colours or not (before in OPENING or before in PUTTING) or i + 2 >= len(words):
        return None
    if words[i + 1].text not in ONTO | {"at"}:
        return None
    named = next((m for m in mentions_in(words[i + 2 :], scene) if m.start == 0), None)
    if named is None or scene[named.id].movable or not scene.single(named.id):
        return None
    ids = tuple(sorted((e.id for e in scene.objects if words[i].text in e.colour), key=natural))
    return Meant(i, i + 1, ids)
