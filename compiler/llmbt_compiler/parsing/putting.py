"""A thing is put on a place: the goal that makes, the position of a container that is taken, two that change places."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from typing import Self

from llmbt_atl.library import Library
from llmbt_atl.template import Pattern, Role, Template
from llmbt_compiler.parsing.clauses import Clause, Group, Phrase
from llmbt_compiler.parsing.ground import Stop
from llmbt_compiler.parsing.ledger import Entry
from llmbt_compiler.parsing.model import Extent, Note, NoteKind
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Fault, Found
from llmbt_compiler.parsing.resolving import Resolving
from llmbt_compiler.parsing.scene import natural
from llmbt_compiler.parsing.verbs import Shape
from llmbt_compiler.parsing.words import lexicon
from llmbt_ir.diagnostics import Diagnostic

__all__ = ["Putting", "extent_of", "goal_pattern"]


@dataclass
class Putting(Resolving):
    """`named` are places that some step names; `last` and `container` are what "the same" repeats; `wanting` are the
    complaints about things without a place, which a later step may still name; `begin` is where a row of places begins.
    """

    named: frozenset[str] = frozenset()
    last: tuple[Template, ...] = ()
    container: str | None = None
    wanting: dict[tuple[str, ...], Diagnostic] = field(default_factory=dict)
    begin: str | None = None
    following: bool = False  # another group of the same clause came before

    def fork(self) -> Self:
        """A second one that goes on from here by itself."""
        other = copy(self)
        other.notes, other.diagnostics, other.used = list(self.notes), list(self.diagnostics), list(self.used)
        other.ledger, other.wanting = self.ledger.fork(), dict(self.wanting)
        return other

    def fit(self, id_: str, type_: str, extent: Extent) -> None:
        entity, library = self.scene[id_], self.scene.library
        if entity.type in library.types and not self.scene.is_a(id_, type_):
            self.complain("E311", f"{id_} is a {entity.type}, not a {type_}", extent, "the library wants another kind")
            raise Stop

    def settled(self, target: str) -> None:
        """A step that left out where something goes was made good by a later one."""
        for ids, diagnostic in list(self.wanting.items()):
            left = tuple(i for i in ids if i != target)
            if left != ids:
                del self.wanting[ids]
                if left:
                    self.wanting[left] = diagnostic
                else:
                    self.diagnostics.remove(diagnostic)

    def put(
        self,
        clause: Clause,
        templates: Sequence[Template],
        ids: tuple[str, ...],
        places: tuple[str, ...],
        extent: Extent | None = None,
    ) -> None:
        """Each object to its place: all to one, or in pairs."""
        extent = extent or clause.extent
        if len(set(places)) == 1:
            places = places[:1]  # "the leftmost position of level 2, position 21"
        if len(ids) == 1 and len(places) > 1:
            title = f"{ids[0]} would be in {len(places)} places: {' and '.join(places[:6])}"
            self.complain("E343", title, extent, "one thing is in one place", "name one of them")
            raise Stop
        if len(places) != 1 and len(places) != len(ids):
            self.complain(
                "E312", f"{len(ids)} objects and {len(places)} places cannot be paired", extent,
                f"{', '.join(ids[:6])} | {', '.join(places[:6])}", "name one place for each, or one for all",
            )  # fmt: skip
            raise Stop
        pairs = zip(ids, places if len(places) == len(ids) else places * len(ids), strict=True)
        for target, place in pairs:
            self.one(templates, target, place, extent)
        self.targets = (ids, self.turn)

    def one(self, templates: Sequence[Template], target: str, place: str, extent: Extent) -> None:
        if place == ORIGIN:
            start = self.origin.get(target)
            if start is None:
                self.complain("E305", f"the map does not say where {target} was", extent, "where?")
                raise Stop
            if target not in self.ledger.handled and self.ledger.where.get(target) == start:
                title = f"{target} is on {start}, and was never taken from there"
                self.complain("E305", title, extent, "where?", "name the place")
                raise Stop
            self.note(NoteKind.INFERRED, f"{target} goes back to {start}", extent)
            place = start
        template = self.template_for(templates, place)
        slot, what = template.param(Role.DESTINATION), template.param(Role.TARGET)
        assert slot is not None
        assert what is not None
        self.fit(target, what.type, extent)
        spot, note = self.spot(target, place, slot.type, extent)
        pattern = goal_pattern(template, self.scene.library, {what.name, slot.name})
        assert pattern is not None
        condition = pattern.bind({what.name: target, slot.name: spot})
        old = self.ledger.of(target)
        inner = old is not None and old.container is not None and self.scene.within(spot, old.container)
        container = place if note is not None and place != ANYWHERE else None
        entry = Entry(condition, self.now, extent, target=target, place=spot, container=container, note=note)
        self.ledger.put(entry, inner=inner)
        self.settled(target)
        self.container = place if note is not None or not self.scene.single(spot) else None
        self.place = (container or spot, self.turn)

    def template_for(self, templates: Sequence[Template], place: str) -> Template:
        """The first template into whose destination a place fits, or has a place that does."""
        able = [t for t in (*templates, *self.placing()) if self.shape(t) is Shape.PLACE]
        for template in able:
            slot = template.param(Role.DESTINATION)
            if place != ANYWHERE and slot is not None and self.scene.is_a(place, slot.type):
                return template
        for template in able:
            slot = template.param(Role.DESTINATION)
            if place != ANYWHERE and slot is not None and self.scene.spots(place, slot.type):
                return template
        return (
            next((t for t in able if t not in templates[:1]), able[0])
            if len(able) > 1 and "_" in able[0].name
            else able[0]
        )

    def spot(self, target: str, place: str, type_: str, extent: Extent) -> tuple[str, Note | None]:
        """The place itself, or the lowest free one within it."""
        scene, ledger = self.scene, self.ledger
        if place != ANYWHERE and (scene.is_a(place, type_) or scene[place].type not in scene.library.types):
            return place, None
        if place == ANYWHERE:
            every = (p.id for p in scene.map.places if scene.single(p.id) and scene.is_a(p.id, type_))
            spots = tuple(sorted(every, key=natural))
        else:
            spots = scene.spots(place, type_)
        name = "the scene" if place == ANYWHERE else place
        if not spots:
            self.complain("E302", f"nothing can be put on {name}", extent, f"it has no {type_}")
            raise Stop
        here = ledger.where.get(target)
        if here in spots and here is not None and target not in ledger.pending:
            return here, Note(self.now.number, NoteKind.CHOSEN, f"{target} is on {name} already: {here}", extent)
        begin = self.begin if self.begin in spots else spots[0]
        spots = spots[spots.index(begin) :]
        free = [s for s in spots if s not in self.barred and (not scene.single(s) or not ledger.taken(s, target))]
        if not free:
            self.complain(
                "E308", f"no free position on {name} for {target}", extent, "all are taken",
                f"{name} has {', '.join(spots[:8])}",
            )  # fmt: skip
            raise Stop
        best = next((s for s in free if s not in self.named), free[0])
        text = f"{name}: {target} to {best}, the lowest free position"
        return best, Note(self.now.number, NoteKind.CHOSEN, text, extent)

    def exchange(self, clause: Clause, things: Group) -> None:
        """ "Swap object 1 and object 3": each goes where the other stands."""
        ids: list[str] = []
        phrases = [_owned(p) for p in sorted(things.phrases, key=lambda p: p.extent.start)]
        pointing = [p for p in phrases if len(p.parts) == 1 and lexicon().is_(p.parts[0].text, "plural_pronouns")]
        for i, p in enumerate(phrases):
            after = phrases[i + 1] if i + 1 < len(phrases) else None
            told = (
                after is not None and after.kind != "Target" and lexicon().is_(after.preposition, "at", "from", "inner")
            )
            here = self.places_of(after) if told and after is not None else ()
            at = self.places_of(p) if not self.quiet(p) else ()
            on = [o for a in at for o, w in self.ledger.where.items() if w == a]
            if p.kind != "Target" and i and self.all_there(phrases[i - 1 : i], p):
                continue
            if i and p.kind != "Target" and set(on) and set(on) <= set(ids):
                continue
            if p in pointing:
                ids.extend(self.last_moved())
                continue
            talk = replace(self.talk(), targets=(), pending=())
            found = self.narrowed(p, talk, here, False)
            if isinstance(found, Fault) and len(phrases) == 1 and p.many_of(2):  # "swap the two blocks", just put down
                placed = tuple(i for i in found.candidates if i in self.ledger.handled)
                found = Found(placed) if len(placed) == 2 else found
            if isinstance(found, Fault) and not on:
                raise self.fault(found)
            ids.extend(on if isinstance(found, Fault) else found.ids)
        ids = list(dict.fromkeys(ids))
        spots = [self.ledger.where.get(i) for i in ids]
        if len(ids) != 2 or None in spots or not self.placing():
            self.complain("E305", "a swap takes two objects that stand on places", clause.extent, "which two?")
            raise Stop
        extent = extent_of(clause, things)
        for target, place in zip(ids, reversed(spots), strict=True):
            self.one(self.placing(), target, str(place), extent)
        self.targets, self.lost = (tuple(ids), self.turn), False

    def last_moved(self) -> tuple[str, ...]:
        """What was named last if it is two things, or else what the last step that moved something moved."""
        targets = self.talk().targets
        moves = self.ledger.moves
        last = [str(e.target) for e in moves if e.step.number == moves[-1].step.number and e.target is not None]
        return targets if len(targets) == 2 else tuple(dict.fromkeys(last))


def _owned(phrase: Phrase) -> Phrase:
    """ "The positions of object 1" stands for object 1."""
    texts = [t.text for t in phrase.parts]
    lex = lexicon()
    for i, text in enumerate(texts[:-1]):
        if (
            text == "of"
            and i
            and (texts[i - 1].removesuffix("s") in lex.places or texts[i - 1] in {"content", "contents"})
        ):
            return replace(phrase, parts=phrase.parts[i + 1 :])
    return phrase


def extent_of(clause: Clause, group: Group) -> Extent:
    extent = clause.extent
    for p in group.phrases:
        extent = extent | p.extent
    return extent


def goal_pattern(template: Template, library: Library, bound: set[str]) -> Pattern | None:
    """The first goal of a Post that is about exactly what is bound, or about a part of it."""
    goals = [p for p in template.post if library.conditions[p.name].goal and p.params()]
    exact = next((p for p in goals if set(p.params()) == bound), None)
    return exact or next((p for p in goals if set(p.params()) <= bound), None)
