"""What a request orders in so many words, and no action of the library does: "wipe the table"."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from llmbt_atl.library import Library
from llmbt_compiler.checking.sentences import ENDS, one_line, sentence_at, span_of
from llmbt_compiler.parsing.words import Token, lexicon, tokens
from llmbt_ir.diagnostics import Diagnostic

__all__ = ["unable"]

_CARRYING = frozenset({
    "throw", "toss", "unpack", "lean", "share", "hide", "call", "ring", "light", "sell", "buy", "steal", "assemble",
    "disassemble", "paste", "fill", "flip",
})  # fmt: skip
"""Verbs of the lexicon's `other` that may mean that a thing is brought somewhere."""
_MORE = frozenset({
    "open", "weigh", "butter", "photograph", "charge",
})  # fmt: skip
_SETTLING = frozenset({"fix", "repair"})
_TURNING = frozenset({"turn", "rotate", "spin", "swivel", "twist", "flip", "tilt"})
_WHOLE = frozenset({"round", "around", "over", "upside", "sideways", "degrees", "clockwise", "back", "label", "face"})
_POINTING = frozenset({"it", "that", "this"})
_TAKING_BACK = frozenset(
    {"scratch", "strike", "scrap", "forget", "ignore", "cancel", "cross", "delete", "erase", "hold"}
)
"""Said of what was just said, "scratch that", and of no thing."""
"""What is said before: "position 12 should have a block in it; fix that"."""
_BEFORE = frozenset({"and", "then", "please", "also", "you", "just", "pls", "first", "to"})
_MARKS = ENDS | {":", ","}
_OBJECT = frozenset({
    "the", "it", "them", "my", "a", "an", "some", "me", "us", "both", "all", "each", "every", "this", "that", "these",
    "those", "object", "objects", "one", "up", "everything", "two",
})  # fmt: skip
_OTHERS = frozenset({"i", "im", "ill", "we", "she", "he", "they", "weve", "ive", "who", "want", "going"})


def unable(request: str, library: Library) -> Iterator[Diagnostic]:
    """E144 for each verb in the imperative, or after "you" and "and", that brings nothing anywhere and is none of
    the library's, where it has an object and the user is not who does it."""
    line = one_line(request)
    words = tokens(line)
    known = {w for t in library.templates.values() for w in (*t.verbs, *t.words.split())}
    verbs = ((lexicon().verbs["other"] - _CARRYING) | _MORE) - known
    for i, t in enumerate(words[:-1]):
        switched = t.text in {"turn", "switch"} and words[i + 1].text in {"on", "off"}
        turned = t.text in _TURNING and t.text not in known and _has_object(words, i)
        tidied = t.text == "clean" and words[i + 1].text == "up"
        has_object = t.text in verbs and words[i + 1].text in _OBJECT and not tidied
        settles = t.text in _SETTLING and words[i + 1].text in _POINTING
        if settles or _takes_back(words, i):
            continue
        if (has_object or turned or (switched and t.text not in known)) and _is_ordered(words, i):
            can = ", ".join(t.name for t in library.templates.values() if t.verbs)
            title = f"the request asks to `{t.text}`, and nothing that the robot can do does that"
            yield Diagnostic("E144", title, span_of((t,), line), "cannot be done", f"it can {can}")


def _has_object(words: Sequence[Token], i: int) -> bool:
    """Whether something is turned: "turn the red one round", "rotate object 3 by ninety degrees"."""
    _, stop = sentence_at(words, i)
    return words[i + 1].text in _OBJECT and any(t.text in _WHOLE for t in words[i + 2 : stop])


def _takes_back(words: Sequence[Token], i: int) -> bool:
    """ "Scratch that", at the end of what is said: a correction and no order."""
    end = i + 2 >= len(words) or not words[i + 2].word
    return words[i].text in _TAKING_BACK and words[i + 1].text == "that" and end


def _is_ordered(words: Sequence[Token], i: int) -> bool:
    begin, _ = sentence_at(words, i)
    begin = max((k + 1 for k in range(begin, i) if words[k].text == ":"), default=begin)
    before = [t.text for t in words[begin:i]]
    if lexicon().function["negation"] & set(before) or lexicon().function["conditional"] & set(before):
        return False
    if not before:
        return True
    said = max((k for k, w in enumerate(before) if w == "you"), default=-1)
    others = max((k for k, w in enumerate(before) if w in _OTHERS), default=-1)
    if others > said or "so" in before or "that" in before or "which" in before:
        return False
    return before[-1] in _MARKS or (before[-1] in _BEFORE and (before[-1] != "to" or said >= 0))
