"""Places told by counting from a thing: "right beside the green" has two sides, "two slots to the left" ends."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from llmbt_compiler.checking.phrases import Meant, landmark
from llmbt_compiler.checking.sentences import sentence_at
from llmbt_compiler.parsing.ledger import Ledger
from llmbt_compiler.parsing.names import Talk
from llmbt_compiler.parsing.scene import Scene, natural
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.space.world import World
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["Shift", "beside", "shifts"]

_SIDES = frozenset({"left", "right", "leftmost", "rightmost", "front", "behind", "back", "either", "both", "each"})
_STEPS = frozenset({"slot", "slots", "place", "places", "position", "positions", "spot", "spots", "space", "spaces",
                    "step", "steps", "notch", "notches"})  # fmt: skip
_FURTHER = frozenset({"further", "farther", "along", "over", "more", "up", "across", "to", "the", "towards"})


@dataclass(frozen=True, slots=True)
class Shift:
    """ "Two slots further left", words[start:end]: so many places to one side of where a thing stands."""

    start: int
    end: int
    count: int
    side: str

    def of(self, place: str, scene: Scene) -> str | None:
        """The place that it leads to from `place`; None beyond the end, or where there is no row."""
        row = _row(place, scene)
        at = row.index(place) + (self.count if self.side == "right" else -self.count) if place in row else -1
        return row[at] if 0 <= at < len(row) else None

    def beyond(self, place: str, scene: Scene) -> bool:
        """Whether it leads beyond the end of the row that a place is in."""
        return place in _row(place, scene) and self.of(place, scene) is None


def shifts(words: Sequence[Token]) -> Iterator[Shift]:
    """Every phrase that counts places to the left or to the right of where something stands now."""
    for i, t in enumerate(words[:-2]):
        count = int(t.number) if t.number is not None and t.number.isdecimal() else (1 if t.text in {"a", "an"} else 0)
        if not 0 < count < 20 or words[i + 1].text not in _STEPS:
            continue
        k = i + 2
        while k < len(words) and words[k].text in _FURTHER:
            k += 1
        of = k + 1 < len(words) and words[k + 1].text == "of"
        if k < len(words) and words[k].text in {"left", "right"} and not of:
            yield Shift(i, k + 1, count, words[k].text)


def _row(place: str, scene: Scene) -> tuple[str, ...]:
    """The positions beside a place, from the left to the right; none where it is in no row."""
    inner = next(iter(scene.map.containers(place)), None) if place else None
    if inner is None or not scene.single(place):
        return ()
    return _world(scene).in_order(inner, "left") or ()


def beside(
    words: Sequence[Token],
    phrases: Sequence[Meant],
    placed: Sequence[tuple[str, ...]],
    scene: Scene,
) -> Iterator[tuple[Meant, str]]:
    """Where the request wants a thing beside another, both sides of which are free: those words with both places, and
    the place that the goals take. `phrases` are those read otherwise: what stands in them tells things apart."""
    read = {k for p in phrases for k in range(p.start, max(p.end, p.stop))}
    where = {o.id: o.place for o in scene.map.objects}
    for relation in relations(words):
        if relation.name != "next" or relation.owner or relation.start in read:
            continue
        mark = landmark(words, relation.end, scene)
        rows = {m: r for m in (mark.ids if mark is not None else ()) if (r := _row(where.get(m) or "", scene))}
        if mark is None or len(rows) != 1 or any(a[0] in rows for a in placed):
            continue
        begin, end = sentence_at(words, relation.start)
        said = {t.text for k, t in enumerate(words[begin:end], begin) if not relation.start <= k < relation.end}
        if said & _SIDES or lexicon().function["conditional"] & said:
            continue
        ((one, row),) = rows.items()
        at = row.index(where[one] or "")
        sides = tuple(p for p in row if abs(row.index(p) - at) == 1 and p not in where.values())
        taken = [a[1] for a in placed if a[1] in sides]
        if len(sides) > 1 and len(taken) == 1:
            yield Meant(relation.start, mark.end, tuple(sorted(sides, key=natural))), taken[0]


def _world(scene: Scene) -> World:
    where = {o.id: o.place for o in scene.map.objects}
    return World(scene, Ledger(dict(where)), where, Talk(where), "")
