"""Things told by a comparison with another: "the block that is smaller than object 1", "as tall as the milk"."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from llmbt_compiler.parsing.scene import Entity, Scene
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["Comparison", "comparison"]

_MORE = {
    "larger": "size", "bigger": "size", "greater": "size", "taller": "height", "higher": "height",
    "wider": "width", "broader": "width", "longer": "width",
}  # fmt: skip
_LESS = {
    "smaller": "size", "tinier": "size", "littler": "size", "shorter": "height", "lower": "height",
    "narrower": "width",
}  # fmt: skip
_EQUAL = {
    "large": "size", "big": "size", "small": "size", "tall": "height", "high": "height", "wide": "width",
    "long": "width", "size": "size", "height": "height", "width": "width", "length": "width",
}  # fmt: skip
_STRESSING = frozenset({"even", "slightly", "much", "a", "bit", "little", "just", "exactly", "still", "of"})
_TOLERANCE_M = 1e-6


@dataclass(frozen=True, slots=True)
class Comparison:
    """What is `more` (1), `less` (-1) or as much (0) of a `measure` as that which is named from `mark` on."""

    measure: str
    sign: int
    mark: int

    def among(self, ids: Sequence[str], mark: str, scene: Scene) -> tuple[str, ...]:
        """Those of `ids` that compare so with `mark`."""
        of = _MEASURES[self.measure]
        bound = of(scene[mark])
        return tuple(i for i in ids if i != mark and _sign(of(scene[i]) - bound) == self.sign)


def comparison(words: Sequence[Token], at: int) -> Comparison | None:
    """The comparison that begins right here: "smaller than", "as big as", "the same height as"."""
    while at < len(words) and words[at].text in _STRESSING:
        at += 1
    said = [t.text for t in words[at : at + 4]]
    if len(said) > 2 and said[1] == "than":
        for table, sign in ((_MORE, 1), (_LESS, -1)):
            if said[0] in table:
                return Comparison(table[said[0]], sign, at + 2)
    if len(said) > 3 and said[0] == said[2] == "as" and said[1] in _EQUAL:
        return Comparison(_EQUAL[said[1]], 0, at + 3)
    if said and lexicon().is_(said[0], "articles"):
        at, said = at + 1, said[1:]
    if len(said) > 2 and said[0] == "same" and said[1] in _EQUAL and words[at + 2].text in {"as", "like"}:
        return Comparison(_EQUAL[said[1]], 0, at + 3)
    return None


_MEASURES: dict[str, Callable[[Entity], float]] = {
    "size": lambda e: e.measure("size"),
    "height": lambda e: e.measure("height"),
    "width": lambda e: max(e.size_m[:2]),
}


def _sign(difference: float) -> int:
    return 0 if abs(difference) <= _TOLERANCE_M else 1 if difference > 0 else -1
