"""Names held against the map: what a phrase may come to, why it may not, and what objects and places share."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from llmbt_compiler.parsing.model import Extent
from llmbt_compiler.parsing.phrase import Description
from llmbt_compiler.parsing.scene import Entity, Scene, compact, natural, squash
from llmbt_compiler.parsing.words import Token, lexicon, tokens

__all__ = [
    "ANYWHERE",
    "ORIGIN",
    "SHOWN",
    "Fault",
    "Found",
    "Talk",
    "ambiguous",
    "borrowed",
    "corrections",
    "exactly_named",
    "ids_of",
    "joined",
    "listed",
    "numbered",
    "says",
    "unknown",
]

ANYWHERE = "*"
"""Stands for "a free position" with no container named."""
ORIGIN = "<"
"""Stands for "its original place": where each target stood at the start."""
SHOWN = 6


@dataclass(frozen=True, slots=True)
class Talk:
    """What was said and done before a phrase: references and quantities are understood by it.

    `where` is where the objects stand after the steps so far; `handled` have a goal or are in the hand; `pending` are
    picked up and not put down; `targets`, `described` and `place` belong to the last phrases, in this step or the one
    before; `lost`: the last target could not be resolved, so that "it" means nothing; `mentioned` are objects that the
    step names on the side ("after picking up the coke, bring it ..."), `around` such places; `vacated` is where the
    thing taken last stood; `listed` are several things that were named together not long ago; `whole`: the last targets
    were named as one ("everything"); `taken` is what was taken or moved last; `among` are the things from which a step
    says to choose ("of the two balls, ...").
    """

    where: Mapping[str, str | None] = field(default_factory=dict)
    handled: frozenset[str] = frozenset()
    pending: tuple[str, ...] = ()
    targets: tuple[str, ...] = ()
    described: tuple[str, ...] = ()
    place: str | None = None
    lost: bool = False
    mentioned: tuple[str, ...] = ()
    around: tuple[str, ...] = ()
    vacated: str | None = None
    listed: tuple[str, ...] = ()
    whole: bool = False
    taken: str | None = None
    among: tuple[str, ...] = ()


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


def ids_of(entities: Iterable[Entity]) -> tuple[str, ...]:
    return tuple(sorted({e.id for e in entities}, key=natural))


def listed(ids: Sequence[str]) -> str:
    more = f" and {len(ids) - SHOWN} more" if len(ids) > SHOWN else ""
    return ", ".join(ids[:SHOWN]) + more


def says(parts: Sequence[Token]) -> str:
    first = next((i for i, t in enumerate(parts) if not lexicon().is_(t.text, "articles")), 0)
    return " ".join(t.text for t in parts[first:])[:80]


def exactly_named(parts: Sequence[Token], pool: Sequence[Entity]) -> tuple[Entity, ...]:
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


def unknown(d: Description, scene: Scene, movable: bool, said: str) -> Fault:
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
    ids = tuple(dict.fromkeys(e.id for e in hits)) if d.numbers else ids_of(hits)
    if not ids:
        keys = {k: e.id for e in pool for k in sorted(e.keys)}
        ids = tuple(dict.fromkeys(keys[k] for k in difflib.get_close_matches(said, sorted(keys), n=3, cutoff=0.6)))
    ids = ids[:SHOWN]
    everything = ids_of(pool)
    return Fault(
        "E301" if movable else "E302",
        f"the scene has no {kind} `{said}`",
        d.extent,
        "not in the map",
        f"did you mean {listed(ids)}?" if ids else f"the map has {listed(everything)}" if everything else "",
        ids,
    )


def ambiguous(d: Description, ids: Sequence[str], said: str, why: str = "") -> Fault:
    return Fault(
        "E304",
        f"`{said}` fits {len(ids)} things" if not why else f"`{said}`: {why}",
        d.extent,
        "which?",
        f"say which of {listed(ids)}",
        tuple(ids),
    )


def corrections(d: Description) -> tuple[str, ...]:
    return tuple(f"`{w.token.text}` is read as `{w.text}`" for w in d.words if w.corrected)


def numbered(
    d: Description, scene: Scene, movable: bool, said: str, pool: Sequence[Entity] | None = None
) -> tuple[Entity, ...] | Fault:
    """The things that the numbers name, each number exactly one; of `pool`, where one is given."""
    pool = scene.pool(movable) if pool is None else pool
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
            return unknown(d, scene, movable, said)
        if len(hits) > 1:
            return ambiguous(d, ids_of(hits), said)
        found.append(hits[0])
    for first, last in d.ranges:
        ends = [next((e for e in fitting if e.number == n), None) for n in (first, last)]
        if ends[0] is None or ends[1] is None:
            return unknown(replace(d, numbers=(first if ends[0] is None else last,)), scene, movable, said)
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


def joined(found: Sequence[Found]) -> Found:
    return Found(
        tuple(dict.fromkeys(i for f in found for i in f.ids)),
        tuple(c for f in found for c in f.corrected),
        tuple(c for f in found for c in f.chosen),
        tuple(w for f in found for w in f.words),
        any(f.vague for f in found),
    )


def borrowed(descriptions: Sequence[Description], colours: frozenset[str]) -> list[Description]:
    """ "Red and yellow blocks": an adjective alone takes the noun's number; "the red and the blue cup", "the small and
    large saline bottles": and the noun, of a size with all that tells what it is a size of."""
    out = list(descriptions)
    sizes = lexicon().sizes.keys()
    for i in range(len(out) - 2, -1, -1):
        d, then = out[i], out[i + 1]
        own = {w.text for w in d.words}
        alone = own <= colours | sizes and then.head and not (d.anaphoric or d.pronoun or d.numbers)
        if alone and (d.size or own & sizes):
            out[i] = replace(d, words=(*d.words, *(w for w in then.words if w.text not in sizes | colours)), head=True)
        elif not d.head and not d.pronoun and then.plural and d.words and d.count is None:
            out[i] = replace(d, plural=True)
        elif alone and d.definite and d.words and not then.plural:
            out[i] = replace(d, words=(*d.words, *[w for w in then.words if w.text not in own][-1:]), head=True)
    return out
