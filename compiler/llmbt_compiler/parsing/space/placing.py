"""Relations and ranks of one clause: which object is meant, and which place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from llmbt_atl.template import Role
from llmbt_compiler.keywords.labels import Kind
from llmbt_compiler.parsing.clauses import Clause, Phrase
from llmbt_compiler.parsing.model import Extent
from llmbt_compiler.parsing.names import Fault, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.space.expressions import Relation, rank_of, relations
from llmbt_compiler.parsing.space.ranking import Ranking
from llmbt_compiler.parsing.space.reading import ONTO, STOPS, name_end, named
from llmbt_compiler.parsing.space.world import Wanted, said
from llmbt_compiler.parsing.verbs import Shape
from llmbt_compiler.parsing.words import Token, lexicon
from llmbt_ir.diagnostics import Severity

__all__ = ["Placing"]

_GLUE = frozenset({
    "that", "which", "is", "are", "located", "standing", "sitting", "lying", "placed", "situated", "currently",
    "stands", "sits", "lies", "being", ",",
})  # fmt: skip
_STANDS = (_GLUE - {","}) | {"already", "now", "still", "what", "thats", "up", "over"}
_REASONS = frozenset({"as", "because", "since", "where", "so"})


def _little(t: Token) -> bool:
    return lexicon().is_(t.text, "articles", "vacant", "filler")


class Placing(Ranking):
    """Reads a clause with relations and ranks."""

    def related(self) -> Clause:
        shapes = {self.walk.shape(t) for t in self.verb.templates}
        for relation in reversed(relations(self.line)):
            if shapes == {Shape.TRAVEL} and not any(g.targets for g in self.clause.groups):
                self.by_the_landmark()
            else:
                self.relation(relation, shapes)
        for phrase in self.clause.phrases:
            self.rank(phrase)
        return self.clause

    def by_the_landmark(self) -> None:
        """The robot goes next to something: near it is where it is to be."""
        self.clause = replace(
            self.clause,
            groups=tuple(
                replace(
                    g,
                    destinations=tuple(replace(p, relation="") for p in g.destinations),
                    locations=tuple(replace(p, relation="") for p in g.locations),
                )
                for g in self.clause.groups
            ),
        )

    def relation(self, relation: Relation, shapes: set[Shape]) -> None:
        if self.in_a_reason(relation) or (Shape.PLACE not in shapes and self.in_a_parenthesis(relation)):
            return
        head = self.head(relation)
        if head is not None and head.kind is not Kind.TARGET and self.walk.quiet(head):
            head = None
        if relation.name == "top" and not (head is not None and self.is_modifier(relation, head, shapes, self.line)):
            return
        if relation.name in {"above", "below"} and (head is None or head.kind is Kind.TARGET):
            return
        marks, stop = self.landmarks(relation)
        if marks is None:
            return
        if len(marks) == 1 and self.at_an_end(relation, marks[0], stop):
            return
        begin = head.extent.start if head is not None else self.line[relation.start].start
        words = tuple(t for t in self.line if begin <= t.start and t.end <= self.line[stop - 1].end)
        extent = Extent(begin, self.line[stop - 1].end)
        if head is not None and head.kind is Kind.TARGET and not self.is_place(head):
            if self.is_modifier(relation, head, shapes, self.line[stop:]):
                self.modify(relation, head, marks, words, extent)
            else:
                start = self.line[relation.start].start
                after = tuple(t for t in words if t.start >= start)
                self.destination(relation, None, marks, after, Extent(start, extent.end), stop)
            return
        self.destination(relation, head, marks, words, extent, stop)

    def at_an_end(self, relation: Relation, mark: str, stop: int) -> bool:
        """ "At the far left of level 2", "on the left side of level 2": its last position there. Whether that was said;
        what is "to the left of" a row of positions is none of them."""
        scene = self.walk.scene
        if relation.name not in {"left", "right"} or scene[mark].movable or scene.single(mark):
            return False
        row = self.world.in_order(mark, relation.name)
        if not row or row == (mark,):
            return False
        start = relation.start
        while start and self.line[start - 1].text in {"far", "very", "extreme", "the"}:
            start -= 1
        start -= start > 0 and start < relation.start and self.line[start - 1].text in ONTO
        lead = self.line[start : relation.end]
        extent = Extent(lead[0].start, self.line[stop - 1].end)
        outer = any(t.text in {"far", "very", "extreme", "hand", "side"} for t in lead)
        if not outer and lead[0].text not in {"on", "at", "in"}:
            words = extent.cut(self.walk.now.text)
            hint = f"did you mean {row[0]}?"
            raise self.walk.fault(
                Fault("E304", f"`{words}`: beside it, or at its end?", extent, "where?", hint, row[:2])
            )
        self.put((named(Kind.DESTINATION, row[0], extent, "on"),), extent)
        return True

    def in_a_reason(self, relation: Relation) -> bool:
        """ "... as it stands in front of the milk": said about the step, not asked for; its phrases are left out."""
        since = max(
            (p.extent.end for p in self.clause.phrases if p.extent.end <= self.line[relation.start].start), default=0
        )
        between = [t for t in self.line[: relation.start] if t.start >= since]
        reason = next((t for t in between if t.text in _REASONS), None)
        if reason is None:
            return False
        self.put((), Extent(reason.start, self.line[name_end(self.line, relation) - 1].end))
        return True

    def in_a_parenthesis(self, relation: Relation) -> bool:
        """ "Pick up object 4 (the green block closer to you)": said about what has been named."""
        opened = [i for i, t in enumerate(self.line[: relation.start]) if t.text == "("]
        if not opened or any(t.text == ")" for t in self.line[opened[-1] : relation.start]) or not opened[-1]:
            return False
        before = self.line[opened[-1] - 1]
        if before.number is None or not any(p.extent.end >= before.end for p in self.clause.phrases):
            return False
        stop = next((t.end for t in self.line[relation.end :] if t.text == ")"), self.line[-1].end)
        self.put((), Extent(self.line[opened[-1]].start, stop))
        return True

    def head(self, relation: Relation) -> Phrase | None:
        """The noun phrase right before a relation; None where there is none that it could belong to."""
        i = relation.start - 1
        while i >= 0 and self.line[i].text in _GLUE:
            i -= 1
        if i < 0:
            return None
        at = self.line[i]
        for p in self.clause.phrases:
            if p.extent.start <= at.start and at.end <= p.extent.end:
                pointing = len(p.parts) == 1 and lexicon().is_(p.parts[0].text, "pronouns", "plural_pronouns")
                kept = tuple(t for t in p.parts if t.end <= at.end)
                return None if pointing or not kept else replace(p, parts=kept)
            if p.extent.start <= self.line[relation.start].start and self.line[relation.start].end <= p.extent.end:
                kept = tuple(t for t in p.parts if t.end <= at.end)
                return replace(p, parts=kept) if kept else None
        if at.text in self.walk.scene.generic(False) or at.text in self.walk.scene.vocabulary(False):
            j = i
            while j > 0 and self.line[j - 1].word and self.line[j - 1].text not in STOPS:
                j -= 1
            parts = self.line[j : i + 1]
            return Phrase(Kind.DESTINATION, parts, Extent(parts[0].start, parts[-1].end))
        return None

    def landmarks(self, relation: Relation) -> tuple[tuple[str, ...] | None, int]:
        """What the words after a relation name, and where they end. No ids: whoever looks. None: nothing follows."""
        if relation.owner:
            known = self.world.talk.targets or self.world.talk.pending
            fault = Fault("E305", f"`{relation.owner}` points to nothing named before", self.extent(relation), "what?")
            if len(known) != 1:
                raise self.walk.fault(fault)
            return known, relation.end
        want = 2 if relation.name == "between" else 1
        limit = name_end(self.line, relation)
        first: Fault | None = None
        for stop in range(limit, relation.end, -1):
            parts = self.line[relation.end : stop]
            if parts[-1].text == "and" or not any(t.word or t.number is not None for t in parts):
                continue
            if self.world.viewer(parts):
                return (), stop
            found = self.both(parts) if want > 1 else self.mark(parts)
            if isinstance(found, Found) and len(found.ids) == want:
                self.walk.told(found, Phrase(Kind.LOCATION, parts, Extent(parts[0].start, parts[-1].end)))
                return found.ids, stop
            first = first or (found if isinstance(found, Fault) else self.too_many(found, parts, want))
        there = self.standing_there(first, limit, relation) if first is not None and want == 1 else None
        if there is not None:
            return there
        if relation.name in {"nearest", "farthest", "next", "above", "below"} and first is None:
            return None, relation.end
        raise self.walk.fault(
            first
            or Fault("E305", "the words name nothing to be next to", self.extent(relation), "what?", "name the thing")
        )

    def standing_there(self, fault: Fault, stop: int, relation: Relation) -> tuple[tuple[str, ...], int] | None:
        """ "The green block on the shelf", of several green ones: that which stands on the place named behind it.
        Behind "that is" so too, where the relation leaves one side open and not two."""
        while relation.name != "next" and stop < len(self.line) and self.line[stop].text in _STANDS:
            stop += 1
        if fault.code != "E304" or stop + 1 >= len(self.line) or self.line[stop].text not in {"on", "in", "at", "from"}:
            return None
        place = self.place_at(self.line[stop + 1 :])
        if place is None:
            return None
        where = self.walk.ledger.where
        ids = tuple(i for i in fault.candidates if self.walk.scene.within(where.get(i), place[0]))
        return (ids, stop + 1 + place[1]) if len(ids) == 1 else None

    def both(self, parts: Sequence[Token]) -> Found | Fault:
        """Two landmarks: "object 1 and position 12", or "the two green blocks"."""
        joint = next((i for i, t in enumerate(parts) if t.text == "and"), None)
        whole = self.mark(parts)
        if joint is None or isinstance(whole, Found):
            return whole
        found = [self.mark(p) for p in (parts[:joint], parts[joint + 1 :])]
        for f in found:
            if isinstance(f, Fault):
                return f
        return Found(tuple(i for f in found if isinstance(f, Found) for i in f.ids))

    def mark(self, parts: Sequence[Token]) -> Found | Fault:
        """A landmark: a name, or something that has a rank ("the smallest block")."""
        of = rank_of(parts, 0, len(parts))
        if of is not None and of.stop == len(parts):
            pool = self.world.every(of.core, True)
            if not isinstance(pool, Fault) and (not of.plain or len(pool[0]) > 1):
                return self.world.ranked(of, True, pool[0], parts, False)
        return self.world.landmark(parts)

    def too_many(self, found: Found, parts: Sequence[Token], want: int) -> Fault:
        words, extent = said(parts, self.walk.now.text), Extent(parts[0].start, parts[-1].end)
        if len(found.ids) < want:
            return Fault("E305", f"between {words} and what?", extent, "what?", "name both things")
        return Fault("E304", f"`{words}` fits {len(found.ids)} things", extent, "which?", "say which", found.ids)

    def extent(self, relation: Relation) -> Extent:
        return Extent(self.line[relation.start].start, self.line[relation.end - 1].end)

    def is_modifier(self, relation: Relation, head: Phrase, shapes: set[Shape], after: Sequence[Token]) -> bool:
        """Whether a relation after an object tells which one is meant, and not where it is to go."""
        if head.kind is not Kind.TARGET:
            return False
        if Shape.PLACE not in shapes and self.clause.action:
            return True
        between = [t.text for t in self.line if head.extent.end <= t.start < self.line[relation.start].start]
        if any(w in _GLUE and w != "," for w in between):
            return True
        known = resolve_objects(head.parts, self.walk.scene, replace(self.world.talk, targets=(), pending=()))
        unique = isinstance(known, Found) and not known.chosen
        begin = after[0].start if after else self.line[-1].end
        if any(p.parts[0].start == p.parts[-1].start and p.extent.start >= begin for p in self.clause.phrases):
            return True  # another relation says where it goes
        goes = self.goes_on(after if relation.name != "top" else self.line[relation.end :])
        if goes is None:
            return False
        preposition, place = goes
        inner = not self.walk.scene.single(place) and preposition in {"on", "in", "at"}
        return not (unique and inner)

    def goes_on(self, after: Sequence[Token]) -> tuple[str, str] | None:
        """The preposition and the place that come after a phrase: where the thing is to go."""
        for i, t in enumerate(after):
            if t.text not in ONTO:
                if t.text in {",", ";", ".", "and", "then"}:
                    return None
                continue
            place = self.place_at(after[i + 1 :])
            if place is not None:
                return t.text, place[0]
        return None

    def modify(
        self, relation: Relation, head: Phrase, marks: Sequence[str], words: Sequence[Token], extent: Extent
    ) -> None:
        pool = self.world.every(head.parts, True)
        if isinstance(pool, Fault):
            raise self.walk.fault(pool)
        any_of = self.any_of(relation, words)
        found = self.world.related(relation, pool[0], any_of or marks, words, pool[1], either=bool(any_of))
        if isinstance(found, Fault):
            raise self.walk.fault(found)
        self.put(tuple(named(Kind.TARGET, i, extent) for i in found.ids), extent)
        self.unlabelled(extent)

    def any_of(self, relation: Relation, words: Sequence[Token]) -> tuple[str, ...]:
        """All that an indefinite landmark may be ("next to a yellow one"); nothing where it is one thing."""
        after = [t for t in self.line[relation.end :] if t.end <= words[-1].end]
        if relation.name in {"between", "nearest", "farthest"} or not after or after[0].text not in {"a", "an", "any"}:
            return ()
        pool = self.world.every(after, True)
        return pool[0] if not isinstance(pool, Fault) and len(pool[0]) > 1 else ()

    def destination(
        self,
        relation: Relation,
        head: Phrase | None,
        marks: Sequence[str],
        words: Sequence[Token],
        extent: Extent,
        stop: int,
    ) -> None:
        """The places in a relation to something: where a thing is to go, or where it is now."""
        kind = head.kind if head is not None and head.kind is Kind.LOCATION and head.preposition == "from" else None
        targets = self.targets()
        vacant = head is not None and any(lexicon().is_(t.text, "vacant") for t in head.parts)
        definite = head is not None and any(lexicon().is_(t.text, "definite") for t in head.parts)
        if head is not None and relation.name in {"above", "below"}:
            self.level(relation, head, marks, words, extent)
            return
        container, extent = self.container(stop, extent)
        exact = self.exactly(stop)
        if exact is None and container is None and head is not None and kind is None:
            container = self.named_place(head)
            if container is not None and self.walk.scene.single(container):
                exact, container = (container, extent.end), None
        free = head is None or vacant or container is not None
        scene = self.walk.scene
        said = {t.text for t in head.parts} if head is not None else set()
        own = frozenset(said & scene.vocabulary(False) - scene.generic(False)) if not container else frozenset[str]()
        count = max(1, len(targets)) if head is None else 1
        wanted = Wanted(count, free, definite and not container, container, targets, own)
        if exact is not None:
            extent = Extent(extent.start, exact[1])
            found = self.world.agrees(relation, marks, exact[0], words)
        else:
            found = self.world.spots(relation, marks, wanted, words)
        if isinstance(found, Fault):
            found = self.left_open(found, relation, container or self.there(relation))
        self.put(tuple(named(kind or Kind.DESTINATION, i, extent, "on") for i in found.ids), extent)

    def named_place(self, head: Phrase) -> str | None:
        """The one place that a phrase names by itself, and not only by its relation."""
        scene = self.walk.scene
        generic = all(
            t.number is None and (not t.word or t.text in scene.generic(False) or _little(t)) for t in head.parts
        )
        if generic or not isinstance(resolve_places(head.parts, scene, Talk()), Found):
            return None  # "the berth to the right of berth L" is none of those that were named before
        return self.walk.quiet_place(replace(head, relation=""))

    def there(self, relation: Relation) -> str | None:
        """ "There, next to it": the place spoken of before."""
        before = [t.text for t in self.line[max(0, relation.start - 2) : relation.start] if t.text != ","]
        return self.world.talk.place if before[-1:] in (["there"], ["here"]) else None

    def left_open(self, fault: Fault, relation: Relation, place: str | None) -> Found:
        """A relation that no goal can say, beside a place that one can: the place is the goal, and a warning says what
        is left open. Where no such place is named, the fault."""
        scene = self.walk.scene
        slots = [s for t in self.walk.placing() if (s := t.param(Role.DESTINATION)) is not None]
        apt = place is not None and not scene.single(place) and any(scene.is_a(place, s.type) for s in slots)
        if fault.code != "E309" or place is None or not apt:
            raise self.walk.fault(fault)
        self.walk.complain(
            "W309",
            f"`{said(self.line[relation.start : relation.end], self.walk.now.text)}` is left open: "
            f"{place} has no positions of its own",
            fault.extent,
            f"anywhere on {place}",
            candidates=(place,),
            severity=Severity.WARNING,
        )
        return Found((place,))

    def level(
        self, relation: Relation, head: Phrase, marks: Sequence[str], words: Sequence[Token], extent: Extent
    ) -> None:
        """ "The level above level 1": the next one up, of those that the noun fits."""
        pool = self.world.every(head.parts, False)
        if isinstance(pool, Fault):
            raise self.walk.fault(pool)
        found = self.world.related(relation, pool[0], marks, words, False)
        if isinstance(found, Fault):
            raise self.walk.fault(found)
        self.put((named(Kind.DESTINATION, found.ids[0], extent, "on"),), extent)

    def exactly(self, stop: int) -> tuple[str, int] | None:
        """ "... left of object 2, on position 12": the position itself, and where its name ends."""
        after = self.line[stop:]
        after = after[1:] if after and after[0].text in {",", "("} else after
        after = after[1:] if after and after[0].text in ONTO else after
        place = self.place_at(after)
        if place is None or not self.walk.scene.single(place[0]):
            return None
        return place[0], after[place[1] - 1].end

    def container(self, stop: int, extent: Extent) -> tuple[str | None, Extent]:
        """ "... on shelf level 2" after a relation: the positions are sought there."""
        after = self.line[stop:]
        if not after or after[0].text not in {"on", "in", "at", "of"}:
            return None, extent
        place = self.place_at(after[1:])
        if place is None or self.walk.scene.single(place[0]):
            return None, extent
        return place[0], Extent(extent.start, after[place[1]].end)
