"""Sentences that say or ask how things are, and order nothing: "is object 2 on position 34?", "object 2 stands there",
"it would fit on position 34"."""

from __future__ import annotations

import re

from llmbt_compiler.parsing.model import Extent
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import lemmas, lexicon, tokens

__all__ = ["STATIVE", "asks_a_fact", "describes", "predicate"]

_ASKS = re.compile(
    r"^\W*(?:(?:did|does|was|were|has|had)\b|(?:is|are)\s+(?!it\b|there\b|you\b|this\b|that\b)"
    r"|have\s+(?:you|they|we|I)\b|(?:should|shall)\s+(?:I|we)\b)[^?.!]*\?\W*$",
    re.IGNORECASE,
)
_STANDING = frozenset({"stand", "sit", "lie", "rest", "fit", "suit", "hang", "lean"})
STATIVE = frozenset({"stands", "sits", "lies", "rests", "fits", "suits", "hangs", "leans"})
"""Said of a thing in the third person, these tell how it is."""
_PERHAPS = frozenset({"would", "could", "might", "may", "can"})
_LINKS = frozenset({
    "go", "goes", "belong", "belongs", "be", "being", "is", "are", "end", "ends", "has", "have", "had", "need", "needs",
    "should", "must", "shall", "will", "can", "ought", "come", "comes", "stand", "sit", "lie", "lying", "standing",
    "sitting", "placed", "put", "set", "moved", "brought", "want", "wants", "live", "deserve", "deserves", "use",
    "destination", "switch", "id", "due",
})  # fmt: skip
"""Words by which a thing comes to its place in a sentence without a verb that puts it there."""


def asks_a_fact(text: str) -> bool:
    """Whether a step is a question for information, and no order in the form of one ("could you ...?")."""
    return _ASKS.match(text) is not None


def describes(text: str, action: Extent, subject: int) -> bool:
    """Whether the action of a clause says how a thing named before it (from `subject`) is, or might be: "object 2
    stands on position 34", "... would fit on position 34"; "should stand" asks for it."""
    if subject >= action.start:
        return False
    said = action.cut(text).casefold()
    lead = [t.text for t in tokens(text, subject, action.start)][-1:]
    stands = not _STANDING.isdisjoint(lemmas(said))
    return stands and (said not in _STANDING or bool(set(lead) & _PERHAPS))


def predicate(text: str, start: int, end: int, scene: Scene) -> str:
    """A word of text[start:end], between a thing and a place, that says something else of the thing than that it goes
    there ("might be *better* on"); empty where there is none."""
    for t in tokens(text, start, end):
        known = t.text in _LINKS or t.text in lexicon().known or t.text in lexicon().sizes or t.text.endswith("est")
        named = any(w.text and not w.corrected for w in (scene.word(t, True), scene.word(t, False)))
        if t.word and t.number is None and len(t.text) > 1 and not known and not named:
            return t.text
    return ""
