"""Names of which the map knows the words and not the whole: "the night pill cup", where the cups are for the morning
and the evening; "the top drawer of the counter"; "the kiln", where there is a kiln trolley; what stands nowhere."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from llmbt_compiler.checking.referring import place_named
from llmbt_compiler.checking.sentences import span_of
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.places import WHEREABOUTS
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import Token, lexicon, singulars, tokens
from llmbt_ir.diagnostics import Diagnostic

__all__ = ["misnamed", "nouns_of"]

_OPENING = frozenset({"the", "that", "this", "my", "our", "your", "his", "her", "their"})
_LONGEST = 5
_ONTO = frozenset({"in", "into", "on", "onto", "to", "inside"})
_ENDS = frozenset({"side", "end", "edge", "corner"})
_PARTS = frozenset({
    "drawer", "shelf", "compartment", "tray", "door", "hook", "bin", "basket", "box", "pocket", "lid", "rail", "hatch",
    "bucket", "cupboard", "cabinet", "bag", "crate", "slot", "bay", "rack",
})  # fmt: skip
"""What furniture has, and things may be put in or on."""


def misnamed(words: Sequence[Token], request: str, scene: Scene) -> Iterator[Diagnostic]:
    """E142 for a definite name of known words that nothing bears, and for a part of a place that the map has not.

    A word of a place before the noun tells where the thing stands ("the shelf blocks"); colours, sizes and ranks are
    not weighed here.
    """
    heads = {parts[-1].text for o in scene.map.objects if (parts := nouns_of(o.name))}
    inside = {k for m in mentions_in(words, scene) for k in range(m.start, m.end)}
    for i, t in enumerate(words):
        if t.text not in _OPENING:
            continue
        end = _run(words, i + 1, scene)
        head = words[end - 1] if end > i + 2 else None
        apart = head is not None and head.text in heads and not inside & set(range(i + 1, end))
        if head is not None and apart and not _borne(words[i + 1 : end], scene):
            said = request[words[i + 1].start : head.end]
            like = tuple(e.id for e in scene.objects if scene.fits(e, head.text))
            yield _lacking(words[i + 1 : end], request, f"no `{said}`", like)
        part = _part(words, i + 1, scene)
        if part:
            yield _lacking(words[i + 1 : part], request, f"no `{words[part - 1].text}`", ())
        half = _half_named(words, i, scene)
        if half:
            yield _lacking(words[i + 1 : i + 2], request, f"no `{words[i + 1].text}`", half)
    yield from _nothing_there(words, request, scene)
    yield from _numbered(words, request, scene)
    yield from _beyond(words, request, scene, heads)


def _beyond(words: Sequence[Token], request: str, scene: Scene, heads: set[str]) -> Iterator[Diagnostic]:
    """ "The third dagger", of two."""
    for i in range(len(words) - 2):
        rank, noun = lexicon().ordinals.get(words[i + 1].text, 0), words[i + 2]
        after = words[i + 3].text if i + 3 < len(words) else ""
        if words[i].text != "the" or rank < 2 or noun.text not in heads - scene.generic(True) or after in heads:
            continue
        like = tuple(e.id for e in scene.objects if scene.fits(e, noun.text))
        if len(like) < rank:
            yield _lacking(words[i + 1 : i + 3], request, f"no {words[i + 1].text} `{noun.text}`", like)


def _half_named(words: Sequence[Token], i: int, scene: Scene) -> tuple[str, ...]:
    """ "Into the kiln", where there is a kiln trolley: the places of whose names the word is but a part that says what
    they are for; none where it may be their noun."""
    if not i or i + 1 >= len(words) or words[i - 1].text not in _ONTO or words[i].text not in _OPENING:
        return ()
    word, after = words[i + 1], words[i + 2] if i + 2 < len(words) else None
    own = scene.vocabulary(False)
    goes_on = after is not None and (after.number is not None or after.text in own | _ENDS or after.text == "of")
    goes_on = goes_on or (after is not None and bool(scene.word(after, False).text))  # "the sorting aera"
    if word.text not in own - scene.vocabulary(True) - scene.generic(False) - WHEREABOUTS or goes_on:
        return ()
    places = [p for p in scene.map.places if word.text in scene[p.id].words]
    whole = any(not _before_noun(word.text, p.name) or word.text == p.type or scene[p.id].person for p in places)
    return () if whole else tuple(p.id for p in places)


def _before_noun(word: str, name: str) -> bool:
    parts = [t.text for t in nouns_of(name) if len(t.text) > 1]
    return word in parts[:-1] and word != parts[-1]


def _nothing_there(words: Sequence[Token], request: str, scene: Scene) -> Iterator[Diagnostic]:
    """ "What's in the middle well", where nothing is."""
    for i, t in enumerate(words[:-3]):
        k = i + 1 + int(words[i + 1].text == "is")
        if t.text not in {"what", "whats", "whatever"} or words[k].text not in {"in", "on", "inside"}:
            continue
        place, stop = place_named(words, k + 1, scene)
        if place is not None and not any(scene.within(o.place, place) for o in scene.map.objects):
            yield _lacking(words[i:stop], request, f"nothing on {place}", ())


def _numbered(words: Sequence[Token], request: str, scene: Scene) -> Iterator[Diagnostic]:
    """ "To table four", where nothing goes by that noun."""
    known = scene.vocabulary(True) | scene.vocabulary(False) | lexicon().known | lexicon().places | lexicon().objects
    for i in range(1, len(words) - 1):
        lead, noun = words[i - 1], words[i]
        if lead.text not in {"to", "onto", "into"} or words[i + 1].number is None or words[i + 1].text == "one":
            continue
        plain = noun.word and noun.number is None and len(noun.text) > 2 and not known & set(singulars(noun.text))
        near = scene.word(noun, False)
        if plain and not (near.near or near.text):
            yield _lacking(words[i : i + 2], request, f"no `{noun.text} {words[i + 1].text}`", ())


def nouns_of(name: str) -> list[Token]:
    """The words of a name, without its numbers; the last is its noun."""
    return [t for t in tokens(name) if t.word and t.number is None]


def _lacking(parts: Sequence[Token], request: str, what: str, like: tuple[str, ...]) -> Diagnostic:
    title = f"the request names what is not there: the scene has {what}"
    return Diagnostic("E142", title, span_of(parts, request), "not in the map", "say another", candidates=like)


def _run(words: Sequence[Token], i: int, scene: Scene) -> int:
    """Where the words that names of the map have end; `i` where something else is said there too."""
    own = scene.vocabulary(True) | scene.vocabulary(False)
    end = i
    while end < len(words) and end - i <= _LONGEST and words[end].word and words[end].number is None:
        if words[end].text not in own:
            break
        end += 1
    after = words[end] if end < len(words) else None
    goes_on = after is not None and (after.number is not None or after.text in {"one", "ones", "of", "for", "with"})
    return i if goes_on else end


def _borne(parts: Sequence[Token], scene: Scene) -> bool:
    """Whether a thing bears these words, or bears some and stands where the others say."""
    sizes = lexicon().sizes.keys()
    said = [t.text for t in parts if t.text not in sizes and t.text not in scene.colours]
    places = {p.id: p for p in scene.places}
    for o in scene.map.objects:
        thing = scene[o.id]
        left = [w for w in said if not scene.fits(thing, w)]
        around = [places[p] for p in (o.place, *scene.map.containers(o.place)) if p in places] if o.place else []
        if all(any(w in p.words for p in around) for w in left) and scene.fits(thing, said[-1]):
            return True
    return len(said) < 2


def _part(words: Sequence[Token], i: int, scene: Scene) -> int:
    """Where "top drawer" of "the top drawer of the counter" ends; 0 where the map has such a thing, or it is of no
    place."""
    end = i
    while end < len(words) and end - i < 3 and words[end].word and words[end].text != "of":
        end += 1
    if end == i or end + 1 >= len(words) or words[end].text != "of":
        return 0
    noun, known = words[end - 1], scene.vocabulary(True) | scene.vocabulary(False)
    forms = set(singulars(noun.text))
    named = any(m.start in {end + 1, end + 2} and not scene[m.id].movable for m in mentions_in(words, scene))
    return end if forms & _PARTS and not forms & known and named else 0
