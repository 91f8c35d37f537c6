"""What a request names and a reply passes over."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise

from llmbt_compiler.checking.choices import left_open
from llmbt_compiler.checking.complaints import several
from llmbt_compiler.checking.numbers import named_by_number, numbered
from llmbt_compiler.checking.points import OpenPoint
from llmbt_compiler.checking.referring import meant_objects, pointed_to
from llmbt_compiler.checking.sentences import span_of
from llmbt_compiler.checking.wording import phrase_at
from llmbt_compiler.parsing import ParseResult
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.names import Found
from llmbt_compiler.parsing.scene import Scene, natural
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.space.reading import name_end
from llmbt_compiler.parsing.words import Token, lexicon
from llmbt_ir.diagnostics import Diagnostic

__all__ = ["passed_over", "short_of_all"]

_APART = frozenset({
    "one", "other", "either", "first", "second", "third", "stay", "stays", "leave", "keep", "only", "half", "any",
    "left", "right", "front", "back", "former", "latter", "where", "swap", "exchange",
})  # fmt: skip
_BEING = frozenset({",", "(", "that", "thats", "which", "is", "the", "its", "it", "i", "mean", "-"})
_LEAVING = frozenset({
    "leave", "leaving", "stay", "stays", "keep", "remain", "remains", "where", "swap", "exchange", "switch", "already",
    "currently", "now", "was", "from", "empty",
    "still", "than", "rather", "like", "clear", "free", "stands", "temporarily", "via", "through",
})  # fmt: skip


_NOT = frozenset({"isnt", "arent", "wasnt", "werent", "doesnt", "dont", "didnt", "hasnt", "wont", "cant"})


_CORRECTED = re.compile(
    r"\b(?:i meant?|scratch that|make (?:that|it)|no,? (?:sorry|wait|hang on|hold on)|sorry,? (?:no|not)|correction"
    r"|on second thoughts?|or rather|(?:strike|scrap|forget|ignore) that|changed my mind"
    r"|hang on|hold on|wait,? no|no,? not)\b",
    re.IGNORECASE,
)
"""Takes something back that was said before."""


_EXCEPTED = re.compile(
    r"\b(?:with the exception of|exception|apart from|aside from|save for|other than|barring|minus|bar the"
    r"|(?:all|everything|anything|every one|any|nothing|none|both)(?: of them)? (?:but|save|besides)|but not)\b",
    re.IGNORECASE,
)
"""What is named behind it is to be left alone."""


_TURNING = ("negation", "except", "instead", "conditional")


def passed_over(
    words: Sequence[Token], request: str, parsed: ParseResult, scene: Scene, said: frozenset[str]
) -> Iterator[OpenPoint]:
    """Objects by their numbers or names, numbered places where nothing stands yet, and colours, that the request names
    and the goals and the steps leave out; not where it may name them for another reason: as landmarks, in a condition,
    to be left alone."""
    if any(phrase_at(words, k, "staying", "hands_off") or t.text == "let" for k, t in enumerate(words)):
        return
    if any(t.text in _LEAVING | _NOT or lexicon().is_(t.text, *_TURNING) for t in words) or _states(words):
        return
    if _CORRECTED.search(request) is not None or _EXCEPTED.search(request) is not None:
        return
    landmarks = {id(t) for r in relations(words) for t in words[r.end : name_end(words, r)]}
    moved = {g.condition.args[0] for g in parsed.goals if g.condition.args}
    told = [m for m in meant_objects(words, request, scene) if m.stop and moved & set(m.ids)]
    landmarks |= {id(t) for m in told for t in words[m.start : m.stop]}  # "the green neighbour of the red block"
    its = [pointed_to(words, r.end, scene) for r in relations(words)]  # "see object 2? The one next to it"
    about = {
        *said,
        *(i for m in its if m is not None for i in m.ids),
        *(a for g in parsed.goals for a in g.condition.args),
    }
    about |= {i for m in parsed.moves for i in (m.target, m.place)}
    chosen = any(t.text == "either" for t in words) or left_open(words, request, scene, movable=True)
    for start, end, ids in _mentions(words, scene):
        if _aside(words, start) or (chosen and _alternative(words, start, end)):
            continue
        if not landmarks & {id(t) for t in words[start:end]} and not any(_concerns(i, about, scene) for i in ids):
            rival = _said_to_be(words, start, scene)
            if rival is not None:
                both = tuple(sorted({rival, *ids}, key=natural))
                yield OpenPoint(several(words[start:end], request, both, [rival]), rival)
                continue
            named = request[words[start].start : words[end - 1].end]
            title = f"the request names `{named}`, and the reply passes over it"
            yield OpenPoint(
                Diagnostic("E143", title, span_of(words[start:end], request), "no goal is about it",
                           "say it again in other words, or leave it out", candidates=ids[:6])
            )  # fmt: skip


def _said_to_be(words: Sequence[Token], start: int, scene: Scene) -> str | None:
    """ "Object 5, that's the red one", where object 5 is yellow: the thing that is named by its number before."""
    k = start
    while k and words[k - 1].text in _BEING:
        k -= 1
    found = named_by_number(words, k - 2, scene) if k >= 2 and k < start and numbered(words, k - 2, scene) else None
    return found.ids[0] if isinstance(found, Found) and len(found.ids) == 1 and scene[found.ids[0]].movable else None


def _alternative(words: Sequence[Token], start: int, end: int) -> bool:
    """Whether an "or" stands right before or behind what is named."""
    return "or" in {t.text for t in (*words[max(0, start - 2) : start], *words[end : end + 2])}


def _aside(words: Sequence[Token], start: int) -> bool:
    """Whether what is named is only compared with, or declined: "on the same level as the red one", "no coke"."""
    before = [t.text for t in words[max(0, start - 3) : start] if not lexicon().is_(t.text, "articles")]
    after = [t.text for t in words[start + 1 : start + 4]]
    if before[-1:] == ["with"] and {"on", "in"} & set(after) and {"it", "there"} & set(after):
        return True  # "the level with the red block on it"
    return before[-1:] in (["as"], ["no"], ["of"]) and (before[-1] != "of" or "level" in before)


def _states(words: Sequence[Token]) -> bool:
    """Whether something is told ("object 3 is in the way"), and not only told apart ("that is nearer")."""
    return any(b.text in {"is", "are"} and a.text not in {"that", "which", "who"} for a, b in pairwise(words))


def _mentions(words: Sequence[Token], scene: Scene) -> Iterator[tuple[int, int, tuple[str, ...]]]:
    """Where a text names things, and which they may be."""
    occupied = {o.place for o in scene.map.objects}
    for i in range(len(words)):
        found = named_by_number(words, i, scene) if i + 1 < len(words) and numbered(words, i, scene) else None
        if isinstance(found, Found) and len(found.ids) == 1:
            (id_,) = found.ids
            inner = {id_, *(p.id for p in scene.map.inside(id_))} if not scene[id_].movable else set()
            if not inner & occupied:
                yield i, i + 2, (id_,)
        if words[i].text in scene.colours:
            yield i, i + 1, tuple(e.id for e in scene.objects if words[i].text in e.colour)
        for e in scene.objects:
            size = len(e.id.split("_"))
            text = " ".join(t.text for t in words[i : i + size])
            if e.number is None and text == e.id.replace("_", " "):
                yield i, i + size, (e.id,)


def _concerns(id_: str, about: set[str], scene: Scene) -> bool:
    """Whether the goals are about a thing, or about a place in it."""
    if id_ in about:
        return True
    return not scene[id_].movable and any(a in {p.id for p in scene.map.inside(id_)} for a in about)


def short_of_all(words: Sequence[Token], request: str, parsed: ParseResult, scene: Scene) -> Iterator[OpenPoint]:
    """ "The two reds on level 2", of which the goals take one, and the other is not there yet: E143. Not where the
    request speaks of one of them by itself, takes something out, or tells something else by them."""
    said = {t.text for t in words}
    if said & (_APART | set(lexicon().sizes)) or any(lexicon().is_(t.text, *_TURNING) for t in words):
        return
    placed = {g.condition.args[0]: g.condition.args[1] for g in parsed.goals if g.condition.name == "On"}
    where = {o.id: o.place for o in scene.map.objects}
    phrases = tuple(meant_objects(words, request, scene))
    named = {m.id for m in mentions_in(words, scene)}
    for p in phrases:
        taken = [i for i in p.ids if i in placed]
        marks = any(p.start - 2 < r.end <= p.start for r in relations(words))
        of = p.start > 0 and words[p.start - 1].text in {"of", "between", "than", "among"}
        if not (p.exactly and len(p.ids) == p.count > 1 and 0 < len(taken) < p.count) or marks or of:
            continue
        if named & set(p.ids) or any(set(q.ids) < set(p.ids) for q in phrases):
            continue
        around = {c for i in taken for c in (placed[i], *tuple(scene.map.containers(placed[i]))[:1])}
        left = tuple(i for i in p.ids if i not in taken and not any(scene.within(where.get(i), c) for c in around))
        if left:
            phrase = request[words[p.start].start : words[p.end - 1].end]
            title = f"the request names `{phrase}`, and the reply takes {', '.join(taken)} alone"
            span = span_of(words[p.start : p.end], request)
            yield OpenPoint(
                Diagnostic("E143", title, span, "no goal is about the rest", "say it again", candidates=left)
            )
