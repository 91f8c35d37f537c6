"""A clause that is being read: its tokens, and the phrases in it as far as they are settled."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from llmbt_compiler.keywords.labels import Kind
from llmbt_compiler.parsing.acts import Acting
from llmbt_compiler.parsing.clauses import Clause, Group, Phrase
from llmbt_compiler.parsing.model import Extent
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Found
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.space.expressions import Relation, relations
from llmbt_compiler.parsing.space.world import World
from llmbt_compiler.parsing.verbs import Verb
from llmbt_compiler.parsing.words import Token, tokens

__all__ = ["ONTO", "STOPS", "Reading", "name_end", "named"]

STOPS = frozenset({
    ",", ".", ";", ":", "and", "then", "so", "which", "that", "while", "to", "on", "onto", "into", "in", "at", "from",
    "for", "with", "using", "by", "(", ")", "but", "where", "as", "before", "after", "until", "is", "are",
})  # fmt: skip
"""What ends a name."""
ONTO = frozenset({"on", "onto", "to", "into", "in", "at"})
LONGEST_NAME = 8


def named(kind: Kind, id_: str, extent: Extent, preposition: str = "") -> Phrase:
    """A phrase that names one thing, standing where the words stood that meant it."""
    parts = tuple(replace(t, start=extent.start, end=extent.end) for t in tokens(id_))
    return Phrase(kind, parts, extent, preposition)


def name_end(line: Sequence[Token], relation: Relation) -> int:
    """Where the landmarks after a relation may end at the latest."""
    joints = 1 if relation.name == "between" else 0
    begins = {r.start for r in relations(line)}
    i = relation.end
    while i < len(line) and i not in begins and i - relation.end < LONGEST_NAME * (1 + joints):
        if line[i].text == "and" and joints == 1:
            joints = 2
        elif line[i].text in STOPS:
            break
        i += 1
    return i


@dataclass
class Reading:
    """One clause, all its tokens, its verb, and the world as it is when the clause is carried out."""

    walk: Acting
    world: World
    clause: Clause
    verb: Verb
    line: tuple[Token, ...]

    def place_at(self, after: Sequence[Token]) -> tuple[str, int] | None:
        """The place that the tokens begin with, and how many of them name it."""
        size = next((i for i, t in enumerate(after) if t.text in STOPS and t.text != "of"), len(after))
        for length in range(min(size, LONGEST_NAME), 0, -1):
            found = resolve_places(after[:length], self.walk.scene, self.world.talk)
            if isinstance(found, Found) and len(found.ids) == 1 and not {ANYWHERE, ORIGIN} & set(found.ids):
                return found.ids[0], length
        return None

    def targets(self) -> tuple[str, ...]:
        phrases = [p for g in self.clause.groups for p in g.targets if not self.is_place(p)]
        ids = tuple(dict.fromkeys(i for p in phrases for i in self.walk.quiet(p)))
        return ids or tuple(self.walk.ledger.pending)

    def is_place(self, phrase: Phrase) -> bool:
        words = [t.text for t in phrase.parts if t.word]
        return bool(words) and (words[-1] in self.walk.scene.generic(False))

    def put(self, made: Sequence[Phrase], extent: Extent) -> None:
        """Let new phrases stand for all that overlap with the words they were made of."""
        groups = list(self.clause.groups) or [Group()]

        def kept(phrases: Iterable[Phrase]) -> tuple[Phrase, ...]:
            return tuple(p for p in phrases if p.extent.end <= extent.start or extent.end <= p.extent.start)

        hit = [k for k, g in enumerate(groups) if any(p not in kept(g.phrases) for p in g.phrases)]
        before = [k for k, g in enumerate(groups) if any(p.extent.end <= extent.start for p in g.phrases)]
        at = hit[0] if hit else (before[-1] if before else 0)
        groups = [Group(kept(g.targets), kept(g.destinations), kept(g.locations)) for g in groups]
        by = {k: tuple(p for p in made if p.kind is k) for k in (Kind.TARGET, Kind.DESTINATION, Kind.LOCATION)}
        groups[at] = Group(
            (*groups[at].targets, *by[Kind.TARGET]),
            (*groups[at].destinations, *by[Kind.DESTINATION]),
            (*groups[at].locations, *by[Kind.LOCATION]),
        )
        self.clause = replace(self.clause, groups=tuple(g for g in groups if g.phrases))
