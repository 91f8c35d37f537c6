"""What a model's question offers: which of the things that it names are its candidates, and which only tell of them.

"There is a free position on both sides of object 2. Should object 4 go on position 12 or on position 14?" offers two
positions.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from llmbt_compiler.checking.referring import meant_objects
from llmbt_compiler.parsing.mentions import Mention, mentions_in
from llmbt_compiler.parsing.names import Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.words import Token, lexicon, tokens

__all__ = ["offered"]

_WHICH = frozenset({"which", "what"})
_AUXILIARY = frozenset({
    "do", "should", "would", "shall", "is", "are", "did", "can", "may", "will", "does", "could", "must", "goes", "go",
    "belongs", "belong", "has", "have",
})  # fmt: skip
_ENDS = frozenset({".", "?", "!", ";"})
_BREAKS = frozenset({*_ENDS, ":"})


@dataclass(frozen=True, slots=True)
class _Question:
    """A question's words and what they name; `asked` is where its "which", "what" or "where" stands."""

    words: tuple[Token, ...]
    named: tuple[Mention, ...]
    asked: int | None
    scene: Scene

    def of(self, movable: bool) -> tuple[Mention, ...]:
        return tuple(m for m in self.named if self.scene[m.id].movable == movable)


def offered(text: str, scene: Scene) -> tuple[tuple[str, ...], bool | None]:
    """The ids that a question offers, in their order, and whether it asks for an object (True), for a place (False), or
    does not show (None)."""
    words = tokens(text)
    inside = {m.id for m in mentions_in(words, scene)}
    named = tuple(
        m
        for m in mentions_in(words, scene)
        if scene[m.id].movable or not any(o != m.id and not scene[o].movable and scene.within(o, m.id) for o in inside)
    )
    marks = [i for i, t in enumerate(words) if t.text in _WHICH | {"where"}]
    question = _Question(words, named, next(iter(marks), None), scene)
    told = _told_apart(question, text)
    if told:
        return told, True
    movable = _kind(question)
    if movable is None:
        return tuple(dict.fromkeys(m.id for m in named)), None
    pool = question.of(movable)
    fits = _fitting(question)
    own = [m for m in pool if m not in _telling(question)]
    among = [m for m in own if m.id in fits]
    offers = _either_or(question, own)
    for found in ([m for m in offers if m in among], among, own, pool):
        if len({m.id for m in found}) > 1:
            return tuple(dict.fromkeys(m.id for m in found)), movable
    numbers = _numbers(question, movable)
    if len(numbers) > 1:
        return numbers, movable
    whole = tuple(dict.fromkeys(m.id for m in pool))
    if len(whole) <= 1 and fits and scene[fits[0]].movable == movable:
        return fits, movable
    return whole, movable


def _either_or(q: _Question, named: Sequence[Mention]) -> tuple[Mention, ...]:
    """Those on both sides of an "or": "Do you mean object 4 or object 5? Both are next to object 6"."""
    for i in (k for k, t in enumerate(q.words) if t.text == "or"):
        begin = max((k + 1 for k in range(i) if q.words[k].text in _BREAKS), default=0)
        stop = next((k for k in range(i, len(q.words)) if q.words[k].text in _BREAKS), len(q.words))
        before = [m for m in named if begin <= m.start < i]
        after = [m for m in named if i < m.start < stop]
        if before and after and after[0].start <= i + 2:
            return (*before, *after)
    return ()


def _told_apart(q: _Question, text: str) -> tuple[str, ...]:
    """ "The green one on position 12 or the yellow one on position 22": things that are told by where they stand."""
    phrases = [m for m in meant_objects(q.words, text, q.scene) if len(m.ids) == 1 and not q.words[m.end - 1].digits]
    for after in phrases:
        if not after.start or q.words[after.start - 1].text != "or":
            continue
        begin = max((k for k in range(after.start) if q.words[k].text in _BREAKS), default=-1)
        before = [m for m in phrases if begin < m.start < after.start]
        beside = any(r.end >= m.start > r.start for r in relations(q.words) for m in (*before, after))
        if before and not beside:
            return tuple(dict.fromkeys(m.ids[0] for m in (*before, after)))
    return ()


