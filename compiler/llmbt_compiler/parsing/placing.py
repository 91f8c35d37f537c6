"""A thing comes to a place: what is put, where it is to go, and the goal that makes."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, takewhile

from llmbt_atl.template import Role, Template
from llmbt_compiler.keywords.labels import Kind
from llmbt_compiler.parsing.beside import in_passing, mentions
from llmbt_compiler.parsing.clauses import Clause, Group, Phrase
from llmbt_compiler.parsing.ground import Open, Stop
from llmbt_compiler.parsing.model import Extent, NoteKind
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Found, exactly_named
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.putting import Putting, extent_of, goal_pattern
from llmbt_compiler.parsing.verbs import Shape
from llmbt_compiler.parsing.words import Token, lemmas, lexicon, tokens

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
class Placing(Putting):
    """What a clause brings, and where it says that it is to go."""

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
            self.note(NoteKind.INFERRED, f"{', '.join(ids)}: also to {_called(again)}", clause.extent)
            return (again,)
        if self.following and self.place[0] is not None and self.place[1] == self.turn:
            place = self.container or self.place[0]
            if not self.scene.single(place):  # "the milk to the user, then the cookies"
                self.note(NoteKind.INFERRED, f"{', '.join(ids)}: also to {_called(place)}", clause.extent)
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
        """Whether "to its original position" follows the clause's last keyword unlabelled, or a thing is "returned"."""
        end = max((p.extent.end for p in clause.phrases), default=clause.extent.end)
        after = tokens(self.now.text, end)[:5]
        texts = [t.text for t in after]
        m = _CAME_FROM.match(self.now.text, end)
        own = [p for p in clause.phrases if p.kind is Kind.TARGET and not lexicon().is_(p.parts[0].text, "pronouns")]
        if m is not None and (m["came"] or not own):  # "place the green cube where it was": another's place
            return True
        if "return" in lemmas(clause.action.casefold()) and any(p.kind is Kind.TARGET for p in clause.phrases):
            return all(p.kind is Kind.TARGET for p in clause.phrases)
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

    def likewise_there(self, group: Group) -> bool:
        """ "Take object 1 to level 2; likewise object 2": to where the one before it in the step went."""
        if not group.targets or group.destinations or self.place[0] is None or self.place[1] != self.turn:
            return False
        first, last = group.targets[0].extent.start, group.targets[-1].extent.end
        before = [t.text for t in tokens(self.now.text, 0, first) if not lexicon().is_(t.text, "articles")]
        after = [t.text for t in tokens(self.now.text, last)][:2]
        said = [*before[-1:], *after[:1]]
        return after == ["as", "well"] or any(lexicon().is_(w, "likewise") for w in said)

    def so_too(self, clause: Clause) -> bool:
        """Whether "likewise" stands before the clause's verb, and nothing is in the hand."""
        lead = tokens(self.now.text, 0, clause.extent.start)
        return not self.ledger.pending and bool(lead) and lead[0].text in {"likewise", "similarly", "ditto"}


def _its_place(phrase: Phrase) -> bool:
    """ "Its slot", "their places"."""
    words = [t.text for t in phrase.parts]
    lex = lexicon()
    own = words[0] in {"its", "their"} and words[-1].removesuffix("s") in lex.places
    return own and len(words) == 2


def _called(place: str | None) -> str:
    """A place in a note for people."""
    return {ANYWHERE: "any place", ORIGIN: "where it came from"}.get(place or "", place or "")
