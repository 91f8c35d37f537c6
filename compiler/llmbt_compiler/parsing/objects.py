"""Objects held against the map: which a phrase means. Never a guess between two equals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from llmbt_compiler.parsing.model import Extent
from llmbt_compiler.parsing.names import (
    SHOWN,
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
from llmbt_compiler.parsing.phrase import Description, conjuncts, describe, split_exception, split_place
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Entity, Scene, natural
from llmbt_compiler.parsing.words import Token, lexicon, singulars

__all__ = ["resolve_objects"]


def resolve_objects(
    parts: Sequence[Token], scene: Scene, talk: Talk, *, at: tuple[str, ...] = (), picking: bool = False
) -> Found | Fault:
    """The objects that a phrase means. `at`: only those on these places; `picking`: it is to be picked up.

    Faults: E301 unknown, E304 fits several, E307 contradicts the map.
    """
    exact = exactly_named(parts, scene.objects)
    if len(exact) == 1:
        return Found((exact[0].id,), words=())
    parts = _content(_standing_at(parts), scene)
    sorted_out = _of_each(parts, scene, talk, at)
    if sorted_out is not None:
        return sorted_out
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
    descriptions = borrowed([describe(g, scene, True) for g in groups], scene.colours)
    if (
        len(groups) < 3
        and descriptions[0].both
        and descriptions[0].words
        and not any(d.plural or d.count for d in descriptions)
    ):
        descriptions[0] = replace(descriptions[0], both=False)  # "both the blue cube and the blue cylinder"
    found: list[Found] = []
    for d, group in zip(descriptions, groups, strict=True):
        exact = exactly_named(group, scene.objects)
        one = Found((exact[0].id,)) if len(exact) == 1 else _objects(d, says(group), scene, talk, at, picking)
        if isinstance(one, Fault):
            return one
        found.append(one)
    return joined(found)


def _of_each(parts: Sequence[Token], scene: Scene, talk: Talk, at: tuple[str, ...]) -> Found | None:
    """ "One block of each colour": of every colour, or shape, the lowest that nothing was done with."""
    said = [t.text for t in parts]
    i = next((i for i, w in enumerate(said[:-1]) if w in {"each", "every"} and said[i + 1] in _KINDS), 0)
    whole = i + 2 == len(said) and said[i - 1] in {"of", "in", "from", "for"} and said[0] in {"one", "a", "an"}
    if not i or not whole:
        return None
    pool = resolve_objects((replace(parts[0], text="all", number=None), *parts[1 : i - 1]), scene, talk, at=at)
    ids = pool.ids if isinstance(pool, Found) else tuple(e.id for e in scene.objects) if i == 2 else ()
    chosen: dict[frozenset[str], str] = {}
    for id_ in sorted(ids, key=natural):
        kind = scene[id_].colour if said[i + 1] in _COLOURS else _words_of_shape(scene, id_)
        if id_ not in talk.handled and kind:
            chosen.setdefault(kind, id_)
    if len(chosen) < 2:
        return None
    return Found(tuple(chosen.values()), chosen=(f"`{says(parts)}`: {', '.join(chosen.values())}",))


_COLOURS = frozenset({"colour", "color"})
_KINDS = _COLOURS | {"shape"}


def _words_of_shape(scene: Scene, id_: str) -> frozenset[str]:
    shape = next((o.shape for o in scene.map.objects if o.id == id_), "")
    return frozenset({shape}) - {""}


_STANDS = frozenset({"is", "are", "stands", "stand", "sits", "sit", "lies", "lie", "rests", "rest", "was", "were"})
_BESIDES = frozenset(
    {"currently", "now", "standing", "sitting", "lying", "resting", "located", "placed", "still", "already"}
)


def _standing_at(parts: Sequence[Token]) -> Sequence[Token]:
    """ "The block that is currently on position 22", "... that occupies position 22": the block on position 22."""
    if parts and parts[0].text == "whatever":  # "whatever you find on the table"
        at = next((i for i, t in enumerate(parts[:6]) if lexicon().is_(t.text, "at", "from")), 1)
        parts = (parts[0], *parts[at:])
    for i, t in enumerate(parts):
        j = i + 1 if t.text in {"that", "which"} and i else i
        while j > i and j < len(parts) - 1 and parts[j].text in _BESIDES:
            j += 1
        if i and j < len(parts) and parts[j].text in {"occupies", "occupying", "occupy"}:
            return (*parts[:i], Token("on", t.start, parts[j].end), *parts[j + 1 :])
        bare = i and t.text in {"left", "remaining"} and i < len(parts) - 2  # "everything left in the tray"
        if bare and lexicon().is_(parts[i + 1].text, "at", "from"):
            return (*parts[:i], *parts[i + 1 :])
        if j == i or j >= len(parts) or parts[j].text not in _STANDS:
            continue
        j += 1
        while j < len(parts) and parts[j].text in _BESIDES:
            j += 1
        if j < len(parts) - 1 and lexicon().is_(parts[j].text, "at", "from"):
            return (*parts[:i], *parts[j:])
    return parts


def _content(parts: Sequence[Token], scene: Scene) -> Sequence[Token]:
    """ "Carton of milk" is the milk, where the map knows no carton; "the set of green blocks" is these blocks."""
    lex = lexicon()
    for i, t in enumerate(parts[:-2]):
        if t.text in {"contents", "content", "load", "occupant", "occupants"} and parts[i + 1].text == "of":
            return (replace(t, text="everything"), replace(parts[i + 1], text="on"), *parts[i + 2 :])
    for i, t in enumerate(parts[:-1]):
        if t.owner and parts[i + 1].text in {"content", "contents"} and i + 2 == len(parts):
            whole, at = replace(parts[0], text="everything", owner=False), replace(parts[0], text="on", owner=False)
            return (whole, at, *parts[:i], replace(t, owner=False))  # "the pallet's contents"
        if t.text in {"content", "contents"} and parts[i + 1].text == "of" and i + 2 < len(parts):
            whole, at = replace(t, text="everything", start=parts[0].start), replace(parts[i + 1], text="on")
            return (whole, at, *parts[i + 2 :])  # "the whole contents of the tray"
        if t.text in lex.collectives and parts[i + 1].text == "of" and i + 2 < len(parts):
            return (*parts[:i], *parts[i + 2 :])
        vessel = i and t.text == "of" and lex.is_(next(singulars(parts[i - 1].text)), "vessels")
        if vessel and not _vessel_of(parts[i - 1], parts[i + 1 :], scene):
            return (*(p for p in parts[: i - 1] if lex.is_(p.text, "articles")), *parts[i + 1 :])
    return parts


def _vessel_of(vessel: Token, content: Sequence[Token], scene: Scene) -> bool:
    """Whether the map has such a vessel: the "bottle of water" is the water bottle, the "bottle of gel" the gel."""
    kind = next(singulars(vessel.text))
    if kind not in scene.vocabulary(True):
        return False
    said = {w for t in content if t.word and (w := scene.word(t, True).text)}
    plain = any(all(scene.fits(e, w) for w in said) for e in scene.objects) if said else False
    return not plain or any(kind in e.words and all(scene.fits(e, w) for w in said) for e in scene.objects)


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
    whole = resolve_objects(head, scene, talk, at=at, picking=picking) if head else Found(ids_of(scene.objects))
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
            said = says(group)
            ids = whole.ids[:SHOWN]
            return Fault("E304", f"what `{said}` leaves out is not clear", extent, "which?", "name the objects", ids)
        out += found.ids
    ids = tuple(i for i in whole.ids if i not in out)
    if not ids or not out:
        return Fault(
            "E304", f"`{says((*head, *exception))}` leaves nothing clear", extent, "which?", "name the objects"
        )
    return Found(ids, whole.corrected, whole.chosen, whole.words)


def _objects(d: Description, said: str, scene: Scene, talk: Talk, at: tuple[str, ...], picking: bool) -> Found | Fault:
    if d.pronoun == "one":
        return _one_of(d, said, talk)
    if d.pronoun in {"former", "latter"}:
        known = talk.targets or talk.pending
        known = talk.listed if len(known) != 2 and len(talk.listed) == 2 else known
        one = known[:1] if d.pronoun == "former" else known[1:]
        if d.pronoun == "latter" and len(talk.pending) == 1:  # the former has been put down
            return Found(talk.pending)
        return Found(one) if len(known) == 2 else ambiguous(d, known, said, "of which two?")
    if d.pronoun in {"there", "me"}:
        return unknown(d, scene, True, said)
    if d.pronoun or (d.same and not d.numbers):
        return _referred(d, said, talk)
    if d.ordinal and d.anaphoric and not d.texts and len(talk.listed) >= max(d.ordinal, 2):
        return Found((talk.listed[d.ordinal - 1],))  # "grab object 1 and object 2; put the first one ..."
    if d.unknown:
        return unknown(d, scene, True, said)
    corrected = corrections(d)
    if d.numbers or d.ranges:
        hits = numbered(d, scene, True, said)
        return hits if isinstance(hits, Fault) else Found(tuple(e.id for e in hits), corrected, words=d.texts)
    base = [e for e in scene.objects if all(scene.fits(e, w) for w in d.texts)]
    if at:
        base = [e for e in base if any(scene.within(talk.where.get(e.id), p) for p in at)]
        if not base:
            return Fault(
                "E301",
                f"there is no `{said}` on {listed(at)}",
                d.extent,
                "not there",
                _standing(scene, talk, at),
            )
    if talk.among and (d.anaphoric or d.size or d.ordinal or d.count):
        base = [e for e in base if e.id in talk.among] or base
    if not base:
        return unknown(d, scene, True, said)
    if d.anaphoric and d.size and not talk.among and (talk.described or len(talk.targets) == 1):
        kind = set(talk.described) or scene[talk.targets[0]].words - scene.colours
        kind = {w for w in kind if lexicon().alike(w).isdisjoint(lexicon().sizes)}
        base = [
            e for e in base if all(scene.fits(e, w) for w in kind)
        ] or base  # "the bigger cube ..., the smaller one"
    elif d.anaphoric and set(d.texts) <= scene.colours:  # "the red cup on the table, the blue one on the bar"
        said_before = set(talk.described) - scene.colours
        adjectives = scene.colours | lexicon().sizes.keys()
        kinds = [scene[i].words - adjectives for i in talk.targets] if not said_before else []
        alike = [e for e in base if any(kind <= e.words for kind in kinds)]
        alike += [e for e in base if said_before and all(scene.fits(e, w) for w in said_before)]
        base = alike or base
    if d.ordinal and d.bare and talk.described and not at:  # "two of the green blocks ..., the third ..."
        base = [e for e in base if all(scene.fits(e, w) for w in talk.described)] or base
    sized = _sized(d, base, said)
    if isinstance(sized, Fault):
        return sized
    chosen = _quantified(d, list(ids_of(sized)), said, scene, talk, picking)
    return chosen if isinstance(chosen, Fault) else replace(chosen, corrected=corrected, words=d.texts)


_MARGIN = 1.05


def _sized(d: Description, base: Sequence[Entity], said: str) -> Sequence[Entity] | Fault:
    """The largest, the smaller one, the two tallest of `base`; E304 where the sizes do not tell them apart."""
    if not d.size:
        return base
    size = lexicon().sizes[d.size]
    wanted = d.count or (2 if d.both else 1)
    order = sorted(base, key=lambda e: (-e.measure(size.measure) if size.most else e.measure(size.measure), e.id))
    if len(order) <= wanted:
        return order
    inner, outer = order[wanted - 1 : wanted + 1] if len(order) > wanted else (order[-1], order[-1])
    small, large = sorted((inner.measure(size.measure), outer.measure(size.measure)))
    if (size.pair and len(order) != 2) or (d.many and d.count is None) or small <= 0 or large < small * _MARGIN:
        return ambiguous(d, ids_of(base), said, "their sizes do not tell which")
    return order[:wanted]


def _standing(scene: Scene, talk: Talk, at: tuple[str, ...]) -> str:
    on = [o for o, p in talk.where.items() if any(scene.within(p, a) for a in at)]
    return f"on {listed(at)}: {listed(on) if on else 'nothing'}"


def _referred(d: Description, said: str, talk: Talk) -> Found | Fault:
    """What "it", "them" or "the same block" points to."""
    if talk.lost:
        return Fault("", "", d.extent)
    known = talk.targets or talk.pending or talk.mentioned
    if d.plural or d.both:
        known = talk.pending if len(talk.pending) > 1 else known
        if known and not (d.both and len(known) != 2):
            return Found(known)
        return Fault("E305", f"`{said}` points to nothing named before", d.extent, "what?", "name the objects")
    if len(talk.pending) == 1 and talk.pending[0] in known:
        return Found(talk.pending)
    if len(known) == 1 or (known and talk.whole and known == talk.targets):
        return Found(known)  # "take everything off the bar and put it on the table"
    if not known:
        return Fault("E305", f"`{said}` points to nothing named before", d.extent, "what?", "name the object")
    return ambiguous(d, known, said, "could be several things named before")


def _one_of(d: Description, said: str, talk: Talk) -> Found | Fault:
    """ "One" of those picked up or named just before: the lowest that is still in the hand, or that nothing was done
    with."""
    known = talk.pending or tuple(i for i in talk.targets if i not in talk.handled)
    if not known:
        return Fault("E304", f"`{said}` of which?", d.extent, "which?", "name the object", talk.targets)
    return Found(known[:1], chosen=(f"`{said}`: {known[0]} of {listed(known)}",))


def _quantified(d: Description, base: list[str], said: str, scene: Scene, talk: Talk, picking: bool) -> Found | Fault:
    """So many of `base` as the phrase says."""
    wanted = 2 if d.both else d.count
    if d.total is not None and not d.size and d.total != len(base):
        return _exactly(replace(d, count=d.total), base, d.total, said)
    if d.rest:
        left = [i for i in base if i in talk.pending]  # picked up together, and not put down yet
        base = left if left and d.bare else [i for i in base if i not in talk.handled]
        base = [i for i in base if i not in talk.targets or i in left] or base  # "leave the milk; the others ..."
        single = not d.many and wanted is None
        if talk.described and (len(base) > 1 if single else wanted is not None and len(base) != wanted):
            base = [i for i in base if all(scene.fits(scene[i], w) for w in talk.described)]
        if not base:
            return Fault("E301", f"`{said}`: nothing is left", d.extent, "all have been dealt with")
        return _exactly(d, base, 1 if single else wanted, said)
    if wanted is not None and wanted > 1:
        if len(base) > wanted and (not d.definite or d.partitive) and not d.both:
            return _some(base, wanted, said, talk)
        if len(base) > wanted and set(talk.targets) <= set(base) and len(talk.targets) == wanted:
            return Found(talk.targets)
        return _exactly(d, base, wanted, said)
    if d.count == 1 and d.plural and not d.all and len(base) > 1:  # "one of the yellow blocks"
        return _some(base, 1, said, talk)
    if d.indefinite and d.definite and d.plural and len(base) > 1:  # "some of the green blocks"
        return ambiguous(d, base, said)
    colour_alone = bool(d.words) and not (d.head or d.definite or d.indefinite or d.count or d.ordinal)
    if d.all or d.plural or (colour_alone and set(d.texts) <= scene.colours):  # "red on level 3"
        return Found(tuple(base))
    if len(base) == 1:
        return Found(tuple(base))
    if d.ordinal is not None and d.ordinal > len(base):
        return _exactly(d, base, d.ordinal, said)
    left = [i for i in base if i not in talk.handled]
    if d.ordinal is not None and d.ordinal > 1 and len(left) == 1 and len(base) == d.ordinal:
        return Found(tuple(left))  # "a yellow block ..., the second yellow block"
    if d.ordinal is not None:
        return ambiguous(d, base, said, "the map does not say in which order they count")
    if d.indefinite or d.count == 1:
        return _some(base, 1, said, talk)
    held = [i for i in talk.pending if i in base]
    if len(held) == 1 and not picking:
        return Found(tuple(held))
    if (
        len(talk.targets) == 1
        and talk.targets[0] in base
        and (d.pointing or not (picking and talk.targets[0] in talk.handled))
    ):
        return Found(talk.targets)
    if talk.lost and not d.words:
        return Fault("", "", d.extent)
    return ambiguous(d, base, said)


def _exactly(d: Description, base: list[str], wanted: int | None, said: str) -> Found | Fault:
    if wanted is None or len(base) == wanted:
        return Found(tuple(base))
    if len(base) > wanted:
        return ambiguous(d, base, said)
    return Fault(
        "E301",
        f"`{said}`: only {len(base)} of them",
        d.extent,
        "too few",
        f"the map has {listed(base)}",
        tuple(base),
    )


def _some(base: list[str], wanted: int, said: str, talk: Talk) -> Found:
    """The first by id of those that nothing has been done with yet."""
    order = [i for i in base if i not in talk.handled] + [i for i in base if i in talk.handled]
    ids = tuple(order[:wanted])
    return Found(ids, chosen=(f"`{said}`: {', '.join(ids)} of {listed(base)}",))
