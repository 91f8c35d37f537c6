"""The sentence grammar: jinja2 lines in text files, read into rules that draw at random.

A rule is a file: its name without ``.txt``. Each line holds alternatives separated by `` ; ``, with an optional weight
in front (``3| a ; b`` gives 3 to each; without one it is 1). ``#`` begins a comment line. An alternative is a jinja2
template in which every rule of ``words/`` is a function: ``{{ noun() }}`` draws a noun, ``{{ thing('T') }}`` draws from
``thing`` with ``l`` set to ``T``. Built in besides: ``digits(n)``, ``letter()``, ``vocab()`` (a random word of the
tokenizer's vocabulary), ``pseudo()`` (a word that exists nowhere), and the filters ``under`` (spaces to
underscores), ``capital``, ``plain`` (drops the markup), ``third`` and ``ing`` (inflect the actions).

Keywords are marked inline: ``[A grab] the [T red mug]`` with A, T, D or L for action, target, destination, location.
"""

from __future__ import annotations

import re
from bisect import bisect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path
from random import Random
from types import MappingProxyType

from jinja2 import Environment, StrictUndefined, TemplateError

from llmbt_compiler.keywords.labels import Kind

__all__ = ["DATA", "Grammar", "GrammarError", "Segment", "parse_markup", "read_rules"]

DATA = Path(__file__).parent / "data"
"""The shipped grammar: ``structures/`` and ``words/``."""

_LETTERS = "ABCDEFGHJKLMNPQRSTWXYZ"
_ONSETS = [
    "b",
    "bl",
    "br",
    "c",
    "ch",
    "d",
    "dr",
    "f",
    "fl",
    "g",
    "gl",
    "gr",
    "h",
    "j",
    "k",
    "kl",
    "l",
    "m",
    "n",
    "p",
    "pl",
    "pr",
    "qu",
    "r",
    "s",
    "sk",
    "sn",
    "st",
    "t",
    "tr",
    "v",
    "w",
    "x",
    "z",
]
_VOWELS = ["a", "e", "i", "o", "u", "ai", "ea", "ee", "oo", "ou"]
_CODAS = [
    "b",
    "ck",
    "d",
    "f",
    "g",
    "l",
    "ll",
    "m",
    "n",
    "nd",
    "nk",
    "p",
    "r",
    "rk",
    "rt",
    "s",
    "sh",
    "ss",
    "t",
    "x",
    "z",
]
_MARK = re.compile(r"\[([ATDL]) ([^\[\]]+)\]")
_ACTION = re.compile(r"\[A ([^\[\]]+)\]")
_KINDS = {"A": Kind.ACTION, "T": Kind.TARGET, "D": Kind.DESTINATION, "L": Kind.LOCATION}
_DEPTH = 40


class GrammarError(ValueError):
    """A line of the grammar that cannot be read or drawn; the message names the file and the line."""


@dataclass(frozen=True, slots=True)
class Segment:
    """A stretch of a generated step, with the kind of keyword it is, or None."""

    text: str
    kind: Kind | None


@dataclass(frozen=True, slots=True)
class Alternative:
    """One way to expand a rule; `origin` is ``file:line``."""

    template: str
    weight: float
    origin: str


def read_rules(folder: Path) -> dict[str, tuple[Alternative, ...]]:
    """The rules of a folder by name, in the order of their names. Raises GrammarError, and OSError for the folder."""
    rules: dict[str, tuple[Alternative, ...]] = {}
    for path in sorted(folder.glob("*.txt")):
        found: list[Alternative] = []
        for number, raw in enumerate(path.read_text("utf-8").splitlines(), start=1):
            line = raw.strip()
            if not line or line.startswith("#"):
                continue
            origin = f"{path.name}:{number}"
            weighted = re.match(r"(\d+(?:\.\d+)?)\|\s*", line)
            weight = float(weighted.group(1)) if weighted else 1.0
            body = line[weighted.end() :] if weighted else line
            parts = [p.strip() for p in body.split(" ; ")]
            if not all(parts) or weight <= 0:
                raise GrammarError(f"{origin}: an empty alternative or a weight of 0")
            found += [Alternative(p, weight, origin) for p in parts]
        if not found:
            raise GrammarError(f"{path.name}: no alternatives")
        rules[path.stem] = tuple(found)
    return rules


def parse_markup(marked: str) -> tuple[Segment, ...]:
    """``[A grab] the [T cup]`` as segments. Raises GrammarError where a bracket is left over."""
    out: list[Segment] = []
    at = 0
    for m in _MARK.finditer(marked):
        out += [Segment(marked[at : m.start()], None), Segment(m.group(2), _KINDS[m.group(1)])]
        at = m.end()
    out.append(Segment(marked[at:], None))
    for s in out:
        if "[" in s.text or "]" in s.text:
            raise GrammarError(f"a bracket that marks nothing in {marked!r}")
    return tuple(s for s in out if s.text)


