"""Things and places that a request names by a number, and nouns for things."""

from __future__ import annotations

from collections.abc import Sequence

from llmbt_compiler.parsing.names import Fault, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import Token

__all__ = ["is_noun", "named_by_number", "numbered"]


def numbered(words: Sequence[Token], i: int, scene: Scene) -> bool:
    """Whether "object 9" or "position 55" begins here: a word of ids, and a number that does not count something."""
    stems = frozenset[str]().union(*(e.stem for e in (*scene.objects, *scene.places) if e.number is not None))
    after = words[i + 1]
    counts = i + 2 < len(words) and is_noun(words, i + 2, scene)
    return words[i].text in stems and after.number is not None and after.text != "one" and not counts


def named_by_number(words: Sequence[Token], i: int, scene: Scene) -> Found | Fault:
    movable = any(words[i].text in e.stem for e in scene.objects)
    resolve = resolve_objects if movable else resolve_places
    return resolve(words[i : i + 2], scene, Talk())


def is_noun(words: Sequence[Token], i: int, scene: Scene) -> bool:
    if i >= len(words) or not words[i].word:
        return False
    known = scene.word(words[i], True).text
    return bool(known) and known not in scene.colours and scene.understood(known, True)
