"""A noun phrase taken apart: words, numbers, quantity and what it refers back to, before anything is looked
up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from llmbt_compiler.parsing.model import Extent
from llmbt_compiler.parsing.scene import Scene, Word
from llmbt_compiler.parsing.words import Token, lexicon, singulars

__all__ = ["Description", "conjuncts", "describe", "excepts", "split_exception", "split_place"]


@dataclass(frozen=True, slots=True)
class Description:
    """One noun phrase. `words` are content words; `numbers` name things, `count` says how many of them."""

    extent: Extent
    words: tuple[Word, ...] = ()
    numbers: tuple[str, ...] = ()
    ranges: tuple[tuple[str, str], ...] = ()
    count: int | None = None
    all: bool = False
    both: bool = False
    rest: bool = False
    same: bool = False
    vacant: bool = False
    origin: bool = False
    definite: bool = False
    indefinite: bool = False
    plural: bool = False
    head: bool = False
    initial: str = ""
    ordinal: int | None = None
    rank: str = ""
    size: str = ""
    pronoun: str = ""
    partitive: bool = False  # "two of the blocks"
    total: int | None = None  # "two of the three blocks": how many there are
    anaphoric: bool = False  # "one" or "ones" in the place of a noun
    pointing: bool = False  # "this block"

    @property
    def many(self) -> bool:
        """Whether it means several things."""
        return self.all or self.both or self.plural or (self.count or 0) > 1

    @property
    def unknown(self) -> tuple[Word, ...]:
        """The words that the scene has no use for."""
        return tuple(w for w in self.words if not w.text)

    @property
    def texts(self) -> tuple[str, ...]:
        """The words as the vocabulary has them."""
        return tuple(w.text for w in self.words if w.text)

    @property
    def bare(self) -> bool:
        """Nothing that describes: no words, no numbers."""
        return not (self.words or self.numbers or self.ranges)


def split_place(parts: Sequence[Token], *prepositions: str) -> tuple[tuple[Token, ...], tuple[Token, ...]]:
    """A phrase and what follows its first inner preposition: "block | position 12" of
    "block on position 12".
    """
    lex = lexicon()
    for i, t in enumerate(parts):
        hit = t.text in prepositions or (not prepositions and lex.is_(t.text, "at", "from"))
        if hit and 0 < i < len(parts) - 1:
            return tuple(parts[:i]), tuple(parts[i + 1 :])
    return tuple(parts), ()


_EXCEPTING = (
    ("with", "the", "exception", "of"), ("other", "than"), ("apart", "from"), ("aside", "from"), ("except", "for"),
    ("save", "for"), ("but", "not"), ("save",), ("except",), ("excepting",), ("excluding",), ("without",), ("besides",),
    ("minus",), ("but",), ("barring",), ("leaving", "out"), ("leaving", "aside"), ("not", "counting"), ("ignoring",),
)  # fmt: skip
_BEING = frozenset({"that", "which", "who", "is", "are", "being", "be"})
_NOT = frozenset({"not", "isnt", "arent", "non", "neither"})


def excepts(parts: Sequence[Token], i: int) -> int:
    """How many tokens from `i` on say that what follows is left out ("except for", "that are not"); 0: none do."""
    texts = [t.text for t in parts[i : i + 5]]
    for words in _EXCEPTING:
        if tuple(texts[: len(words)]) == words:
            return len(words)
    k = 0
    while k < len(texts) - 1 and k < 2 and texts[k] in _BEING:
        k += 1
    return k + 1 if k < len(texts) and texts[k] in _NOT else 0


def split_exception(parts: Sequence[Token]) -> tuple[tuple[Token, ...], tuple[Token, ...]] | None:
    """A phrase and what it leaves out: "all blocks | green" of "all blocks that are not green"; None: nothing."""
    for i, t in enumerate(parts):
        size = excepts(parts, i)
        if not size or i + size >= len(parts):
            continue
        rest = list(parts[i + size :])
        if t.text == "non" or (t.text == "not" and i + size + 1 < len(parts) and i < len(parts) - 2 and i <= 1):
            rest = [r for r in rest if r.text != "-"]
            return (*parts[:i], *rest[1:]), tuple(rest[:1])
        return tuple(p for p in parts[:i] if p.text != ","), tuple(rest)
    return None


def conjuncts(parts: Sequence[Token]) -> tuple[tuple[Token, ...], ...]:
    """The phrases that "and" or commas join; a list of numbers stays with its noun ("objects 1, 2 and 4")."""
    out: list[list[Token]] = [[]]
    for i, t in enumerate(parts):
        noun = t.text == "well" and i > 0 and parts[i - 1].text != "as"  # "the left well"
        joint = t.text in {",", "&", "+", ";", "/"} or (lexicon().is_(t.text, "joints") and not noun)
        if not joint:
            out[-1].append(t)
        elif out[-1] and not (t.text == "," and _adjectives(out[-1], parts[i + 1 :])):
            out.append([])
    merged: list[list[Token]] = []
    for group in (g for g in out if g):
        words = [t for t in group if t.word and t.number is None and not lexicon().is_(t.text, "filler", "ranges")]
        if merged and not words and any(t.number is not None for t in merged[-1]):
            merged[-1].extend(group)
        else:
            merged.append(group)
    return tuple(tuple(g) for g in merged)


def _adjectives(before: Sequence[Token], after: Sequence[Token]) -> bool:
    """Whether a comma parts adjectives of one noun, the first of size or shape: "the shorter, blue cylinder"."""
    lex = lexicon()
    first = {t.text for t in before if t.word and t.text != "all" and not lex.is_(t.text, "articles")}
    then = {t.text for t in after}
    ordering = lex.sizes.keys() | lex.shapes.keys()
    return first <= ordering and then.isdisjoint(lex.sizes) and not any(lex.is_(w, "joints", "articles") for w in then)


@dataclass
class _Reader:
    """One pass over the tokens of a phrase. What has been read so far decides what a number means."""

    scene: Scene
    movable: bool
    parts: Sequence[Token]
    flags: dict[str, object] = field(default_factory=dict)
    words: list[Word] = field(default_factory=list)
    numbers: list[str] = field(default_factory=list)
    ranges: list[tuple[str, str]] = field(default_factory=list)
    noun: bool = False  # a noun has been read: a number after it is a name
    marked: bool = False
    between: bool = False

    @property
    def nouns(self) -> frozenset[str]:
        return self.scene.nouns(self.movable)

    def read(self) -> Description:
        for i, t in enumerate(self.parts):
            self.token(i, t)
        extent = Extent(self.parts[0].start, self.parts[-1].end)
        d = Description(extent, tuple(self.words), tuple(self.numbers), tuple(self.ranges))
        d = replace(d, head=self.noun, **self.flags)  # type: ignore[arg-type]
        texts = [t.text for t in self.parts]
        if d.size and texts[texts.index(d.size) + 1 : texts.index(d.size) + 2] == [
            "of"
        ]:  # "the bigger of the two balls"
            d = replace(d, count=None, plural=False, both=False)
        return d

    def token(self, i: int, t: Token) -> None:
        if t.text in {"#", "№"}:
            self.marked = True
        elif t.text in {"-", "–", "—", "~"} or (lexicon().is_(t.text, "ranges") and self.numbers):
            self.between = bool(self.numbers)
        elif t.number is not None and not self.one(t):
            self.number(i, t)
        elif t.word:
            self.function(i, t)

    def one(self, t: Token) -> bool:
        """Whether "one" stands for a noun ("the yellow one") and not for the number."""
        if t.text != "one" or self.marked or (self.noun and self.words[-1:] and self.counted(self.words[-1].text)):
            return False
        described = bool(self.words) or any(k in self.flags for k in ("rest", "ordinal", "rank", "same"))
        last = t is self.parts[-1]
        if len(self.parts) == 1 and self.movable:
            self.flags["pronoun"] = "one"
            return True
        if described or (last and "definite" in self.flags):
            self.noun = self.flags["anaphoric"] = True
            return True
        return False

    def counted(self, noun: str) -> bool:
        """Whether things of this noun go by numbers."""
        pool = self.scene.pool(self.movable)
        return noun in self.nouns and any(e.number is not None and self.scene.fits(e, noun) for e in pool)

    def number(self, i: int, t: Token) -> None:
        value = str(t.number)
        content = any(p.word and p.number is None and not self.small(p) for p in self.parts[i + 1 :])
        counted = any(k in self.flags for k in ("rest", "all", "both"))
        if self.between and self.numbers:
            self.ranges.append((self.numbers.pop(), value))
            self.between = False
        elif self.noun or self.marked or self.numbers or self.ranges:
            self.numbers.append(value)
        elif self.flags.get("partitive") and "count" in self.flags and value.isascii() and value.isdigit():
            self.flags["total"] = min(int(value), 10**9)  # "two of the three blocks"
        elif content or counted or t.word:
            self.flags["partitive"] = [p.text for p in self.parts[i + 1 : i + 2]] == ["of"]
            self.flags["count"] = int(value) if value.isascii() and value.isdigit() and len(value) < 10 else 10**9
        else:
            self.numbers.append(value)

    def small(self, t: Token) -> bool:
        return lexicon().is_(t.text, "filler", "joints", "ranges", "articles")

    def function(self, i: int, t: Token) -> None:
        lex = lexicon()
        own = self.scene.vocabulary(self.movable)
        if t.text in {"ones", "one"}:
            self.flags["plural"] = t.text == "ones"
            self.noun = self.flags["anaphoric"] = True
        elif t.text in own and (not lex.is_(t.text, "articles") or self.letter(i, t)):
            self.content(t)
        elif self.movable and t.text in lex.sizes:
            self.flags["size"] = t.text
        elif t.text in lex.ordinals:
            self.flags["ordinal"] = lex.ordinals[t.text]
        elif t.text in {"number", "no", "nr", "num", "id"}:
            self.marked = True
        elif not self.flag(t):
            nxt = self.parts[i + 1] if i + 1 < len(self.parts) else None
            if len(t.text) == 1 and nxt is not None and nxt.digits and nxt.glued:
                self.flags["initial"] = t.text
                self.noun = True
            elif (not lex.is_(t.text, "filler", "joints") or self.a_noun(i, t)) and not self.suffix(i, t):
                self.content(t)

    def a_noun(self, i: int, t: Token) -> bool:
        """Whether a word that else says nothing ends the phrase and is a noun of the other kind: "in the well"."""
        return 0 < i == len(self.parts) - 1 and t.text in self.scene.nouns(not self.movable)

    def letter(self, i: int, t: Token) -> bool:
        """Whether "a" is a code and no article: "rack A", "A4"."""
        after = self.parts[i + 1] if i + 1 < len(self.parts) else None
        coded = after is not None and after.digits and after.glued
        return len(t.text) == 1 and (coded or (bool(self.words) and (after is None or not after.word)))

    def suffix(self, i: int, t: Token) -> bool:
        """The end of "1st" or "2nd": the number before it was an ordinal."""
        if t.text not in {"st", "nd", "rd", "th"} or not t.glued:
            return False
        before = self.parts[i - 1] if i else None
        if before is None or not before.digits or len(before.text) > 4:
            return False
        self.flags.pop("count", None)
        if self.numbers:
            self.numbers.pop()
        self.flags["ordinal"] = int(before.text)
        return True

    def flag(self, t: Token) -> bool:
        """Take a word as one that quantifies or points; False where it is none."""
        lex = lexicon()
        if not self.movable and lex.is_(t.text, "last"):
            self.flags["rank"] = "last"
            return True
        for name, lists in (
            ("all", ("all",)),
            ("rest", ("rest",)),
            ("both", ("both",)),
            ("same", ("same",)),
            ("origin", ("back_to",)),
        ):
            if lex.is_(t.text, *lists):
                self.flags[name] = True
                if t.text in {"others", "everything", "rest", "everybody"}:
                    self.flags["plural"], self.noun = True, True
                return True
        if not self.movable and lex.is_(t.text, "vacant"):
            self.flags["vacant"] = True
            return True
        if not self.movable:
            for name in ("top", "bottom", "middle"):
                if lex.is_(t.text, name):
                    self.flags["rank"] = name
                    return True
        if lex.is_(t.text, "definite", "indefinite", "articles"):
            self.flags["definite" if not lex.is_(t.text, "indefinite") else "indefinite"] = True
            if t.text in {"this", "that"}:
                self.flags["pointing"] = True
            if t.text in {"these", "those"}:
                self.flags["plural"] = True
            return True
        return False

    def content(self, t: Token) -> None:
        word = self.scene.word(t, self.movable)
        lex = lexicon()
        named = self.words and self.words[-1].text not in self.scene.colours
        vessel = next((form for form in singulars(t.text) if lex.is_(form, "vessels")), None)
        if self.movable and named and vessel is not None and vessel not in self.scene.vocabulary(True):
            return  # "coke can", where the map knows no can
        if (
            not word.text
            and not self.movable
            and t.text.endswith("ing")
            and any(lex.is_(w.text, "users") for w in self.words)
        ):
            return  # "the person reading at the desk"
        self.words.append(word)
        self.noun = word.text not in self.scene.colours
        if word.plural:
            self.flags["plural"] = True


def describe(parts: Sequence[Token], scene: Scene, movable: bool) -> Description:
    """Take one phrase apart. `parts` is not empty; `movable` says whether it is to name objects or places."""
    extent = Extent(parts[0].start, parts[-1].end)
    said = [t.text for t in parts if (t.word or t.number is not None) and t.text != "of"]
    if movable and said and said[-1] in {"former", "latter"} and len(said) <= 2:
        return Description(extent, pronoun=said[-1])
    both = len(said) == 2 and said[0] in {"all", "both"}
    if said and (len(said) == 1 or both) and said[-1] not in scene.vocabulary(movable):
        kinds = ("plural_pronouns", "pronouns", "there", "me")
        for kind in kinds if movable else ("him", *kinds):
            if lexicon().is_(said[-1], kind):
                many = kind == "plural_pronouns"
                return Description(extent, pronoun=kind, plural=many, both="both" in said)
    return _Reader(scene, movable, parts).read()
