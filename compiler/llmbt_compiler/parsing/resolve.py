"""Names held against the map: which objects, which places a phrase means. Never a guess
between two equals.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from llmbt_compiler.parsing.model import Extent
from llmbt_compiler.parsing.phrase import Description, conjuncts, describe, split_exception, split_place
from llmbt_compiler.parsing.scene import Entity, Scene, compact, natural, squash
from llmbt_compiler.parsing.words import Token, lexicon, tokens

__all__ = ["ANYWHERE", "ORIGIN", "Fault", "Found", "Talk", "resolve_objects", "resolve_places"]

ANYWHERE = "*"
"""Stands for "a free position" with no container named."""
ORIGIN = "<"
"""Stands for "its original place": where each target stood at the start."""
_SHOWN = 6


@dataclass(frozen=True, slots=True)
class Talk:
    """What was said and done before a phrase: references and quantities are understood by it.

    `where` is where the objects stand after the steps so far; `handled` have a goal or are in the hand;
    `pending` are picked up and not put down; `targets`, `described` and `place` belong to the last phrases,
    in this step or the one before; `lost`: the last target could not be resolved, so that "it" means nothing.
    """

    where: Mapping[str, str | None] = field(default_factory=dict)
    handled: frozenset[str] = frozenset()
    pending: tuple[str, ...] = ()
    targets: tuple[str, ...] = ()
    described: tuple[str, ...] = ()
    place: str | None = None
    lost: bool = False


@dataclass(frozen=True, slots=True)
class Found:
    """The ids, in the order of the words; what was corrected or chosen on the way; the words that described
    them.
    """

    ids: tuple[str, ...]
    corrected: tuple[str, ...] = ()
    chosen: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    vague: bool = False


@dataclass(frozen=True, slots=True)
class Fault:
    """Why a phrase names nothing, or too much. An empty `code`: the reason has been told already."""

    code: str
    title: str
    extent: Extent
    label: str = ""
    help: str = ""
    candidates: tuple[str, ...] = ()


def _ids(entities: Iterable[Entity]) -> tuple[str, ...]:
    return tuple(sorted({e.id for e in entities}, key=natural))


def _listed(ids: Sequence[str]) -> str:
    more = f" and {len(ids) - _SHOWN} more" if len(ids) > _SHOWN else ""
    return ", ".join(ids[:_SHOWN]) + more


def _says(parts: Sequence[Token]) -> str:
    kept = [t.text for t in parts if not lexicon().is_(t.text, "articles")] or [t.text for t in parts]
    return " ".join(kept)[:80]


def _exact(parts: Sequence[Token], pool: Sequence[Entity]) -> tuple[Entity, ...]:
    """The things whose id, or else whose name, the whole phrase spells."""
    plain = [t for t in parts if not lexicon().is_(t.text, "articles")]
    keys = {squash(parts), squash(plain)} - {""}
    ids = {e.id: squash(tokens(e.id)) for e in pool}
    glued = {compact(k) for k in keys}
    return (
        tuple(e for e in pool if ids[e.id] in keys)
        or tuple(e for e in pool if not e.keys.isdisjoint(keys))
        or tuple(e for e in pool if compact(ids[e.id]) in glued)
    )


def _closeness(number: str, entity: Entity) -> int:
    a, b = number, entity.number or ""
    if a.isascii() and a.isdigit() and b.isascii() and b.isdigit() and max(len(a), len(b)) < 10:
        return abs(int(a) - int(b))
    return 10**9


def _unknown(d: Description, scene: Scene, movable: bool, said: str) -> Fault:
    """E301 or E302 with what comes nearest: the same words with other numbers, colours or kinds, or a like
    spelling.
    """
    kind = "object" if movable else "place"
    pool = scene.pool(movable)
    hits = [e for w in d.words for n in w.near for e in pool if scene.fits(e, n)]
    if not hits and d.texts:
        hits = [e for e in pool if all(scene.fits(e, w) for w in d.texts)]
        if d.numbers:
            hits.sort(key=lambda e: (_closeness(d.numbers[-1], e), natural(e.id)))
    ids = tuple(dict.fromkeys(e.id for e in hits)) if d.numbers else _ids(hits)
    if not ids:
        keys = {k: e.id for e in pool for k in sorted(e.keys)}
        ids = tuple(dict.fromkeys(keys[k] for k in difflib.get_close_matches(said, sorted(keys), n=3, cutoff=0.6)))
    ids = ids[:_SHOWN]
    everything = _ids(pool)
    return Fault(
        "E301" if movable else "E302",
        f"the scene has no {kind} `{said}`",
        d.extent,
        "not in the map",
        f"did you mean {_listed(ids)}?" if ids else f"the map has {_listed(everything)}" if everything else "",
        ids,
    )


def _ambiguous(d: Description, ids: Sequence[str], said: str, why: str = "") -> Fault:
    return Fault(
        "E304",
        f"`{said}` fits {len(ids)} things" if not why else f"`{said}`: {why}",
        d.extent,
        "which?",
        f"say which of {_listed(ids)}",
        tuple(ids),
    )


def _corrections(d: Description) -> tuple[str, ...]:
    return tuple(f"`{w.token.text}` is read as `{w.text}`" for w in d.words if w.corrected)


def _numbered(d: Description, scene: Scene, movable: bool, said: str) -> tuple[Entity, ...] | Fault:
    """The things that the numbers name, each number exactly one."""
    pool = scene.pool(movable)
    fitting = [e for e in pool if all(scene.fits(e, w) for w in d.texts)]
    if d.initial:
        fitting = [e for e in fitting if d.initial in e.initials]
    found: list[Entity] = []
    for number in d.numbers:
        hits = [e for e in fitting if e.number == number]
        literal = [e for e in hits if set(d.texts) <= e.words]
        hits = literal or hits
        exact = [e for e in hits if e.stem == set(d.texts)]
        hits = exact if len(hits) > 1 and exact else hits
        if not hits:
            others = [e for e in pool if e.number == number]
            if movable and len(others) == 1 and not d.initial:
                return _contradiction(d, others[0], said)
            return _unknown(d, scene, movable, said)
        if len(hits) > 1:
            return _ambiguous(d, _ids(hits), said)
        found.append(hits[0])
    for first, last in d.ranges:
        ends = [next((e for e in fitting if e.number == n), None) for n in (first, last)]
        if ends[0] is None or ends[1] is None:
            return _unknown(replace(d, numbers=(first if ends[0] is None else last,)), scene, movable, said)
        span = sorted(natural(e.id) for e in ends if e is not None)
        inside = (e for e in fitting if e.stem == ends[0].stem and span[0] <= natural(e.id) <= span[1])
        found.extend(sorted(inside, key=lambda e: natural(e.id)))
    return tuple(dict.fromkeys(found))


def _contradiction(d: Description, entity: Entity, said: str) -> Fault:
    return Fault(
        "E307",
        f"`{said}` contradicts the map",
        d.extent,
        f"{entity.id} is described otherwise",
        f"the map has {entity.id}: {' '.join(sorted(entity.words))}",
        (entity.id,),
    )


# --- objects -------------------------------------------------------------------------------------------------------


def resolve_objects(
    parts: Sequence[Token], scene: Scene, talk: Talk, *, at: tuple[str, ...] = (), picking: bool = False
) -> Found | Fault:
    """The objects that a phrase means. `at`: only those on these places; `picking`: it is to be picked up.

    Faults: E301 unknown, E304 fits several, E307 contradicts the map.
    """
    exact = _exact(parts, scene.objects)
    if len(exact) == 1:
        return Found((exact[0].id,), words=())
    head, inner = split_place(parts) if split_exception(parts) is None else (tuple(parts), ())
    if inner:
        place = resolve_places(inner, scene, talk)
        if isinstance(place, Fault):
            return place
        at = at + place.ids
    parted = split_exception(head)
    if parted is not None:
        return _without(*parted, scene, talk, at, picking)
    groups = conjuncts(head)
    if not groups:
        return Fault("E305", "no object is named", Extent(parts[0].start, parts[-1].end), "what?")
    descriptions = _borrowed([describe(g, scene, True) for g in groups])
    found: list[Found] = []
    for d, group in zip(descriptions, groups, strict=True):
        exact = _exact(group, scene.objects)
        one = Found((exact[0].id,)) if len(exact) == 1 else _objects(d, _says(group), scene, talk, at, picking)
        if isinstance(one, Fault):
            return one
        found.append(one)
    return _joined(found)


def _without(
    head: Sequence[Token],
    exception: Sequence[Token],
    scene: Scene,
    talk: Talk,
    at: tuple[str, ...],
    picking: bool,
) -> Found | Fault:
    """ "all blocks that are not green", "everything except object 1": what the head means but the exception. One that
    is not plainly understood is E304, never ignored."""
    whole = resolve_objects(head, scene, talk, at=at, picking=picking) if head else Found(_ids(scene.objects))
    if isinstance(whole, Fault):
        return whole
    extent = Extent((*head, *exception)[0].start, (*head, *exception)[-1].end)
    out: list[str] = []
    for group in conjuncts(exception):
        d = describe(group, scene, True)
        adjective = bool(d.texts) and not d.unknown and set(d.texts) <= scene.colours and not (d.head or d.numbers)
        counted = d.count is not None or d.indefinite or all(t.word and t.number is not None for t in group)
        if adjective and not d.definite:
            out += [e.id for e in scene.objects if all(scene.fits(e, w) for w in d.texts)]
            continue
        found = None if counted else resolve_objects(group, scene, Talk(where=talk.where))
        if not isinstance(found, Found):
            said = _says(group)
            ids = whole.ids[:_SHOWN]
            return Fault("E304", f"what `{said}` leaves out is not clear", extent, "which?", "name the objects", ids)
        out += found.ids
    ids = tuple(i for i in whole.ids if i not in out)
    if not ids or not out:
        return Fault(
            "E304", f"`{_says((*head, *exception))}` leaves nothing clear", extent, "which?", "name the objects"
        )
    return Found(ids, whole.corrected, whole.chosen, whole.words)


def _joined(found: Sequence[Found]) -> Found:
    return Found(
        tuple(dict.fromkeys(i for f in found for i in f.ids)),
        tuple(c for f in found for c in f.corrected),
        tuple(c for f in found for c in f.chosen),
        tuple(w for f in found for w in f.words),
        any(f.vague for f in found),
    )


def _borrowed(descriptions: list[Description]) -> list[Description]:
    """ "red and yellow blocks": an adjective alone takes the noun's number."""
    out = list(descriptions)
    for i in range(len(out) - 2, -1, -1):
        if not out[i].head and not out[i].pronoun and out[i + 1].plural and out[i].words and out[i].count is None:
            out[i] = replace(out[i], plural=True)
    return out


