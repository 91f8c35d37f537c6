"""What a request wants done in so many words, and no action of the library does: "wipe the table", "once you have
heated the tea", "I'd like the bread sliced"."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache

from llmbt_atl.library import Library
from llmbt_compiler.checking.sentences import ENDS, one_line, sentence_at, span_of
from llmbt_compiler.checking.wording import base_of, listed, phrase_at
from llmbt_compiler.parsing.words import Token, lexicon, singulars, tokens
from llmbt_ir.diagnostics import Diagnostic
from llmbt_ir.semantic_map import MapObject, MapPlace, SemanticMap

__all__ = ["unable"]

_SETTLING = frozenset({"fix", "repair"})
_TURNING = frozenset({"turn", "rotate", "spin", "swivel", "twist", "flip", "tilt"})
_WHOLE = frozenset({"round", "around", "over", "upside", "sideways", "degrees", "clockwise", "back", "label", "face"})
_POINTING = frozenset({"it", "that", "this"})
_TAKING_BACK = frozenset(
    {"scratch", "strike", "scrap", "forget", "ignore", "cancel", "cross", "delete", "erase", "hold"}
)
"""Said of what was just said, "scratch that", and of no thing."""
_BEFORE = frozenset({"and", "then", "please", "also", "you", "just", "pls", "first", "to", "so"})
_MARKS = ENDS | {":", ",", "-"}
_OBJECT = frozenset({
    "the", "it", "them", "my", "a", "an", "some", "me", "us", "both", "all", "each", "every", "this", "that", "these",
    "those", "object", "objects", "one", "up", "everything", "two",
})  # fmt: skip
_OTHERS = frozenset({"i", "im", "ill", "we", "she", "he", "they", "weve", "ive", "who", "want", "going"})
_PERSONS = frozenset({
    "i", "im", "ill", "id", "ive", "we", "were", "well", "wed", "weve", "she", "he", "they", "who", "somebody",
    "someone", "shes", "hes", "theyve", "everybody",
})  # fmt: skip
_AWAITED = frozenset({"ensure", "sure", "see", "once", "when", "after", "until", "before", "soon"})
_BEING = frozenset({"be", "is", "been", "gets", "get", "being", "are"})
_COMING = frozenset({"will", "going", "about", "could", "may", "might", "can"})
_ARTICLES = frozenset({"the", "a", "an", "my", "our", "your", "his", "her", "their", "some"})
_WISHING = frozenset({"like", "want", "need", "prefer", "have", "get", "love", "wish", "bring", "fetch", "give", "hand",
                      "serve", "pass", "with", "brought", "served", "delivered", "handed", "fetched"})  # fmt: skip
_LEADING = frozenset({"after", "before", "by", "needs", "need", "wants", "requires", "to", "on", "upon", "than",
                      "start", "begin", "includes", "including"})  # fmt: skip
_ENDING = frozenset({"and", "then", "before", "first", "please", "for", "when", "on", "to", "in", "into", "at", "with",
                     "until", "so", "up", "open", "or", "by", "beforehand", "as"})  # fmt: skip
_DONE = frozenset({"already", "yesterday", "earlier", "ago", "previously", "was", "were"})
_RELATIVE = frozenset({"that", "which", "thats"})
_JOBS = frozenset({"job", "task", "step", "first", "next", "duty", "assignment"})


@cache
def _verbs() -> frozenset[str]:
    return (lexicon().verbs["other"] - listed("abilities", "carrying")) | listed("abilities", "more")


def unable(request: str, semantic_map: SemanticMap, library: Library) -> Iterator[Diagnostic]:
    """E144 for each verb that brings nothing anywhere and is none of the library's, where the robot is to do it: in the
    imperative or after "you" and "and", with an object; in a form that says what is to be done with a thing ("should be
    peeled", "after peeling", "the apple, peeled"). Not where the user, or somebody else, is who does it, and no noun of
    the map's names in such a form ("screws on berth L")."""
    line = one_line(request)
    words = tokens(line)
    known = frozenset(w for t in library.templates.values() for w in (*t.verbs, *t.words.split()))
    places = _nouns(semantic_map.places)
    nouns = places | _nouns(semantic_map.objects)
    for i, t in enumerate(words):
        if _excused(words, i):
            continue
        ordered = _quarter_turn(words, i) or _orders(words, i, known) or _lets(words, i, known) or _state(words, i)
        named = not nouns.isdisjoint(singulars(t.text))
        article = i > 0 and words[i - 1].text in _ARTICLES  # "let the sugar and the tin trade places"
        ordered = ordered and not (named and (t.text in places or article))  # "bin it", where there is a bin
        verb = t.text if ordered else None if named else _done_to_a_thing(words, i, known)
        if verb is not None:
            can = ", ".join(t.name for t in library.templates.values() if t.verbs)
            title = f"the request asks to `{verb}`, and nothing that the robot can do does that"
            yield Diagnostic("E144", title, span_of((t,), line), "cannot be done", f"it can {can}")


def _nouns(things: Sequence[MapObject | MapPlace]) -> frozenset[str]:
    return frozenset(t.text for thing in things for name in (thing.id, thing.name) for t in tokens(name) if t.word)


def _excused(words: Sequence[Token], i: int) -> bool:
    """ "I'd ask you to pour me a cup, but that's beyond you": the user knows that it cannot be done."""
    begin, end = sentence_at(words, i)
    said = [t.text for t in words[begin:end]]
    but = said.index("but") if "but" in said else 0
    after = [said[k : k + 2] for k in range(but, len(said))] if but > i - begin else []
    return any(pair in (["beyond", "you"], ["you", "cant"], ["you", "cannot"], ["not", "able"]) for pair in after)


def _orders(words: Sequence[Token], i: int, known: frozenset[str]) -> bool:
    """ "Wipe the table", "turn it round", "switch on the lamp"."""
    if i + 1 >= len(words):
        return False
    text, after = words[i].text, words[i + 1].text
    switched = text in {"turn", "switch"} and (after in {"on", "off"} or _off(words, i)) and text not in known | {"on"}
    turned = text in _TURNING and text not in known and _has_object(words, i)
    tidied = text == "clean" and after == "up"
    has_object = text in _verbs() - known and after in _OBJECT and not tidied
    settles = text in _SETTLING and after in _POINTING
    if settles or _takes_back(words, i) or phrase_at(words, i, "abilities", "idioms"):
        return False
    return (has_object or turned or switched) and _is_ordered(words, i)


def _off(words: Sequence[Token], i: int) -> bool:
    """ "Switch the telly off"."""
    after = [t.text for t in words[i + 1 : i + 5]]
    return after[:1] != [] and after[0] in _ARTICLES and "off" in after[2:]


def _quarter_turn(words: Sequence[Token], i: int) -> bool:
    """ "Object 5 needs a quarter turn", "ninety degrees clockwise"."""
    said = [t.text for t in words[max(0, i - 2) : i + 1]]
    begin, end = sentence_at(words, i)
    if lexicon().function["negation"] & {t.text for t in words[begin:end]}:
        return False
    return said[-1] in {"clockwise", "anticlockwise", "counterclockwise", "degrees"} or (
        said[-1] == "turn" and said[-2:-1] in (["quarter"], ["half"], ["full"])
    )


def _lets(words: Sequence[Token], i: int, known: frozenset[str]) -> bool:
    """ "Let it cool", "give object 6 a good clean"."""
    begin, _ = sentence_at(words, i)
    before = [t.text for t in words[begin:i]]
    verbs = _verbs() - known - listed("abilities", "enjoying") | {"clean"}
    if words[i].text not in verbs or lexicon().function["negation"] & set(before):
        return False
    let = next((k for k in range(len(before) - 1, max(-1, len(before) - 6), -1) if before[k] == "let"), None)
    if let is not None and let < len(before) - 1:
        return not {"me", "us", "my", "you", "to", ",", "be", "and"} & set(before[let:])
    give = next((k for k, w in enumerate(before) if w in {"give", "giving"}), None)
    if give is None or not {"a", "another"} & set(before[-3:]) or {"me", "us", "him", "her"} & set(before[give:]):
        return False
    return len(before) - give > 2


def _state(words: Sequence[Token], i: int) -> bool:
    """ "Make sure the coke is cold": how a thing is to be, and no action makes it so."""
    begin, _ = sentence_at(words, i)
    before = [t.text for t in words[begin:i]]
    if words[i].text not in listed("abilities", "states") or not {"is", "gets", "are", "be"} & set(before[-3:]):
        return False
    told = [before[k : k + 2] for k in range(len(before))]
    sure = any(pair in (["make", "sure"], ["see", "that"], ["see", "to"]) for pair in told) or "ensure" in before
    return sure and not lexicon().function["negation"] & set(before)


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
    if before[-1] == "so" and before[-2:-1] in ([","], ["and"], ["-"]):
        return True  # "I want my tea hot, so heat it first"
    said = max((k for k, w in enumerate(before) if w == "you"), default=-1)
    others = max((k for k, w in enumerate(before) if w in _OTHERS), default=-1)
    if others > said or "so" in before or "that" in before or "which" in before:
        return False
    return before[-1] in _MARKS or (before[-1] in _BEFORE and (before[-1] != "to" or said >= 0))


def _done_to_a_thing(words: Sequence[Token], i: int, known: frozenset[str]) -> str | None:
    """The verb of "should be peeled", "after peeling the apple", "once you have heated it", "I'd like it sliced"."""
    text = words[i].text
    verb = base_of(text, _verbs())
    if verb is None or verb in known or text in known or not words[i].word:
        return None
    begin, end = sentence_at(words, i)
    clause = max((k + 1 for k in range(begin, i) if words[k].text in {",", ":", "but", "-"}), default=begin)
    before = [t.text for t in words[clause:i]]
    after = [t.text for t in words[i + 1 : end]]
    if lexicon().function["negation"] & set(before) or lexicon().function["conditional"] & set(before):
        return None
    if text == verb or not text.endswith("ing"):
        return verb if _participle(text, verb, before, after, [t.text for t in words[begin:i]]) else None
    if verb in listed("abilities", "enjoying") or _PERSONS & set(before[-3:]):
        return None  # "after eating the apple I want ..."
    led = before[-1:] and before[-1] in _LEADING and (before[-1] != "to" or before[-2:] == ["prior", "to"])
    if before[-2:-1] == ["and"] and led and before[-1] in {"need", "needs"}:
        return None  # "my hands are dirty and need washing"
    job = not before and after[:1] and after[0] in _OBJECT and _JOBS & set(after)
    return verb if led or job else None


def _participle(text: str, verb: str, before: Sequence[str], after: Sequence[str], said: Sequence[str]) -> bool:
    """Whether what is to be done is told by a participle, or by "you" and a verb in a clause of time."""
    you = next((k for k in range(len(before) - 1, -1, -1) if before[k] in {"you", "youve", "you'll"}), None)
    done = [w for w in before[(you or 0) + 1 :] if w not in {"have", "had", "do", "already", "just", "first"}]
    if you is not None and not done and (set(before[:you]) & {"once", "when", "after", "before", "soon", "until"}):
        return after[:1] != [] and after[0] in _OBJECT
    if text == verb and text not in {"cut", "split", "shut"}:
        return False
    if (
        _DONE & {*before[-4:], *after[:3]}
        or _RELATIVE & set(before[-2:])
        or ("by" in after[:3] and not {"by", "you"} <= set(after[:3]))
    ):
        return False
    if verb in listed("abilities", "telling"):
        return False
    if before[-1:] and before[-1] in _BEING:
        meant = _AWAITED & set(said[:-1]) or (before[-1] == "be" and not _COMING & set(before))
        return bool(meant) and not _PERSONS & set(before[-3:-1])
    ends = not after or not after[0].isalpha() or after[0] in _ENDING or after[0].endswith("ly")
    if (
        ends
        and said[: len(said) - len(before)][-1:] in ([","], ["but"])
        and set(before) <= {"once", "when", "first", "nicely", "well"}
    ):
        return True  # "the coke, chilled", "the block, once polished, ..."
    wished = bool(set(said) & _WISHING) and not (_PERSONS & set(before[-2:]))
    nominal = (len(before) > 1 and before[-1] not in _OBJECT - {"it", "them"}) or not before
    return ends and wished and nominal and not _relative(before)


def _relative(before: Sequence[str]) -> bool:
    """ "(Bring me) the milk my wife (opened)": who did it stands between, as a phrase of its own."""
    last = max((k for k, w in enumerate(before) if w in _ARTICLES), default=0)
    return len(before) - 3 <= last > 0 and before[last - 1] not in _WISHING | _ENDING | {
        "me",
        "us",
        "of",
        "all",
        "both",
        "having",
    }
