"""The request itself as the steps, once an answer has settled what it left open; for where nobody is there to go on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from llmbt_atl.library import Library
from llmbt_compiler.asking.question import Asked
from llmbt_compiler.checking.referring import Meant, meant_objects
from llmbt_compiler.checking.sides import shifts
from llmbt_compiler.checking.spots import meant_places
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.space.reading import name_end
from llmbt_compiler.parsing.words import Token, lexicon, tokens
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["restated"]

_AT = frozenset({"on", "in", "at", "to", "onto", "into"})
_ASKED = frozenset({"should", "shall", "must", "put", "place", "move", "does", "do"})
_FETCHING = frozenset({"bring", "fetch", "get", "give", "hand", "pass", "want", "like", "have", "gimme", "need"})


def restated(
    request: str, asked: Asked, ids: Sequence[str], semantic_map: SemanticMap, library: Library
) -> Iterator[str]:
    """Ways to say the request with the `ids` that an answer chose: in the place of the phrase that fits several of the
    candidates, or with nothing but the one thing and the one place that are then left. The likeliest first."""
    scene = Scene(semantic_map, library)
    line = " ".join(request.split())
    words = tokens(line)
    objects = tuple(meant_objects(words, line, scene))
    about = tuple(dict.fromkeys(m.ids[0] for m in objects if len(m.ids) == 1))
    places = tuple(meant_places(words, line, scene, about))
    names = " and ".join(i.replace("_", " ") for i in ids)
    for phrase in (*objects, *places):
        if set(ids) <= set(phrase.ids) and len(phrase.ids) > 1:
            begin = words[phrase.start].start
            on = "on " if _lacks_preposition(words, phrase, scene) else ""
            yield f"{line[:begin]}{on}{names}{line[words[max(phrase.end, phrase.stop) - 1].end :]}"
    if {t.text for t in words} & (lexicon().verbs["exchange"] | {"versa"}):
        return  # one place would be half of it
    if scene[ids[0]].movable:
        meant = next((p for p in objects if set(ids) <= set(p.ids) and len(p.ids) > 1), None)
        inside = range(meant.start, max(meant.end, meant.stop)) if meant is not None else range(0)
        rest = [t for k, t in enumerate(words) if k not in inside]
        for relation in relations(words):
            if relation.start not in inside:  # "... should stand to the left of object 2"
                stop = words[max(name_end(words, relation), relation.end) - 1].end
                yield f"Put {names} {line[words[relation.start].start : stop]}."
        here = next((o.place for o in scene.map.objects if o.id == ids[0]), None)
        for shift in shifts(words):  # "it should be one position further left"
            place = shift.of(here, scene) if here is not None else None
            if place is not None:
                yield f"Put {names} on {place.replace('_', ' ')}."
        named = _places_named(rest, scene) or _who_asks(rest, scene)
        named = tuple(p for p in named if len(named) == 1 or not scene.within(here, p))
        told = [p for p in places if p.start not in inside]
        if told:  # "at the right end of level 3"
            named = told[0].ids if len(told) == 1 else ()
        known = {m.id for m in mentions_in(rest, scene) if scene[m.id].movable} - set(asked.candidates)
        if len(named) == 1 and not known:
            yield f"Put {names} on {named[0].replace('_', ' ')}."
        return
    for moved in (_moved(words, objects, places, scene), _asked_about(asked.text, scene)):
        if len(ids) == 1 and len(moved) == 1:
            yield f"Put {moved[0].replace('_', ' ')} on {names}."


def _asked_about(question: str, scene: Scene) -> tuple[str, ...]:
    """What a question wants a place for: "on which side of object 1 should object 5 go?"."""
    words = tokens(question)
    named = [m for m in mentions_in(words, scene) if scene[m.id].movable]
    return tuple(dict.fromkeys(m.id for m in named if m.start and words[m.start - 1].text in _ASKED))


def _lacks_preposition(words: Sequence[Token], phrase: Meant, scene: Scene) -> bool:
    """Whether a phrase for a place stands without one: "shelf level 2, middle slot"."""
    before = words[phrase.start - 1].text if phrase.start else ""
    return not scene[phrase.ids[0]].movable and before not in {"on", "in", "at", "to", "onto", "into"}


def _who_asks(words: Sequence[Token], scene: Scene) -> tuple[str, ...]:
    """The user, where something is to be brought and nobody says to whom, or "to me"."""
    fetched = any(t.text in _FETCHING for t in words)
    return tuple(p.id for p in scene.persons) if fetched and len(scene.persons) == 1 else ()


def _places_named(words: Sequence[Token], scene: Scene) -> tuple[str, ...]:
    """The places that a request names by their own names, the innermost alone."""
    found = dict.fromkeys(m.id for m in mentions_in(words, scene) if not scene[m.id].movable)
    numbers = [t.number for k, t in enumerate(words) if t.digits and k and words[k - 1].text in _AT]
    found |= dict.fromkeys(p.id for p in scene.places if p.number in numbers and scene.single(p.id))
    return tuple(p for p in found if not any(o != p and scene.within(o, p) for o in found))


def _moved(words: Sequence[Token], objects: Sequence[Meant], places: Sequence[Meant], scene: Scene) -> tuple[str, ...]:
    """What a request is about: the things that it names plainly, those left out that others are to be next to."""
    landmarks = {k for r in relations(words) for k in range(r.start, max(name_end(words, r), r.end + 1))}
    landmarks |= {k for p in places for k in range(p.start, p.end)}
    spans = [(m.start, m.end, m.ids) for m in objects if len(m.ids) == m.count]
    spans += [(m.start, m.end, (m.id,)) for m in mentions_in(words, scene) if scene[m.id].movable]
    taken = {k for a, b, _ in spans for k in range(a, b)} | {k for m in objects for k in range(m.start, m.end)}
    for k, t in enumerate(words):  # "red goes next to the yellow one"
        ids = tuple(e.id for e in scene.objects if t.text in e.colour)
        if k not in taken and len(ids) == 1:
            spans.append((k, k + 1, ids))
    return tuple(dict.fromkeys(i for a, b, ids in spans if not landmarks & set(range(a, b)) for i in ids))
