"""Labels that the words around them belie, set right by what the lexicon and the map know: a verb at the head of a
clause that was not labelled, a word that is no verb and was, the subject of "... is to be placed on ..."."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.model import LabelledStep
from llmbt_compiler.parsing.names import Found, Talk, exactly_named
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.verbs import Shape, read_verb, shape_of
from llmbt_compiler.parsing.words import Token, lexicon, tokens

__all__ = ["mended"]

_ENDS = frozenset({".", ";", "!", "?", ":"})
_DASHES = frozenset({"-", "–", "—"})
_BE = frozenset({"be", "been", "being", "is", "are", "gets", "get", "got"})
_MODAL = frozenset({"should", "shall", "must", "will", "may", "to", "need", "needs", "ought", "can"})
_DENIED = frozenset({"neither", "nor", "no", "none"})
_BETWEEN = frozenset({
    "both", "all", "each", "also", "now", "then", "next", "first", "finally", "please", "therefore", "thus", "still",
    "only", "be", "to", "have", "has", "is", "are", "supposed", "meant", "due", "always", "eventually", "simply",
})  # fmt: skip
_NO_VERBS = frozenset({
    "quick", "quickly", "now", "ok", "okay", "right", "well", "so", "sorry", "hey", "hi", "hello", "alright", "fine",
    "great", "thanks", "first", "second", "secondly", "third", "thirdly", "next", "finally", "urgent", "done", "lastly",
    "firstly", "immediately", "then", "dear", "upright", "level", "steady", "horizontally", "vertically", "both",
    "lord", "reserved", "meant", "intended",
})  # fmt: skip
_EMPLOYING = frozenset({"use", "using", "utilise", "utilize", "employ"})
_BY = frozenset({"by", "with", "via", "using", "the", "a", "through"})
_MANNER = frozenset({
    "upright", "steady", "horizontally", "vertically", "slowly", "gently", "carefully", "quickly", "both", "safely",
    "securely", "softly", "firmly", "neatly", "smoothly", "straight", "swiftly",
})  # fmt: skip
_TITLES = frozenset(
    {"target", "object", "item", "thing", "task", "goal", "job", "step", "next", "destination", "part", "first"}
)
_STATING = frozenset(
    {"weighs", "weigh", "measures", "contains", "looks", "seems", "feels", "costs", "holds", "belongs", "consists"}
)
_PASSIVE = frozenset({"put", "set", "laid", "sent", "brought", "taken", "given", "held", "left"})
_BEFORE = re.compile(
    r"(?<=\w)\s*,?\s+before\s+(?P<verb>\w+ing)\s+(?P<thing>[^,;:.]{2,60}?)\s+(?:on|onto|to|into|in|at)\s+(?:the\s+)?(?P<place>[^,;:.]{2,60}?)"
    r"(?=\s*(?:[.;!]|$))",
    re.IGNORECASE,
)
_NP = 7


def mended(step: LabelledStep, scene: Scene) -> LabelledStep:
    """The step with the labels that its words bear out."""
    step = _listed_places(step, scene)
    step = _clear_of(_objects_of(_without_manners(_no_verbs(step, scene)), scene))
    step = _goings(_missed_verbs(step, scene), scene)
    return _subjects(_passives(_participles(_before(step, scene), scene), scene), scene)


def _objects_of(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Relocate | the going barrel": what stands right behind a verb, and names things and no place, is its object."""
    out: list[KeywordSpan] = []
    for s in step.spans:
        last = out[-1] if out else None
        behind = last is not None and last.label is Kind.ACTION and s.label is Kind.DESTINATION
        lead = tokens(step.text, last.end, s.start) if last is not None and behind else ()
        if behind and all(lexicon().is_(t.text, "articles") for t in lead):
            words = tokens(step.text, s.start, s.end)
            if exactly_named(words, scene.objects) and not exactly_named(words, scene.places):
                out.append(replace(s, label=Kind.TARGET))
                continue
        out.append(s)
    return replace(step, spans=tuple(out))


