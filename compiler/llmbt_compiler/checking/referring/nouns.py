"""Where a noun phrase begins and ends, and all that its words fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from llmbt_compiler.checking.referring.lists import FETCHING, LONGEST, MASS, OPENING, PUTTING, STRESSING
from llmbt_compiler.checking.telling import hearsay
from llmbt_compiler.parsing.names import Fault, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import rank_of
from llmbt_compiler.parsing.words import Token, lexicon, singulars

__all__ = ["all_of", "bare", "noun", "numbers", "parenthesis", "plural"]

_NOUNS = frozenset({
    "one", "ones", "pair", "couple", "neighbour", "neighbor", "trio", "half", "side", "part", "kind", "sort", "lot",
    "already", "there", "friend", "twin", "brother",
})  # fmt: skip
"""Words after a colour by which it is no noun, or told by more."""


def noun(words: Sequence[Token], i: int, scene: Scene) -> int:
    """Where the noun phrase that begins with an article at i ends; 0 where it is none about a single object."""
    for j in range(i + 1, min(len(words), i + 1 + LONGEST)):
        t = words[j]
        after = words[j + 1] if j + 1 < len(words) else None
        if t.text == "one" and j > i + 1:
            return j + 1
        if not t.word or lexicon().is_(t.text, "all", "both", "rest", "same") or (t.number and t.text != "one"):
            return 0
        if t.text in lexicon().ordinals or t.text in lexicon().sizes or rank_of((t,), 0, 1) is not None:
            continue
        if t.text in STRESSING and after is not None and rank_of((after,), 0, 1) is not None:
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


def bare(words: Sequence[Token], i: int, scene: Scene) -> bool:
    """Whether a phrase in a telegram's style begins: a colour with no article before it ("red block to level 2")."""
    before = words[i - 1].text if i else "."
    opens = before in OPENING | {"me", "gimme"} or before in PUTTING | FETCHING
    ranks = words[i].text in lexicon().sizes and rank_of(words, i, i + 1) is not None
    return opens and (words[i].text in scene.colours or ranks)


def plural(t: Token, scene: Scene) -> bool:
    if t.text == "ones":
        return True
    word = scene.word(t, True)
    return bool(word.text) and word.plural and not word.corrected


def numbers(t: Token, scene: Scene) -> bool:
    """Whether a number after this word names something: "object 2"."""
    return any(t.text in e.stem for e in (*scene.objects, *scene.places) if e.number is not None)


def all_of(phrase: Sequence[Token], scene: Scene, where: dict[str, str | None]) -> Found | Fault:
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


def parenthesis(words: Sequence[Token], at: int) -> bool:
    return at < len(words) and words[at].text == "("
