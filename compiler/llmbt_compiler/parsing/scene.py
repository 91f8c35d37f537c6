"""The map as names: which words and numbers each object and place goes by, and which places hold one thing
only.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from llmbt_atl.library import Library
from llmbt_atl.template import ANY
from llmbt_compiler.parsing.words import Token, closest, lexicon, singulars, tokens
from llmbt_ir.semantic_map import MapObject, MapPlace, SemanticMap

__all__ = ["Entity", "Scene", "Word", "compact", "natural", "squash"]


@dataclass(frozen=True, slots=True)
class Entity:
    """A thing of the map as language sees it: the words that may describe it and its number.

    `stem` are the words of the id; `keys` its id and name with all that spelling may change taken out.
    """

    id: str
    type: str
    movable: bool
    words: frozenset[str]
    stem: frozenset[str]
    number: str | None
    keys: frozenset[str]
    colour: frozenset[str] = frozenset()
    size_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    person: bool = False

    def measure(self, name: str) -> float:
        """How large ("size": the edge of a cube of its volume), how high or how long it is, in metres."""
        if name == "length":
            return max(self.size_m)
        x, y, z = self.size_m
        return z if name == "height" else (x * y * z) ** (1 / 3)

    @property
    def initials(self) -> frozenset[str]:
        """What "P12" may begin with."""
        return frozenset(w[0] for w in self.words)


@dataclass(frozen=True, slots=True)
class Word:
    """A content word of a phrase, as the map's vocabulary knows it; `text` is empty where it does not."""

    token: Token
    text: str
    plural: bool = False
    corrected: bool = False
    near: tuple[str, ...] = ()


def natural(id_: str) -> tuple[tuple[int, int, str], ...]:
    """A sorting key by which position_9 comes before position_11, and act_two before act_three."""
    return tuple(
        (0, int(t.number), "")
        if t.number is not None and t.number.isascii() and t.number.isdigit() and len(t.number) < 10
        else (1, 0, t.text)
        for t in tokens(id_)
    )


def squash(parts: Iterable[Token]) -> str:
    """A name without case, spaces and marks: the same for all spellings of one id."""
    kept = [t.number if t.number is not None else t.text for t in parts if t.word or t.number is not None]
    return " ".join(kept)


def compact(key: str) -> str:
    """A squashed name with the spaces between its words gone too ("sortingarea"); numbers stay apart."""
    out = ""
    for part in key.split(" "):
        apart = bool(out) and out[-1].isdigit() and part[:1].isdigit()
        out += " " + part if apart else part
    return out


def _spelled(name: str) -> str:
    """A name as it is said: squashed, without the article that it may begin with ("the noon slot")."""
    parts = tokens(name)
    begin = 1 if len(parts) > 1 and parts[0].text == "the" else 0
    return squash(parts[begin:])


def _words(text: str) -> frozenset[str]:
    told = (t for t in tokens(text) if t.word and t.number is None)
    return frozenset(t.text for t in told if t.text not in {"of", "with", "for", "and", "the"})


def _number(text: str) -> str | None:
    return next((t.number for t in reversed(tokens(text)) if t.number is not None), None)


def _build(size: tuple[float, float, float]) -> frozenset[str]:
    """Words for a thing that is much wider than high."""
    x, y, z = size
    return frozenset({"flat", "thin"}) if 0 < z * 3 <= min(x, y) else frozenset()


def _object(o: MapObject) -> Entity:
    stem = _words(o.id)
    words = stem | _words(o.name) | _words(o.colour) | _words(o.shape) | _words(o.type) | _build(o.size_m)
    keys = frozenset({squash(tokens(o.id)), _spelled(o.name)})
    number = _number(o.id) or _number(o.name)
    return Entity(o.id, o.type, True, words, stem, number, keys, _words(o.colour), o.size_m)


