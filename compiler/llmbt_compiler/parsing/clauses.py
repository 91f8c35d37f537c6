"""A step's keywords in clauses: each action with its particle and the phrases that belong to it.

Determiners, quantifiers and prepositions are no keywords (the tagging convention), so they are read from the
words around a span.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise, takewhile

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.model import Extent, LabelledStep
from llmbt_compiler.parsing.phrase import excepts
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
_MARKUP = frozenset("*`\"“”'‘’")
_POINTERS = frozenset({"one", "first", "second", "former", "latter", "other", "others"})
_TRAIL = 6
_APART = frozenset({"apart", "aside", "save", "with", "excepting", "barring"})
_STANDING = frozenset(
    {
        "that",
        "which",
        "is",
        "are",
        "currently",
        "now",
        "standing",
        "lying",
        "stands",
        "lies",
        "sits",
        "stand",
        "lie",
        "sit",
    }
)
_INNER = frozenset({"on", "in", "at", "of", "inside", "within", "from"})


@dataclass(frozen=True, slots=True)
class Phrase:
    """A target, destination or location with the words around it that bear on it.

    `parts` are its tokens with the quantifiers before it; `preposition` stands before these; `relation` is a
    relation word among them ("next", "behind"); `aside` is a parenthesis right after it; `trail` what follows
    a preposition right after it, as "shelf level 1" in "position 12 on shelf level 1"; `after` what follows a comma,
    as "slot 2" in "rack B, slot 2".
    """

    kind: Kind
    parts: tuple[Token, ...]
    extent: Extent
    preposition: str = ""
    relation: str = ""
    aside: tuple[Token, ...] = ()
    trail: tuple[Token, ...] = ()
    after: tuple[Token, ...] = ()
    excluded: bool = False
    apposed: bool = False
    vague: bool = False

    def many_of(self, count: int) -> bool:
        """Whether it says so many ("the two blocks")."""
        return any(t.number == str(count) for t in self.parts[:2]) or (count == 2 and self.parts[0].text == "both")

    def about(self, list_name: str) -> bool:
        """Whether one of its words is in a function-word list."""
        return any(lexicon().is_(form, list_name) for t in self.parts for form in (t.text, t.text.removesuffix("s")))


@dataclass(frozen=True, slots=True)
class Group:
    """Targets that share their destinations and locations."""

    targets: tuple[Phrase, ...] = ()
    destinations: tuple[Phrase, ...] = ()
    locations: tuple[Phrase, ...] = ()

    @property
    def phrases(self) -> tuple[Phrase, ...]:
        """All of them."""
        return (*self.targets, *self.destinations, *self.locations)


@dataclass(frozen=True, slots=True)
class Clause:
    """One action (None where the step leaves it out) and its phrases, in groups."""

    action: str
    extent: Extent
    particles: tuple[str, ...] = ()
    groups: tuple[Group, ...] = ()
    negated: bool = False
    conditional: bool = False
    exception: tuple[Token, ...] = ()
    heading: bool = False

    @property
    def phrases(self) -> tuple[Phrase, ...]:
        """The phrases of all groups."""
        return tuple(p for g in self.groups for p in g.phrases)


@dataclass(frozen=True)
class _Text:
    """A step's tokens, and which of them lie in a keyword."""

    step: LabelledStep
    spans: tuple[KeywordSpan, ...]
    all: tuple[Token, ...]
    left_out: dict[int, tuple[Token, ...]] = field(default_factory=dict)  # by where a target ends: its exception

    def inside(self, start: int, end: int) -> tuple[Token, ...]:
        return tuple(t for t in self.all if start <= t.start and t.end <= end)

    def words_between(self, start: int, end: int) -> list[str]:
        return [t.text for t in self.inside(start, end)]

    def covered(self, t: Token) -> bool:
        if any(t in parts for parts in self.left_out.values()):
            return True
        return any(s.start < t.end and t.start < s.end for s in self.spans)

    def before(self, at: int) -> list[Token]:
        """The free tokens before an offset, nearest first, up to the keyword before."""
        out: list[Token] = []
        for t in reversed([t for t in self.all if t.end <= at]):
            if self.covered(t):
                break
            if t.text not in _MARKUP:
                out.append(t)
        return out

    def after(self, at: int) -> list[Token]:
        """The free tokens after an offset, up to the next keyword."""
        out: list[Token] = []
        for t in (t for t in self.all if t.start >= at):
            if self.covered(t):
                break
            if t.text not in _MARKUP:
                out.append(t)
        return out


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
    text, spans = _with_exceptions(_Text(step, spans, tokens(step.text)))
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
            lent = tuple(_phrase(text, s) for s in lender if s.label is Kind.TARGET)  # "pick and place object 5 on ..."
            clause = replace(clause, groups=(Group(lent),) if lent else ())
        out.append(clause)
        begin = max((s.end for s in group), default=begin)
    return tuple(out)