def _objects(d: Description, said: str, scene: Scene, talk: Talk, at: tuple[str, ...], picking: bool) -> Found | Fault:
    if d.pronoun or (d.same and not d.numbers):
        return _referred(d, said, talk)
    if d.unknown:
        return _unknown(d, scene, True, said)
    corrected = _corrections(d)
    if d.numbers or d.ranges:
        hits = _numbered(d, scene, True, said)
        return hits if isinstance(hits, Fault) else Found(tuple(e.id for e in hits), corrected, words=d.texts)
    base = [e for e in scene.objects if all(scene.fits(e, w) for w in d.texts)]
    if at:
        base = [e for e in base if any(scene.within(talk.where.get(e.id), p) for p in at)]
        if not base:
            return Fault(
                "E301",
                f"there is no `{said}` on {_listed(at)}",
                d.extent,
                "not there",
                _standing(scene, talk, at),
            )
    if not base:
        return _unknown(d, scene, True, said)
    chosen = _quantified(d, list(_ids(base)), said, scene, talk, picking)
    return chosen if isinstance(chosen, Fault) else replace(chosen, corrected=corrected, words=d.texts)


def _standing(scene: Scene, talk: Talk, at: tuple[str, ...]) -> str:
    on = [o for o, p in talk.where.items() if any(scene.within(p, a) for a in at)]
    return f"on {_listed(at)}: {_listed(on) if on else 'nothing'}"


