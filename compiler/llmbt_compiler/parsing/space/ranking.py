"""Ranks of one clause: "the leftmost red block", "the second position from the left on level 2"."""

from __future__ import annotations

from collections.abc import Sequence

from llmbt_compiler.keywords.labels import Kind
from llmbt_compiler.parsing.clauses import Phrase
from llmbt_compiler.parsing.model import Extent
from llmbt_compiler.parsing.names import ANYWHERE, Fault, Found
from llmbt_compiler.parsing.space.expressions import Ranked, rank_of, side_of
from llmbt_compiler.parsing.space.reading import Reading, named
from llmbt_compiler.parsing.space.world import Wanted
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["Ranking"]

_ENDS = frozenset({"end", "side", "edge", "corner", "part", "half"})


class Ranking(Reading):
    """Reads a clause with ranks."""

    def rank(self, phrase: Phrase) -> None:
        """ "The leftmost red block", "the second position from the left on level 2"."""
        if phrase.parts[0].start == phrase.parts[-1].start or phrase.relation or phrase not in self.clause.phrases:
            return  # settled already: a name stands for it
        start = next((i for i, t in enumerate(self.line) if t.start >= phrase.parts[0].start), None)
        if start is None:
            return
        end = next((i for i, t in enumerate(self.line) if t.start >= phrase.extent.end), len(self.line))
        if phrase.kind is Kind.TARGET and self.at_a_side(start, end, phrase):
            return
        of = rank_of(self.line, start, end)
        if of is None or (not of.core and not of.end):
            return
        movable = phrase.kind is Kind.TARGET
        exact = (self.walk.quiet if movable else self.walk.places_of)(phrase)
        if len(exact) == 1 and ANYWHERE not in exact and (of.plain or of.stop > end):
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

    def at_a_side(self, start: int, end: int, phrase: Phrase) -> bool:
        """ "The green block at the back of the sorting area": of those that stand there. Whether that was said."""
        of = side_of(self.line, start, end)
        place = self.place_at(self.line[of.stop :]) if of is not None else None
        pool = self.world.every(of.core, True) if of is not None and place is not None else None
        if of is None or place is None or not isinstance(pool, tuple) or self.walk.scene.single(place[0]):
            return False
        ids = [i for i in pool[0] if self.walk.scene.within(self.walk.ledger.where.get(i), place[0])]
        stop = of.stop + place[1]
        if not ids:
            return False
        found = self.world.ranked(of, True, ids, self.line[start:stop], False)
        if isinstance(found, Fault):
            raise self.walk.fault(found)
        extent = Extent(phrase.parts[0].start, self.line[stop - 1].end)
        self.put(tuple(named(phrase.kind, i, extent, phrase.preposition or "on") for i in found.ids), extent)
        return True

    def ranked_object(self, of: Ranked, words: Sequence[Token], phrase: Phrase) -> Found | Fault | None:
        core, at = of.core, None
        group = next((g for g in self.clause.groups if phrase in g.phrases), None)
        for location in group.locations if group is not None else ():
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
        scene = self.walk.scene
        own = nouns & scene.vocabulary(False) - scene.generic(False) - _ENDS
        wanted = Wanted(1, vacant, container=inside, targets=self.targets(), nouns=frozenset(own))
        return self.world.place_ranked(of, wanted, words)

    def _slot_words(self) -> frozenset[str]:
        scene = self.walk.scene
        return frozenset[str]().union(*(e.words for e in scene.places if scene.single(e.id)))