_CLEAR_OF = re.compile(
    r"\b(?:clear|free|out|away|off)\s+(?:of|from)\s+(?:(?:the|its|their|this|that)\s+)?$", re.IGNORECASE
)


def _listed_places(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "... in the test bay, the tool caddy and the damp box": what goes on a list of places by a place's name."""
    out: list[KeywordSpan] = []
    for s in step.spans:
        last = out[-1] if out else None
        listed = last is not None and last.label is Kind.DESTINATION and s.label is Kind.TARGET
        gap = [t.text for t in tokens(step.text, last.end, s.start)] if last is not None and listed else []
        joined = bool(gap) and all(w in {",", "and", "&"} or lexicon().is_(w, "articles") for w in gap)
        words = tokens(step.text, s.start, s.end) if joined else ()
        place = bool(words) and len(exactly_named(words, scene.places)) == 1
        known = isinstance(resolve_objects(words, scene, Talk()), Found) if place else True
        out.append(s if known else replace(s, label=Kind.DESTINATION))
    return replace(step, spans=tuple(out))


def _clear_of(step: LabelledStep) -> LabelledStep:
    """ "Lift it clear of the tray": where it was, and not where it goes."""
    spans = tuple(
        replace(s, label=Kind.LOCATION)
        if s.label is Kind.DESTINATION and _CLEAR_OF.search(step.text, max(0, s.start - 30), s.start)
        else s
        for s in step.spans
    )
    return replace(step, spans=spans) if spans != step.spans else step


def _with(step: LabelledStep, *spans: KeywordSpan) -> LabelledStep:
    return replace(step, spans=tuple(sorted((*step.spans, *spans), key=lambda s: s.start))) if spans else step


def _span(step: LabelledStep, start: int, end: int, kind: Kind) -> KeywordSpan:
    return KeywordSpan(start, end, kind, step.text[start:end])


def _cut(span: KeywordSpan, end: int) -> KeywordSpan:
    """A keyword up to an offset, without the blanks before it."""
    text = span.text[: max(0, end - span.start)].rstrip()
    return replace(span, end=span.start + len(text), text=text)


def _free(step: LabelledStep, start: int, end: int) -> bool:
    return not any(s.start < end and start < s.end for s in step.spans)


def _no_verbs(step: LabelledStep, scene: Scene) -> LabelledStep:
    """Without actions that are no verbs: "quick, the bread", "by camera"."""
    parts = tokens(step.text)

    def wrong(s: KeywordSpan) -> bool:
        word = s.text.casefold()
        if s.label is not Kind.ACTION:
            return False
        lead = next((t.text for t in reversed(parts) if t.end <= s.start), "")
        if lexicon().is_(word, "robot") and lead in _BY:
            return True
        after = [t.text for t in parts if t.start >= s.end and not lexicon().is_(t.text, "articles")]
        if word in _EMPLOYING and any(lexicon().is_(w, "robot") for w in after[:2]) and "to" in after[1:4]:
            return True  # "use the gripper to pick up ..."
        return word in _NO_VERBS and not read_verb(word, (), scene.library).templates

    kept = tuple(s for s in step.spans if not wrong(s))
    return replace(step, spans=kept) if len(kept) < len(step.spans) else step


def _without_manners(step: LabelledStep) -> LabelledStep:
    """Without targets that are adverbs ("slowly and upright"), and without a "both" at the end of one."""
    out: list[KeywordSpan] = []
    for s in step.spans:
        words = [t.text for t in tokens(step.text, s.start, s.end)]
        titled = step.text[s.end :].lstrip(" *_`").startswith(":")
        if s.label is Kind.TARGET and titled and words and set(words) <= _TITLES:
            continue
        if s.label is not Kind.ACTION and words and (set(words) <= _MANNER or words[0] in _STATING):
            continue
        if s.label is Kind.TARGET and len(words) > 1 and words[-1] in {"both", "all", "each"}:
            out.append(_cut(s, s.end - len(words[-1])))
        else:
            out.append(s)
    return replace(step, spans=tuple(out)) if tuple(out) != step.spans else step


def _missed_verbs(step: LabelledStep, scene: Scene) -> LabelledStep:
    """With the verbs that begin a clause behind a full stop, a dash or a comma and that were not labelled."""
    parts = tokens(step.text)
    if (
        parts
        and step.spans
        and all(s.label is not Kind.ACTION for s in step.spans)
        and _free(step, parts[0].start, parts[0].end)
    ):
        verb = read_verb(parts[0].text, (), scene.library)
        if verb.is_("checking") and verb.lemma == parts[0].text:  # "confirm by camera that ..."
            return _with(step, _span(step, parts[0].start, parts[0].end, Kind.ACTION))
    found = [
        _span(step, t.start, t.end, Kind.ACTION)
        for i, t in enumerate(parts)
        if i and _free(step, t.start, t.end) and _heads(step, parts, i) and _a_verb(parts, i, scene)
    ]
    return _with(step, *found)


def _heads(step: LabelledStep, parts: Sequence[Token], i: int) -> bool:
    """Whether a token begins a clause of its own."""
    before = parts[i - 1]
    dash = before.text in _DASHES and not before.glued and not parts[i].glued
    if before.text in _ENDS or dash:
        return any(s.label is Kind.ACTION for s in step.spans)
    then = before.text == "then" and i > 1 and (parts[i - 2].text in {",", ";", "and", "."} | _DASHES)
    joined = before.text == "," or then
    lead = {t.text for t in parts[:i]}
    orders = any(s.label is Kind.ACTION and s.end <= before.start for s in step.spans)
    return joined and orders and not any(lexicon().is_(w, "conditional", "negation") for w in lead)


def _a_verb(parts: Sequence[Token], i: int, scene: Scene) -> bool:
    """Whether a token is a verb of the library in its plain form, by what follows it."""
    word = parts[i]
    verb = read_verb(word.text, (), scene.library) if word.word and word.number is None else None
    if verb is None or verb.corrected or verb.lemma.split("_")[0] != word.text:
        return False
    if not (verb.templates or verb.is_("opening", "closing")):
        return False
    after = parts[i + 1] if i + 1 < len(parts) else None
    if after is None or after.text in _ENDS | {","}:
        return word.text not in scene.vocabulary(True) | scene.vocabulary(False) | lexicon().places
    lex = lexicon()
    begins = lex.is_(after.text, "articles", "pronouns", "plural_pronouns", "all", "both", "at", "onto", "particles")
    noun = scene.understood(after.text, True) or after.text in scene.colours
    return begins or (noun and word.text not in scene.vocabulary(False) | lexicon().places)


def _passives(step: LabelledStep, scene: Scene) -> LabelledStep:
    """With the participle of an order in the passive ("every block should be placed on level 2", "get stored")."""
    parts = tokens(step.text)
    for i in range(1, len(parts)):
        t, be = parts[i], parts[i - 1]
        if be.text not in _BE and i > 1 and be.text in _BETWEEN:
            be = parts[i - 2]
        if be.text not in _BE or not (t.text.endswith("ed") or t.text in _PASSIVE):
            continue
        lead = [p for p in parts[:i] if p.end <= be.start][-4:]
        ordered = be.text == "be" or be.text.startswith("get") or any(p.text in _MODAL for p in lead)
        if not ordered or any(lexicon().is_(p.text, "negation", "conditional", "subordinate") for p in lead[-3:]):
            continue
        if any(p.text in _DENIED for p in parts[:i]):
            continue
        verb = read_verb(t.text, (), scene.library)
        if verb.corrected or not verb.templates or verb.is_("idle"):
            continue
        touched = [s for s in step.spans if s.start < t.end and be.start < s.end]
        kept = [s for s in step.spans if s not in touched]
        kept += [_cut(s, be.start) for s in touched if s.start < be.start and s.label is not Kind.ACTION]
        kept.sort(key=lambda s: s.start)
        return _with(replace(step, spans=tuple(kept)), _span(step, t.start, t.end, Kind.ACTION))
    return step


def _before(step: LabelledStep, scene: Scene) -> LabelledStep:
    """With what is to be done next in "... before placing the red block on position 31"."""
    m = _BEFORE.search(step.text)
    verb = read_verb(m["verb"].casefold(), (), scene.library) if m is not None else None
    if m is None or verb is None or verb.corrected or not verb.templates or not _free(step, *m.span("verb")):
        return step
    things = resolve_objects(
        tokens(step.text, *m.span("thing")), scene, Talk({o.id: o.place for o in scene.map.objects})
    )
    where = resolve_places(tokens(step.text, *m.span("place")), scene, Talk())
    if not isinstance(things, Found) or not isinstance(where, Found) or things.corrected or where.corrected:
        return step
    kept = tuple(s for s in step.spans if s.end <= m.start() or m.end() <= s.start)
    kinds = (("verb", Kind.ACTION), ("thing", Kind.TARGET), ("place", Kind.DESTINATION))
    return _with(replace(step, spans=kept), *(_span(step, *m.span(k), kind) for k, kind in kinds))


def _participles(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "See the newspaper | conveyed to the table": a participle taken for a part of the name is what is done."""
    out: list[KeywordSpan] = []
    for s in step.spans:
        parts = tokens(step.text, s.start, s.end)
        last = parts[-1] if len(parts) > 1 else None
        had = out and out[-1].label is Kind.ACTION and out[-1].text.casefold() in {"see", "have", "get", "want"}
        if s.label is Kind.TARGET and last is not None and last.text in lexicon().verbs["exchange"] and out:
            out.append(_cut(s, last.start))  # "have A and B switch places"
            continue
        if s.label is Kind.TARGET and last is not None and had and last.text.endswith("ed"):
            verb = read_verb(last.text, (), scene.library)
            if verb.templates and not verb.corrected:
                end = parts[-2].end
                out[-1] = replace(s, end=end, text=step.text[s.start : end])
                out.append(_span(step, last.start, last.end, Kind.ACTION))
                continue
        out.append(s)
    return replace(step, spans=tuple(out)) if tuple(out) != step.spans else step


_GOING = frozenset({"go", "goes", "belong", "belongs", "come", "comes"})
_FINITE = frozenset({"goes", "belongs", "comes", "belong"})
_INTENDED = _MODAL | {"then", "now", "also", "just", "next", "finally", "later", "afterwards", "instead", "ought", "to"}
_WHITHER = frozenset(
    {"on", "onto", "in", "into", "at", "between", "beside", "behind", "next", "left", "right", "under"}
)


def _subject_of(step: LabelledStep, action: KeywordSpan) -> KeywordSpan | None:
    """The thing right before "goes" or "should go": what is to go there, and not the robot."""
    before = max((s for s in step.spans if s.end <= action.start), key=lambda s: s.end, default=None)
    if before is None or before.label is not Kind.TARGET or action.text.casefold() not in _GOING:
        return None
    between = [t.text for t in tokens(step.text, before.end, action.start)]
    told = all(w in _INTENDED for w in between) and (bool(_MODAL & set(between)) or action.text.casefold() in _FINITE)
    told = told or (not between and action.text.casefold() == "go")
    return before if told else None


def _pronoun_of(step: LabelledStep, action: KeywordSpan) -> KeywordSpan | None:
    """The unlabelled "it" right before "goes" or "should go"."""
    before = max((s.end for s in step.spans if s.end <= action.start), default=0)
    lead = list(tokens(step.text, before, action.start))
    while lead and lead[-1].text in _INTENDED:
        lead.pop()
    it = lead[-1] if lead and lead[-1].text in {"it", "they"} and action.text.casefold() in _GOING else None
    return _span(step, it.start, it.end, Kind.TARGET) if it is not None else None


def _goings(step: LabelledStep, scene: Scene) -> LabelledStep:
    """ "Fetch the tea, and the biscuits can go on the desk", "the red block should go between A and B": the thing is to
    be put there."""
    place = next(
        (t for t in scene.library.templates.values() if shape_of(t, scene.library) is Shape.PLACE and t.verbs), None
    )
    acts = [s for s in step.spans if s.label is Kind.ACTION]
    out: list[KeywordSpan] = []
    for s in step.spans:
        after = [t.text for t in tokens(step.text, s.end)]
        while after and (lexicon().is_(after[0], "particles") or after[0] in {"directly", "right", "over", "just"}):
            if after[0] == "right" and after[1:2] == ["of"]:
                break
            after.pop(0)
        related = after[:1] and (
            after[0] in _WHITHER - {"on", "onto", "in", "into", "at", "next", "beside"} or after[:2] == ["to", "the"]
        )
        told = s in acts and after[:1] and (after[0] in _WHITHER or after[0] == "to") and place is not None
        it = _pronoun_of(step, s) if told and s is not acts[0] else None
        if it is not None:
            out.append(it)
        said = it is not None or (told and (related or s is not acts[0]) and _subject_of(step, s) is not None)
        if said and place is not None:
            out.append(replace(s, text=str(place.verbs[0])))
        else:
            out.append(s)
    step = replace(step, spans=tuple(out)) if tuple(out) != step.spans else step
    for s in step.spans if acts and place is not None else ():
        goes, whither = (*tokens(step.text, s.end)[:2], None, None)[:2]
        if goes is None or whither is None or place is None or goes.text not in _FINITE or whither.text not in _WHITHER:
            continue
        if s.label is Kind.TARGET and s.start > acts[0].end and _free(step, goes.start, goes.end):
            return _with(step, KeywordSpan(goes.start, goes.end, Kind.ACTION, str(place.verbs[0])))
    return step


def _subjects(step: LabelledStep, scene: Scene) -> LabelledStep:
    """With the thing before "is to be placed" that was not labelled, where the clause has no other."""
    parts = tokens(step.text)
    spans = sorted(step.spans, key=lambda s: s.start)
    for k, action in enumerate(spans):
        plain = action.text.casefold() in {"live", "sleep", "sit", "stand", "rest", "reside"}
        done = action.text.endswith("ed") or action.text.casefold() in _PASSIVE or plain
        if action.label is not Kind.ACTION or not done:
            continue
        before = next((s for s in reversed(spans[:k]) if s.label is Kind.ACTION), None)
        begin = before.end if before is not None else 0
        after = next((s.start for s in spans[k + 1 :] if s.label is Kind.ACTION), len(step.text))
        if any(s.label is Kind.TARGET and begin <= s.start < after for s in spans):
            continue
        if not any(
            shape_of(t, scene.library) in {Shape.PLACE, Shape.PICK}
            for t in read_verb(action.text, (), scene.library).templates
        ):
            continue
        found = next(_named_before(parts, action.start, begin, scene), None)
        if found is not None and _free(step, found[0].start, found[-1].end):
            return _with(step, _span(step, found[0].start, found[-1].end, Kind.TARGET))
    return step


def _named_before(parts: Sequence[Token], at: int, begin: int, scene: Scene) -> Iterator[Sequence[Token]]:
    """The noun phrases right before the auxiliaries of a participle that name things."""
    lead = [t for t in parts if begin <= t.start and t.end <= at]
    end = len(lead)
    while end and (lead[end - 1].text in _BE | _MODAL | _BETWEEN):
        end -= 1
    if end == len(lead):
        return
    for size in range(min(_NP, end), 0, -1):
        words = lead[end - size : end]
        if not all(w.word or w.number is not None for w in words) or lexicon().is_(
            words[0].text, "onto", "at", "joints"
        ):
            continue
        if lexicon().is_(words[0].text, "articles") and size > 1:
            words = words[1:]
        found = resolve_objects(words, scene, Talk({o.id: o.place for o in scene.map.objects}))
        if isinstance(found, Found) and not found.corrected:
            yield words