def _referred(d: Description, said: str, talk: Talk) -> Found | Fault:
    """What "it", "them" or "the same block" points to."""
    if talk.lost:
        return Fault("", "", d.extent)
    known = talk.targets or talk.pending
    if d.plural or d.both:
        known = talk.pending if len(talk.pending) > 1 else known
        if known and not (d.both and len(known) != 2):
            return Found(known)
        return Fault("E305", f"`{said}` points to nothing named before", d.extent, "what?", "name the objects")
    if len(talk.pending) == 1 and talk.pending[0] in known:
        return Found(talk.pending)
    if len(known) == 1:
        return Found(known)
    if not known:
        return Fault("E305", f"`{said}` points to nothing named before", d.extent, "what?", "name the object")
    return _ambiguous(d, known, said, "could be several things named before")


def _quantified(d: Description, base: list[str], said: str, scene: Scene, talk: Talk, picking: bool) -> Found | Fault:
    """So many of `base` as the phrase says."""
    wanted = 2 if d.both else d.count
    if d.rest:
        base = [i for i in base if i not in talk.handled]
        single = not d.many and wanted is None
        if talk.described and (len(base) > 1 if single else wanted is not None and len(base) != wanted):
            base = [i for i in base if all(scene.fits(scene[i], w) for w in talk.described)]
        if not base:
            return Fault("E301", f"`{said}`: nothing is left", d.extent, "all have been dealt with")
        return _exactly(d, base, 1 if single else wanted, said)
    if wanted is not None and wanted > 1:
        if len(base) > wanted and not d.definite and not d.both:
            return _some(base, wanted, said, talk)
        if len(base) > wanted and set(talk.targets) <= set(base) and len(talk.targets) == wanted:
            return Found(talk.targets)
        return _exactly(d, base, wanted, said)
    if d.count == 1 and d.plural and not d.all and len(base) > 1:  # "one of the yellow blocks"
        return _some(base, 1, said, talk)
    if d.indefinite and d.definite and d.plural and len(base) > 1:  # "some of the green blocks"
        return _ambiguous(d, base, said)
    if d.all or d.plural:
        return Found(tuple(base))
    if len(base) == 1:
        return Found(tuple(base))
    if d.ordinal is not None:
        return _ambiguous(d, base, said, "the map does not say in which order they count")
    if d.indefinite or d.count == 1:
        return _some(base, 1, said, talk)
    held = [i for i in talk.pending if i in base]
    if len(held) == 1 and not picking:
        return Found(tuple(held))
    if len(talk.targets) == 1 and talk.targets[0] in base and not (picking and talk.targets[0] in talk.handled):
        return Found(talk.targets)
    if talk.lost and not d.words:
        return Fault("", "", d.extent)
    return _ambiguous(d, base, said)


