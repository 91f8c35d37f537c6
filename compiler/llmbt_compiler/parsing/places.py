"""Places held against the map: which a phrase means. Never a guess between two equals."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

from llmbt_compiler.parsing.model import Extent
from llmbt_compiler.parsing.names import (
    ANYWHERE,
    ORIGIN,
    Fault,
    Found,
    Talk,
    ambiguous,
    borrowed,
    corrections,
    exactly_named,
    ids_of,
    joined,
    listed,
    numbered,
    says,
    unknown,
)
from llmbt_compiler.parsing.phrase import Description, conjuncts, describe, split_place
from llmbt_compiler.parsing.scene import Entity, Scene, natural
from llmbt_compiler.parsing.words import Token, lexicon, tokens

__all__ = ["USERS", "WHEREABOUTS", "resolve_places"]


_OWN = frozenset({"hand", "hands", "side", "lap"})
_SEAT = frozenset({"location", "position", "place", "spot", "seat", "chair"})


def resolve_places(parts: Sequence[Token], scene: Scene, talk: Talk) -> Found | Fault:
    """The places that a phrase means, containers as they are named; ANYWHERE and ORIGIN stand for themselves.

    Faults: E302 unknown, E304 fits several, E307 contradicts the map.
    """
    exact = exactly_named(parts, scene.places)
    if len(exact) == 1:
        return Found((exact[0].id,))
    if (
        parts[-1].text in _OWN | _SEAT
        and len(parts) > 1
        and (parts[-2].owner or lexicon().is_(parts[-2].text, "articles"))
    ):
        owners = [t for t in parts[:-1] if t.owner and lexicon().is_(t.text, "users")]
        pronoun = {"my": "me", "your": "you", "our": "us", "his": "him", "her": "her", "their": "them"}.get(
            parts[-2].text
        )
        pronoun = pronoun if parts[-1].text in _OWN else None
        if owners and scene.persons:  # "the user's hands"
            return resolve_places(tuple(replace(t, owner=False) for t in parts[:-1]), scene, talk)
        if pronoun is not None and scene.persons:
            return resolve_places((replace(parts[-2], text=pronoun),), scene, talk)
    own = [t for t in parts[:-1] if t.owner and lexicon().is_(t.text, "users")]
    if own and parts[-1].text in scene.generic(False) and len(scene.persons) == 1:
        return Found((scene.persons[0].id,))  # "the user's place"
    parts = (*(t for t in parts[:-1] if not (t.owner and lexicon().is_(t.text, "users"))), parts[-1])
    extent = Extent(parts[0].start, parts[-1].end)
    if len(parts) > 1 and parts[-1].text == "there" and talk.place is not None:  # "the second position there"
        return _nested(parts[:-1], tokens(talk.place), scene, talk)
    left = _left(parts, scene, talk)
    if left is not None:
        return left
    owner = next((i for i, t in enumerate(parts[:-1]) if t.owner), None)
    if owner is not None and len(exactly_named(_plain(parts[: owner + 1]), scene.places)) == 1:
        return _nested(parts[owner + 1 :], _plain(parts[: owner + 1]), scene, talk)  # "rack B's last slot"
    head, inner = split_place(parts, "on", "in", "at", "of", "inside", "within", "from")
    inner = inner or _side_by_side(parts, scene)
    if inner and len(inner) + len(head) > len(parts):
        head = parts[len(inner) :] if parts[: len(inner)] == inner else parts[: -len(inner)]
    if inner and not _quantifier_only(head):
        return _nested(head, inner, scene, talk)
    groups = conjuncts(parts)
    if not groups:
        return Fault("E305", "no place is named", extent, "where?")
    found: list[Found] = []
    for d, group in zip(borrowed([describe(g, scene, False) for g in groups], scene.colours), groups, strict=True):
        exact = exactly_named(group, scene.places)
        one = Found((exact[0].id,)) if len(exact) == 1 else _places(d, says(group), scene, talk)
        if isinstance(one, Fault):
            return one
        found.append(one)
    return joined(found)


_STEAD = frozenset({"place", "stead", "spot", "position"})
_BECOMING = frozenset({"now", "newly", "leaves", "left", "become", "becomes", "became"})
_LEAVING = frozenset({"leaves", "left", "vacates", "vacated", "frees", "freed"})
_LEFT = frozenset({"freed", "vacated", "emptied"})


def _left(parts: Sequence[Token], scene: Scene, talk: Talk) -> Found | Fault | None:
    """ "The now empty slot", "the vacated position", "that slot" where no slot was named: where the thing taken last
    stood; None for other phrases."""
    lex = lexicon()
    said = [t.text for t in parts]
    kinds = [w for t in parts if (w := scene.word(t, False).text)]
    if len(said) == 2 and said[0] in {"its", "their"} and said[1] in _STEAD and talk.vacated is not None:
        own = any(talk.where.get(i) is None or i == talk.taken for i in talk.targets)
        if own or not talk.targets:
            extent = Extent(parts[0].start, parts[-1].end)
            return Fault("E305", f"`{says(parts)}`: whose, and which?", extent, "where?", "name the place")
        return Found((talk.vacated,))  # "put object 3 in the sorting area; object 7 in its place"
    if len(said) == 2 and said[0] in {"its", "their"} and said[1] in scene.generic(False):
        return Found((ORIGIN,))  # "set it back in its slot"
    pointed = len(said) == 2 and said[0] in {"that", "this"} and said[1] in scene.generic(False)
    if pointed and talk.vacated is not None and scene.single(talk.vacated):
        here = talk.place is not None and all(scene.fits(scene[talk.place], w) for w in kinds)
        return None if here else Found((talk.vacated,))  # "take crate A from its slot ...; crate C into that slot"
    freed = (
        any(w in _LEFT for w in said)
        or {"that", "leaves"} <= set(said)
        or any(a in _BECOMING and lex.is_(b, "vacant") for a, b in pairwise(said))
    )
    freed = freed or any(a in {"it", "this", "that"} and b in _LEAVING for a, b in pairwise(said))
    if not freed:
        return None
    if (
        talk.vacated is not None
        and scene.single(talk.vacated)
        and all(scene.fits(scene[talk.vacated], w) for w in kinds)
    ):
        return Found((talk.vacated,))
    extent = Extent(parts[0].start, parts[-1].end)
    return Fault("E305", f"`{says(parts)}`: nothing was taken from such a place", extent, "where?", "name the place")


def _plain(parts: Sequence[Token]) -> tuple[Token, ...]:
    return (*parts[:-1], replace(parts[-1], owner=False))


def _side_by_side(parts: Sequence[Token], scene: Scene) -> tuple[Token, ...]:
    """The container of "level 3 position 4" or "slot 2 rack B", two names with nothing between them; empty for none."""
    for i in range(2, len(parts) - 1):
        left, right = tuple(parts[:i]), tuple(parts[i:])
        for outer in (left, right):
            known = exactly_named(outer, scene.places)
            if len(known) == 1 and scene.map.inside(known[0].id) and left[-1].number and right[-1].number:
                return outer
    return ()


def _quantifier_only(parts: Sequence[Token]) -> bool:
    lex = lexicon()
    return all(lex.is_(t.text, "all", "both", "articles", "rest") or t.number is not None for t in parts)


def _nested(head: Sequence[Token], inner: Sequence[Token], scene: Scene, talk: Talk) -> Found | Fault:
    """ "position 12 on shelf level 1": the place, if it lies in the container; a vague
    one is the container.
    """
    outer = resolve_places(inner, scene, talk)
    if isinstance(outer, Fault):
        return outer
    d = describe(head, scene, False)
    generic = bool(d.texts) and all(w in scene.generic(False) for w in d.texts)
    if d.vacant and (d.ordinal == 1 or d.rank == "bottom"):  # "the first free position on level 2"
        d = replace(d, ordinal=None, rank="")
    if not d.unknown and not d.numbers and not d.all and d.ordinal is None and (d.vacant or generic) and not d.rank:
        return _part_of(d, outer, scene, talk) or replace(outer, vague=True)
    inside = tuple(e for e in scene.places if any(scene.within(e.id, c) for c in outer.ids) and e.id not in outer.ids)
    found = _places(d, says(head), scene, talk, inside)
    if not isinstance(found, Fault):
        return replace(found, corrected=outer.corrected + found.corrected)
    elsewhere = resolve_places(head, scene, talk)
    if isinstance(elsewhere, Fault):
        return found if d.ordinal is not None or d.rank else elsewhere
    if ANYWHERE in outer.ids:
        return elsewhere  # "position 11 (any free position would do)"
    if all(scene[i].person and not any(scene.map.containers(i)) for i in elsewhere.ids):
        return elsewhere  # "the person at the desk": the map does not say where people are
    if all(any(scene.within(c, e) for c in outer.ids) for e in elsewhere.ids):
        return outer
    at = ", ".join(f"{e} is on {next(iter(scene.map.containers(e)), 'no container')}" for e in elsewhere.ids)
    return Fault(
        "E307",
        f"`{says(head)}` is not on {listed(outer.ids)}",
        Extent(head[0].start, inner[-1].end),
        at,
        f"did you mean {listed((*elsewhere.ids, *outer.ids))}?",
        (*elsewhere.ids, *outer.ids),
    )


def _places(
    d: Description, said: str, scene: Scene, talk: Talk, pool: tuple[Entity, ...] | None = None
) -> Found | Fault:
    if d.pronoun:
        return _pointed(d, said, scene, talk)
    if d.unknown:
        return unknown(d, scene, False, said)
    if d.origin:
        return _old(d, scene, talk)
    if d.same:
        return _same(d, said, scene, talk)
    pool = scene.places if pool is None else pool
    corrected = corrections(d)
    if d.numbers or d.ranges:
        hits = numbered(d, scene, False, said, pool)
        if isinstance(hits, Fault):
            return _counted(d, pool, scene) or hits
        return Found(tuple(e.id for e in hits), corrected)
    generic = all(w in scene.generic(False) for w in d.texts)
    if d.vacant and generic and (d.rank or (d.ordinal or 1) > 1):
        return ambiguous(d, ids_of(pool), said)  # "the second free slot": which come before it depends on what is taken
    if d.vacant and generic:
        return Found((ANYWHERE,), vague=True)
    base = [e for e in pool if all(scene.fits(e, w) for w in d.texts)]
    if d.texts and set(d.texts) <= WHEREABOUTS and len(base) < len(pool):
        return unknown(d, scene, False, said)  # "to the right" is not the right well, nor "back" the back ring
    base = [e for e in base if not any(o is not e and scene.within(o.id, e.id) for o in base)] if d.vacant else base
    if d.vacant and len(base) > 1 and not d.rank and (d.ordinal or 1) == 1:
        return _vacant(d, base, said, scene, talk)
    if not base or (d.bare and not d.rank):
        return unknown(d, scene, False, said)
    named = [e for e in base if set(d.texts) <= e.stem | {e.type}]
    base = named or base
    if d.rank or d.ordinal is not None:
        return _ranked(d, base, scene, said, corrected, inside=pool is not scene.places)
    if not d.many:
        exact = [e for e in base if e.stem == set(d.texts)]
        base = exact or base
        if len(base) > 1 and talk.place in {e.id for e in base} and (d.definite or generic):
            return Found((str(talk.place),), corrected)
        if len(base) > 1:
            return ambiguous(d, ids_of(base), said)
    return Found(ids_of(base), corrected)


def _part_of(d: Description, outer: Found, scene: Scene, talk: Talk) -> Found | None:
    """ "The empty bay of the rack", in a library without slots: the first of its parts that nothing stands on."""
    whole = outer.ids[0] if len(outer.ids) == 1 and not scene.single_types else ""
    parts = [p.id for p in scene.map.inside(whole)] if whole and whole not in {ANYWHERE, ORIGIN} else []
    taken = {p for p in talk.where.values() if p is not None}
    fits = [i for i in parts if not scene.map.inside(i) and all(scene.fits(scene[i], w) for w in d.texts)]
    free = [i for i in fits or parts if i not in taken]
    return Found(tuple(free[:1])) if free else None


WHEREABOUTS = frozenset({
    "left", "right", "front", "back", "rear", "middle", "centre", "center", "top", "bottom", "upper", "lower", "inner",
    "outer", "near", "far", "side", "end", "morning", "noon", "evening", "night",
})  # fmt: skip
"""Words that tell one place from another of its kind, or a time, and name none by themselves."""


def _vacant(d: Description, base: Sequence[Entity], said: str, scene: Scene, talk: Talk) -> Found | Fault:
    """ "A free niche", where only some of the places are niches: any of what holds them, or the one that is free."""
    above = {next(iter(scene.map.containers(e.id)), "") for e in base}
    whole = above.pop() if len(above) == 1 else ""
    if whole and {p.id for p in scene.map.inside(whole)} == set(ids_of(base)) and scene.single(base[0].id):
        return Found((whole,), vague=True)
    taken = {p for p in talk.where.values() if p is not None}
    free = [e for e in base if e.id not in taken]
    return Found((free[0].id,)) if len(free) == 1 else ambiguous(d, ids_of(free or base), said)


def _counted(d: Description, pool: Sequence[Entity], scene: Scene) -> Found | None:
    """ "Position 2 on level 1" where the positions there are numbered 11 to 14: the second."""
    if pool is scene.places or len(d.numbers) != 1 or d.ranges or not d.texts:
        return None
    row = sorted((e for e in pool if e.number and all(scene.fits(e, w) for w in d.texts)), key=lambda e: natural(e.id))
    number = d.numbers[0]
    small = number.isascii() and number.isdigit() and 0 < int(number) <= len(row) < 10
    alike = len({e.stem for e in row}) == 1 and all(len(str(e.number)) > 1 for e in row)
    return Found((row[int(number) - 1].id,)) if small and alike else None


USERS = frozenset({"user", "operator", "owner"})
"""The person who speaks, where the map has several, by the id."""


def _pointed(d: Description, said: str, scene: Scene, talk: Talk) -> Found | Fault:
    """ "there", and "me" or "her" where the map has a person."""
    if d.pronoun in {"me", "him"}:
        people = ids_of(scene.persons)
        if talk.place in people and d.pronoun == "him":
            return Found((str(talk.place),))
        users = tuple(e.id for e in scene.persons if e.stem & USERS)
        if d.pronoun == "me" and len(users) == 1:
            return Found(users)
        if len(people) == 1:
            return Found(people)
        return ambiguous(d, people, said) if people else unknown(d, scene, False, said)
    if talk.place is not None:
        return Found((talk.place,))
    if len(talk.around) == 1:  # "since the desk is empty, put the apple there"
        return Found(talk.around)
    return Fault("E305", f"`{said}` points to no place named before", d.extent, "where?", "name the place")


def _old(d: Description, scene: Scene, talk: Talk) -> Found:
    """ "Its old slot": where it stood, or, said of what never stood elsewhere, where the thing before it did."""
    moved = any(i in talk.handled for i in talk.targets)
    other = talk.vacated is not None and scene.single(talk.vacated) and talk.taken not in talk.targets
    if not (other and d.texts and talk.targets) or moved or talk.vacated is None:
        return Found((ORIGIN,))
    fits = all(scene.fits(scene[talk.vacated], w) for w in d.texts)
    return Found((talk.vacated,) if fits else (ORIGIN,))


def _same(d: Description, said: str, scene: Scene, talk: Talk) -> Found | Fault:
    """ "the same level": the last place, or its container that the noun fits."""
    if talk.place is None:
        return Fault("E305", f"`{said}` points to no place named before", d.extent, "where?", "name the place")
    around = (talk.place, *scene.map.containers(talk.place))
    fitting = [p for p in around if all(scene.fits(scene[p], w) for w in d.texts)]
    return Found(tuple(fitting[:1])) if fitting else unknown(d, scene, False, said)


_ALPHABET = "abcdefghijklmnopqrstuvwxyz"


def _in_line(base: Sequence[Entity], scene: Scene) -> tuple[str, ...]:
    """Places that have no numbers in the order of the map, where they lie so along one line; none else."""
    ids = {e.id for e in base}
    places = [p for p in scene.map.places if p.id in ids]
    at = [p.surface_m for p in places if p.surface_m is not None]
    if len(at) < max(2, len(base)) or any(e.number is not None for e in base):
        return ()
    steps = [(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(at)]
    straight = any(all(s[k] * steps[0][k] > 0 and abs(s[1 - k]) < abs(s[k]) for s in steps) for k in (0, 1))
    return tuple(p.id for p in places) if straight else ()


def _ranked(
    d: Description, base: list[Entity], scene: Scene, said: str, corrected: tuple[str, ...], *, inside: bool
) -> Found | Fault:
    """ "The top level", by how high it lies; "the second level", "the last position on level 1": by number, where the
    numbers run from 1, the rank is an end, or the places are those `inside` one that is named."""
    pick: Mapping[str, Callable[[int], int | None]] = {
        "top": lambda n: n - 1,
        "last": lambda n: n - 1 if inside else None,
        "bottom": lambda _: 0,
        "middle": lambda n: n // 2 if n % 2 else None,
    }
    lined = _in_line(base, scene) if inside and (d.rank == "last" or (d.ordinal is not None and not d.rank)) else ()
    if lined and (d.ordinal or 1) <= len(lined):
        return Found((lined[-1 if d.rank else (d.ordinal or 1) - 1],), corrected)
    row = sorted((e for e in base if e.number is not None), key=lambda e: natural(e.id))
    alike = len({e.stem for e in row}) == 1
    letters = sorted((w, e.id) for e in base for w in e.stem if len(w) == 1 and w.isalpha())
    lettered = [e for _, e in letters]  # racks A and B
    if not row and len(lettered) == len(base) > 1 and "".join(w for w, _ in letters) in _ALPHABET:
        at = d.ordinal - 1 if d.ordinal is not None and not d.rank else None
        return (
            Found((lettered[at],), corrected)
            if at is not None and at < len(lettered)
            else ambiguous(d, ids_of(base), said)
        )
    if alike and inside and d.count and (d.ordinal == 1 or d.rank == "last") and d.count <= len(row):
        some = row[: d.count] if d.ordinal == 1 else row[-d.count :]  # "the first two positions of level 2"
        return Found(ids_of(some), corrected)
    if alike and d.rank:
        at = pick[d.rank](len(row))
        ids = ids_of(row) if d.rank == "last" else scene.upwards(ids_of(row))
        if at is not None:
            return Found((ids[at],), corrected)
    if alike and d.ordinal is not None and (inside or [e.number for e in row] == [str(i + 1) for i in range(len(row))]):
        if d.ordinal <= len(row):
            return Found((row[d.ordinal - 1].id,), corrected)
        return Fault("E302", f"there is no `{said}`", d.extent, "", f"the map has {listed(ids_of(base))}", ids_of(base))
    return ambiguous(d, ids_of(base), said)
