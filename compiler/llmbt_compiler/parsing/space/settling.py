"""A clause with relations made into one with names: each relational phrase gives way to the ids that it means.

The walk knows names only; what "the block left of object 2" or "in a row on level 1" means is settled here, clause by
clause, since it depends on where the steps before have put things.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace

from llmbt_compiler.keywords.labels import Kind
from llmbt_compiler.parsing.acts import Acting
from llmbt_compiler.parsing.clauses import Clause, Group, Phrase
from llmbt_compiler.parsing.ground import Stop
from llmbt_compiler.parsing.model import LabelledStep, NoteKind
from llmbt_compiler.parsing.space.arranging import Arranging
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.space.orders import arrangement
from llmbt_compiler.parsing.space.placing import Placing
from llmbt_compiler.parsing.space.reading import name_end
from llmbt_compiler.parsing.space.world import World
from llmbt_compiler.parsing.verbs import Verb, read_verb
from llmbt_compiler.parsing.words import lexicon, tokens

__all__ = ["certainty", "related"]


def certainty(step: LabelledStep) -> float:
    """How sure the tagger is of a step's keywords, those left out that a relation or an order explains."""
    text = tokens(step.text)
    explained = [(text[r.start].start, text[r.end - 1].end) for r in relations(text)]
    asked = arrangement(step.text)
    explained += list(asked.parts) if asked is not None else []
    if not explained or not step.spans:
        return step.certainty
    nouns = lexicon().places
    kept = [
        s.confidence
        for s in step.spans
        if not any(a < s.end and s.start < b for a, b in explained) and s.text.split()[-1].lower() not in nouns
    ]
    return max(step.certainty, min(kept, default=1.0))


def related(walk: Acting, clause: Clause, start: int, end: int) -> Iterator[Clause]:
    """The clause with every relation, rank and order in text[start:end] settled; in parts, one after the other, where a
    later part may build on an earlier one. Stop where one cannot be settled; the reason has been noted."""
    text = walk.now.text
    spoken = relations(tokens(text, start, end)) or arrangement(text, start, end)
    if not spoken or not clause.groups:
        yield _settled(walk, clause, start, end)
        return
    groups = tuple(part for g in _joined(clause.groups, text, start, end) for part in _apart(g, text, start, end))
    if not groups:  # what seemed a thing or a place is a landmark
        yield _settled(walk, clause, start, end)
        return
    starts = [min(p.extent.start for p in g.phrases) for g in groups]
    for group, begin, stop in zip(groups, [start, *starts[1:]], [*starts[1:], end], strict=True):
        yield _settled(walk, replace(clause, groups=(group,)), begin, stop)


def _joined(groups: Sequence[Group], text: str, start: int, end: int) -> tuple[Group, ...]:
    """The groups, where a landmark that was taken for a target opens none: "the block between A and B"."""
    line = tokens(text, start, end)
    marks = [(line[r.end].start, line[name_end(line, r) - 1].end) for r in relations(line) if r.end < len(line)]

    def mark(p: Phrase) -> bool:
        return any(a <= p.extent.start and p.extent.end <= b for a, b in marks)

    out: list[Group] = []
    for g in groups:
        kept = tuple(p for p in g.targets if not mark(p))
        lost = tuple(replace(p, kind=Kind.LOCATION) for p in g.targets if mark(p))
        before = out.pop() if out and lost and not kept else Group()
        locations = (*before.locations, *g.locations, *lost)
        out.append(Group((*before.targets, *kept), (*before.destinations, *g.destinations), locations))
    return tuple(out)


def _apart(group: Group, text: str, start: int, end: int) -> Iterator[Group]:
    """ "A to its left and B on position 12": what comes after "its left" is another pair of thing and place."""
    line = tokens(text, start, end)
    ends = [line[r.end - 1].end for r in relations(line) if r.owner]
    cuts = [
        p.extent.start
        for p in group.targets[1:]
        if any(group.targets[0].extent.end < e <= p.extent.start for e in ends)
    ]
    for low, high in itertools.pairwise([start, *cuts, end + 1]):
        kept = [
            tuple(p for p in ps if low <= p.extent.start < high)
            for ps in (group.targets, group.destinations, group.locations)
        ]
        if any(kept):
            yield Group(*kept)


def _settled(walk: Acting, clause: Clause, start: int, end: int) -> Clause:
    verb = _verb(walk, clause)
    targets = [p for p in clause.phrases if p.kind is Kind.TARGET]
    if clause.negated or clause.conditional or (targets and all(walk.of_robot(p) for p in targets)):
        return clause
    text = walk.now.text
    world = World(walk.scene, walk.ledger, walk.origin, walk.talk(), text)
    parts = tokens(text, start, end)
    asked = arrangement(text, start, end)
    try:
        if asked is not None and walk.placing():
            made = Arranging(walk, world, clause, verb, parts).arranged(asked)
            if made is not None:
                return made
        if not verb.templates and clause.action:
            return clause
        return Placing(walk, world, clause, verb, parts).related()
    except Stop:
        walk.lost, walk.targets = True, ((), -9)
        raise
    finally:
        for note in world.notes:
            walk.note(NoteKind.INFERRED, note, clause.extent)


def _verb(walk: Acting, clause: Clause) -> Verb:
    words = [t.text for t in tokens(clause.action) if t.word]
    return read_verb(words[0] if words else "", (*words[1:], *clause.particles), walk.scene.library)