def _place(p: MapPlace, library: Library) -> Entity:
    stem = _words(p.id)
    words = stem | _words(p.name) | _words(p.type) | (frozenset({"buffer"}) if p.buffer else frozenset())
    keys = frozenset({squash(tokens(p.id)), _spelled(p.name)})
    person = library.is_a(p.type, "person") or not words.isdisjoint(lexicon().function["users"])
    return Entity(p.id, p.type, False, words, stem, _number(p.id) or _number(p.name), keys, person=person)


@dataclass(frozen=True)
class Scene:
    """A map and a library, indexed for resolving names; without `snap` only as they are spelled."""

    map: SemanticMap
    library: Library
    snap: bool = True

    @cached_property
    def objects(self) -> tuple[Entity, ...]:
        """What can be moved."""
        return tuple(_object(o) for o in self.map.objects)

    @cached_property
    def places(self) -> tuple[Entity, ...]:
        """Where things can be."""
        return tuple(_place(p, self.library) for p in self.map.places)

    @cached_property
    def spelled(self) -> frozenset[tuple[str, ...]]:
        """The ids and names of all things, as their words and numbers in order."""
        names = [n for o in self.map.objects for n in (o.id, o.name)]
        names += [n for p in self.map.places for n in (p.id, p.name)]
        return frozenset(k for n in names if (k := tuple(_spelled(n).split(" "))) != ("",))

    @cached_property
    def persons(self) -> tuple[Entity, ...]:
        """The people among the places."""
        return tuple(e for e in self.places if e.person)

    @cached_property
    def _by_id(self) -> dict[str, Entity]:
        return {e.id: e for e in (*self.objects, *self.places)}

    def __getitem__(self, id_: str) -> Entity:
        return self._by_id[id_]

    def pool(self, movable: bool) -> tuple[Entity, ...]:
        """The objects, or the places."""
        return self.objects if movable else self.places

    @cached_property
    def colours(self) -> frozenset[str]:
        """The colours that the map uses."""
        return frozenset[str]().union(*(e.colour for e in self.objects))

    @cached_property
    def _vocabularies(self) -> tuple[frozenset[str], frozenset[str]]:
        def of(pool: tuple[Entity, ...]) -> frozenset[str]:
            return frozenset[str]().union(*(e.words for e in pool))

        return of(self.places), of(self.objects)

    def vocabulary(self, movable: bool) -> frozenset[str]:
        """All words by which things of a kind go."""
        return self._vocabularies[movable]

    @cached_property
    def _nouns(self) -> tuple[frozenset[str], frozenset[str]]:
        def of(things: Iterable[MapObject | MapPlace]) -> frozenset[str]:
            told = [t for o in things for t in (o.id, o.name, o.type, getattr(o, "shape", ""))]
            plain = ([x.text for x in tokens(t) if x.word and x.number is None and len(x.text) > 1] for t in told)
            return frozenset(words[-1] for words in plain if words)

        return of(self.map.places) | lexicon().places, of(self.map.objects) | lexicon().objects | frozenset(
            lexicon().sorts
        )

    def nouns(self, movable: bool) -> frozenset[str]:
        """The words that a name, a type or a shape of a kind ends with, and those that stand for any."""
        return self._nouns[movable]

    def generic(self, movable: bool) -> frozenset[str]:
        """The nouns that fit everything of a kind: of places not those by which only some of the map's go ("niche",
        where there are bays too)."""
        return lexicon().objects if movable else self._generic_places

    @cached_property
    def _generic_places(self) -> frozenset[str]:
        slots = [e for e in self.places if self.single(e.id)]
        own = self.vocabulary(False)
        return frozenset(w for w in lexicon().places if w not in own or all(w in e.words for e in slots))

    def understood(self, word: str, movable: bool) -> bool:
        """Whether a word is in the vocabulary, a synonym of one that is, or generic."""
        own = self.vocabulary(movable)
        if not movable and self.persons and lexicon().is_(word, "users"):
            return True
        return word in own or word in self.generic(movable) or not own.isdisjoint(lexicon().alike(word))

    def word(self, token: Token, movable: bool) -> Word:
        """A token as a word of the vocabulary: as it stands, its singular, an abbreviation, a slip, or
        unknown.
        """
        for i, form in enumerate(singulars(token.text)):
            if self.understood(form, movable):
                return Word(token, form, plural=i > 0)
        if not self.snap:
            return Word(token, "")
        own = self.vocabulary(movable) | self.generic(movable)
        plural = token.text.endswith("s")
        for form in singulars(token.text):
            cut = len(form) >= 3 and not lexicon().is_(form, "him", "pronouns", "plural_pronouns")
            longer = {w for w in own if cut and w.startswith(form)}
            if len(longer) == 1:
                return Word(token, longer.pop(), plural=form != token.text)
        near = closest(token.text, own) or (closest(token.text[:-1], own) if plural else ())
        if len(near) == 1:
            return Word(token, near[0], plural=plural and not near[0].endswith("s"), corrected=True)
        return Word(token, "", near=near)

    def fits(self, entity: Entity, word: str) -> bool:
        """Whether a word of the vocabulary may describe a thing."""
        if word in entity.words or (entity.movable and word in lexicon().anything):
            return True
        if word in self.vocabulary(entity.movable):
            return False
        if word in self.generic(entity.movable) or (entity.person and lexicon().is_(word, "users")):
            return True
        called = entity.words - (entity.colour - entity.stem) if word in lexicon().sorts else entity.words
        return not called.isdisjoint(lexicon().alike(word))

    def upwards(self, places: Iterable[str]) -> tuple[str, ...]:
        """Places from the lowest to the highest, by their surfaces; by their numbers where the map does not say how
        high they lie, or some lie equally high."""
        ids = sorted(set(places), key=natural)
        heights = {i: p.surface_m[2] for i in ids if (p := self.map.place(i)) is not None and p.surface_m is not None}
        known = len(heights) == len(ids) == len(set(heights.values()))
        return tuple(sorted(ids, key=lambda i: heights[i]) if known else ids)

    def within(self, place: str | None, container: str) -> bool:
        """Whether a place is a container or lies in it."""
        return place is not None and (place == container or container in self.map.containers(place))

    @cached_property
    def single_types(self) -> frozenset[str]:
        """The types of places that hold one thing at a time, as the library's state variables say."""
        found: set[str] = set()
        for v in self.library.variables:
            for value in v.values:
                keys = value.params()
                goal = self.library.conditions[value.name].goal
                if goal and ANY in value.args and len(keys) == 1 and len(value.args) == 2:
                    found.update(p.type for p in v.params if value.args[0] == ANY and p.name == keys[0])
        return frozenset(found)

    def single(self, place: str) -> bool:
        """Whether a place holds one thing at a time; ANYWHERE and ORIGIN are no place that does."""
        entity = self._by_id.get(place)
        return entity is not None and any(self.library.is_a(entity.type, t) for t in self.single_types)

    def is_a(self, id_: str, type_: str) -> bool:
        """Whether a thing is of a library type. `buffer` places are of the type `buffer`
        where there is one.
        """
        entity = self._by_id[id_]
        if self.library.is_a(entity.type, type_):
            return True
        place = self.map.place(id_)
        return place is not None and place.buffer and self.library.is_a("buffer", type_)

    def spots(self, container: str, type_: str) -> tuple[str, ...]:
        """The places of a type within a container, in the order of their numbers; of the map where they have none."""
        found = [p.id for p in self.map.inside(container) if self.is_a(p.id, type_)]
        numbered = all(self[i].number is not None for i in found)
        return tuple(sorted(found, key=natural) if numbered else found)

    def buffer(self, type_: str) -> str | None:
        """Where things are put aside."""
        return next((p.id for p in self.map.places if p.buffer and self.is_a(p.id, type_)), None)
