"""What a text names by ids and by names of their own."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import Token, lexicon, tokens

__all__ = ["Mention", "mentioned_in", "mentions_in", "names_in", "one_named"]

_LONGEST_NAME = 6
_MARKS = frozenset({",", ".", "?", "!", ";", ":", "(", ")", "-", "\u2013", "\u2014", "or", "and"})


def mentioned_in(text: str, scene: Scene) -> tuple[str, ...]:
    """Everything that a text names by an id or a name of its own."""
    objects, places, _ = names_in(tokens(text), scene)
    return (*objects, *places)


@dataclass(frozen=True, slots=True)
class Mention:
    """A thing that words[start:end] name."""

    start: int
    end: int
    id: str


def names_in(words: Sequence[Token], scene: Scene) -> tuple[list[str], list[str], str | None]:
    """The objects and the places that a text names by an id or a name of their own, and which come first."""
    found = list(dict.fromkeys(m.id for m in mentions_in(words, scene)))
    objects = [i for i in found if scene[i].movable]
    first = ("object" if scene[found[0]].movable else "place") if found else None
    return objects, [i for i in found if not scene[i].movable], first


def mentions_in(words: Sequence[Token], scene: Scene) -> tuple[Mention, ...]:
    """Where a text names things by an id or a name of their own, in order; "object 1, 2 or 4" names three."""
    found: list[Mention] = []
    i = 0
    while i < len(words):
        for length in range(min(_LONGEST_NAME, len(words) - i), 0, -1):
            hit = _named(words[i : i + length], scene)
            if hit is not None:
                found.append(Mention(i, i + length, hit))
                i += length
                break
        else:
            i += 1
    return tuple(sorted((*found, *_lists(words, scene, {(m.start, m.id) for m in found})), key=lambda m: m.start))


def _named(parts: Sequence[Token], scene: Scene) -> str | None:
    """The thing that just these words name: with a number, or by a name that nothing else has."""
    inner = [t for t in parts if t.text != "-"]
    if len(inner) > 1 and "-" not in {parts[0].text, parts[-1].text}:  # "the 8-dram vial", "bin G-M"
        whole = [e for pool in (scene.objects, scene.places) for e in pool if _spelt(inner) in e.keys]
        if len(whole) == 1 and (len(inner) < len(parts) or parts[0].number is not None):
            return whole[0].id
    if any(t.text in _MARKS for t in parts) or parts[0].number is not None:
        return None
    if lexicon().is_(parts[0].text, "articles", "at", "from", "all") or not any(t.word for t in parts):
        return None
    if _counts(parts, scene):
        return None
    spelt = _spelt(parts)
    for pool in (scene.objects, scene.places):
        hits = [e for e in pool if spelt in e.keys]
        if len(hits) == 1:
            return hits[0].id
    if parts[-1].number is None or any(lexicon().is_(t.text, "at", "from", "onto") for t in parts):
        return None
    ids = one_named(parts, scene)
    return ids[0] if len(ids) == 1 else None


def _counts(parts: Sequence[Token], scene: Scene) -> bool:
    """Whether "one" is no name's number: "only one", "the green one"."""
    every = (*scene.objects, *scene.places)
    return parts[-1].text == "one" and not any(t.text in e.stem for t in parts for e in every)


def _spelt(parts: Sequence[Token]) -> str:
    return " ".join(t.number if t.number is not None else t.text for t in parts)


def _lists(words: Sequence[Token], scene: Scene, known: set[tuple[int, str]]) -> Iterator[Mention]:
    """ "Object 1, 2 or 4", "level 1 or 2": the numbers after a noun that has one already."""
    for i, t in enumerate(words):
        if not t.word or t.number is not None or i + 1 >= len(words) or words[i + 1].number is None:
            continue
        if _counts(words[i : i + 2], scene):
            continue
        j = i + 1
        while j < len(words) and (words[j].text in {",", "or", "and"} or words[j].number is not None):
            if words[j].number is not None:
                noun = t if not t.text.endswith("s") else replace(t, text=t.text[:-1])
                for id_ in one_named((noun, words[j]), scene)[:1]:
                    if (i, id_) not in known:
                        yield Mention(j, j + 1, id_)
            j += 1


def one_named(parts: Sequence[Token], scene: Scene) -> tuple[str, ...]:
    for resolve in (resolve_objects, resolve_places):
        found = resolve(parts, scene, Talk()) if parts else None
        if isinstance(found, Found) and not {ANYWHERE, ORIGIN} & set(found.ids) and not found.corrected:
            return found.ids
    return ()
