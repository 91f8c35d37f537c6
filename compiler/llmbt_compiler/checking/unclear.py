"""Names that several places or persons of the map bear: "the board", "the bedside locker", "me"."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from llmbt_compiler.checking.complaints import several
from llmbt_compiler.checking.misnamed import nouns_of
from llmbt_compiler.checking.points import OpenPoint
from llmbt_compiler.parsing import Goal
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.names import Fault, Talk
from llmbt_compiler.parsing.places import USERS, WHEREABOUTS, resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import rank_of
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["unclear_names"]

_OPENING = frozenset({"the", "that", "this", "my", "our", "your", "his", "her", "their"})
_ANY = frozenset({
    "same", "other", "own", "right", "left", "next", "first", "last", "main", "usual", "correct", "proper", "whole",
    "only", "free", "empty", "nearest", "closest", "old", "new", "nice", "little", "big", "good", "actual", "very",
    "wrong", "opposite", "remaining", "outer", "outermost", "inner", "innermost", "middle", "upper", "lower",
    "top", "bottom", "present", "current", "previous", "former", "latter", "second", "third", "better", "best",
})  # fmt: skip
_TELLING = frozenset({
    "of", "one", "to", "on", "in", "at", "next", "left", "right", "beside", "behind", "that", "which", "where", "with",
    "nearest", "closest", "between", "above", "below", "near", "by", "under", "over", "without", "holding",
})  # fmt: skip
"""Behind a noun: may tell which is meant."""
_GIVING = frozenset({"bring", "give", "hand", "fetch", "pass", "get", "serve", "grab", "for", "to", "gimme"})
_ME = frozenset({"me", "us"})
_SELF = (["i", "am"], ["im"], ["this", "is"], ["its"])


def unclear_names(words: Sequence[Token], request: str, goals: Sequence[Goal], scene: Scene) -> Iterator[OpenPoint]:
    """E141 for a place told by a word that the map does not know, of several of its kind, and for "me" where the map
    has several persons and none is the user; where the goals take one of them."""
    placed = [g.condition.args[1] for g in goals if g.condition.name == "On" and not g.condition.negated]
    for parts, ids in (*_places(words, scene), *_persons(words, scene)):
        taken = [i for i in ids if any(scene.within(p, i) for p in placed)]
        if len(ids) > 1 and len(taken) == 1:
            what = "persons" if all(scene[i].person for i in ids) else "places"
            yield OpenPoint(several(parts, request, ids, taken, what), taken[0])


def _places(words: Sequence[Token], scene: Scene) -> Iterator[tuple[Sequence[Token], tuple[str, ...]]]:
    """ "The bedside locker", "the board": an article, a noun of several places, and no more before it than a word that
    nothing says what it means."""
    heads = {parts[-1].text for p in scene.map.places if (parts := nouns_of(p.name))}
    own = {m.id for m in mentions_in(words, scene)}
    nouns = heads - scene.generic(False) - {"level", "shelf"}
    for i in range(len(words) - 1):
        end = next((k for k in (i + 4, i + 3, i + 2) if k <= len(words) and words[k - 1].text in nouns), 0)
        after = words[end] if end and end < len(words) else None
        more = after is not None and (after.number is not None or after.text in scene.vocabulary(False) | _TELLING)
        if words[i].text not in {"the", "that", "this"} or not end or more:
            continue
        found = resolve_places(words[i + 1 : end], scene, Talk())
        ids = found.candidates if isinstance(found, Fault) and found.code == "E304" else ()
        if ids and not own & set(ids) and not {t.text for t in words[i + 1 : end - 1]} & (_ANY | WHEREABOUTS):
            yield words[i:end], ids
    known = scene.vocabulary(True) | scene.vocabulary(False) | lexicon().known | _ANY | lexicon().sizes.keys()
    for i in range(len(words) - 2):
        told, noun = words[i + 1], words[i + 2]
        after = words[i + 3] if i + 3 < len(words) else None
        if (
            words[i].text not in _OPENING
            or noun.text not in heads - scene.generic(False)
            or (after is not None and after.number is not None)
        ):
            continue
        ranks = told.text in lexicon().ordinals or rank_of((told,), 0, 1) is not None
        if told.word and told.number is None and told.text not in known and not ranks:
            yield words[i : i + 3], tuple(p.id for p in scene.places if noun.text in p.words)


def _persons(words: Sequence[Token], scene: Scene) -> Iterator[tuple[Sequence[Token], tuple[str, ...]]]:
    """ "Bring me ...", where nobody on the map is the user."""
    persons = scene.persons
    said = [t.text for t in words]
    if len(persons) < 2 or any(p.stem & USERS for p in persons):
        return
    if any(said[k : k + len(s)] == s for s in _SELF for k in range(len(said))):
        return  # "this is Ann, bring me ..."
    if any(not scene[m.id].movable and scene[m.id].person for m in mentions_in(words, scene)):
        return
    for i in range(1, len(words)):
        if said[i] in _ME and said[i - 1] in _GIVING:
            yield words[i : i + 1], tuple(p.id for p in persons)
            return