class Grammar:
    """Rules ready to draw from. Drawing depends on the generator handed in and on nothing else."""

    def __init__(
        self,
        structures: Mapping[str, tuple[Alternative, ...]],
        words: Mapping[str, tuple[Alternative, ...]],
        vocabulary: tuple[str, ...],
    ) -> None:
        self._random = Random(0)
        self._depth = 0
        self._vocabulary = vocabulary
        self._listed = words["noun_real"] if "noun_real" in words and not vocabulary else ()
        self._environment = Environment(undefined=StrictUndefined, autoescape=False)
        self._environment.filters.update(
            under=lambda s: str(s).replace(" ", "_"),
            capital=lambda s: str(s)[:1].upper() + str(s)[1:],
            plain=lambda s: _MARK.sub(r"\2", str(s)),
            third=lambda s: _inflect(str(s), third_person),
            ing=lambda s: _inflect(str(s), gerund),
        )
        builtin: dict[str, Callable[..., str]] = {
            "digits": self._digits,
            "letter": lambda: self._random.choice(_LETTERS),
            "vocab": self._vocab,
            "pseudo": self._pseudo,
        }
        clash = builtin.keys() & words.keys()
        if clash:
            raise GrammarError(f"rules named like something built in: {', '.join(sorted(clash))}")
        self._environment.globals.update(builtin)
        self._environment.globals.update({name: self._rule(alts) for name, alts in words.items()})
        self._structures = {name: self._rule(alts) for name, alts in structures.items()}

    @classmethod
    def load(
        cls,
        vocabulary: tuple[str, ...],
        folder: Path = DATA,
        more: Mapping[str, Sequence[str]] = MappingProxyType({}),
    ) -> Grammar:
        """The grammar of a folder that has ``structures/`` and ``words/``; `more` adds alternatives to rules of words.
        Without a `vocabulary` there are no unknown nouns: ``vocab()`` and ``pseudo()`` draw from ``noun_real``.

        What is added to a rule shares half of its weight. Raises GrammarError, OSError.
        """
        words = read_rules(folder / "words")
        for name, entries in more.items():
            if name not in words:
                raise GrammarError(f"no rule `{name}` to add words to")
            if entries:
                weight = sum(a.weight for a in words[name]) / len(entries)
                words[name] += tuple(Alternative(e, weight, f"added to {name}") for e in entries)
        return cls(read_rules(folder / "structures"), words, vocabulary)

    @property
    def structures(self) -> tuple[str, ...]:
        """The names of the sentence structures."""
        return tuple(self._structures)

    def draw(self, structure: str, random: Random) -> str:
        """One marked-up sentence of a structure. Raises GrammarError for a faulty line, KeyError for the name."""
        self._random = random
        self._depth = 0
        return re.sub(r" {2,}", " ", self._structures[structure]()).strip()

    def bullet(self, random: Random) -> str:
        """What may stand in front of a step in a list: a draw from the rule ``bullet``, or nothing without one."""
        rule = self._environment.globals.get("bullet")
        self._random = random
        return str(rule()) if callable(rule) else ""

    def _rule(self, alternatives: tuple[Alternative, ...]) -> Callable[..., str]:
        totals = list(accumulate(a.weight for a in alternatives))
        renderers = [self._renderer(a) for a in alternatives]

        def expand(l: str = "") -> str:  # noqa: E741 - what the templates call it
            if self._depth > _DEPTH:
                raise GrammarError(f"rules that call each other without end, near {alternatives[0].origin}")
            self._depth += 1
            try:
                return renderers[bisect(totals, self._random.random() * totals[-1])](l)
            finally:
                self._depth -= 1

        return expand

    def _renderer(self, alternative: Alternative) -> Callable[[str], str]:
        text = alternative.template
        if "{{" not in text and "{%" not in text:
            return lambda _: text
        try:
            template = self._environment.from_string(text)
        except TemplateError as e:
            raise GrammarError(f"{alternative.origin}: {e}") from e

        def render(label: str) -> str:
            try:
                return template.render(l=label)
            except TemplateError as e:
                raise GrammarError(f"{alternative.origin}: {e}") from e

        return render

    def _digits(self, most: int) -> str:
        """A number of at most so many digits, without leading zeros; half of them have exactly so many."""
        n = most if self._random.random() < 0.6 else self._random.randint(1, most)
        low = 10 ** (n - 1) if n > 1 else 1
        return str(self._random.randint(low, 10**n - 1))

    def _vocab(self) -> str:
        return self._random.choice(self._vocabulary or self._listed_nouns())

    def _listed_nouns(self) -> tuple[str, ...]:
        """Where no vocabulary is given, unknown nouns are drawn from the listed ones."""
        return tuple(a.template for a in self._listed) or ("thing",)

    def _pseudo(self) -> str:
        if not self._vocabulary:
            return self._vocab()
        pick = self._random.choice
        n = 1 if self._random.random() < 0.3 else 2
        return "".join(pick(_ONSETS) + pick(_VOWELS) for _ in range(n)) + pick(_CODAS)


def _inflect(marked: str, form: Callable[[str], str]) -> str:
    return _ACTION.sub(lambda m: f"[A {form(m.group(1))}]", marked)


def third_person(verb: str) -> str:
    """``pick`` to ``picks``."""
    irregular = {"be": "is", "do": "does", "go": "goes"}
    if verb in irregular:
        return irregular[verb]
    if re.search(r"(s|x|z|ch|sh)$", verb):
        return verb + "es"
    if re.search(r"[^aeiou]y$", verb):
        return verb[:-1] + "ies"
    return verb + "s"


def gerund(verb: str) -> str:
    """``put`` to ``putting``."""
    if verb.endswith("e") and not re.search(r"(ee|oe|ye)$", verb) and verb != "be":
        return verb[:-1] + "ing"
    if re.search(r"^[^aeiou]*[aeiou][bdgklmnprt]$", verb) and not re.search(r"(ck|[aeiou]{2}.)$", verb):
        return verb + verb[-1] + "ing"
    return verb + "ing"
