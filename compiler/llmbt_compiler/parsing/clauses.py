"""A step's keywords in clauses: each action with its particle and the phrases that belong to it.

Determiners, quantifiers and prepositions are no keywords (the tagging convention), so they are read from the
words around a span.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise, takewhile

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.model import Extent, LabelledStep
from llmbt_compiler.parsing.phrase import excepts
from llmbt_compiler.parsing.phrases import (
    INNER,
    MARKUP,
    STANDING,
    Clause,
    Group,
    Phrase,
    StepText,
    groups_of,
    particles_of,
    phrase_of,
)
from llmbt_compiler.parsing.words import Token, lemmas, lexicon, tokens

__all__ = ["Clause", "Group", "Phrase", "clauses", "extents"]

_RESTRICTING = (
    ("that", "is"), ("that", "are"), ("which", "is"), ("which", "are"), ("made", "of"), ("made", "from"), ("labelled",),
    ("labeled",), ("marked",), ("named",), ("called",), ("coloured",), ("colored",), ("with", "the", "letter"),
    ("with", "the", "number"), ("with", "the", "label"), ("with", "the", "name"), ("with", "the", "id"),
    ("with", "the", "colour"), ("with", "the", "color"), ("with", "number"), ("with", "letter"), ("with", "label"),
    ("with", "id"),
)  # fmt: skip
_STILL = frozenset({"left", "still", "there", "here", "now", "currently", "already", "next", "closest"})
_FAILING = frozenset({"forget", "hesitate", "fail", "omit"})  # "don't forget to ..."
_TOLD = frozenset({"that", "whether", "if", "you", "we", "i", "how", "it"})
_WISHED = frozenset(
    {
        "great", "nice", "good", "kind", "helpful", "wonderful", "lovely", "appreciate", "grateful", "glad", "obliged",
        "pleased", "delighted", "thankful", "happy", "fantastic", "awesome", "perfect", "ideal", "super",
    }
)  # fmt: skip
_NO_NAME = frozenset({"to", "do", "dont", "not", "any"})
_POINTERS = frozenset({"one", "first", "second", "former", "latter", "other", "others"})
_APART = frozenset({"apart", "aside", "save", "with", "excepting", "barring"})


def _sorted(step: LabelledStep) -> tuple[KeywordSpan, ...]:
    """The keywords within the text, in order, parts of one name joined, overlaps dropped."""
    size = len(step.text)
    found = sorted((s for s in step.spans if 0 <= s.start < s.end <= size), key=lambda s: (s.start, -s.end))
    out: list[KeywordSpan] = []
    for s in found:
        last = out[-1] if out else None
        if last is not None and s.start < last.end:
            continue
        joined = last is not None and s.label is last.label and s.label is not Kind.ACTION
        if last is not None and joined and not step.text[last.end : s.start].strip():
            text = step.text[last.start : s.end]
            out[-1] = replace(last, end=s.end, text=text, confidence=min(last.confidence, s.confidence))
        else:
            out.append(s)
    return tuple(out)


def clauses(step: LabelledStep) -> tuple[Clause, ...]:
    """The clauses of a step, in order. A step without an action is one clause with an empty one."""
    spans = _sorted(step)
    text, spans = _with_exceptions(StepText(step, spans, tokens(step.text)))
    out: list[Clause] = []
    begin = 0
    groups = [part for g in _grouped(text, spans) for part in _by_colon(text, g)]
    for i, (group, nxt) in enumerate(pairwise([*groups, []])):
        end = nxt[0].start if nxt else len(step.text)
        clause = _clause(text, group, begin, end)
        if out and (lexicon().is_(out[-1].action.casefold(), "negation", "unreal") or _reported(text, out[-1], group)):
            clause = replace(clause, negated=True)
        if out and out[-1].conditional and _goes_on(text.words_between(begin, clause.extent.start)):
            clause = replace(clause, conditional=True)  # "if it falls, stop and pick it up"
        if nxt and _is_heading(text, group, nxt):
            clause = replace(clause, heading=True)
        lender = _lender(text, groups[i:]) if not clause.phrases and clause.action else ()
        if lender:
            lent = tuple(phrase_of(text, s) for s in lender if s.label is Kind.TARGET)  # "pick and place object 5"
            clause = replace(clause, groups=(Group(lent),) if lent else ())
        out.append(clause)
        begin = max((s.end for s in group), default=begin)
    return tuple(out)


def _goes_on(between: Sequence[str]) -> bool:
    """Whether no more than "and" stands between two clauses, and what belongs to the first one's verb ("up")."""
    said = [w for w in between if w not in {"then", "simply", "just"} and not lexicon().is_(w, "particles")]
    return said in ([",", "and"], ["and"])


