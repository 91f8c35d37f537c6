"""Names by where things stand: "the block left of object 2", "the leftmost one", "on the position next to object 3".

What a phrase means is computed from the map's coordinates and the places that things have come to in the steps so far
(`llmbt_compiler.relations`). Nothing is guessed between two equals.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from llmbt_compiler.parsing.ledger import Ledger
from llmbt_compiler.parsing.model import Extent
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Fault, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene, natural
from llmbt_compiler.parsing.space.expressions import Ranked, Relation
from llmbt_compiler.parsing.words import Token, lexicon
from llmbt_compiler.relations import (
    ALIGNED_M,
    DIRECTIONS,
    SAME_HEIGHT_M,
    Around,
    Thing,
    above,
    behind,
    below,
    beside,
    between,
    distance,
    in_front_of,
    layout,
    left_of,
    nearest_first,
    on_top_of,
    ranked,
    right_of,
    ties,
)

__all__ = ["Wanted", "World", "said"]

_SHOWN = 6
_VIEWERS = frozenset({"me", "us", "you", "robot", "arm", "gripper", "viewer", "myself", "yourself"})
_TWO: Mapping[str, Callable[[Thing, Thing], bool]] = {
    "left": left_of,
    "right": right_of,
    "front": in_front_of,
    "behind": behind,
    "top": on_top_of,
    "above": above,
    "below": below,
}
_ACROSS = frozenset({"left", "right"})
_SIDES = _ACROSS | {"front", "behind"}
_WORDS = {
    "left": "left of", "right": "right of", "front": "in front of", "behind": "behind", "next": "next to",
    "between": "between", "top": "on top of", "above": "above", "below": "below", "nearest": "nearest to",
    "farthest": "farthest from",
}  # fmt: skip


def said(parts: Sequence[Token], text: str) -> str:
    """The words from the first to the last token, as the step has them."""
    return text[parts[0].start : parts[-1].end][:80] if parts else ""


@dataclass(frozen=True, slots=True)
class Wanted:
    """Places that are looked for: how many, whether only a free one will do (else the very next one is meant, free or
    not), whether the words speak of exactly one, within which container, and by which nouns of the map's own they
    go."""

    count: int = 1
    free: bool = True
    definite: bool = False
    container: str | None = None
    targets: tuple[str, ...] = ()
    nouns: frozenset[str] = frozenset()


@dataclass
class World:
    """The map as it is after the steps so far."""

    scene: Scene
    ledger: Ledger
    origin: Mapping[str, str | None]
    talk: Talk
    text: str
    notes: list[str] = field(default_factory=list)

    def around(self) -> Around:
        """Everything whose position is known by now."""
        moved: dict[str, str | None] = {}
        for o, place in self.ledger.where.items():
            if place != self.origin.get(o) or o in self.ledger.pending:
                known = place is not None and o not in self.ledger.pending and self.scene.single(place)
                moved[o] = place if known else None
        return layout(self.scene.map, moved)

    # -- noun phrases ----------------------------------------------------------------------------------------------

    def landmark(self, parts: Sequence[Token]) -> Found | Fault:
        """The objects or the places that a noun phrase means, whichever it is."""
        movable = self._of_objects(parts)
        first, second = (resolve_objects, resolve_places) if movable else (resolve_places, resolve_objects)
        found = first(parts, self.scene, self.talk)
        if isinstance(found, Found) and not {ANYWHERE, ORIGIN} & set(found.ids):
            return found
        other = second(parts, self.scene, self.talk)
        if isinstance(other, Found) and not {ANYWHERE, ORIGIN} & set(other.ids) and not other.corrected:
            return other
        return found if isinstance(found, Fault) else other

    def viewer(self, parts: Sequence[Token]) -> bool:
        """Whether a noun phrase means the one who looks: "the robot", "me"."""
        words = [t.text for t in parts if not lexicon().is_(t.text, "articles")]
        if not words or not set(words) <= _VIEWERS:
            return False
        return not any(w in self.scene.vocabulary(True) | self.scene.vocabulary(False) for w in words)

    def _of_objects(self, parts: Sequence[Token]) -> bool:
        lex = lexicon()
        for t in parts:
            if lex.is_(t.text, "pronouns", "plural_pronouns") or t.text in self.scene.vocabulary(True):
                return True
            if t.text in self.scene.vocabulary(False) or t.text in self.scene.generic(False):
                return False
        return True

    def every(self, parts: Sequence[Token], movable: bool) -> tuple[tuple[str, ...], bool] | Fault:
        """All things that a noun phrase may mean, however many it speaks of; and whether it speaks of several."""
        lex = lexicon()
        kept = tuple(
            t for t in parts if not lex.is_(t.text, "articles", "indefinite") and t.text not in {"one", "ones"}
        )
        many = any(t.text == "ones" or lex.is_(t.text, "all", "both") for t in parts)
        if not any(t.word for t in kept):
            pool = self.scene.pool(movable)
            if self.talk.described and movable:
                pool = tuple(e for e in pool if all(self.scene.fits(e, w) for w in self.talk.described)) or pool
            return tuple(sorted((e.id for e in pool), key=natural)), many
        first = kept[0]
        whole = (Token("all", first.start, first.start), *kept)
        resolve = resolve_objects if movable else resolve_places
        found = resolve(whole, self.scene, self.talk)
        if isinstance(found, Fault):
            return replace(found, title=found.title.replace("`all ", "`"))
        single = resolve(kept, self.scene, self.talk)
        plural = any(self.scene.word(t, movable).plural for t in kept if t.word)
        return found.ids, many or (plural and not (isinstance(single, Found) and len(single.ids) == 1))

    # -- referents -------------------------------------------------------------------------------------------------

    def ranked(
        self, of: Ranked, movable: bool, pool: Sequence[str], phrase: Sequence[Token], many: bool
    ) -> Found | Fault:
        """What has a rank among `pool`: the second from the left, the largest, the nearest to whoever looks."""
        around = self.around()
        extent = Extent(phrase[0].start, phrase[-1].end)
        words = said(phrase, self.text)
        unknown = [i for i in pool if around.get(i) is None]
        if unknown:
            return self._no_position(unknown, words, extent)
        things = [around[i] for i in pool]
        if of.end in {"near", "far"}:
            viewer = Thing("", 0.0, 0.0, 0.0, 0.0)
            groups = nearest_first(things, viewer)
            groups = groups if of.end == "near" else tuple(reversed(groups))
            hit = _at(groups, of.rank)
            self.notes.append(f"`{words}` is taken from where the {around.seen_by} stands")
        elif of.rank == 0:
            hit = _middle(things)
        else:
            hit = ranked(things, DIRECTIONS[of.end], of.rank)
        return self._chosen(hit, pool, words, extent, movable, many)

    def related(
        self,
        of: Relation,
        pool: Sequence[str],
        landmarks: Sequence[str],
        phrase: Sequence[Token],
        many: bool,
        *,
        either: bool = False,
    ) -> Found | Fault:
        """Which of `pool` are in a relation to the landmarks; where one thing is meant, the next one if the others all
        lie beyond it. `either`: any one of the landmarks will do ("next to a yellow one")."""
        around = self.around()
        extent = Extent(phrase[0].start, phrase[-1].end)
        words = said(phrase, self.text)
        unknown = [i for i in landmarks if around.get(i) is None]
        if unknown:
            return self._no_position(unknown, words, extent)
        marks = [around[i] for i in landmarks] or [Thing("", 0.0, 0.0, 0.0, 0.0)]
        things = [t for i in pool if (t := around.get(i)) is not None and i not in landmarks]
        if either and of.name not in {"nearest", "farthest"}:
            objects = {e.id: t for e in self.scene.objects if (t := around.get(e.id)) is not None}
            near = [t for i in pool if (t := around.get(i)) is not None]
            hit = tuple(
                t.id for t in near if any(m.id != t.id and self._holds(of.name, t, [m], objects) for m in marks)
            )
        elif of.name in {"nearest", "farthest"}:
            groups = nearest_first(things, marks[0])
            hit = _at(groups if of.name == "nearest" else tuple(reversed(groups)), 1)
        else:
            objects = {e.id: t for e in self.scene.objects if (t := around.get(e.id)) is not None}
            hit = tuple(t.id for t in things if self._holds(of.name, t, marks, objects))
            hit = hit or (self._in_order(of.name, things, marks) if not many else ())
            if len(hit) > 1 and not many and of.name in _TWO:
                nearer = [c for c in hit if all(x == c or _TWO[of.name](around[x], around[c]) for x in hit)]
                hit = tuple(nearer) or hit
        return self._chosen(hit, pool, words, extent, True, many)

    def _in_order(self, name: str, things: Sequence[Thing], marks: Sequence[Thing]) -> tuple[str, ...]:
        """What is on that side of a landmark as the prompt lists it: on the same surface, however far before or behind
        it. Only for who looks for a thing: where one is to stand, it would say too little."""
        if name not in _SIDES or len(marks) != 1:
            return ()
        on = self.ledger.where.get(marks[0].id)
        level = [t for t in things if on is not None and self.ledger.where.get(t.id) == on]
        across = name in _ACROSS
        mark, *along = (replace(t, ahead=0.0) if across else replace(t, right=0.0) for t in (marks[0], *level))
        return tuple(t.id for t in along if _TWO[name](t, mark))

    def _holds(self, name: str, thing: Thing, marks: Sequence[Thing], others: Mapping[str, Thing]) -> bool:
        if name == "between":
            return len(marks) == 2 and between(thing, marks[0], marks[1])
        if name == "next":
            return any(beside(thing, m, others) for m in marks)
        return all(_TWO[name](thing, m) for m in marks)

    def _chosen(
        self, hit: Sequence[str], pool: Sequence[str], words: str, extent: Extent, movable: bool, many: bool
    ) -> Found | Fault:
        ids = tuple(sorted(hit, key=natural))
        if not ids:
            shown = tuple(pool[:_SHOWN])
            kind = "E301" if movable else "E302"
            return Fault(
                kind, f"the scene has no `{words}`", extent, "by where things stand", _did_you_mean(shown), shown
            )
        if len(ids) > 1 and not many:
            return Fault(
                "E304",
                f"`{words}` fits {len(ids)} things",
                extent,
                "which?",
                f"say which of {', '.join(ids[:_SHOWN])}",
                ids,
            )
        self.notes.append(f"`{words}`: {', '.join(ids)}")
        return Found(ids)

    def _no_position(self, ids: Sequence[str], words: str, extent: Extent) -> Fault:
        return Fault(
            "E309",
            f"`{words}`: it is not known where {', '.join(ids[:_SHOWN])} will stand",
            extent,
            "the map and the steps before do not say it",
            "name the thing or the place itself",
        )

    # -- destinations ----------------------------------------------------------------------------------------------

    def spots(self, of: Relation, landmarks: Sequence[str], wanted: Wanted, phrase: Sequence[Token]) -> Found | Fault:
        """Places that take one thing each, in a relation to the landmarks: the nearest of them first."""
        around = self.around()
        extent = Extent(phrase[0].start, phrase[-1].end)
        words = said(phrase, self.text)
        unknown = [i for i in landmarks if around.get(i) is None]
        if unknown:
            return self._no_position(unknown, words, extent)
        marks = [around[i] for i in landmarks] or [Thing("", 0.0, 0.0, 0.0, 0.0)]
        slots = self._slots(around, wanted.container, wanted.nouns)
        apart = {i: t for i, t in slots.items() if all(distance(t, m) > ALIGNED_M for m in marks)}
        fitting = [t for t in apart.values() if self._lies(of.name, t, marks, apart)]
        level = [t for t in fitting if all(abs(t.bottom - m.bottom) <= SAME_HEIGHT_M for m in marks)]
        fitting = level if of.name not in {"nearest", "farthest", "above", "below"} and level else fitting
        order = sorted(fitting, key=lambda t: (sum(distance(t, m) for m in marks), natural(t.id)))
        order = order[::-1] if of.name == "farthest" else order
        if not order:
            return self._nowhere(of, landmarks, words, extent)
        if of.direct or not wanted.free:
            order = order[: max(wanted.count, 1)] if of.name != "next" else order
        free = [t.id for t in order if not self._taken(t.id, wanted.targets)]
        if not wanted.free and not of.direct and of.name != "next":
            free = [t.id for t in order]
        if len(free) < wanted.count:
            names = ", ".join(t.id for t in order[:_SHOWN])
            return Fault("E308", f"`{words}`: no free position there", extent, "all are taken", f"there is {names}")
        return self._settled(free, wanted, words, extent)

    def agrees(self, of: Relation, landmarks: Sequence[str], place: str, phrase: Sequence[Token]) -> Found | Fault:
        """A position that the words name beside the relation; E307 where it is not in that relation."""
        around = self.around()
        marks = [t for i in landmarks if (t := around.get(i)) is not None]
        at, words = around.get(place), said(phrase, self.text)
        if at is None or len(marks) < len(landmarks) or of.name in {"nearest", "farthest", "top", "above", "below"}:
            return Found((place,))
        apart = {i: t for i, t in self._slots(around, None).items() if all(distance(t, m) > ALIGNED_M for m in marks)}
        if place in apart and self._lies(of.name, at, marks, apart):
            return Found((place,))
        others = [t.id for t in apart.values() if self._lies(of.name, t, marks, apart) and not self._taken(t.id, ())]
        return Fault(
            "E307",
            f"{place} is not {_WORDS[of.name]} {', '.join(landmarks)}",
            Extent(phrase[0].start, phrase[-1].end),
            f"`{words}` contradicts the map",
            "name the place alone",
            tuple(dict.fromkeys((place, *others[:_SHOWN]))),
        )

    def _settled(self, free: Sequence[str], wanted: Wanted, words: str, extent: Extent) -> Found | Fault:
        if wanted.definite and len(free) > wanted.count:
            ids = tuple(sorted(free, key=natural))
            return Fault(
                "E304",
                f"`{words}` fits {len(ids)} places",
                extent,
                "which?",
                f"say which of {', '.join(ids[:_SHOWN])}",
                ids,
            )
        ids = tuple(free[: wanted.count])
        more = " of " + ", ".join(free[:_SHOWN]) if len(free) > wanted.count else ""
        self.notes.append(f"`{words}`: {', '.join(ids)}{more}")
        return Found(ids)

    def _lies(self, name: str, slot: Thing, marks: Sequence[Thing], slots: Mapping[str, Thing]) -> bool:
        if name in {"nearest", "farthest"}:
            return True
        if name == "between":
            return len(marks) == 2 and between(slot, marks[0], marks[1])
        if name == "next":
            return any(beside(slot, m, slots) for m in marks)
        return all(_TWO[name](slot, m) for m in marks)

    def _slots(self, around: Around, container: str | None, nouns: frozenset[str] = frozenset()) -> dict[str, Thing]:
        """The places with a known position that take single things."""
        inner = {p.id for p in self.scene.map.places if p.parent is not None} - {
            p.parent for p in self.scene.map.places
        }
        parts = inner if not self.scene.single_types else ()  # in a library without slots, the parts of places
        return {
            p.id: t
            for p in self.scene.places
            if (self.scene.single(p.id) or p.id in parts)
            and (t := around.get(p.id)) is not None
            and (container is None or self.scene.within(p.id, container))
            and all(self.scene.fits(p, w) for w in nouns)
        }

    def _taken(self, place: str, targets: Sequence[str]) -> bool:
        who = targets[0] if len(targets) == 1 else ""
        return self.ledger.taken(place, who)

    def _nowhere(self, of: Relation, landmarks: Sequence[str], words: str, extent: Extent) -> Fault:
        """No goal can say it: what a landmark stands on, as a whole, is the nearest that one can."""
        where = ", ".join(landmarks) or "the viewer"
        on = {p for i in landmarks if (p := self.ledger.where.get(i)) is not None and not self.scene.single(p)}
        title = f"`{words}`: there is no position {_WORDS[of.name]} {where}"
        if not on:
            return Fault("E309", title, extent, "none is in the map", "name the place itself")
        ids = tuple(sorted(on, key=natural))
        label = f"{', '.join(ids)} has no positions of its own"
        return Fault("E309", title, extent, label, f"name a place; is anywhere on {ids[0]} right?", ids)

    def place_ranked(self, of: Ranked, wanted: Wanted, phrase: Sequence[Token]) -> Found | Fault:
        """ "The leftmost free position of level 3": among all positions of the container, or the free ones."""
        around = self.around()
        slots = self._slots(around, wanted.container, wanted.nouns)
        extent = Extent(phrase[0].start, phrase[-1].end)
        words = said(phrase, self.text)
        if not slots:
            return Fault("E302", f"`{words}`: the map knows no positions there", extent, "", "name the place itself")
        free = [i for i in slots if not self._taken(i, wanted.targets)]
        pool = free if wanted.free else list(slots)
        if not pool:
            return Fault("E308", f"`{words}`: no free position there", extent, "all are taken")
        if of.end not in {"near", "far"}:
            ends = self.ends(list(slots) if of.rank == 0 else pool, of.end, of.rank)
            ends = tuple(i for i in ends if i in pool) or ends  # of the middle ones the free one
            return self._chosen(ends, pool, words, extent, False, False)
        return self.ranked(of, False, pool, phrase, False)

    def ends(self, slots: Sequence[str], end: str, rank: int) -> tuple[str, ...]:
        """What has a rank among the positions of each row: the leftmost position of a shelf is one of every level."""
        around = self.around()
        rows: dict[str, list[Thing]] = {}
        for i in slots:
            thing = around.get(i)
            if thing is not None:
                rows.setdefault(next(iter(self.scene.map.containers(i)), ""), []).append(thing)
        if end in {"near", "far"} or not rows:
            return ()
        found = [_middle(row) if rank == 0 else ranked(row, DIRECTIONS[end], rank) for row in rows.values()]
        return tuple(sorted((i for ids in found for i in ids), key=natural))

    def in_order(self, container: str, end: str) -> tuple[str, ...] | None:
        """The positions of a container from one end to the other; None where they are not in such an order."""
        slots = self._slots(self.around(), container)
        groups = ties(slots.values(), DIRECTIONS[end])
        return tuple(g[0] for g in groups) if groups and all(len(g) == 1 for g in groups) else None


def _at(groups: Sequence[Sequence[str]], rank: int) -> tuple[str, ...]:
    before = 0
    for group in groups:
        if before < rank <= before + len(group):
            return tuple(group)
        before += len(group)
    return ()


def _middle(things: Sequence[Thing]) -> tuple[str, ...]:
    """The middle one of an odd number of things in a row, from the left or else from the front; of an even number the
    two in the middle."""
    for end in ("left", "front"):
        groups = ties(things, DIRECTIONS[end])
        if len(groups) == len(things) and groups:
            half = len(groups) // 2
            return groups[half] if len(groups) % 2 else (*groups[half - 1], *groups[half])
    return tuple(t.id for t in things)


def _did_you_mean(ids: Sequence[str]) -> str:
    return f"did you mean {', '.join(ids)}?" if ids else ""
