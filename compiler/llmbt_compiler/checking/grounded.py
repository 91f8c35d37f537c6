"""Goals that no word of a request stands for: a thing that it has no word for, a place that it does not say.

The other checks look for words that are suspicious; here every goal is asked for the words that it comes from. "Put
that on the desk" has none for the apple, "get object 3 out of there" none for position 11. Little is taken for a
word: a colour, a sort, a pronoun with something before it, a side, a relation, what stands in the place already.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

from llmbt_atl.library import Library
from llmbt_compiler.checking.levels import levels_from
from llmbt_compiler.checking.points import OpenPoint
from llmbt_compiler.checking.request import VERBS
from llmbt_compiler.checking.sentences import one_line, span_of
from llmbt_compiler.checking.telling import REMEMBERED
from llmbt_compiler.checking.unknown import unknown_place
from llmbt_compiler.parsing import Goal
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.scene import Scene, natural
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.words import Token, lexicon, tokens
from llmbt_ir.diagnostics import Diagnostic
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["ungrounded"]

_SIDES = frozenset({
    "left", "right", "leftmost", "rightmost", "front", "back", "rear", "end", "ends", "edge", "corner", "corners",
    "edges", "outer", "outermost", "inner", "side", "sides", "far", "higher", "lower", "deeper", "further", "farther",
    "close", "closer", "together", "apart", "neighbour", "neighbor", "neighbours", "neighbors", "row", "line", "order",
    "gap", "gaps", "hole", "holes", "join", "joins", "company", "levels", "shelve", "shelved", "shelf", "same",
})  # fmt: skip
_WHEREVER = frozenset({"somewhere", "anywhere", "wherever", "whichever", "sort", "sorted", "arrange", "tidy"})
_OPEN = frozenset({"a", "an", "any", "either", "other", "another"})
_CLEARING = frozenset({"aside", "away", "off", "out", "cleared", "emptied"})
_GIVING = frozenset({
    "bring", "fetch", "get", "hand", "give", "pass", "want", "like", "love", "have", "serve", "need", "do", "drink",
    "eat", "thirsty", "hungry",
})  # fmt: skip
_ANYTHING = frozenset({
    "cargo", "goods", "all", "both", "each", "every", "one", "ones", "nothing", "eat", "drink", "food", "hungry",
    "thirsty", "contents", "content", "what", "stuff", "lot", "whichever",
})  # fmt: skip
_IT = frozenset({"it", "that", "this", "they", "these", "those", "he", "she"})
_PLACES = frozenset({
    "place", "spot", "home", "position", "slot", "corner", "shelf", "level", "bay", "bin", "berth", "cell", "niche",
    "hook", "stand", "pocket", "compartment", "drawer", "rack", "box",
})  # fmt: skip
_HOLDING = frozenset({"hold", "holding", "held", "keep", "keeping", "gripper", "grip"})
_HANDING = frozenset({"bring", "give", "hand", "pass", "deliver", "serve", "take", "get", "fetch", "grab", "carry"})
_IN_HAND = frozenset({("hang", "on"), ("let", "go"), ("your", "hand"), ("the", "hand"), ("in", "hand")})
_TAKING = frozenset({
    "pick", "picked", "picking", "lift", "raise", "grab", "grasp", "seize", "clutch", "take", "get", "fetch", "collect",
    "retrieve",
})  # fmt: skip
_EXCHANGE = frozenset({"where", "versa", "places"})


@dataclass(frozen=True)
class _Request:
    """A request's words, and what stands where before anything is done."""

    words: tuple[Token, ...]
    scene: Scene

    @cached_property
    def texts(self) -> frozenset[str]:
        return frozenset(t.text for t in self.words)

    @cached_property
    def named(self) -> frozenset[str]:
        return frozenset(m.id for m in mentions_in(self.words, self.scene))

    @cached_property
    def where(self) -> dict[str, str | None]:
        return {o.id: o.place for o in self.scene.map.objects}

    def has(self, *lists: str) -> bool:
        """Whether a word is in one of the lexicon's lists."""
        return any(lexicon().is_(t, *lists) for t in self.texts)

    @property
    def orders(self) -> bool:
        """Whether it says anything at all of things and places; "do it" speaks of what was said elsewhere."""
        told = any(self.scene.word(t, m).text for t in self.words for m in (True, False))
        return told or bool(self.texts & VERBS)

    @property
    def clears(self) -> bool:
        """Whether something is to be emptied, or things are to go away, or to change places."""
        verbs = lexicon().verbs
        return bool(self.texts & (_CLEARING | verbs["removing"])) or self.has("vacant")

    @property
    def elsewhere(self) -> bool:
        """ "Somewhere else", "elsewhere": where, is not said."""
        texts = [t.text for t in self.words]
        return "elsewhere" in texts or ["somewhere", "else"] in [texts[k : k + 2] for k in range(len(texts))]

    @property
    def remembered(self) -> bool:
        """ "Its usual place", "where it belongs": a place that only the user knows."""
        texts = [t.text for t in self.words]
        told = any(a.text in REMEMBERED and b.text in _PLACES for a, b in pairwise(self.words))
        return told or any(
            texts[k] == "where" and texts[k + 1] in _IT and texts[k + 2] in {"belongs", "goes", "belong", "go"}
            for k in range(len(texts) - 2)
        )

    @property
    def in_mind(self) -> bool:
        """ "I've got a spot on the shelf in mind for it", "it's on the wrong level": the user knows alone which."""
        texts = [t.text for t in self.words]
        pairs = [texts[k : k + 2] for k in range(len(texts))]
        return ["in", "mind"] in pairs or any(a == "wrong" and b in _PLACES for a, b in pairwise(texts))

    @property
    def exchanges(self) -> bool:
        told = any(self.scene.word(t, m).text for t in self.words for m in (True, False))
        named = any(self.scene.word(t, True).text for t in self.words) or any(self.scene[i].movable for i in self.named)
        verb = bool(self.texts & (_EXCHANGE | lexicon().verbs["exchange"]))
        return verb and told and (named or "where" not in self.texts)

    def counted(self, place: str) -> bool:
        """Whether a place's number stands behind its kind, however it is spelt, or behind a word of where to: "on levl
        1 ... those go on two"."""
        e = self.scene[place]
        return e.number is not None and any(
            b.number == e.number
            and b.text != "one"
            and (lexicon().is_(a.text, "onto", "at") or (bool(w := self.scene.word(a, False).text) and w in e.stem))
            for a, b in pairwise(self.words)
        )

    def fitting(self, id_: str, *, generic: bool) -> bool:
        """Whether a word or a number may stand for a thing; `generic`: one that stands for any of its kind too."""
        e = self.scene[id_]
        for t in self.words:
            if t.number is not None and t.number == e.number:
                return True
            word = self.scene.word(t, e.movable)
            of_all = word.text in self.scene.generic(e.movable)
            if word.text and ((generic and of_all) or (not of_all and self.scene.fits(e, word.text))):
                return True
            if generic and word.near:
                return True
        return False


