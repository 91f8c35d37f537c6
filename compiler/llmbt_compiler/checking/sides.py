"""Places told by counting from a thing: "right beside the green" has two sides, "two slots to the left" ends."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from llmbt_compiler.checking.referring import Meant, landmark
from llmbt_compiler.checking.sentences import sentence_at
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.scene import Scene, natural
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.space.rows import row_of
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["Shift", "beside", "nothing_beyond", "shifts", "sideways"]

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
        row = row_of(place, scene)
        at = row.index(place) + (self.count if self.side == "right" else -self.count) if place in row else -1
        return row[at] if 0 <= at < len(row) else None

    def beyond(self, place: str, scene: Scene) -> bool:
        """Whether it leads beyond the end of the row that a place is in."""
        return place in row_of(place, scene) and self.of(place, scene) is None


def shifts(words: Sequence[Token]) -> Iterator[Shift]:
    """Every phrase that counts places to the left or to the right of where something stands now."""
    yield from _side_last(words)
    for i, t in enumerate(words[:-2]):  # "one further to the left"
        k = i + 1
        while k < len(words) and words[k].text in _FURTHER:
            k += 1
        more = (
            words[i + 1].text in {"further", "farther", "more"}
            and k < len(words)
            and words[k].text in {"left", "right"}
        )
        if more and t.word and t.number is not None and [w.text for w in words[k + 1 : k + 2]] != ["of"]:
            yield Shift(i, k + 1, _count(t), words[k].text)
    for i, t in enumerate(words):  # "left by a slot"
        by = [w.text for w in words[i + 1 : i + 2]] == ["by"] and i + 3 < len(words) and words[i + 3].text in _STEPS
        if t.text in {"left", "right"} and by and _count(words[i + 2]):
            yield Shift(i, i + 4, _count(words[i + 2]), t.text)


def _side_last(words: Sequence[Token]) -> Iterator[Shift]:
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
        rows = {m: r for m in (mark.ids if mark is not None else ()) if (r := row_of(where.get(m) or "", scene))}
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


def sideways(words: Sequence[Token], placed: Sequence[tuple[str, ...]], scene: Scene) -> Iterator[tuple[Meant, str]]:
    """ "Sideways by one slot", "one slot over", "one place to the side": both sides where both are free, and the one
    that the goals take."""
    where = {o.id: o.place for o in scene.map.objects}
    for i, t in enumerate(words):
        begin, end = sentence_at(words, i)
        said = [w.text for w in words[begin:end]]
        counted = next((k for k in range(i - 1, max(begin, i - 2), -1) if words[k].text in _STEPS), None)
        aside = t.text == "sideways" or [w.text for w in words[i - 1 : i + 1]] in (["the", "side"], ["one", "side"])
        ends = i + 1 == len(words) or not words[i + 1].word or words[i + 1].text in {"please", "and", "on"}
        over = t.text in {"over", "along", "across"} and ((counted is not None and ends) or _by_one(words, i))
        by = t.text in _STEPS and i - 2 >= begin and words[i - 2].text == "by" and _count(words[i - 1]) and ends
        by_one = t.text == "one" and [w.text for w in words[max(0, i - 2) : i]] in (["over", "by"], ["along", "by"])
        by = by or (by_one and ends)
        if not (aside or over or by) or set(said) & (_SIDES | {"up", "down", "sideways"} - {t.text}):
            continue
        count = next((int(n) for a, b in pairwise(words[begin:end]) if b.text in _STEPS and (n := _count(a))), 1)
        for one, place in ((a[0], a[1]) for a in placed):
            row = row_of(where.get(one) or "", scene)
            at = row.index(where[one] or "") if row else 0
            sides = tuple(p for p in row if abs(row.index(p) - at) == count and p not in where.values())
            if len(sides) > 1 and place in sides:
                yield Meant(i, i + 1, tuple(sorted(sides, key=natural))), place


def _by_one(words: Sequence[Token], i: int) -> bool:
    """ "Over by one", and nothing behind it."""
    after = words[i + 1 : i + 4]
    counted = [t.text for t in after[:2]] == ["by", "one"]
    counted = counted or (len(after) > 1 and _count(after[0]) == 1 and after[1].text in _STEPS)
    return counted and (len(after) < 3 or not after[2].word)


def _count(t: Token) -> int:
    return int(t.number) if t.number is not None and t.number.isdecimal() else int(t.text in {"a", "an"})


def nothing_beyond(
    words: Sequence[Token], phrases: Sequence[Meant], moved: Sequence[str], scene: Scene
) -> Iterator[tuple[int, int, str]]:
    """Where a place is asked for to the left or the right of the last one of a row: those words, and the last one.
    `phrases` are those that tell things apart, `moved` the things that do not stay where they are."""
    read = {k for p in phrases for k in range(p.start, max(p.end, p.stop))}
    where = {o.id: o.place for o in scene.map.objects}
    for relation in relations(words):
        if relation.name not in {"left", "right"} or relation.owner or relation.start in read:
            continue
        named = next((m for m in mentions_in(words[relation.end :], scene) if m.start <= 1), None)
        mark = landmark(words, relation.end, scene) if named is None else None
        ids = (named.id,) if named is not None else mark.ids if mark is not None else ()
        if len(ids) != 1 or ids[0] in moved:
            continue
        place = ids[0] if not scene[ids[0]].movable else where.get(ids[0]) or ""
        row = row_of(place, scene)
        stop = relation.end + named.end if named is not None else mark.end if mark is not None else relation.end
        if row and place == row[0 if relation.name == "left" else -1]:
            yield relation.start, stop, place
