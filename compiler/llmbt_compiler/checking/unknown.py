"""Nouns of a request that nothing in the scene goes by: "the wine", "on the balcony".

The keywords of the request itself say what is a thing and what is a place to put it; a sort of things ("a drink") is no
name, and what a drink is takes knowledge of the world that the model has.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from llmbt_atl.library import Library
from llmbt_compiler.checking.points import OpenPoint
from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing import Goal, LabelledStep
from llmbt_compiler.parsing.mentions import mentioned_in
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import rank_of
from llmbt_compiler.parsing.words import Token, closest, distance, lexicon, singulars, tokens
from llmbt_ir.diagnostics import Diagnostic, Span
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["unknown_names", "unknown_place"]

_SORTS = frozenset({
    "drink", "beverage", "refreshment", "liquid", "sip", "snack", "food", "meal", "breakfast", "lunch", "dinner",
    "supper", "bite", "fruit", "sweet", "dessert", "treat", "grocery", "stuff", "content", "mess", "rest", "pile",
    "stack", "tower", "row", "column", "line", "order", "sequence", "set", "pair", "couple", "group", "collection",
    "bunch", "lot", "half", "kind", "sort", "type", "colour", "color", "size", "shape", "stock", "load", "freight",
    "remainder", "contents", "help", "favour", "favor", "hand", "way", "turn", "look", "time", "moment", "minute",
    "level", "side", "end", "corner", "edge", "middle", "centre", "center", "left", "right", "front", "back", "top",
    "bottom", "gap", "hole", "space", "room", "storage", "furniture", "surface", "ground", "floor", "air", "robot",
    "system", "scene", "world", "map", "arrangement", "layout", "instruction", "request", "plan", "job", "task",
    "thirst", "hunger", "appetite", "mood", "day", "morning", "evening", "night", "one", "ones", "fella", "guy",
    "bit", "part", "share", "choice", "selection", "option", "preference", "nothing", "none", "neighbour", "neighbor",
    "number", "letter", "name", "label", "discretion", "pick", "call", "judgement", "convenience", "leisure",
})  # fmt: skip
_TURNING = ("negation", "except", "instead", "conditional")
_FETCHING = frozenset({"me", "us", "bring", "fetch", "get", "grab", "want"})
_LEADING = _FETCHING | {"put", "place", "move", "take", "give", "in", "on", "into", "onto", "to", "inside"}
_CUPS = frozenset({"cup", "glass", "mug", "slice", "piece", "bowl", "plate", "portion", "bar"})
_THEM = frozenset({"her", "him", "them"})
_SEATS = frozenset({
    "armchair", "chair", "sofa", "couch", "bed", "wheelchair", "stool", "bench", "settee", "recliner", "rocker", "seat",
    "hammock", "jumper", "dress", "suit", "hat", "coat", "shirt", "sweater", "glasses",
})  # fmt: skip
"""What a person is in, and is no other place for that."""
_GOING_ON = frozenset({"please", "thanks", "over", "from", "on", "in", "for", "that", "which"})
_THE = frozenset({"the", "my", "your", "our", "a", "an", "some", "that", "this"})


def unknown_names(
    sentences: Sequence[LabelledStep], goals: Sequence[Goal], semantic_map: SemanticMap, library: Library
) -> Iterator[OpenPoint]:
    """E142 for each thing, and each place to put it, that is a noun after an article or after "bring me", where that
    noun is no word of the scene, no sort of things, and near to none of either. Its candidates are what the
    goals are about in its place. A sentence that denies, excepts or offers a choice is passed over."""
    scene = Scene(semantic_map, library)
    people = tuple(a for g in goals for a in g.condition.args if not scene[a].movable and scene[a].person)
    for sentence in sentences if people else ():
        away = _somewhere_else(tokens(sentence.text), scene)
        if away is not None:
            yield _lacking(sentence.text, away, people)
    said = {i for s in sentences for i in mentioned_in(s.text, scene)}
    for sentence in sentences:
        line = tokens(sentence.text)
        if any(t.text == "or" or lexicon().is_(t.text, *_TURNING) for t in line):
            continue
        for span in sentence.spans:
            noun = _noun(line, span, scene) if span.label in {Kind.TARGET, Kind.DESTINATION} else None
            if noun is not None:
                movable = span.label is Kind.TARGET
                about = dict.fromkeys(a for g in goals for a in g.condition.args if scene[a].movable == movable)
                if not movable and about and all(_addressed(a, sentences, scene) for a in about):
                    continue  # "our guest in the armchair"
                yield _lacking(sentence.text, noun, tuple(i for i in about if i not in said))


def _addressed(id_: str, sentences: Sequence[LabelledStep], scene: Scene) -> bool:
    """Whether a person is spoken of, however it is spelt: where she sits is then no place to put something."""
    words = (scene.word(t, False).text for s in sentences for t in tokens(s.text))
    return scene[id_].person and any(w and scene.fits(scene[id_], w) for w in words)


def _somewhere_else(words: Sequence[Token], scene: Scene) -> Token | None:
    """ "(Take it) to her in the garden": where somebody is, that the scene does not have; not what she sits on."""
    for k, t in enumerate(words[:-1]):
        before = words[k - 1].text if k else ""
        after = words[k + 1 : k + 5]
        if t.text in _THEM and before == "to" and after and lexicon().is_(after[0].text, "at"):
            away = unknown_place(after, scene)
            if away is not None and not {away.text, *singulars(away.text)} & _SEATS:
                return away
    return None


def unknown_place(words: Sequence[Token], scene: Scene) -> Token | None:
    """The noun of "in the fridge", "onto the windowsill", where nothing in the scene goes by it; for where no known
    place is named."""
    for i, t in enumerate(words[:-2]):
        noun, after = words[i + 2], words[i + 3] if i + 3 < len(words) else None
        if not lexicon().is_(t.text, "at", "onto") or words[i + 1].text not in {"the", "my", "our", "your", "that"}:
            continue
        goes_on = after is not None and after.word and after.text not in _GOING_ON | {"with", "and", "then", "now"}
        if noun.word and noun.number is None and not noun.owner and not goes_on and not _known(noun, scene):
            return noun
    return None


def _lacking(line: str, noun: Token, about: Sequence[str]) -> OpenPoint:
    taken = about[0] if len(about) == 1 else None
    title = f"the request names `{noun.text}`, and nothing in the scene goes by that name"
    label = f"the reply takes {taken} for it" if taken else "not in the map"
    span = Span("request", 1, noun.start + 1, noun.end + 1, line)
    hint = f"is {taken} right?" if taken else "say it in other words, or leave it out"
    return OpenPoint(Diagnostic("E142", title, span, label, hint, candidates=tuple(about)), taken)


def _noun(line: Sequence[Token], span: KeywordSpan, scene: Scene) -> Token | None:
    inside = [i for i, t in enumerate(line) if span.start <= t.start and t.end <= span.end]
    while inside and (lexicon().is_(line[inside[0]].text, "articles") or line[inside[0]].text in _THE):
        inside.pop(0)
    if not inside or inside[0] == 0:
        return None
    before = line[inside[0] - 1].text
    if inside[0] > 1 and line[inside[0] - 2].text in {"of", "like"}:
        return None  # "the colour of a lemon"
    if inside[0] > 1 and line[inside[0] - 2].text == "for" and not scene.persons:
        return None  # "line them up for the stocktake": nobody is there whom it could be for
    if before not in _THE and not (len(inside) == 1 and before in _FETCHING):
        return None
    of = next((k for k in inside if line[k].text == "of"), None)
    if of is not None and len(inside) == 3 and of == inside[1]:  # "bring me a cup of coffee"
        if inside[0] < 2 or line[inside[0] - 2].text not in _FETCHING:
            return None
        inside = [inside[2]] if lexicon().is_(line[inside[0]].text, "vessels") or line[inside[0]].text in _CUPS else []
    *modifiers, head = inside or [-1]
    if head < 0 or any(_is_name(line[k], scene) or line[k].text in lexicon().known for k in modifiers):
        return None
    if modifiers and (modifiers[0] < 2 or line[modifiers[0] - 2].text not in _LEADING):
        return None
    noun, after = line[head], line[head + 1] if head + 1 < len(line) else None
    ends = after is None or not (after.word or after.number is not None) or lexicon().is_(after.text, "joints", "onto")
    polite = after is not None and after.text in _GOING_ON
    if not noun.word or noun.number is not None or noun.owner or not (ends or polite):
        return None
    return None if _known(noun, scene) else noun


def _is_name(t: Token, scene: Scene) -> bool:
    """Whether a word before a noun is a name by itself ("the milk carton"), or no word at all."""
    if not t.word or t.number is not None or lexicon().is_(t.text, "at", "from", "onto", "joints"):
        return True
    word = scene.word(t, True).text or scene.word(t, False).text
    return bool(word) and word not in scene.colours and t.text not in lexicon().sizes


def _known(noun: Token, scene: Scene) -> bool:
    if noun.text in lexicon().known or any(scene.word(noun, m).text or scene.word(noun, m).near for m in (True, False)):
        return True
    if any(distance(noun.text, w) <= 1 for m in (True, False) for w in scene.vocabulary(m) if len(w) > 2):
        return True
    if noun.text in lexicon().sizes or rank_of((noun,), 0, 1) is not None:
        return True
    generic = _SORTS | frozenset(lexicon().ordinals) | lexicon().function["vessels"] | lexicon().function["users"]
    return any(form in generic for form in singulars(noun.text)) or bool(closest(noun.text, generic))
