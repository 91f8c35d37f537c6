"""Phrases that count: "two of the greens", "a few blocks", "the other one"."""

from __future__ import annotations

from collections.abc import Sequence

from llmbt_compiler.checking.referring.lists import AT, EXACTLY, LONGEST, POINTING, STANDING
from llmbt_compiler.checking.referring.model import Meant
from llmbt_compiler.checking.referring.nouns import all_of, noun, numbers, plural
from llmbt_compiler.checking.referring.standing import puts, standing_there, tells
from llmbt_compiler.checking.telling import hearsay
from llmbt_compiler.parsing.names import Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import rank_of
from llmbt_compiler.parsing.words import Token, lexicon, singulars

__all__ = ["one_there", "other", "several", "some_of"]

_VAGUE = frozenset(
    tuple(p.split())
    for p in (
        "a few", "some", "several", "a couple of", "a handful of", "most of", "half of", "half", "a bunch of",
        "many of", "as many", "as many of", "enough", "the agreed number of", "the usual number of", "one or two",
        "two or three", "a pair of", "part of", "a number of",
    )
)  # fmt: skip


def several(words: Sequence[Token], i: int, scene: Scene, where: dict[str, str | None]) -> Meant | None:
    """ "Two of the green blocks", "both yellow ones", "all three drinks"."""
    before = words[i - 1] if i else None
    if before is not None and (before.text in EXACTLY | {"any"} or _ranks(words, i) or numbers(before, scene)):
        return None
    j, exactly, count = i, False, None
    while j < len(words) and (words[j].text in EXACTLY or words[j].text in {"exactly", "just", "only", "any"}):
        exactly = exactly or words[j].text in EXACTLY
        count = 2 if words[j].text == "both" else count
        if words[j].text == "any":
            return None
        j += 1
    one = [t.text for t in words[j : j + 2]] == ["one", "of"]
    number = words[j].number if j < len(words) else None
    if number is not None and (words[j].text != "one" or one):
        count, j = int(number) if number.isdecimal() else None, j + 1
    if count is None or not int(not one) < count < 100:
        return None
    if j < len(words) and words[j].text == "of":
        exactly = False
    while j < len(words) and words[j].text in {"of", "the", "these", "those", "my", "other"}:
        if words[j].text == "other":
            return None
        j += 1
    j += int(one and j < len(words) and words[j].number is not None)  # "one of the two blocks on the shelf"
    stands = next((k for k in range(j, len(words)) if words[k].text not in STANDING), j)
    if exactly and stands < len(words) and words[stands].text in AT:  # "those two (that are) on the shelf"
        there, stop = standing_there(words, stands, [e.id for e in scene.objects], scene, where)
        return Meant(i, stop, there, count, exactly) if len(there) == count else None
    end = next((k + 1 for k in range(j, min(len(words), j + LONGEST)) if plural(words[k], scene)), 0)
    phrase = [t for k, t in enumerate(words[j:end], j) if t.text != "ones" and not hearsay(words, k, scene)]
    if not end or any(t.text in lexicon().sizes or t.text in lexicon().ordinals or not t.word for t in phrase):
        return None
    if not phrase or rank_of(words, j, end) is not None:
        return None
    found = all_of(phrase, scene, where)
    if not isinstance(found, Found) or found.corrected:
        return None
    ids, stop = standing_there(words, end, found.ids, scene, where)
    ids, stop = (ids, stop) if len(ids) >= count else (found.ids, end)  # it says where to
    in_line = [t.text for t in words[stop : stop + 3]] in (["in", "a", "row"], ["in", "a", "line"])
    if tells(words, stop, scene) and words[stop].text != "with" and not in_line:
        return None
    listed = len(phrase) == 1 and end < len(words) and not words[end].word
    if listed and scene.word(phrase[0], True).text in lexicon().anything:
        return None  # "three things: the bread, the milk and the apple"
    return Meant(i, stop, ids, count, exactly)


def _ranks(words: Sequence[Token], i: int) -> bool:
    """Whether a rank or a size stands right before: "the middle-sized (one of the three)"."""
    t = words[i - 1]
    ranked = t.text in lexicon().sizes or t.text in lexicon().ordinals or t.text in {"sized", "middle", "other"}
    return ranked or rank_of(words, i - 1, i) is not None


