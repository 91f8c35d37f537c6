"""Words that tell one thing from others and that no map can check: "my usual drink", "the one Marta told you about"."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from llmbt_compiler.checking.sentences import sentence_at
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import relations
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["REMEMBERED", "along", "entered", "hearsay", "uncheckable"]

REMEMBERED = frozenset({
    "usual", "favourite", "favorite", "regular", "normal", "preferred", "special", "promised", "ordered", "agreed",
    "discussed", "mentioned", "certain", "particular", "requested", "reserved", "chosen", "previous", "correct",
    "customary", "designated",
})  # fmt: skip
_FELT = frozenset({
    "chipped", "scratched", "cracked", "dented", "damaged", "broken", "faulty", "defective", "dirty", "dusty", "clean",
    "stained", "worn", "faded", "shiny", "sticky", "wet", "old", "older", "oldest", "new", "newer", "newest", "heavy",
    "heavier", "heaviest", "good", "best", "better", "nice", "nicer", "nicest", "pretty", "prettier", "prettiest",
    "cheap", "cheaper", "cheapest", "expensive", "wrong", "proper", "mended", "repaired", "marked", "lucky",
    "cancelled",
    "sold", "paid", "hollow", "freshly", "painted", "lightest", "lighter", "scuffed", "bent", "loved", "important",
    "urgent", "dearer", "dearest",
})  # fmt: skip
_MEMORY = frozenset({
    "yesterday", "always", "usually", "told", "asked", "mentioned", "earlier", "promised", "ordered", "wanted",
    "discussed", "recommended", "like", "love", "prefer", "agreed", "week", "month", "morning", "said", "left",
    "forgot", "forgotten", "bought", "brought", "got", "had", "saw", "used", "found", "lent", "borrowed", "dropped",
    "put", "gave", "showed", "shown", "talked", "talking", "spoke", "speaking", "thinking", "thought", "complained",
    "praised", "noticed", "liked", "loved", "picked", "chose", "hid", "meant", "mean", "needed", "received",
    "selected", "started", "paid", "stole", "won", "made", "lost", "misplaced", "mislaid", "sent", "treated", "ago",
    "tonight", "last", "today",
})  # fmt: skip
_ABOUT = frozenset({"lying", "standing", "sitting", "about", "around", "somewhere"})
"""How a thing is left, and not where: "that I left lying about"."""
_WHO = frozenset({"i", "we", "she", "he", "they", "you", "somebody", "someone"})
_OPENING = frozenset({"that", "which", "who", "whose", "with", "you", "i", "we", "she", "he", "they", "nobody", "for"})
_SIDES = frozenset({
    "left", "right", "front", "back", "rear", "middle", "top", "bottom", "end", "corner", "edge", "above", "below",
    "under", "behind", "beside", "between", "near", "next", "far", "there", "here", "down", "up", "alone", "itself",
    "same", "other", "others", "than", "rest", "both", "neighbour", "neighbor", "nothing", "nobody", "row", "side",
    "on", "in", "at", "from", "off", "is", "has", "stands", "sits", "lies", "standing", "lying", "sitting", "by", "as",
    "most", "least", "out", "isnt", "hasnt", "doesnt", "didnt", "isn", "still", "already", "yet",
})  # fmt: skip
_STOPS = frozenset({
    ",", ".", ";", ":", "!", "?", "-", "onto", "into", "to", "goes", "should", "must", "belongs", "needs", "shall",
    "and", "gets", "wants", "please", "has", "ought", "can", "could", "would", "will",
})  # fmt: skip
_SIDE_NOUNS = frozenset({"side", "edge", "row", "column", "line", "end", "front", "back", "middle", "left", "right"})
_ENTERING = frozenset({"stands", "sits", "lies", "standing", "sitting", "lying", "waits", "rests"})
"""Words before a phrase by which its sentence has said where the thing is: "at the left end stands a box"."""
_ENDMOST = frozenset({"left", "right", "end", "front", "back", "rear", "middle", "leftmost", "rightmost", "corner"})
_LONGEST = 12


def hearsay(words: Sequence[Token], at: int, scene: Scene) -> bool:
    """Whether an adjective stands here that tells something that no map says: what is usual, promised, or, of things
    that have nothing but numbers, how they look or feel. Knowledge of the world may tell what a hot drink is."""
    text = words[at].text
    return text in REMEMBERED or (text in _FELT and _numbered(scene))


def uncheckable(words: Sequence[Token], at: int, scene: Scene, *, opened: bool = False) -> bool:
    """Whether the clause that begins here tells a thing by nothing that the map has: "that Marta told you about", "I
    used yesterday"; not "that is nearer to the front". `opened`: a word before it has opened it ("whatever")."""
    if at >= len(words) or (words[at].text not in _OPENING and not opened):
        return False
    stop = at + 1
    while stop < min(len(words), at + _LONGEST) and words[stop].text not in _STOPS and not _leads(words, stop, scene):
        stop += 1
    clause = [t for t in words[at:stop] if t.text not in _ABOUT]
    said = {t.text for t in clause[1:]}
    if any(a.text in _WHO and b.text == "left" for a, b in pairwise(clause)):
        said = said - {"left"} | {"forgot"}  # "that I left lying about"
    if len(clause) < 3 - opened or said & _SIDES or relations(clause) or any(_checked(t, scene) for t in clause[1:]):
        return False
    if words[at].text == "for" or opened:
        return bool(said & _MEMORY)
    return _numbered(scene) or bool(said & _MEMORY)


def along(words: Sequence[Token], at: int) -> bool:
    """ "Down the left-hand side of it", "along the edge", "in the front row": a side that tells, and no destination."""
    said = [t.text for t in words[at : at + 7]]
    side = next((k for k, w in enumerate(said) if w in _SIDE_NOUNS), 0)
    if not side or any(not t.word and t.text != "-" for t in words[at : at + side]):
        return False
    return said[0] in {"down", "along"} or (said[0] in {"in", "from", "of"} and said[side] in {"row", "column"})


def entered(words: Sequence[Token], i: int) -> bool:
    """Whether its sentence has told by a side where the thing stands that a phrase names only then: "right at the
    right-hand end, stands a box"."""
    before = words[sentence_at(words, i)[0] : i]
    return bool(before) and before[-1].text in _ENTERING and any(t.text in _ENDMOST for t in before)


def _leads(words: Sequence[Token], at: int, scene: Scene) -> bool:
    """Whether a place follows: "... on 12", "... in the sorting area"."""
    if not lexicon().is_(words[at].text, "at") or at + 1 >= len(words):
        return False
    k = at + 1 + int(lexicon().is_(words[at + 1].text, "articles"))
    while k + 1 < len(words) and (words[k].text in _SIDES or words[k].text in lexicon().ordinals):
        k += 1
    return k < len(words) and (words[k].digits or bool(scene.word(words[k], False).text))


def _numbered(scene: Scene) -> bool:
    return all(e.number is not None for e in scene.objects)


def _checked(t: Token, scene: Scene) -> bool:
    lex = lexicon()
    if t.number is not None or t.text in lex.sizes or t.text in lex.ordinals or t.text in scene.colours:
        return True
    if lex.is_(t.text, "negation", "except", "vacant"):
        return True
    return any(w.text and not w.corrected for w in (scene.word(t, True), scene.word(t, False)))
