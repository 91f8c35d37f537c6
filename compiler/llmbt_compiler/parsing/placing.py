"""A thing comes to a place: what is put, where it is to go, and the goal that makes."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from itertools import pairwise, takewhile
from typing import Self

from llmbt_atl.library import Library
from llmbt_atl.template import Pattern, Role, Template
from llmbt_compiler.keywords.labels import Kind
from llmbt_compiler.parsing.beside import in_passing, mentions
from llmbt_compiler.parsing.clauses import Clause, Group, Phrase
from llmbt_compiler.parsing.ground import Grounding, Open, Stop
from llmbt_compiler.parsing.ledger import Entry
from llmbt_compiler.parsing.model import Extent, Note, NoteKind
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Fault, Found, exactly_named
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import natural
from llmbt_compiler.parsing.verbs import Shape
from llmbt_compiler.parsing.words import Token, lexicon, tokens
from llmbt_ir.diagnostics import Diagnostic

__all__ = ["Placing", "extent_of", "goal_pattern"]


_CAME_FROM = re.compile(
    r"\s*(?:back\s+)?(?:to\s+)?where\s+(?:it|they)\s+(?:was|were|(?P<came>came)|stood|had\s+been|has\s+been|have\s+been)\b",
    re.IGNORECASE,
)
_STOPS = frozenset({".", ";", "!", "?"})
_SPREADING = frozenset({"distribute", "spread", "divide", "scatter", "split", "allocate"})
_AT_PRESENT = frozenset({"currently", "presently", "now", "standing", "lying", "sitting", "located", "resting"})
_ARROWS = frozenset({"->", "=>", "→", "⇒", "to"})
_SIDE = frozenset({"the", "far", "very", "left", "right", "front", "back", "side", "end", "hand", "most"})


_FINITE = frozenset({"goes", "go", "comes", "belongs", "belong", "should", "must", "can"})


@dataclass
class Placing(Grounding):
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

    def bring(
        self, clause: Clause, templates: tuple[Template, ...], group: Group, excluded: tuple[Phrase, ...]
    ) -> None:
        """On: the target, or what is in the hand, comes to the destination."""
        lex = lexicon()
        targets, destinations, locations = group.targets, list(group.destinations), list(group.locations)
        fronted = [p for p in destinations if p.extent.end <= clause.extent.start and self.quiet_place(p) is not None]
        there = [p for p in destinations if all(lex.is_(t.text, "there") for t in p.parts)]
        if len(fronted) == 1 and there and fronted[0] not in there and clause.action:  # "rack A has room, put it there"
            destinations = [p for p in destinations if p not in there]
        if any(len(p.parts) == 1 and lex.is_(p.parts[0].text, "there") for p in destinations):
            destinations = [p for p in destinations if p.preposition != "for"]  # "leave it there for the user"
        for p in [p for p in destinations if lex.is_(p.preposition, "from")]:
            destinations.remove(p)
            locations.append(p)
        for a, b in pairwise(destinations):
            if (
                self.now.text[a.extent.end : b.extent.start].strip() in _ARROWS
            ):  # "object 1: sorting area -> position 11"
                destinations.remove(a)
                locations.append(a)
        if len(destinations) > 1 and self.taken_from(targets, destinations[0], destinations[-1]):
            locations.append(destinations.pop(0))  # "carry the things on the bar over to the desk"
        for p in [p for p in destinations if len(destinations) > 1 and self.stated(p)]:
            destinations.remove(p)
            locations.append(p)
        placed_on = [p for p in locations if lex.is_(p.preposition, "at", "onto") and not p.relation]
        placed_on = [p for p in placed_on if not self.relative(p)]
        if not destinations and placed_on and not self.all_there(targets, placed_on[-1]):
            destinations.append(placed_on[-1])
            locations.remove(placed_on[-1])
        slots = bool(targets) and all(not self.quiet(p) and self.places_of(p) for p in targets)
        if self.ledger.pending and slots and not destinations:  # "take object 4. put position 33."
            targets, destinations = (), list(targets)
            group = replace(group, targets=())
        missed = self.missed(clause, group)
        self.use(*(missed.parts if missed is not None else ()))
        if missed is not None and not destinations:
            destinations = [missed]
        elif missed is not None and self.onwards(missed) and self.all_there(targets, destinations[-1]):
            locations, destinations = [*locations, *destinations], [missed]  # "the crates on rack A to the pallet"
        if len(destinations) > 1:  # "bring it over here to me", "there is space in rack A, put it in there"
            real = [p for p in destinations if not (len(p.parts) == 1 and lex.is_(p.parts[0].text, "there"))]
            destinations = real if len(real) == 1 else destinations
        if clause.action.casefold() in _SPREADING:  # "distribute the blocks over positions 11 and 12"
            destinations = [replace(p, relation="") if p.relation == "over" else p for p in destinations]
        container = self.outer(destinations, locations)
        ids, words = self.brought(clause, replace(group, locations=tuple(locations)), excluded)
        extent = extent_of(clause, group)
        self.begin = self.beginning(clause)
        places = self.aims(clause, templates, destinations, ids, container)
        ids = self.one_each(group, destinations, ids, places)
        self.put(clause, templates, ids, places, extent)
        taken_off, turn = self.taken_off
        if "aside" in clause.particles and taken_off == self.ledger.vacated is not None and self.turn - turn <= 1:
            self.place = (taken_off, self.turn)  # "there" is the place that was named, not where the thing went
        self.described = words or self.described
        self.last = tuple(t for t in templates if self.shape(t) is Shape.PLACE)

    def one_each(
        self, group: Group, destinations: Sequence[Phrase], ids: tuple[str, ...], places: tuple[str, ...]
    ) -> tuple[str, ...]:
        """ "A green block on each of positions 31 and 33": as many of the kind as there are places."""
        each = any(t.text in {"each", "every"} for p in destinations for t in p.parts)
        if not each or len(ids) != 1 or len(places) < 2 or len(group.targets) != 1:
            return ids
        parts = group.targets[0].parts
        if not (lexicon().is_(parts[0].text, "indefinite") or parts[0].text == "one"):
            return ids
        count = replace(parts[0], text=str(len(places)), number=str(len(places)))
        found = resolve_objects((count, *parts[1:]), self.scene, self.talk())
        return found.ids if isinstance(found, Found) and len(found.ids) == len(places) else ids

    def relative(self, phrase: Phrase) -> bool:
        """Whether a relative clause tells a place ("everything that's on the table"): nothing is to go there."""
        before = max((s.end for s in self.now.spans if s.end <= phrase.extent.start), default=0)
        lead = {t.text for t in tokens(self.now.text, before, phrase.extent.start)}
        return bool(lead & {"is", "are", "was", "were"}) and bool(lead & {"that", "which"})

    def stated(self, phrase: Phrase) -> bool:
        """Whether the words before a place say that a thing is there at the moment ("currently on position 34")."""
        lead = [t.text for t in tokens(self.now.text, 0, phrase.extent.start) if not lexicon().is_(t.text, "articles")]
        return lexicon().is_(phrase.preposition, "at") and len(lead) > 1 and lead[-2] in _AT_PRESENT

    def taken_from(self, targets: Sequence[Phrase], first: Phrase, last: Phrase) -> bool:
        """Whether the first of two places, right behind the only target, is where the things are now."""
        lex = lexicon()
        if len(targets) != 1 or not lex.is_(first.preposition, "at") or not lex.is_(last.preposition, "onto"):
            return False
        place = self.quiet_place(first)
        behind = [t.text for t in tokens(self.now.text, targets[0].extent.end, first.extent.start)]
        plain = [w for w in behind if not lex.is_(w, "articles")] == [first.preposition]
        if place is None or place in {ANYWHERE, ORIGIN} or not plain or first.relation:
            return False
        return isinstance(resolve_objects(targets[0].parts, self.scene, self.talk(), at=(place,)), Found)

    def missed(self, clause: Clause, group: Group | None = None) -> Phrase | None:
        """A place behind the clause's target, or that of a group of it, that the tagger left unlabelled, told by a
        preposition and its name."""
        phrases = clause.phrases if group is None else group.phrases
        targets = [p.extent.end for p in phrases if p.kind is Kind.TARGET]
        start = max(targets, default=clause.extent.end)
        later = (p.extent.start for p in clause.phrases if p not in phrases and p.extent.start > start)
        actions = (s.start for s in self.now.spans if s.label is Kind.ACTION and s.start > start)
        parts = tokens(self.now.text, start, min((*actions, *later), default=len(self.now.text)))
        parts = tuple(takewhile(lambda t: t.text not in _STOPS, parts))
        found: list[Phrase] = []
        for first, last in mentions(parts, self.scene):
            name = tuple(t for t in parts if first.start <= t.start <= last.start)
            lead = [t for t in parts if t.end <= first.start and not lexicon().is_(t.text, "articles")]
            known = any(u.start < last.end and first.start < u.end for u in self.used)
            there = any(lexicon().is_(t.text, "there") for t in lead)
            if (
                known
                or not lead
                or (there and lead[-1].text == "for")
                or not lexicon().is_(lead[-1].text, "onto", "at")
                or in_passing(parts, first, self.now, self.used, narrowing=False)
            ):
                continue
            if len(exactly_named(name, self.scene.places)) == 1:
                found.append(Phrase(Kind.DESTINATION, name, Extent(first.start, last.end), lead[-1].text))
        found = found or list(self.described_behind(parts))
        labelled = any(p.kind is Kind.DESTINATION for p in phrases)
        return found[0] if len(found) == 1 and not (labelled and self.said_of_it(found[0])) else None

    def said_of_it(self, phrase: Phrase) -> bool:
        """Whether what goes to a place is told anew right before it ("..., and after that it goes to position 34")."""
        lead = [t.text for t in tokens(self.now.text, 0, phrase.extent.start)][-4:]
        return any(a in {"it", "they"} and b in _FINITE for a, b in pairwise(lead))

    def onwards(self, phrase: Phrase) -> bool:
        """Whether a preposition tells where something goes, and not for whom."""
        return lexicon().is_(phrase.preposition, "onto") and phrase.preposition != "for"

    def described_behind(self, parts: Sequence[Token]) -> Iterator[Phrase]:
        """Places that words behind a preposition describe ("on the top level") and that were not labelled."""
        spans = [(s.start, s.end) for s in self.now.spans if s.label is not Kind.ACTION]
        for i, t in enumerate(parts):

            def free(w: Token) -> bool:
                return not any(a < w.end and w.start < b for a, b in spans)

            words = tuple(takewhile(lambda w: (w.word or w.number is not None) and free(w), parts[i + 1 : i + 6]))
            if (
                not free(t)
                or t.text == "for"
                or not lexicon().is_(t.text, "onto", "at")
                or in_passing(parts, t, self.now, self.used)
            ):
                continue
            for length in range(len(words), 1, -1):
                found = resolve_places(words[:length], self.scene, self.talk())
                each = words[0].text in {"each", "every"}
                one = (
                    isinstance(found, Found) and (len(found.ids) == 1 or each) and not (found.vague or found.corrected)
                )
                if one and isinstance(found, Found) and found.ids[0] not in {ANYWHERE, ORIGIN}:
                    extent = Extent(words[0].start, words[length - 1].end)
                    yield Phrase(Kind.DESTINATION, words[:length], extent, t.text)
                    break

    def brought(
        self, clause: Clause, group: Group, excluded: tuple[Phrase, ...]
    ) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """What is put: the targets, or what is in the hand."""
        if group.targets:
            found = self.objects(clause, group, group.locations, excluded, picking=False)
            return found.ids, found.words
        pending = tuple(self.ledger.pending)
        if pending:
            self.targets = (pending, self.turn)
            return pending, ()
        if self.lost:
            raise Stop
        self.complain("E305", "no object is named", clause.extent, "what?", "name the object")
        raise Stop

    def aims(
        self,
        clause: Clause,
        templates: Sequence[Template],
        destinations: Sequence[Phrase],
        ids: tuple[str, ...],
        container: Phrase | None,
    ) -> tuple[str, ...]:
        """The places that the destinations name, or that the verb, the hand or the way gone imply."""
        if len(destinations) == 1 and "back" in clause.particles and _its_place(destinations[0]):
            return (ORIGIN,)  # "set it back in its slot"
        if destinations:
            return tuple(i for p in destinations for i in self.where_to(p, container).ids)
        if "back" in clause.particles or self.to_origin(clause):
            return (ORIGIN,)
        if self.place[0] is not None and self.place[1] == self.turn and self.as_well(clause):
            return (self.container or self.place[0],)
        again = self.container or self.place[0]
        if (
            again is not None
            and not self.scene.single(again)
            and self.turn - self.place[1] <= 1
            and self.so_too(clause)
        ):
            self.note(NoteKind.INFERRED, f"{', '.join(ids)}: also to {again}", clause.extent)
            return (again,)
        if self.following and self.place[0] is not None and self.place[1] == self.turn:
            place = self.container or self.place[0]
            if not self.scene.single(place):  # "the milk to the user, then the cookies"
                self.note(NoteKind.INFERRED, f"{', '.join(ids)}: also to {place}", clause.extent)
                return (place,)
        if "aside" in clause.particles:
            slots = [s for t in self.placing() if (s := t.param(Role.DESTINATION)) is not None]
            aside = next((b for s in slots if (b := self.scene.buffer(s.type)) is not None), None)
            if aside is not None:
                self.note(NoteKind.CHOSEN, f"aside is {aside}", clause.extent)
                return (aside,)
        standing = [self.ledger.of(i) for i in ids]
        down = not {"aside", "away", "off", "out"}.intersection(clause.particles)
        if ids and down and all(standing) and not set(ids) & set(self.ledger.pending):  # "carry it to A, set it down"
            return tuple(str(e.place) for e in standing if e is not None)
        if self.ledger.carried is not None and set(ids) <= set(self.ledger.pending):
            place = self.ledger.carried
            self.note(NoteKind.INFERRED, f"{', '.join(ids)} is put down at {place}", clause.extent)
            return (place,)
        for template in templates:
            slot = template.param(Role.DESTINATION)
            buffer = self.scene.buffer(slot.type) if slot is not None else None
            if (
                slot is not None
                and buffer is not None
                and all(p.buffer for p in self.scene.map.places if self.scene.is_a(p.id, slot.type))
            ):
                if self.elsewhere_named(ids, buffer):
                    break
                self.note(NoteKind.CHOSEN, f"no place is named: {buffer}", clause.extent)
                return (buffer,)
            if self.shape(template) is Shape.PLACE and "_" in template.name:
                continue
            break
        self.complain(
            "E305", f"where is {', '.join(ids[:6])} to go?", clause.extent, "no place is named",
            "name the place",
        )  # fmt: skip
        self.wanting[ids] = self.diagnostics[-1]
        raise Open

    def elsewhere_named(self, ids: Sequence[str], buffer: str) -> bool:
        """Whether a step that names no place where the things are to go names one that is neither where they were nor
        the buffer: that may be meant."""
        parts = tokens(self.now.text)
        names = [[t for t in parts if a.start <= t.start <= b.start] for a, b in mentions(parts, self.scene)]
        places = {e.id for n in names for e in exactly_named(n, self.scene.places)}
        done = {p for e in self.ledger.moves if e.step.number == self.now.number for p in (e.place, e.container)}
        here = {p for i in ids for p in (self.ledger.where.get(i), self.origin.get(i))} | {buffer, *done}
        return any(not any(p == h or self.scene.within(h, p) for h in here) for p in places)

    def to_origin(self, clause: Clause) -> bool:
        """Whether "to its original position" follows the clause's last keyword unlabelled."""
        end = max((p.extent.end for p in clause.phrases), default=clause.extent.end)
        after = tokens(self.now.text, end)[:5]
        texts = [t.text for t in after]
        m = _CAME_FROM.match(self.now.text, end)
        own = [p for p in clause.phrases if p.kind is Kind.TARGET and not lexicon().is_(p.parts[0].text, "pronouns")]
        if m is not None and (m["came"] or not own):  # "place the green cube where it was": another's place
            return True
        return texts[:1] == ["to"] and any(lexicon().is_(t, "back_to") for t in texts)

    def beginning(self, clause: Clause) -> str | None:
        """ "Starting at position 12": where a row of places begins. In an order, "starting on the left" is
        of the order (space/orders); other words that name no place are E314."""
        end = max((p.extent.end for p in clause.phrases), default=clause.extent.end)
        after = tokens(self.now.text, clause.extent.start)
        at = next((i for i, t in enumerate(after[:-1]) if t.text in {"starting", "beginning"}), None)
        if at is None or not lexicon().is_(after[at + 1].text, "from", "at", "inner") or after[at].end < end - 40:
            return None
        words = tuple(takewhile(lambda t: t.word or t.number is not None, after[at + 2 :]))
        if self.ordered and {t.text for t in words} <= _SIDE:
            return None
        for length in range(min(len(words), 6), 0, -1):
            found = resolve_places(words[:length], self.scene, self.talk())
            if isinstance(found, Found) and len(found.ids) == 1 and not found.corrected:
                self.use(*words[:length])
                return found.ids[0]
        extent = Extent(after[at].start, words[-1].end if words else after[at].end)
        self.complain("E314", f"`{extent.cut(self.now.text)}` names no place", extent, "which place?")
        raise Stop

    def as_well(self, clause: Clause) -> bool:
        """Whether "too" or "as well" follows the clause's last target: it goes where the one before went."""
        end = max((p.extent.end for p in clause.phrases if p.kind == "Target"), default=0)
        after = [t.text for t in tokens(self.now.text, end)][:2]
        return bool(after) and (lexicon().is_(after[0], "likewise") or after == ["as", "well"])

    def so_too(self, clause: Clause) -> bool:
        """Whether "likewise" stands before the clause's verb, and nothing is in the hand."""
        lead = tokens(self.now.text, 0, clause.extent.start)
        return not self.ledger.pending and bool(lead) and lead[0].text in {"likewise", "similarly", "ditto"}

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


def _its_place(phrase: Phrase) -> bool:
    """ "Its slot", "their places"."""
    words = [t.text for t in phrase.parts]
    lex = lexicon()
    own = words[0] in {"its", "their"} and words[-1].removesuffix("s") in lex.places
    return own and len(words) == 2


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