def _lender(text: StepText, groups: Sequence[Sequence[KeywordSpan]]) -> Sequence[KeywordSpan]:
    """The keywords of the clause whose target an action without one shares: "grasp, lift and move object 3"."""
    for group, nxt in pairwise(groups):
        if not _and(text, group[-1].end, nxt[0].start):
            return ()
        if any(s.label is not Kind.ACTION for s in nxt):
            return nxt
    return ()


def extents(found: Sequence[Clause], size: int) -> tuple[tuple[int, int], ...]:
    """Where the words of each clause begin and end: with its first keyword, and where the next clause begins."""
    starts = [min(c.extent.start, *(p.extent.start for p in c.phrases), size) for c in found]
    return tuple(zip(starts, [*starts[1:], size], strict=True)) if found else ()


def _reported(text: StepText, before: Clause, group: Sequence[KeywordSpan]) -> bool:
    """Whether a clause is what somebody is told or asked ("tell the user that you will put ...")."""
    lex = lexicon()
    if not any(lex.is_(w, "speech") for w in lemmas(before.action.casefold())):
        return False
    action = next((s.start for s in group if s.label is Kind.ACTION), group[0].start)
    lead = [t.text for t in text.all if before.extent.end <= t.start and t.end <= action]
    return any(w in _TOLD for w in lead) and "then" not in lead


def _and(text: StepText, start: int, end: int) -> bool:
    between = [t for t in text.all if start <= t.start and t.end <= end]
    return all(lexicon().is_(t.text, "joints", "particles") or t.text in {",", "/", "&"} for t in between)


def _is_heading(text: StepText, group: Sequence[KeywordSpan], nxt: Sequence[KeywordSpan]) -> bool:
    """Whether a clause with an action and no place is parted by a colon from what tells it in detail ("Sort the blocks:
    put ...")."""
    kinds = {s.label for s in group}
    after = text.after(group[-1].end)
    after = after[1:] if len(group) == 1 and after and lexicon().is_(after[0].text, "particles") else after
    told = {s.label for s in nxt} > {Kind.TARGET}
    by = next((s for s in nxt if s.label is Kind.ACTION), None)
    lead = text.words_between(group[-1].end, by.start)[-1:] if by is not None else []
    if Kind.ACTION in kinds and lead == ["by"] and by is not None and by.text.casefold().endswith("ing"):
        return Kind.DESTINATION not in kinds  # "clear the table by moving everything on it to the shelf"
    return Kind.ACTION in kinds and Kind.DESTINATION not in kinds and bool(after) and after[0].text == ":" and told


def _with_exceptions(text: StepText) -> tuple[StepText, tuple[KeywordSpan, ...]]:
    """Each target's exception ("that are not green", "except object 1") or restriction ("that are green") found in
    the words after it, up to the next action, preposition of place or full stop; keywords in it are no targets."""
    found: dict[int, tuple[Token, ...]] = {}
    gone: set[int] = set()
    ends = {"on", "onto", "to", "into", "in", "at", ".", ";", "from"}
    for s in text.spans:
        if s.label is not Kind.TARGET or s.start in gone:
            continue
        stop = min(
            (o.start for o in text.spans if o.label is Kind.ACTION and o.start >= s.end), default=len(text.step.text)
        )
        after = [t for t in text.all if s.end <= t.start and t.end <= stop and t.text not in MARKUP]
        at = 1 if after and after[0].text == "," else 0
        size = excepts(after, at)
        behind = 0 if size else _standing(text, s.end, after)
        if behind and excepts(after, behind):  # "everything on the shelf apart from the milk"
            at, size = behind, excepts(after, behind)
        cut = text.inside(s.start, s.end)[-1:]  # "the block labelled | object 5", the name cut off
        if not size and cut and (cut[0].text,) in _RESTRICTING and after and after[0].text not in ends:
            close = next((i for i, t in enumerate(after) if t.text in ends or not (t.word or t.number)), len(after))
            found[s.end] = tuple(after[:close])
            gone |= {o.start for o in text.spans if after[0].start <= o.start < after[close - 1].end}
            continue
        texts = tuple(t.text for t in after[:3])
        only = 0 if size else max((len(w) for w in _RESTRICTING if texts[: len(w)] == w), default=0)
        if not size and not only:
            continue
        at, size = (0, only) if only else (at, size)
        words = after[at + size :]
        close = next((i for i, t in enumerate(words) if t.text in ends or _predicate(words, i)), len(words))
        words = words[:close]
        while words and (words[-1].text in {",", ":"} or lexicon().is_(words[-1].text, "joints")):
            words.pop()
        if not any(t.word or t.number is not None for t in words) or words[0].text in _NO_NAME:
            continue
        if only and any(t.text in _STILL for t in words):
            continue
        found[s.end] = tuple(words if only else after[at : at + size] + words)
        gone |= {o.start for o in text.spans if words[0].start <= o.start < words[-1].end}
    spans = tuple(s for s in text.spans if s.start not in gone)
    return replace(text, spans=spans, left_out=found), spans