def some_of(words: Sequence[Token], i: int, scene: Scene, where: dict[str, str | None]) -> Meant | None:
    """ "A few of these blocks", "some of the greens", "a couple of drinks": which, and how many?"""
    said = [t.text for t in words[i : i + 4]]
    size = max((len(p) for p in _VAGUE if tuple(said[: len(p)]) == p), default=0)
    j = i + size
    while size and j < len(words) and words[j].text in {"of", "the", "these", "those", "my", "our", "more"}:
        j += 1
    end = next((k + 1 for k in range(j, min(len(words), j + 3)) if plural(words[k], scene)), 0) if size else 0
    phrase = [t for t in words[j:end] if t.text != "ones"]
    if not phrase or any(not t.word for t in phrase) or rank_of(words, j, end) is not None:
        return None
    found = resolve_objects((Token("all", phrase[0].start, phrase[0].start), *phrase), scene, Talk())
    if not isinstance(found, Found) or found.corrected:
        return None
    ids, stop = standing_there(words, end, found.ids, scene, where)
    if said[:2] == ["as", "many"] and not _agreed(words, stop):
        return None  # "as many as fit"
    return Meant(i, stop, ids, 0, vague=True)


def _agreed(words: Sequence[Token], at: int) -> bool:
    """ "... as we agreed", "as Tom wants": somebody else knows how many."""
    said = [t.text for t in words[at : at + 4]]
    return said[:1] == ["as"] and said[1:2] != ["possible"] and not set(said) & {"fit", "fits", "there", "can", "you"}


def one_there(
    words: Sequence[Token], i: int, scene: Scene, where: dict[str, str | None], group: Sequence[str] = ()
) -> Meant | None:
    """ "The one on level 1", "that one in the sorting area": what stands there, of those named before."""
    if words[i].text not in POINTING or [t.text for t in words[i + 1 : i + 2]] != ["one"]:
        return None
    ids, stop = standing_there(words, i + 2, [e.id for e in scene.objects], scene, where)
    if stop == i + 2 or puts(words, i) or tells(words, stop, scene):
        return None
    hues = {form for t in words[:i] for form in (t.text, *singulars(t.text))}
    named = {o for o in where if hues & set(scene[o].colour)} if not group else set(group)
    return Meant(i, stop, tuple(o for o in ids if o in named) or tuple(ids), stop=stop)


def other(words: Sequence[Token], i: int, single: set[str], scene: Scene) -> Meant | None:
    """ "The other green one", where one of them has been named before: what is left of them."""
    if words[i].text == "another":
        return _another(words, i, single, scene)
    if [t.text for t in words[i : i + 2]] != ["the", "other"] or i + 2 >= len(words):
        return None
    end = noun((*words[: i + 1], *words[i + 2 :]), i, scene)
    phrase = [t for t in words[i + 2 : end + 1] if t.text != "one"] if end else []
    if not phrase or any(t.text in lexicon().sizes or t.text in lexicon().ordinals for t in phrase):
        return None
    found = resolve_objects((Token("all", phrase[0].start, phrase[0].start), *phrase), scene, Talk())
    left = tuple(o for o in found.ids if o not in single) if isinstance(found, Found) else ()
    known = isinstance(found, Found) and single & set(found.ids)
    return Meant(i, end + 1, left) if known and left and not tells(words, end + 1, scene) else None


def _another(words: Sequence[Token], i: int, single: set[str], scene: Scene) -> Meant | None:
    """ "Another block": one more, of all that have not been named."""
    end = noun(words, i, scene)
    phrase = [t for t in words[i + 1 : end] if t.text != "one"] if end else []
    if not phrase or any(t.text in lexicon().sizes or t.text in lexicon().ordinals for t in phrase):
        return None
    found = resolve_objects((Token("all", phrase[0].start, phrase[0].start), *phrase), scene, Talk())
    left = tuple(o for o in found.ids if o not in single) if isinstance(found, Found) else ()
    return Meant(i, end, left) if left and not tells(words, end, scene) else None
