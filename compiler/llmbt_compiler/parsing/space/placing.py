"""Relations and ranks of one clause: which object is meant, and which place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from llmbt_compiler.keywords.labels import Kind
from llmbt_compiler.parsing.clauses import Clause, Phrase
from llmbt_compiler.parsing.model import Extent
from llmbt_compiler.parsing.names import Fault, Found
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.space.expressions import Ranked, Relation, rank_of, relations
from llmbt_compiler.parsing.space.reading import ONTO, STOPS, Reading, name_end, named
from llmbt_compiler.parsing.space.world import Wanted, said
from llmbt_compiler.parsing.verbs import Shape
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["Placing"]

_GLUE = frozenset({
    "that", "which", "is", "are", "located", "standing", "sitting", "lying", "placed", "situated", "currently",
    "stands", "sits", "lies", "being", ",",
})  # fmt: skip
_ENDS = frozenset({"end", "side", "edge", "corner", "part", "half"})


class Placing(Reading):
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
        if relation.name in {"nearest", "farthest", "next", "above", "below"} and first is None:
            return None, relation.end
        raise self.walk.fault(
            first
            or Fault("E305", "the words name nothing to be next to", self.extent(relation), "what?", "name the thing")
        )

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
        found = self.world.related(relation, pool[0], marks, words, pool[1])
        if isinstance(found, Fault):
            raise self.walk.fault(found)
        self.put(tuple(named(Kind.TARGET, i, extent) for i in found.ids), extent)
        self.unlabelled(extent)

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
        wanted = Wanted(
            max(1, len(targets)) if head is None else 1, head is None or vacant, definite, container, targets
        )
        exact = self.exactly(stop)
        if exact is not None:
            extent = Extent(extent.start, exact[1])
            found = self.world.agrees(relation, marks, exact[0], words)
        else:
            found = self.world.spots(relation, marks, wanted, words)
        if isinstance(found, Fault):
            raise self.walk.fault(found)
        self.put(tuple(named(kind or Kind.DESTINATION, i, extent, "on") for i in found.ids), extent)

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

    def unlabelled(self, extent: Extent) -> None:
        """A destination after a relation that the tagger did not label: "the block nearest to the robot on level 2"."""
        group = next(g for g in self.clause.groups if any(p.extent == extent for p in g.targets))
        if any(p.extent.start >= extent.end for p in group.phrases) or Shape.PLACE not in {
            self.walk.shape(t) for t in self.verb.templates
        }:
            return
        after = [t for t in self.line if t.start >= extent.end]
        if after and after[0].text in ONTO:
            place = self.place_at(after[1:])
            if place is not None:
                where = Extent(after[1].start, after[place[1]].end)
                made = named(Kind.DESTINATION, place[0], where, after[0].text)
                groups = tuple(
                    replace(g, destinations=(*g.destinations, made)) if g is group else g for g in self.clause.groups
                )
                self.clause = replace(self.clause, groups=groups)

    def rank(self, phrase: Phrase) -> None:
        """ "The leftmost red block", "the second position from the left on level 2"."""
        if phrase.parts[0].start == phrase.parts[-1].start or phrase.relation:
            return  # settled already: a name stands for it
        start = next((i for i, t in enumerate(self.line) if t.start >= phrase.parts[0].start), None)
        if start is None:
            return
        end = next((i for i, t in enumerate(self.line) if t.start >= phrase.extent.end), len(self.line))
        of = rank_of(self.line, start, end)
        if of is None or (not of.core and not of.end):
            return
        movable = phrase.kind is Kind.TARGET
        exact = (self.walk.quiet if movable else self.walk.places_of)(phrase)
        if len(exact) == 1 and (of.plain or of.stop > end):
            return
        extent = Extent(phrase.parts[0].start, self.line[of.stop - 1].end)
        words = self.line[start : of.stop]
        found = self.ranked_object(of, words, phrase) if movable else self.ranked_place(of, words)
        if found is None:
            return
        if isinstance(found, Fault):
            raise self.walk.fault(found)
        kind = phrase.kind if movable or phrase.preposition == "from" else Kind.DESTINATION
        self.put(tuple(named(kind, i, extent, phrase.preposition or "on") for i in found.ids), extent)
        if movable:
            self.unlabelled(extent)

    def ranked_object(self, of: Ranked, words: Sequence[Token], phrase: Phrase) -> Found | Fault | None:
        core, at = of.core, None
        group = next(g for g in self.clause.groups if phrase in g.phrases)
        for location in group.locations:
            at = self.walk.quiet_place(location) if not location.relation and at is None else at
        cut = next((i for i, t in enumerate(core) if i and t.text in {"on", "in", "at", "of"}), None)
        if cut is not None:
            place = self.place_at(core[cut + 1 :])
            core, at = (core[:cut], place[0]) if place is not None else (core, None)
        pool = self.world.every(core, True)
        if isinstance(pool, Fault):
            return pool
        where = self.walk.ledger.where
        ids = [i for i in pool[0] if at is None or self.walk.scene.within(where.get(i), at)]
        if of.plain and len(ids) < 2:
            return None
        return self.world.ranked(of, True, ids, words, False)

    def ranked_place(self, of: Ranked, words: Sequence[Token]) -> Found | Fault | None:
        lex = lexicon()
        core = [t for t in of.core if not lex.is_(t.text, "articles")]
        vacant = any(lex.is_(t.text, "vacant") for t in core)
        cut = next((i for i, t in enumerate(core) if t.text in {"on", "in", "at", "of"}), len(core))
        nouns = {t.text for t in core[:cut] if not lex.is_(t.text, "vacant")}
        if not nouns <= self.walk.scene.generic(False) | _ENDS | self._slot_words():
            return None
        container = self.place_at(core[cut + 1 :]) if cut < len(core) else None
        if container is None and cut == len(core):
            after = self.line[of.stop :]
            if after and after[0].text in {"on", "in", "at", "of"}:
                container = self.place_at(after[1:])
        inside = container[0] if container is not None else None
        if inside is None and of.end not in {"near", "far"}:
            if not nouns:
                return None
            inside = (
                self.world.talk.place
                if self.world.talk.place and not self.walk.scene.single(self.world.talk.place)
                else None
            )
        wanted = Wanted(1, vacant, container=inside, targets=self.targets())
        return self.world.place_ranked(of, wanted, words)

    def _slot_words(self) -> frozenset[str]:
        scene = self.walk.scene
        return frozenset[str]().union(*(e.words for e in scene.places if scene.single(e.id)))
