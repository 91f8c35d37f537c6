"""Two of a kind in a request whose author does not know which: "Up to 31. Or was it 33?"."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from llmbt_compiler.checking.wording import phrase_at
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.names import Found, Talk
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import Token, lexicon, tokens

__all__ = ["doubted"]

_AGAIN = frozenset({"was", "is", "were", "does", "did", "do", "maybe", "perhaps", "rather", "should", "could"})
_LEVELS = frozenset({"top", "bottom", "middle", "highest", "lowest", "upper", "lower", "upmost"})
_NEAR = 5


def doubted(words: Sequence[Token], scene: Scene) -> Iterator[tuple[int, tuple[str, str]]]:
    """Where the "or" stands, and the two things or places that it stands between."""
    unsure = any(phrase_at(words, k, "doubts", "unsure") for k in range(len(words)))
    named = sorted({*_named(words, scene)})
    for i, t in enumerate(words[:-1]):
        if t.text != "or" or not (unsure or words[i + 1].text in _AGAIN):
            continue
        before = [id_ for k, id_ in named if k < i]
        after = [id_ for k, id_ in named if i < k <= i + _NEAR]
        if before and after and scene[before[-1]].movable == scene[after[0]].movable and before[-1] != after[0]:
            yield i, (before[-1], after[0])


def _named(words: Sequence[Token], scene: Scene) -> Iterator[tuple[int, str]]:
    mentions = mentions_in(words, scene)
    yield from ((m.start, m.id) for m in mentions)
    inside = {k for m in mentions for k in range(m.start, m.end)}
    for k, t in enumerate(words):
        if t.digits and k not in inside:
            found = [e.id for e in scene.places if e.number == t.number]
            found = found or [e.id for e in scene.objects if e.number == t.number]
            if len(found) == 1 and not (k and words[k - 1].text in scene[found[0]].stem):
                yield k, found[0]
        if t.text in _LEVELS or lexicon().is_(t.text, "top", "bottom", "middle"):
            place = resolve_places(tokens(f"{t.text} level"), scene, Talk())
            if isinstance(place, Found) and len(place.ids) == 1 and not scene.single(place.ids[0]):
                yield k, place.ids[0]