def _goes_on(between: Sequence[str]) -> bool:
    """Whether no more than "and" stands between two clauses, and what belongs to the first one's verb ("up")."""
    said = [w for w in between if w not in {"then", "simply", "just"} and not lexicon().is_(w, "particles")]
    return said in ([",", "and"], ["and"])


def _lender(text: _Text, groups: Sequence[Sequence[KeywordSpan]]) -> Sequence[KeywordSpan]:
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


def _reported(text: _Text, before: Clause, group: Sequence[KeywordSpan]) -> bool:
    """Whether a clause is what somebody is told or asked ("tell the user that you will put ...")."""
    lex = lexicon()
    if not any(lex.is_(w, "speech") for w in lemmas(before.action.casefold())):
        return False
    action = next((s.start for s in group if s.label is Kind.ACTION), group[0].start)
    lead = [t.text for t in text.all if before.extent.end <= t.start and t.end <= action]
    return any(w in _TOLD for w in lead) and "then" not in lead


def _and(text: _Text, start: int, end: int) -> bool:
    between = [t for t in text.all if start <= t.start and t.end <= end]
    return all(lexicon().is_(t.text, "joints", "particles") or t.text in {",", "/", "&"} for t in between)


def _is_heading(text: _Text, group: Sequence[KeywordSpan], nxt: Sequence[KeywordSpan]) -> bool:
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


def _with_exceptions(text: _Text) -> tuple[_Text, tuple[KeywordSpan, ...]]:
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
        after = [t for t in text.all if s.end <= t.start and t.end <= stop and t.text not in _MARKUP]
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


def _standing(text: _Text, end: int, after: Sequence[Token]) -> int:
    """How many of the tokens after a target tell where it is ("that are on the shelf"), up to the end of that place's
    keyword; 0 where none do."""
    here = next((o for o in text.spans if o.start >= end), None)
    if here is None or here.label is not Kind.LOCATION:
        return 0
    lead = [t for t in after if t.end <= here.start]
    plain = all(t.text in _STANDING or t.text in _INNER or lexicon().is_(t.text, "articles") for t in lead)
    count = sum(t.end <= here.end for t in after)
    return count + (len(after) > count and after[count].text == ",") if lead and plain else 0


def _grouped(text: _Text, spans: Sequence[KeywordSpan]) -> list[list[KeywordSpan]]:
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


def _said_of(text: _Text, thing: KeywordSpan, action: KeywordSpan) -> bool:
    """Whether an action is said of the thing right before it: "the tea, and the biscuits | can go", "... | goes"."""
    between = text.words_between(thing.end, action.start)
    said = text.step.text[action.start : action.end].casefold()
    if not between:
        return said in {"go", "goes", "belong", "belongs", "comes"}
    return between[0] in _MODAL and all(
        w in _MODAL or w in {"to", "be", "then", "also", "now", "just"} for w in between
    )


def _by_colon(text: _Text, group: list[KeywordSpan]) -> list[list[KeywordSpan]]:
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


def _clause(text: _Text, spans: Sequence[KeywordSpan], begin: int, end: int) -> Clause:
    action = next((s for s in spans if s.label is Kind.ACTION), None)
    phrases = [_phrase(text, s) for s in spans if s.label is not Kind.ACTION]
    phrases = [_after_verb(p, action) for p in phrases]
    missed = _missed(text, action) if not any(p.kind is Kind.TARGET for p in phrases) else None
    if missed is not None:
        phrases.insert(0, _phrase(text, missed))
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
        _particles(text, action, phrases),
        _groups(phrases),
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


def _missed(text: _Text, action: KeywordSpan | None) -> KeywordSpan | None:
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


def _particles(text: _Text, action: KeywordSpan | None, phrases: Sequence[Phrase]) -> tuple[str, ...]:
    """ "up" of "pick up", "down" of "put it down", "back" of "put it back on": after the verb or after its
    target.
    """
    if action is None:
        return ()
    found: list[str] = []
    targets = [p.extent.end for p in phrases if p.kind is Kind.TARGET and p.extent.start >= action.end][:1]
    for at in (action.end, *targets):
        for t in text.after(at)[:2]:
            if not lexicon().is_(t.text, "particles"):
                break
            found.append(t.text)
    return tuple(found)