def _kind(q: _Question) -> bool | None:
    """Whether objects are asked for: what stands on both sides of an "or" tells, then the noun after "which", then what
    there are several of."""
    for i, t in enumerate(q.words):
        if t.text != "or":
            continue
        start = max((k for k in range(i) if q.words[k].text in _ENDS), default=-1)
        stop = next((k for k in range(i, len(q.words)) if q.words[k].text in _ENDS), len(q.words))
        before = [m for m in q.named if start < m.start < i and m not in _telling(q)]
        after = [m for m in q.named if i < m.start < stop and m not in _telling(q)]
        kinds = {q.scene[m.id].movable for m in before} & {q.scene[m.id].movable for m in after}
        if len(kinds) == 1:
            return kinds.pop()
        if after and before:
            return q.scene[after[0].id].movable
    if q.asked is not None and q.words[q.asked].text == "where":
        return False
    noun = _noun(q)
    if noun is not None:
        return noun
    if q.asked is not None and q.words[q.asked].text == "what" and not _phrase(q):
        return True  # "what should I put there?"
    many = [len({m.id for m in q.of(k)}) > 1 for k in (True, False)]
    if many[0] != many[1] or (q.asked is not None and many[0]):
        return many[0]
    return q.scene[q.named[0].id].movable if q.named else None


def _numbers(q: _Question, movable: bool) -> tuple[str, ...]:
    """ "Which of the positions, 12 or 13?": what has these numbers, where each is one thing's alone."""
    if not any(t.text == "or" for t in q.words):
        return ()
    by = [[e.id for e in q.scene.pool(movable) if e.number == t.number] for t in q.words if t.digits]
    return tuple(dict.fromkeys(found[0] for found in by if len(found) == 1))


def _phrase(q: _Question) -> tuple[Token, ...]:
    """The words from "which" to the verb: "Which box next to the juice"."""
    if q.asked is None:
        return ()
    stop = next(
        (k for k in range(q.asked + 1, len(q.words)) if q.words[k].text in _AUXILIARY | _BREAKS | {","}), len(q.words)
    )
    return q.words[q.asked + 1 : stop]


def _noun(q: _Question) -> bool | None:
    """What "which" asks for by its noun: an object (True) or a place."""
    for t in _phrase(q)[:6]:
        if not t.word or t.number is not None:
            continue
        as_object, as_place = q.scene.word(t, True), q.scene.word(t, False)
        in_objects = bool(as_object.text) and not as_object.corrected and as_object.text not in q.scene.colours
        in_places = bool(as_place.text) and not as_place.corrected
        if t.text in {"side", "end"}:
            return False
        if in_objects != in_places:
            return in_objects
    return None


def _telling(q: _Question) -> tuple[Mention, ...]:
    """What is named only to tell of others: within the words from "which" to the verb, and right after a relation or a
    comparison."""
    begin = q.asked if q.asked is not None else 0
    within = range(begin, begin + 1 + len(_phrase(q)))
    marks = [r.end for r in relations(q.words)] + [k + 1 for k, t in enumerate(q.words) if t.text == "than"]
    return tuple(m for m in q.named if m.start in within or any(_follows(q, k, m) for k in marks))


def _follows(q: _Question, at: int, mention: Mention) -> bool:
    """Whether only the words of a noun phrase stand between a relation and what is named: "next to the red block
    (object 6)"."""
    return at <= mention.start and all(
        lexicon().is_(t.text, "articles") or t.text == "(" or bool(q.scene.word(t, True).text)
        for t in q.words[at : mention.start]
    )


def _fitting(q: _Question) -> tuple[str, ...]:
    """ "Which green block": all of them."""
    phrase = tuple(t for t in _phrase(q) if t.number is None)
    for nouns in _heads(phrase):
        every = (Token("all", nouns[0].start, nouns[0].start), *nouns)
        for resolve in (resolve_objects, resolve_places):
            found = resolve(every, q.scene, Talk())
            if isinstance(found, Found) and len(found.ids) > 1 and not found.corrected and "*" not in found.ids:
                return found.ids
    return ()


def _heads(phrase: Sequence[Token]) -> Iterator[tuple[Token, ...]]:
    """What "which ... of the ..." may be about, the longest words first."""
    kept = tuple(t for t in phrase if t.text not in {"one", "ones", "of"} and not lexicon().is_(t.text, "articles"))
    stop = next((k for k, t in enumerate(kept) if not t.word), len(kept))
    for length in range(min(stop, 4), 0, -1):
        yield kept[:length]
