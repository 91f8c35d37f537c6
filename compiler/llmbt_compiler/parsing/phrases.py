"""The phrases of a clause: keywords with the quantifiers and prepositions around them, in groups."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import takewhile

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.model import Extent, LabelledStep
from llmbt_compiler.parsing.phrase import excepts
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = [
    "INNER",
    "MARKUP",
    "STANDING",
    "Clause",
    "Group",
    "Phrase",
    "StepText",
    "groups_of",
    "particles_of",
    "phrase_of",
]

MARKUP = frozenset("*`\"“”'‘’")
_TRAIL = 6
STANDING = frozenset({
    "that", "which", "is", "are", "currently", "now", "standing", "lying", "stands", "lies", "sits",
    "stand", "lie", "sit",
})  # fmt: skip
INNER = frozenset({"on", "in", "at", "of", "inside", "within", "from"})


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
class StepText:
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
            if t.text not in MARKUP:
                out.append(t)
        return out

    def after(self, at: int) -> list[Token]:
        """The free tokens after an offset, up to the next keyword."""
        out: list[Token] = []
        for t in (t for t in self.all if t.start >= at):
            if self.covered(t):
                break
            if t.text not in MARKUP:
                out.append(t)
        return out


def particles_of(text: StepText, action: KeywordSpan | None, phrases: Sequence[Phrase]) -> tuple[str, ...]:
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


def groups_of(phrases: Sequence[Phrase]) -> tuple[Group, ...]:
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


def phrase_of(text: StepText, span: KeywordSpan) -> Phrase:
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
    kept = tuple(t for t in core if t.text not in MARKUP)
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


def _followed(text: StepText, phrase: Phrase) -> Phrase:
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
    stands = next((i for i, t in enumerate(free) if t.text not in STANDING), len(free))
    free = free[stands:] if stands < len(free) and free[stands].text in INNER else free
    if free[0].text in INNER or free[0].text == ",":
        trail = tuple(takewhile(lambda t: t.word or t.number is not None, free[1 : _TRAIL + 1]))
        return replace(phrase, after=trail) if free[0].text == "," else replace(phrase, trail=trail)
    return phrase