def _groups(phrases: Sequence[Phrase]) -> tuple[Group, ...]:
    """Targets with what belongs to them: "A on x and B on y" are two groups, "give Bob A and Ann B" too."""
    groups: list[list[Phrase]] = [[]]
    seen = [p.kind for p in phrases if p.kind is not Kind.LOCATION]
    first = seen[0] if seen else Kind.TARGET
    ordered = first is Kind.DESTINATION and seen.count(Kind.DESTINATION) > 1 and seen.count(Kind.TARGET) > 1
    opener = Kind.DESTINATION if ordered else Kind.TARGET
    for p in phrases:
        here = groups[-1]
        opened = any(x.kind is opener for x in here)
        closed = any(x.kind is not opener for x in here[_first(here, opener) :])
        if p.kind is opener and opened and closed and not p.excluded:
            groups.append([])
        groups[-1].append(p)
    if first is Kind.DESTINATION and not ordered:  # "fetch me the water from the bar and the apple from the table"
        fronted = [p for p in groups[0][: _first(groups[0], Kind.TARGET)] if p.kind is Kind.DESTINATION]
        bare = [g for g in groups[1:] if not any(p.kind is Kind.DESTINATION for p in g)]
        for g in bare if not any(p.kind is Kind.DESTINATION for p in groups[0] if p not in fronted) else []:
            g.extend(fronted)
    return tuple(
        Group(
            tuple(p for p in g if p.kind is Kind.TARGET),
            tuple(p for p in g if p.kind is Kind.DESTINATION),
            tuple(p for p in g if p.kind is Kind.LOCATION),
        )
        for g in groups
        if g
    )


def _first(phrases: Sequence[Phrase], kind: Kind) -> int:
    return next((i for i, p in enumerate(phrases) if p.kind is kind), 0)


def _quantifier(t: Token) -> bool:
    lex = lexicon()
    lists = ("articles", "all", "both", "rest", "same", "indefinite", "back_to", "vacant")
    return lex.is_(t.text, *lists) or t.text in lex.ordinals or t.number is not None


def _phrase(text: _Text, span: KeywordSpan) -> Phrase:
    core = text.inside(span.start, span.end)
    if not core:
        core = (Token(span.text[:40].casefold() or "?", span.start, span.end),)
    left: list[Token] = []
    free = text.before(span.start)
    while free and (
        _quantifier(free[0]) or (free[0].text in {"of", "single"} and len(free) > 1 and _quantifier(free[1]))
    ):
        left.insert(0, free.pop(0))
    preposition, relation = _relation(free)
    lex = lexicon()
    if relation == "over" and len(core) == 1 and lex.is_(core[0].text, "there"):
        relation = ""  # "bring it over there"
    amount = [t.text for t in free[:3] if t.text not in {"of", "the", "-"}][:1]
    fronts = [t.text for t in free[:3]]
    excluded = any(lex.is_(w, "except") or w == "not" for w in fronts[:2]) or "instead" in fronts
    excluded = excluded or "rather" in fronts
    lead = free[:4][::-1]
    apart = any(excepts(lead, i) == len(lead) - i > 1 for i in range(len(lead)))  # "apart from objects 5 and 6"
    excluded = excluded or apart
    kept = tuple(t for t in core if t.text not in _MARKUP)
    phrase = Phrase(
        Kind.TARGET if apart else span.label,
        (*left, *(kept or core), *text.left_out.get(span.end, ())),
        Extent(span.start, span.end),
        preposition,
        relation,
        excluded=excluded,
        apposed=bool(free) and free[0].text == ",",
        vague=bool(amount) and lex.is_(amount[0], "vague"),
    )
    return _followed(text, phrase)


def _relation(free: Sequence[Token]) -> tuple[str, str]:
    """The preposition right before a phrase, and the relation word that goes with it."""
    lex = lexicon()
    if not free:
        return "", ""
    preposition = free[0].text
    around: list[str] = []
    for t in free[:5]:
        linked = t.text in {"to", "the", "of", "in", "on", "from", "side", "at", "its"}
        if not linked and not lex.is_(t.text, "relations"):
            break
        around.append(t.text)
    for i, w in enumerate(around):
        after = around[i - 1] if i else ""
        loose = w in {"over", "around", "past", "right", "left", "close"} and after in {
            "to",
            "on",
            "in",
            "at",
        }
        loose = (loose and not (w == "close" and after == "to")) or (w == "right" and i == 0)
        if lex.is_(w, "relations") and not loose and not (w == "top" and after in {"of", ""}):
            return preposition, w
    return preposition, ""


def _followed(text: _Text, phrase: Phrase) -> Phrase:
    """What comes right after a phrase and still speaks of it."""
    free = text.after(phrase.extent.end)
    if not free:
        return phrase
    if free[0].text in {"(", "["}:
        inside: list[Token] = []
        for t in free[1:]:
            if t.text in {")", "]"}:
                break
            inside.append(t)
        return replace(phrase, aside=tuple(inside))
    stands = next((i for i, t in enumerate(free) if t.text not in _STANDING), len(free))
    free = free[stands:] if stands < len(free) and free[stands].text in _INNER else free
    if free[0].text in _INNER or free[0].text == ",":
        trail = tuple(takewhile(lambda t: t.word or t.number is not None, free[1 : _TRAIL + 1]))
        return replace(phrase, after=trail) if free[0].text == "," else replace(phrase, trail=trail)
    return phrase
