"""Sentences that say or ask how things are, and order nothing: "is object 2 on position 34?", "object 2 stands there",
"it would fit on position 34"."""

from __future__ import annotations

import re
from collections.abc import Sequence

from llmbt_compiler.parsing.model import Extent
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import Token, lemmas, lexicon, tokens

__all__ = ["STATIVE", "asks_a_fact", "courteous", "describes", "predicate", "states_a_fact"]

_ASKS = re.compile(
    r"^\W*(?:(?:did|does|was|were|has|had)\b|(?:is|are)\s+(?!it\b|there\b|you\b|this\b|that\b)"
    r"|have\s+(?:you|they|we|I)\b|(?:should|shall)\s+(?:I|we)\b)[^?.!]*\?\W*$",
    re.IGNORECASE,
)
_ONE_CLAUSE = (
    r"(?:(?!\b(?:and|so|but|then|please|needs?|must|should|shall|ought|has|have|belongs?|goes|to\s+(?:be|go|move|come|get))\b)"
    r"[^,;:.!?])*[.!]?\s*$"
)
"""To the end, with no other clause and no word of what ought to be."""
_STATES = re.compile(
    r"^\W*(?:(?:I|we|they)\s+(?:can\s+|could\s+|already\s+|currently\s+|now\s+|just\s+|really\s+|still\s+)*"
    r"(?:see|saw|find|found|notice|noticed|spot|spotted|observe|observed|detect|detected|remember|have|had|know|knew"
    r"|think|thought|believe|guess|love|like|liked|enjoy)\s+(?!to\b)"
    r"|you\s+(?:can|will|may|might)\s+(?:see|find|notice|spot)\b"
    r"|(?:(?:on|in|at)\s+[^,;:.!?]{1,40}\s+)?there(?:\s+is|\s+are|'s)\s+(?!to\b)"
    r"|(?!(?:the\s+)?(?:robot|arm|gripper|hand)\b)(?:(?:the|this|that|my|our)\s|[a-z]+\s+\w*\d)"
    r"(?:(?!\b(?:that|which|who|where|what|wherever|whichever|whatever|if)\b)[^,;:.!?]){0,60}?"
    r"\s(?:suits|fits|holds|contains|is\s+where|is\s+(?:\w+\s+)?(?:free|empty|enough|suitable)\s+for)\b)" + _ONE_CLAUSE,
    re.IGNORECASE,
)
_COURTEOUS = re.compile(
    r"^\W*(?:good\s+)?(?:morning|afternoon|evening|day|hello|hi|hey|hiya|cheers|ta|thanks|thank\s+you|please|surprise\s+me|much\s+obliged|bye|ciao)"
    r"(?:\W+(?:a\s+(?:lot|million|bunch)|(?:ever\s+so|so|very|too)\s+much|mate|love|dear|robot|there|all|everyone|everybody|again|kindly|you|in\s+advance|then|sir"
    r"|my\s+(?:dear|friend)|young\s+man|buddy|pal))*[\s,.!?]*$",
    re.IGNORECASE,
)
_STANDING = frozenset({"stand", "sit", "lie", "rest", "fit", "suit", "hang", "lean"})
_UNDUE = frozenset({"fit", "suit", "look"})
"""What no robot can see to: it is so or it is not."""
STATIVE = _UNDUE | {"stands", "sits", "lies", "rests", "hangs", "leans", "looks", "fits", "suits"}
"""Said of a thing, these tell how it is."""
_PERHAPS = frozenset({"would", "could", "might", "may", "can"})
_LINKS = frozenset({
    "go", "goes", "belong", "belongs", "be", "being", "is", "are", "end", "ends", "has", "have", "had", "need", "needs",
    "should", "must", "shall", "will", "can", "ought", "come", "comes", "stand", "sit", "lie", "lying", "standing",
    "sitting", "placed", "put", "set", "moved", "brought", "want", "wants", "live", "deserve", "deserves", "use",
    "destination", "switch", "id", "due", "get", "gets", "getting",
})  # fmt: skip
"""Words by which a thing comes to its place in a sentence without a verb that puts it there."""
_OBLIGED = frozenset({"must", "shall", "should"})
_OBLIGED_TO = frozenset({"has", "have", "needs", "need", "ought", "wants", "want", "is", "are"})


def asks_a_fact(text: str) -> bool:
    """Whether a step is a question for information, and no order in the form of one ("could you ...?")."""
    return _ASKS.match(text) is not None


def states_a_fact(text: str) -> bool:
    """Whether a step, one clause, says what is seen, known, liked or there, and orders nothing."""
    return _STATES.match(text) is not None


def courteous(text: str) -> bool:
    """Whether a step only greets or thanks."""
    return _COURTEOUS.match(text) is not None


def describes(text: str, action: Extent, subject: int) -> bool:
    """Whether the action of a clause says how a thing named before it (from `subject`) is, or might be: "object 2
    stands on position 34", "... would fit on position 34"; "should stand" asks for it."""
    if subject >= action.start:
        return False
    said = action.cut(text).casefold()
    lead = [t.text for t in tokens(text, subject, action.start)][-1:]
    stands = not _STANDING.isdisjoint(lemmas(said))
    return stands and (said not in _STANDING or bool(set(lead) & _PERHAPS) or said in _UNDUE)


def predicate(text: str, start: int, end: int, scene: Scene) -> str:
    """A word of text[start:end], between a thing and a place, that says something else of the thing than that it goes
    there ("might be *better* on"); empty where there is none. What it has to do there ("has to *sleep* at") is an order
    to bring it there, whatever it is."""
    line = tokens(text, start, end)
    for i, t in enumerate(line):
        known = t.text in _LINKS or t.text in lexicon().known or t.text in lexicon().sizes or t.text.endswith("est")
        named = any(w.text and not w.corrected for w in (scene.word(t, True), scene.word(t, False)))
        if t.word and t.number is None and len(t.text) > 1 and not known and not named and not _obliged(line[: i + 1]):
            return t.text
    return ""


def _obliged(line: Sequence[Token]) -> bool:
    """Whether the words before the last one, a verb, make a duty of it: "must", "has to"."""
    *lead, verb = (t.text for t in line)
    duty = lead[-1:] and (lead[-1] in _OBLIGED or (lead[-1] == "to" and not _OBLIGED_TO.isdisjoint(lead[-2:-1])))
    return bool(duty) and verb not in _UNDUE
