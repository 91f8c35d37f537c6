"""Several things put into an order, or in a row: each gets a position of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from llmbt_compiler.keywords.labels import Kind
from llmbt_compiler.parsing.clauses import Clause, Group, Phrase
from llmbt_compiler.parsing.ground import Stop
from llmbt_compiler.parsing.model import Extent
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Fault, Found
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.scene import natural
from llmbt_compiler.parsing.space.orders import Arrangement
from llmbt_compiler.parsing.space.reading import ONTO, Reading, named
from llmbt_compiler.parsing.verbs import Shape
from llmbt_compiler.relations import DIRECTIONS, layout, ties

__all__ = ["Arranging"]


class Arranging(Reading):
    """Reads a clause that asks for an order."""

    def arranged(self, asked: Arrangement) -> Clause | None:
        """Several things put into an order: each with its position. None where it is about one thing only."""
        walk, text = self.walk, self.walk.now.text
        outside = [
            p
            for p in self.clause.phrases
            if not any(a < p.extent.end and p.extent.start < b for a, b in asked.parts) or p.kind is Kind.TARGET
        ]
        targets = [p for p in outside if p.kind is Kind.TARGET and not p.excluded]
        found = [resolve_objects(p.parts, walk.scene, walk.talk()) for p in targets]
        ids = tuple(dict.fromkeys(i for f in found if isinstance(f, Found) for i in f.ids))
        if not targets:
            ids = tuple(walk.ledger.pending)
        if len(ids) < 2 and all(isinstance(f, Found) for f in found):
            return None
        for f in found:
            if isinstance(f, Fault):
                if f.code == "E304":
                    return None
                raise walk.fault(f)
        extent = Extent(asked.parts[0][0], asked.parts[-1][1])
        if not asked.known:
            words = text[extent.start : extent.end]
            raise walk.fault(
                Fault("E309", f"`{words}`: the map does not tell such an order", extent, "", "name the order itself")
            )
        places = self._named_places(outside, asked)
        if len(places) == 1 and not walk.scene.single(places[0]):
            chosen = self._run(places[0], asked, ids, extent)
        elif len(places) == len(ids) and all(walk.scene.single(p) for p in places):
            chosen = self._sorted_places(places, asked)
        elif places:
            return None
        else:
            chosen = self._run(self._common(ids, extent), asked, ids, extent)
        order = self._in_order(ids, asked)
        self.world.notes.append("in order: " + ", ".join(f"{i} to {p}" for i, p in zip(order, chosen, strict=True)))
        template = walk.placing()[0]
        placing = any(walk.shape(t) is Shape.PLACE for t in self.verb.templates)
        where = Extent(min(p.extent.start for p in targets), extent.end) if targets else extent
        where = Extent(min(where.start, extent.start), max(where.end, extent.end))
        group = Group(
            tuple(named(Kind.TARGET, i, where) for i in order),
            tuple(named(Kind.DESTINATION, p, where, "on") for p in chosen),
        )
        return replace(
            self.clause,
            action=self.clause.action if placing else template.name,
            particles=(),
            groups=(group,),
            exception=(),
        )

    def _named_places(self, phrases: Sequence[Phrase], asked: Arrangement) -> tuple[str, ...]:
        """The places that the clause names beside the words of the order, labelled or not."""
        out: list[str] = []
        for p in phrases:
            if p.kind is not Kind.TARGET and not self.walk.quiet(p):
                out += [i for i in self.walk.places_of(p) if i not in {ANYWHERE, ORIGIN}]
        if out:
            return tuple(dict.fromkeys(out))
        for i, t in enumerate(self.line):
            inside = any(a <= t.start < b for a, b in asked.parts)
            if t.text in ONTO and not inside:
                place = self.place_at(self.line[i + 1 :])
                if place is not None:
                    return (place[0],)
        return ()

    def _common(self, ids: Sequence[str], extent: Extent) -> str:
        """The innermost place with positions that all the things stand on by now."""
        walk = self.walk
        around = [
            [p, *walk.scene.map.containers(p)] if (p := walk.ledger.where.get(i)) is not None else [] for i in ids
        ]
        for place in around[0] if around else ():
            if all(place in a for a in around) and len(self._spots(place)) >= len(ids):
                return place
        walk.complain(
            "E305", f"where are {', '.join(ids[:6])} to stand?", extent, "no place is named", "name the place"
        )
        raise Stop

    def _spots(self, place: str) -> tuple[str, ...]:
        scene = self.walk.scene
        return tuple(p.id for p in scene.map.inside(place) if scene.single(p.id))

    def _run(self, container: str, asked: Arrangement, ids: Sequence[str], extent: Extent) -> tuple[str, ...]:
        """So many free positions of a container, from the end asked for: without gaps, where there are so many."""
        walk = self.walk
        order = self.world.in_order(container, asked.end)
        if order is None and asked.end in {"left", "right"}:
            order = self.world.in_order(container, "front" if asked.end == "left" else "back")
        if not order:
            walk.complain(
                "E309", f"the positions of {container} are in no such order", extent, "",
                "name a place with positions in a row",
            )  # fmt: skip
            raise Stop
        who = frozenset(ids)
        taken = {p for o, p in walk.ledger.where.items() if o not in who}
        taken |= {e.place for e in walk.ledger.goals if e.target is not None and e.target not in who}
        free = [p not in taken for p in order]
        n = len(ids)
        for at in range(len(order) - n + 1):
            if all(free[at : at + n]):
                return order[at : at + n]
        loose = tuple(p for p, f in zip(order, free, strict=True) if f)
        if len(loose) < n or asked.row:
            kind = " in a row" if asked.row and len(loose) >= n else ""
            walk.complain(
                "E308", f"{container} has no {n} free positions{kind}", extent, f"free: {', '.join(loose) or 'none'}"
            )
            raise Stop
        return loose[:n]

    def _sorted_places(self, places: Sequence[str], asked: Arrangement) -> tuple[str, ...]:
        """Named positions, from the end asked for; as named where nothing but their listing gives an order."""
        around = self.world.around()
        things = [t for p in places if (t := around.get(p)) is not None]
        groups = ties(things, DIRECTIONS[asked.end])
        if asked.key == "listed" or len(groups) != len(places):
            return tuple(places)
        return tuple(g[0] for g in groups)

    def _in_order(self, ids: Sequence[str], asked: Arrangement) -> tuple[str, ...]:
        """The things, the one that comes first in front; things alike by their ids, with a note."""
        if asked.key == "listed":
            return tuple(ids)
        if asked.key == "number":
            return tuple(sorted(ids, key=natural))
        start = layout(self.walk.scene.map)
        groups = ties([start[i] for i in ids], DIRECTIONS[asked.key])
        for group in groups:
            if len(group) > 1:
                self.world.notes.append(f"{', '.join(sorted(group, key=natural))} are alike: by their ids")
        return tuple(i for g in groups for i in sorted(g, key=natural))