def ungrounded(request: str, goals: Sequence[Goal], semantic_map: SemanticMap, library: Library) -> Iterator[OpenPoint]:
    """E142 for each thing that the goals bring somewhere and the request has no word for, E305 for each place, and for
    each thing that is only picked up where the request does not ask for that (a reply cut off behind its first words).
    """
    scene = Scene(semantic_map, library)
    line = one_line(request)
    said = _Request(tokens(line), scene)
    placed = [g.condition.args for g in goals if g.condition.name == "On" and not g.condition.negated]
    if not said.orders:
        return
    span = span_of(said.words, line)
    for thing in (g.condition.args[0] for g in goals if g.condition.name == "Holding" and not g.condition.negated):
        if not _held(said, thing):
            title = f"where is {thing} to go? the reply only picks it up"
            yield OpenPoint(Diagnostic("E305", title, span, "no step puts it anywhere", "name the place"), None)
    for thing, place in ((a[0], a[1]) for a in placed):
        if not _thing(said, thing):
            title = f"nothing in the request stands for {thing}, and the reply takes it"
            label, hint = f"no word for {thing}", f"is {thing} right? else name the thing"
            every = tuple(sorted((e.id for e in scene.objects), key=natural))
            yield OpenPoint(Diagnostic("E142", title, span, label, hint, candidates=every), thing)
        elif not _place(said, thing, place, any(p == said.where.get(thing) for o, p in placed if o != thing)):
            unknown = unknown_place(said.words, scene)
            if unknown is not None:
                title = f"the request names `{unknown.text}`, and nothing in the scene goes by that name"
                hint = "name a place of the scene"
                yield OpenPoint(
                    Diagnostic("E142", title, span_of((unknown,), line), "not in the map", hint, candidates=(place,)),
                    place,
                )
                continue
            title = f"where is {thing} to go? the reply takes {place} without asking"
            yield OpenPoint(Diagnostic("E305", title, span, "no place is named", "name the place"), place)