_PREDICATES = frozenset({
    "should", "shall", "must", "will", "may", "can", "could", "has", "have", "need", "needs", "get", "gets", "go",
    "goes", "belong", "belongs", "come", "comes", "be",
})  # fmt: skip


def _predicate(words: Sequence[Token], i: int) -> bool:
    """Whether the predicate of the whole begins here ("everything but the red block | is to be moved")."""
    after = words[i + 1].text if i + 1 < len(words) else ""
    told = words[i].text in {"is", "are"} and (after in {"to", "all", "both"} or after.endswith("ed") or after == "put")
    return i > 0 and (words[i].text in _PREDICATES or told)


def _standing(text: StepText, end: int, after: Sequence[Token]) -> int:
    """How many of the tokens after a target tell where it is ("that are on the shelf"), up to the end of that place's
    keyword; 0 where none do."""
    here = next((o for o in text.spans if o.start >= end), None)
    if here is None or here.label is not Kind.LOCATION:
        return 0
    lead = [t for t in after if t.end <= here.start]
    plain = all(t.text in STANDING or t.text in INNER or lexicon().is_(t.text, "articles") for t in lead)
    count = sum(t.end <= here.end for t in after)
    return count + (len(after) > count and after[count].text == ",") if lead and plain else 0


def _grouped(text: StepText, spans: Sequence[KeywordSpan]) -> list[list[KeywordSpan]]:
    """The keywords of each clause. What stands before the first action belongs to it.

    In "object 1 is placed on A and object 2 is placed on B" the second target belongs to the second action.
    """
    out: list[list[KeywordSpan]] = [[]]
    for s in spans:
        if s.label is Kind.ACTION and any(x.label is Kind.ACTION for x in out[-1]):
            moved: list[KeywordSpan] = []
            here = out[-1]
            first = next(i for i, x in enumerate(here) if x.label is Kind.ACTION)
            fronted = any(x.label is Kind.TARGET for x in here[:first])
            ended = any(t.text in {":", ".", ";"} for t in text.inside(here[-1].end, s.start))
            own = len(here) > first + 2 and _said_of(text, here[-1], s)
            if (fronted or own) and len(here) > first + 1 and here[-1].label is Kind.TARGET and not ended:
                moved = [here.pop()]
            out.append(moved)
        out[-1].append(s)
    return [g for g in out if g]


_MODAL = frozenset({"can", "could", "should", "shall", "must", "will", "may", "has", "have", "needs", "need", "ought"})


def _said_of(text: StepText, thing: KeywordSpan, action: KeywordSpan) -> bool:
    """Whether an action is said of the thing right before it: "the tea, and the biscuits | can go", "... | goes"."""
    between = text.words_between(thing.end, action.start)
    said = text.step.text[action.start : action.end].casefold()
    if not between:
        return said in {"go", "goes", "belong", "belongs", "comes"}
    return between[0] in _MODAL and all(
        w in _MODAL or w in {"to", "be", "then", "also", "now", "just"} for w in between
    )


def _by_colon(text: StepText, group: list[KeywordSpan]) -> list[list[KeywordSpan]]:
    """ "Distribute object 3 and object 5: | the first one to position 33, ...": a heading, and what it comes to."""
    for i in range(2, len(group) - 1):
        first, then = group[:i], group[i:]
        colon = any(t.text == ":" for t in text.inside(first[-1].end, then[0].start))
        heading = {s.label for s in first} == {Kind.ACTION, Kind.TARGET} and {s.label for s in then} == {
            Kind.TARGET,
            Kind.DESTINATION,
        }
        if colon and heading and any(t.text in _POINTERS for s in then for t in text.inside(s.start, s.end)):
            return [first, then]
    return [group]