def _exactly(d: Description, base: list[str], wanted: int | None, said: str) -> Found | Fault:
    if wanted is None or len(base) == wanted:
        return Found(tuple(base))
    if len(base) > wanted:
        return _ambiguous(d, base, said)
    return Fault(
        "E301",
        f"`{said}`: only {len(base)} of them",
        d.extent,
        "too few",
        f"the map has {_listed(base)}",
        tuple(base),
    )


def _some(base: list[str], wanted: int, said: str, talk: Talk) -> Found:
    """The first by id of those that nothing has been done with yet."""
    order = [i for i in base if i not in talk.handled] + [i for i in base if i in talk.handled]
    ids = tuple(order[:wanted])
    return Found(ids, chosen=(f"`{said}`: {', '.join(ids)} of {_listed(base)}",))


# --- places --------------------------------------------------------------------------------------------------------


def resolve_places(parts: Sequence[Token], scene: Scene, talk: Talk) -> Found | Fault:
    """The places that a phrase means, containers as they are named; ANYWHERE and ORIGIN stand for themselves.

    Faults: E302 unknown, E304 fits several, E307 contradicts the map.
    """
    exact = _exact(parts, scene.places)
    if len(exact) == 1:
        return Found((exact[0].id,))
    extent = Extent(parts[0].start, parts[-1].end)
    head, inner = split_place(parts, "on", "in", "at", "of", "inside", "within", "from")
    if inner and not _quantifier_only(head):
        return _nested(head, inner, scene, talk)
    groups = conjuncts(parts)
    if not groups:
        return Fault("E305", "no place is named", extent, "where?")
    found: list[Found] = []
    for d, group in zip(_borrowed([describe(g, scene, False) for g in groups]), groups, strict=True):
        exact = _exact(group, scene.places)
        one = Found((exact[0].id,)) if len(exact) == 1 else _places(d, _says(group), scene, talk)
        if isinstance(one, Fault):
            return one
        found.append(one)
    return _joined(found)


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
    if not d.unknown and not d.numbers and not d.all and d.ordinal is None and (d.vacant or generic) and not d.rank:
        return replace(outer, vague=True)
    inside = tuple(e for e in scene.places if any(scene.within(e.id, c) for c in outer.ids) and e.id not in outer.ids)
    found = _places(d, _says(head), scene, talk, inside)
    if not isinstance(found, Fault):
        return replace(found, corrected=outer.corrected + found.corrected)
    elsewhere = resolve_places(head, scene, talk)
    if isinstance(elsewhere, Fault):
        return elsewhere
    if all(any(scene.within(c, e) for c in outer.ids) for e in elsewhere.ids):
        return outer
    at = ", ".join(f"{e} is on {next(iter(scene.map.containers(e)), 'no container')}" for e in elsewhere.ids)
    return Fault(
        "E307",
        f"`{_says(head)}` is not on {_listed(outer.ids)}",
        Extent(head[0].start, inner[-1].end),
        at,
        f"did you mean {_listed((*elsewhere.ids, *outer.ids))}?",
        (*elsewhere.ids, *outer.ids),
    )


