"""What else in its sentence tells which of several things a phrase means, where the phrase alone does not."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from llmbt_compiler.checking.referring.lists import AT, STANDING
from llmbt_compiler.checking.referring.standing import place_named
from llmbt_compiler.checking.sentences import sentence_at
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["told_apart"]

_BETWEEN = frozenset({"and", ",", "with", "&", "both", "each", "two", "or"})


def told_apart(
    words: Sequence[Token], start: int, end: int, taken: Collection[str], fits: Collection[str], scene: Scene
) -> bool:
    """Whether a place that the sentence of words[start:end] names is where what is `taken` stands, and none of the
    others that it fits: behind things that are named in a row ("the yellow block and the green block on the shelf"), or
    of a landmark, where something is to go ("on level 1, next to the green block")."""
    where = {o.id: o.place for o in scene.map.objects}

    def tells(place: str | None) -> bool:
        there = {o for o in fits if place is not None and scene.within(where.get(o), place)}
        return bool(there) and there == set(taken)

    at = end
    while at < len(words) and (
        words[at].text in _BETWEEN | STANDING or _names(words[at], scene) or words[at].text.endswith("ing")
    ):
        at += 1
    if end < at < len(words) and words[at].text in AT and tells(place_named(words, at + 1, scene)[0]):
        return True
    if not any(start - 2 < r.end <= start for r in relations(words)):
        return False
    begin, stop = sentence_at(words, start)
    return any(words[k].text in AT and tells(place_named(words, k + 1, scene)[0]) for k in range(begin, stop))


def _names(t: Token, scene: Scene) -> bool:
    """Whether a word only names a thing of some colour or sort."""
    return lexicon().is_(t.text, "articles") or t.text in scene.colours or bool(scene.word(t, True).text)