def _clause(text: StepText, spans: Sequence[KeywordSpan], begin: int, end: int) -> Clause:
    action = next((s for s in spans if s.label is Kind.ACTION), None)
    phrases = [phrase_of(text, s) for s in spans if s.label is not Kind.ACTION]
    phrases = [_after_verb(p, action) for p in phrases]
    missed = _missed(text, action) if not any(p.kind is Kind.TARGET for p in phrases) else None
    if missed is not None:
        phrases.insert(0, phrase_of(text, missed))
    extent = Extent(spans[0].start, spans[-1].end)
    lex = lexicon()
    start = action.start if action is not None else end
    lead = [t for t in text.all if begin <= t.start and t.end <= start and not text.covered(t)]
    begun = action.end if action is not None else spans[-1].end
    tail = [t for t in text.all if begun <= t.start and t.end <= end and not text.covered(t)]
    own = lead[1:] if begin and lead and lex.is_(lead[0].text, "conditional") else lead
    own = [*own, *tail] if end == len(text.step.text) else own
    iffs = [t.start for t in own if lex.is_(t.text, "conditional")]
    wished = any(t.text in _WISHED and t.start < min(iffs, default=0) for t in lead)
    conditional = (any(_conditional(a, b) for a, b in pairwise([*own, None])) and not wished) or _in_case(lead)
    conditional |= action is not None and _should(lead)
    conditional &= not {"unless", "already"} <= {t.text for t in own}  # a goal that holds already costs nothing
    excepted = [i + max(1, excepts(tail, i)) for i, t in enumerate(tail) if _excepted(tail, i)]
    exception = tuple(tail[excepted[0] :]) if excepted else _fronted(lead)
    if any(p.excluded for p in phrases):
        exception = ()
    return Clause(
        action.text if action is not None else "",
        Extent(action.start, action.end) if action is not None else extent,
        particles_of(text, action, phrases),
        groups_of(phrases),
        (
            any(lex.is_(t.text, "negation") for t in _inserted(lead)[-3:])
            and not any(t.text in _FAILING for t in lead[-3:])
        )
        or any((a.text, b.text) == ("no", "need") for a, b in pairwise(lead)),
        conditional,
        exception,
    )


def _excepted(tail: Sequence[Token], i: int) -> bool:
    """Whether words behind the keywords begin what is left out: "except for", "apart from"."""
    return lexicon().is_(tail[i].text, "except") or (excepts(tail, i) > 1 and tail[i].text in _APART)


def _inserted(lead: Sequence[Token]) -> Sequence[Token]:
    """Without what stands between commas right before the verb ("shall not, under any circumstances, touch")."""
    commas = [i for i, t in enumerate(lead) if t.text == ","]
    inserted = len(commas) > 1 and commas[-1] == len(lead) - 1 and lexicon().is_(lead[commas[-2] - 1].text, "negation")
    return lead[: commas[-2]] if inserted else lead


def _fronted(lead: Sequence[Token]) -> tuple[Token, ...]:
    """What "with the exception of the bread, move ..." leaves out, said before the verb and unlabelled."""
    if len(lead) < 2 or lead[0].text in {"but", "without", "besides", "not", "that", "which", "is", "are", "be"}:
        return ()
    size = excepts(lead, 0)
    words = list(takewhile(lambda t: t.text not in {",", ":", ";"}, lead[size:])) if size else []
    return tuple(words)


def _after_verb(phrase: Phrase, action: KeywordSpan | None) -> Phrase:
    """ "Hand over the milk": a word that belongs to the verb says nothing of where the thing behind it is."""
    known = action is not None and f"{action.text.casefold()}_{phrase.relation}" in lexicon().synonyms
    return replace(phrase, preposition="", relation="") if known and phrase.kind is Kind.TARGET else phrase


def _missed(text: StepText, action: KeywordSpan | None) -> KeywordSpan | None:
    """A pronoun right after the verb that the tagger left unlabelled: "bring it", "move
    everything on ...".
    """
    free = text.after(action.end) if action is not None else []
    while free and lexicon().is_(free[0].text, "particles"):
        free.pop(0)
    if not free or free[0].text not in {"it", "them", "everything"}:
        return None
    return KeywordSpan(free[0].start, free[0].end, Kind.TARGET, free[0].text)


def _conditional(t: Token | None, after: Token | None) -> bool:
    """An "if" that is no courtesy ("if possible", "if you would be so kind")."""
    polite = after is not None and lexicon().is_(after.text, "courtesy")
    return t is not None and lexicon().is_(t.text, "conditional") and not polite


def _should(lead: Sequence[Token]) -> bool:
    """ "Should that be taken, use position 33": a condition, as its verb comes first."""
    words = [t.text for t in lead]
    begun = [i for i, w in enumerate(words) if w == "should" and (i == 0 or words[i - 1] in {";", ".", ",", "but"})]
    return bool(begun) and "," in words[begun[-1] :]


def _in_case(lead: Sequence[Token]) -> bool:
    return any(a.text == "in" and b.text == "case" for a, b in pairwise(lead))