def _thing(said: _Request, thing: str) -> bool:
    if said.exchanges or said.texts & _ANYTHING or said.texts & set(lexicon().sizes):
        return True
    here = said.where.get(thing)
    stands = here is not None and any(said.scene.within(here, p) for p in said.named)
    return said.fitting(thing, generic=True) or (stands and said.clears)


def _held(said: _Request, thing: str) -> bool:
    """Whether the request wants a thing in the hand: it says so, or only to take it, and names nowhere else for it."""
    if said.texts & _HOLDING or any((a.text, b.text) in _IN_HAND for a, b in pairwise(said.words)):
        return True
    here = said.where.get(thing)
    elsewhere = any(not said.scene[i].movable and not said.scene.within(here, i) for i in said.named)
    given = said.has("me", "users", "him") and bool(said.scene.persons) and bool(said.texts & _HANDING)
    return bool(said.texts & _TAKING) and not (elsewhere or given)


def _place(said: _Request, thing: str, place: str, wanted: bool) -> bool:
    """`wanted`: where the thing stands, something else is to go."""
    scene = said.scene
    if scene[place].person:
        return bool(said.texts & _GIVING) or said.has("me", "users", "him") or said.fitting(place, generic=False)
    of = scene.map.place(place)
    if of is not None and of.buffer and (wanted or said.clears):
        return True
    around = {place, *scene.map.containers(place), *(p.id for p in scene.map.inside(place))}
    there = [o.id for o in scene.map.objects if o.place in around and o.id != thing]
    if said.in_mind and place not in said.named:
        return False
    if around & said.named or any(said.counted(p) for p in (place, *scene.map.containers(place))):
        return True
    if said.remembered:
        return False
    if (said.texts & _WHEREVER and not said.elsewhere) or _open_place(said):
        return True
    if set(levels_from(said.words, said.where.get(thing), scene)) & {place, *scene.map.containers(place)}:
        return True
    if scene.single(place):
        ranked = said.has("top", "bottom", "middle") or any(t.text in lexicon().ordinals for t in said.words)
        to_something = any(r.end < len(said.words) and said.words[r.end].word for r in relations(said.words))
        if ranked or to_something or said.texts & _SIDES or (there and said.exchanges):
            return True
    if any(said.fitting(i, generic=False) for i in (place, *there)):
        return True
    return any(said.fitting(c, generic=False) for c in scene.map.containers(place) if scene[c].number is None)


def _open_place(said: _Request) -> bool:
    """ "A free level", "the other side", "another place"."""
    for a, b in pairwise(said.words):
        if a.text == "nothing" and b.text in {"on", "in"}:
            return True  # "the level with nothing on it"
        place = bool(said.scene.word(b, False).text)
        free = lexicon().is_(b.text, "vacant") or (place and not said.scene.word(b, True).text)
        if (a.text in _OPEN and free) or (lexicon().is_(a.text, "vacant") and place):
            return True
    return False