def _places(
    d: Description, said: str, scene: Scene, talk: Talk, pool: tuple[Entity, ...] | None = None
) -> Found | Fault:
    if d.pronoun:
        return _pointed(d, said, scene, talk)
    if d.unknown:
        return _unknown(d, scene, False, said)
    if d.origin:
        return Found((ORIGIN,))
    if d.same:
        return _same(d, said, scene, talk)
    pool = scene.places if pool is None else pool
    corrected = _corrections(d)
    if d.numbers or d.ranges:
        hits = _numbered(d, scene, False, said)
        if isinstance(hits, Fault):
            return hits
        if not set(hits) <= set(pool):
            return _unknown(d, scene, False, said)
        return Found(tuple(e.id for e in hits), corrected)
    generic = all(w in scene.generic(False) for w in d.texts)
    if d.vacant and generic:
        return Found((ANYWHERE,), vague=True)
    base = [e for e in pool if all(scene.fits(e, w) for w in d.texts)]
    if not base or (d.bare and not d.rank):
        return _unknown(d, scene, False, said)
    named = [e for e in base if set(d.texts) <= e.stem | {e.type}]
    base = named or base
    if d.rank or d.ordinal is not None:
        return _ranked(d, base, said, corrected)
    if not d.many:
        exact = [e for e in base if e.stem == set(d.texts)]
        base = exact or base
        if len(base) > 1 and talk.place in {e.id for e in base} and (d.definite or generic):
            return Found((str(talk.place),), corrected)
        if len(base) > 1:
            return _ambiguous(d, _ids(base), said)
    return Found(_ids(base), corrected)


def _pointed(d: Description, said: str, scene: Scene, talk: Talk) -> Found | Fault:
    """ "there", and "me" where the map has a user."""
    if d.pronoun == "me":
        users = [e.id for e in scene.places if not e.words.isdisjoint(lexicon().function["users"])]
        if len(users) == 1:
            return Found(tuple(users))
        return _unknown(d, scene, False, said)
    if talk.place is not None:
        return Found((talk.place,))
    return Fault("E305", f"`{said}` points to no place named before", d.extent, "where?", "name the place")


def _same(d: Description, said: str, scene: Scene, talk: Talk) -> Found | Fault:
    """ "the same level": the last place, or its container that the noun fits."""
    if talk.place is None:
        return Fault("E305", f"`{said}` points to no place named before", d.extent, "where?", "name the place")
    around = (talk.place, *scene.map.containers(talk.place))
    fitting = [p for p in around if all(scene.fits(scene[p], w) for w in d.texts)]
    return Found(tuple(fitting[:1])) if fitting else _unknown(d, scene, False, said)


def _ranked(d: Description, base: list[Entity], said: str, corrected: tuple[str, ...]) -> Found | Fault:
    """ "the top level", "the second level": by number, where the numbers run from 1 or the rank is an end."""
    pick: Mapping[str, Callable[[int], int | None]] = {
        "top": lambda n: n - 1,
        "bottom": lambda _: 0,
        "middle": lambda n: n // 2 if n % 2 else None,
    }
    numbered = sorted((e for e in base if e.number is not None), key=lambda e: natural(e.id))
    alike = len({e.stem for e in numbered}) == 1
    if alike and d.rank:
        at = pick[d.rank](len(numbered))
        if at is not None:
            return Found((numbered[at].id,), corrected)
    if alike and d.ordinal is not None and [e.number for e in numbered] == [str(i + 1) for i in range(len(numbered))]:
        if d.ordinal <= len(numbered):
            return Found((numbered[d.ordinal - 1].id,), corrected)
        return Fault("E302", f"there is no `{said}`", d.extent, "", f"the map has {_listed(_ids(base))}", _ids(base))
    return _ambiguous(d, _ids(base), said)
