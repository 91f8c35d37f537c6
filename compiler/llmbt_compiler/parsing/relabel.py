"""Steps relabelled before they are read, where their form or the map's names say more than the tagger does: calls of a
program, notes without a verb, names that a keyword cuts.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace

from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing.beside import mentions
from llmbt_compiler.parsing.doubts import put_right
from llmbt_compiler.parsing.forms import (
    asked_for,
    assured,
    filled,
    left_free,
    let_go,
    listed,
    made_free,
    once_more,
    place_of_its_own,
    told_as_placing,
    wanted_by,
)
from llmbt_compiler.parsing.frames import as_before, contrasted, one_each, passive, renamed, so_there, tabled, trimmed
from llmbt_compiler.parsing.headings import from_to, in_turn, named_by_heading
from llmbt_compiler.parsing.model import LabelledStep
from llmbt_compiler.parsing.names import exactly_named
from llmbt_compiler.parsing.polite import outspoken
from llmbt_compiler.parsing.repairs import mended
from llmbt_compiler.parsing.rewording import reworded
from llmbt_compiler.parsing.rows import given, rows
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.scoped import scoped
from llmbt_compiler.parsing.together import (
    also_named,
    done_by,
    headed_by_things,
    inverted,
    of_those,
    parted,
    placed_there,
    released,
    same_noun,
    whole_with_colour,
)
from llmbt_compiler.parsing.told import destined, due, goings, record, vice_versa
from llmbt_compiler.parsing.verbs import read_verb
from llmbt_compiler.parsing.whereabouts import by_their_things, in_its_stead
from llmbt_compiler.parsing.wishes import wished
from llmbt_compiler.parsing.words import lexicon, tokens

__all__ = ["relabelled"]

_LONGEST = 2000


def relabelled(step: LabelledStep, scene: Scene) -> LabelledStep:
    """The step with the keywords that its form implies; as it is where its form implies none."""
    if len(step.text) > _LONGEST:
        return step
    step = in_its_stead(put_right(step), scene)
    table = tabled(step, scene)
    if table is not None:
        return table
    step = scoped(trimmed(left_free(one_each(renamed(outspoken(step), scene)))), scene)
    step = reworded(contrasted(so_there(passive(as_before(step, scene), scene), scene), scene))
    told = from_to(step, scene)
    if told is not None:
        return told
    step = named_by_heading(in_turn(step))
    called = _calls(step, scene)
    if called is not None:
        return called
    for form in (record, vice_versa, destined, goings, due, rows, given, wished, once_more):
        told = form(step, scene)
        if told is not step:
            return told
    told = listed(step, scene) or told_as_placing(inverted(step, scene), scene)
    if told is not step:
        return told
    step = let_go(
        place_of_its_own(
            made_free(filled(assured(wanted_by(asked_for(step, scene), scene), scene), scene), scene), scene
        )
    )
    if not scene.snap:
        return step
    step = by_their_things(_whole_names(_nouns_for_verbs(mended(step, scene), scene), scene), scene)
    step = headed_by_things(
        parted(released(done_by(of_those(whole_with_colour(same_noun(step), scene), scene), scene), scene), scene),
        scene,
    )
    return also_named(placed_there(step, scene), scene)


# --- calls ----------------------------------------------------------------------------------------------------------

_CALL = re.compile(r"(?:[A-Za-z]\w*\.)?(?P<verb>[A-Za-z]\w*)\s*\((?P<args>[^()]*)\)")
_ARGUMENT = re.compile(r"(?:\w+\s*[=:]\s*)?[\"'`]?(?P<name>[^\"'`,>→]*[^\"'`,>→\s=-])[\"'`]?\s*")
_BETWEEN = re.compile(r"[\s\d;,.>→-]*(?:and|then)?[\s;,.>→-]*")


def _calls(step: LabelledStep, scene: Scene) -> LabelledStep | None:
    """ "pick(object_1); place(object_1, position_12)": each name an action, its arguments by what they are."""
    found = list(_CALL.finditer(step.text))
    edges = [0, *(e for m in found for e in m.span()), len(step.text)]
    outside = zip(edges[::2], edges[1::2], strict=True)
    if not found or not all(_BETWEEN.fullmatch(step.text, a, b) for a, b in outside):
        return None
    spans: list[KeywordSpan] = []
    for m in found:
        spans.append(KeywordSpan(*m.span("verb"), Kind.ACTION, _verb_of(m["verb"], scene)))
        spans += _arguments(step.text, *m.span("args"), scene)
    return replace(step, spans=tuple(spans), readings=())


def _verb_of(name: str, scene: Scene) -> str:
    """The name of a call, or of a condition ("On(object_1, position_11)") the verb that brings it about."""
    if read_verb(name, (), scene.library).templates:
        return name
    for t in scene.library.templates.values():
        for p in t.post:
            if p.name.casefold() == name.casefold() and scene.library.conditions[p.name].goal and t.verbs:
                return str(t.verbs[0])
    return name


def _arguments(text: str, start: int, end: int, scene: Scene) -> Iterator[KeywordSpan]:
    """Things are targets; the last place is where they go, one before it where they are."""
    names: list[tuple[int, int, bool]] = []
    at = start
    for part in re.split(r",|>|→", text[start:end]):
        m = _ARGUMENT.search(text, at, at + len(part))
        if m is not None and m["name"].strip():
            a, b = m.span("name")
            known = exactly_named(tokens(text, a, b), scene.places) if tokens(text, a, b) else ()
            names.append((a, b, bool(known)))
        at += len(part) + 1
    places = sum(place for _, _, place in names)
    for i, (a, b, place) in enumerate(names):
        kind = Kind.DESTINATION if place or (i and not places) else Kind.TARGET
        if place and places > 1 and i < len(names) - 1:
            kind = Kind.LOCATION
        yield KeywordSpan(a, b, kind, text[a:b])


# --- verbs and nouns -------------------------------------------------------------------------------------------------


def _nouns_for_verbs(step: LabelledStep, scene: Scene) -> LabelledStep:
    """An action that is no verb and names a thing of the scene ("Milk to the user") is a target."""
    own = scene.vocabulary(True)

    def label(s: KeywordSpan) -> KeywordSpan:
        word = s.text.casefold()
        if s.label is not Kind.ACTION or (word not in own and word not in scene.colours):
            return s
        verb = read_verb(word, (), scene.library)
        known = (verb.templates or verb.classes) and not verb.corrected
        return s if known else replace(s, label=Kind.TARGET)

    return replace(step, spans=tuple(label(s) for s in step.spans))


# --- names that a keyword cuts --------------------------------------------------------------------------------------


def _whole_names(step: LabelledStep, scene: Scene) -> LabelledStep:
    """A keyword that covers a part of a name is the whole of it, where nothing else is labelled there."""
    spans = sorted(step.spans, key=lambda s: s.start)
    for first, last in mentions(tokens(step.text), scene):
        touched = [s for s in spans if s.start < last.end and first.start < s.end]
        kinds = {s.label for s in touched}
        if not touched or len(kinds) > 1 or kinds == {Kind.ACTION}:
            continue
        start, end = min(first.start, touched[0].start), max(last.end, touched[-1].end)
        if len(touched) == 1 and (start, end) == (touched[0].start, touched[0].end):
            continue
        if first.text == "a" or (lexicon().is_(last.text, "articles") and not step.text[last.start].isupper()):
            continue
        whole = replace(
            touched[0], start=start, end=end, text=step.text[start:end], confidence=min(s.confidence for s in touched)
        )
        spans = sorted([*(s for s in spans if s not in touched), whole], key=lambda s: s.start)
    return replace(step, spans=tuple(spans))
