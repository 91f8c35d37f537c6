"""Things told by how they compare with others: "a block larger than object 1", "the green one that is as big as the
red one", "smaller than object 3 but larger than object 5". What they compare with is never what is meant."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from llmbt_compiler.keywords.labels import Kind
from llmbt_compiler.parsing.model import Extent, LabelledStep
from llmbt_compiler.parsing.names import Fault, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.plainly import instead
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import Token, lexicon, tokens

__all__ = ["compared"]

_MARGIN = 1.05
"""Sizes nearer to each other than this are the same."""
_ADVERBS = frozenset(
    {"even", "still", "much", "slightly", "little", "bit", "noticeably", "clearly", "a", "somewhat", "far"}
)
_BEING = frozenset({"is", "are", "was", "were", "s"})
_RELATIVE = frozenset({"that", "which"})
_SAME = frozenset({"size", "height", "length"})
_ENDS = frozenset({
    ",", ".", ";", ":", "!", "?", "(", ")", "and", "but", "yet", "on", "onto", "to", "into", "in", "at", "from", "for",
    "is", "are", "goes", "go", "should", "must", "has", "needs", "belongs", "please", "off", "up", "over", "back",
    "then", "as",
})  # fmt: skip
_OTHERS = frozenset({"others", "other", "rest", "all", "any", "every", "each", "everything", "anything"})
_ASKING = frozenset({"is", "are", "was", "were", "does", "do", "did"})
_LONGEST = 7


@dataclass(frozen=True, slots=True)
class _Comparison:
    """The words `start` to `stop` of a line: how it compares by `measure` (more: 1, less: -1, the same: 0), and
    `marks`, what it compares with; `denied`: it is said not to."""

    start: int
    stop: int
    measure: str
    sign: int
    marks: tuple[Token, ...]
    denied: bool = False


def compared(step: LabelledStep, scene: Scene, talk: Talk) -> LabelledStep | Fault:
    """The step with the id of the thing in place of a description by a comparison; a fault where none or several fit
    it."""
    line = tokens(step.text)
    for i in range(1, len(line)):
        if not _begins(line, i):
            continue
        chain = [c for c in (_comparison(line, i),) if c is not None]
        while chain and chain[-1].stop + 1 < len(line) and line[chain[-1].stop].text in {"but", "yet", "and"}:
            after = next((k for k in range(chain[-1].stop + 1, chain[-1].stop + 5) if _begins(line, k)), None)
            more = _comparison(line, after) if after is not None else None
            if more is None:
                break
            chain.append(more)
        told = _headed(line, chain[0].start, scene) if chain else None
        if told is not None:
            start, head, attributive = told
            if attributive or head[0].text in {"one", "which"}:
                return _settled(step, line, start, head, chain, scene, talk)
    return step


def _begins(line: Sequence[Token], i: int) -> bool:
    """Whether "bigger than", "as big as" or "the same size as" begins at a token."""
    if i >= len(line):
        return False
    sizes, after = lexicon().sizes, [t.text for t in line[i + 1 : i + 3]]
    if line[i].text in sizes and line[i].text.endswith("er"):
        return after[:1] == ["than"]
    if line[i].text == "as":
        return len(after) == 2 and after[0] in sizes and after[1] == "as"
    return line[i].text == "same" and len(after) == 2 and after[0] in _SAME and after[1] == "as"


def _comparison(line: Sequence[Token], i: int) -> _Comparison | None:
    size = lexicon().sizes.get(line[i].text)
    first = i + 2 if size is not None else i + 3
    stop = next((k for k in range(first, len(line)) if line[k].text in _ENDS), len(line))
    both = stop - first == 1 and line[first].text in {"both", "either"}
    stop = min(stop, first + _LONGEST)
    if stop == first or both:
        return None
    start = i
    while start > 1 and (
        line[start - 1].text in _ADVERBS | {"the", "of"} and (size is None or line[start - 1].text in _ADVERBS)
    ):
        start -= 1
    denied = line[start - 1].text in {"no", "not", "isnt", "arent"}
    start -= denied
    measure = size.measure if size is not None else _measured(line[i + 1].text)
    sign = 0 if size is None else 1 if size.most else -1
    return _Comparison(start, stop, measure, sign, tuple(line[first:stop]), denied)


def _measured(word: str) -> str:
    size = lexicon().sizes.get(word)
    return size.measure if size is not None else word


def _headed(line: Sequence[Token], at: int, scene: Scene) -> tuple[int, tuple[Token, ...], bool] | None:
    """The noun phrase before a comparison: where it begins, its tokens, and whether the comparison tells which is meant
    (and does not say how it is)."""
    end = at
    linked = end > 0 and line[end - 1].text in _BEING
    end -= linked
    relative = end > 0 and line[end - 1].text in _RELATIVE
    end -= relative
    end -= end > 0 and relative and line[end - 1].text == ","
    lex = lexicon()
    start = end
    while start > 0 and end - start < _LONGEST:
        t = line[start - 1]
        noun = t.word and (scene.word(t, True).text or t.text in lex.sizes or t.text in {"one", "ones", "something"})
        small = (
            lex.is_(t.text, "articles", "all", "both", "indefinite", "definite")
            or t.number is not None
            or t.text == "of"
        )
        apart = t.text == "," and line[start].text in {"one", "ones"} and start == end - 1
        if not (noun or small or apart) or t.text in _ENDS - {","}:
            break
        start -= 1
    head = tuple(line[start:end])
    if (
        not head
        or not any(t.word for t in head)
        or (start == 0 and line[0].text in _ASKING)
        or (start and line[start - 1].text in _ASKING and not linked)
    ):
        return None
    return start, head, relative or not linked


def _settled(
    step: LabelledStep,
    line: Sequence[Token],
    start: int,
    head: tuple[Token, ...],
    chain: Sequence[_Comparison],
    scene: Scene,
    talk: Talk,
) -> LabelledStep | Fault:
    extent = Extent(line[start].start, line[chain[-1].stop - 1].end)
    words = extent.cut(step.text)
    pool, many = _pool(head, scene, talk)
    if isinstance(pool, Fault):
        return pool
    for c in chain:
        if c.denied:
            return Fault("E305", f"`{words}`: which is meant is not understood", extent, "which?", "name the thing")
        others = _marks(c, scene, talk, pool)
        if isinstance(others, Fault):
            return others
        marks, size = others
        extent = Extent(extent.start, c.marks[size - 1].end)
        holds = _HOLDS[c.sign]
        at = {i: scene[i].measure(c.measure) for i in (*pool, *marks)}
        pool = tuple(i for i in pool if i not in marks and all(holds(at[i], at[m]) for m in marks) and at[i] > 0)
    if not pool:
        return Fault("E301", f"the scene has no `{words}`", extent, "by their sizes")
    if len(pool) > 1 and not many:
        said = f"say which of {', '.join(pool)}"
        return Fault("E304", f"`{words}` fits {len(pool)} things", extent, "which?", said, pool)
    plain = " and ".join((",".join(pool[:-1]), pool[-1])) if len(pool) > 1 else pool[0]
    if len(plain) > extent.end - extent.start:
        return Fault("E304", f"`{words}` fits {len(pool)} things", extent, "which?", "name them", pool)
    return instead(step, extent, plain, Kind.TARGET)


_HOLDS: dict[int, Callable[[float, float], bool]] = {
    1: lambda a, b: a > b * _MARGIN,
    -1: lambda a, b: a * _MARGIN < b,
    0: lambda a, b: max(a, b) <= min(a, b) * _MARGIN,
}


def _pool(head: tuple[Token, ...], scene: Scene, talk: Talk) -> tuple[tuple[str, ...] | Fault, bool]:
    """All things that a noun phrase may mean, and whether it speaks of several."""
    lex = lexicon()
    many = any(t.text == "ones" or lex.is_(t.text, "all") or t.text in {"everything", "anything"} for t in head)
    many = many or (head[0].text != "one" and any(t.word and scene.word(t, True).plural for t in head))
    comma = next((i for i, t in enumerate(head) if t.text == ","), None)
    kept = head[:comma] if comma is not None else head
    bare = {"one", "ones", "something", "everything", "anything", "of", "which", "a", "an"}
    kept = tuple(t for t in kept if t.text not in bare and not lex.is_(t.text, "articles", "indefinite", "all"))
    if not kept:
        pool = tuple(e.id for e in scene.objects)
        described = tuple(e.id for e in scene.objects if all(scene.fits(e, w) for w in talk.described))
        return described or pool, many
    everything = (Token("all", kept[0].start, kept[0].start), *kept)
    found = resolve_objects(
        kept if any(t.digits for t in kept) else everything, scene, replace(talk, targets=(), pending=())
    )
    return (found if isinstance(found, Fault) else found.ids), many


def _marks(c: _Comparison, scene: Scene, talk: Talk, pool: Sequence[str]) -> tuple[tuple[str, ...], int] | Fault:
    """What something is compared with, and in how many words. "Than the others" names nothing."""
    if any(t.text in _OTHERS for t in c.marks):
        extent = Extent(c.marks[0].start, c.marks[-1].end)
        return Fault("E305", "what it is compared with is not understood", extent, "than what?", "name the things")
    tried = ((resolve_objects(c.marks[:size], scene, talk), size) for size in range(len(c.marks), 0, -1))
    found, size = next((f for f in tried if isinstance(f[0], Found)), (resolve_objects(c.marks, scene, talk), 0))
    if isinstance(found, Found) and found.chosen:
        extent = Extent(c.marks[0].start, c.marks[-1].end)
        return Fault("E304", "what it is compared with fits several things", extent, "than which?", "", tuple(pool))
    return found if isinstance(found, Fault) else (found.ids, size)
