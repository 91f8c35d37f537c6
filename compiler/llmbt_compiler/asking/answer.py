"""Answers that name a candidate, settled here: the step is said again with the answer in it, and read anew."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from llmbt_atl.library import Library
from llmbt_compiler.asking.question import Asked, Slot
from llmbt_compiler.checking.spots import meant_places
from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing import LabelledStep
from llmbt_compiler.parsing.ledger import Ledger
from llmbt_compiler.parsing.mentions import mentioned_in
from llmbt_compiler.parsing.model import Extent
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import rank_of, relations
from llmbt_compiler.parsing.space.world import World
from llmbt_compiler.parsing.words import Token, lexicon, tokens
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["Edit", "choose", "edit_for", "edited"]

_MOST = 300
_SIDES = frozenset({"left", "right", "middle", "end", "leftmost", "rightmost", "corner"})
_POLITE = frozenset({
    "please", "thanks", "thank", "yes", "ok", "okay", "sure", "i", "mean", "meant", "want", "take", "use", "choose",
    "would", "like", "think", "say", "go", "with", "be", "it", "is", "was", "should", "put", "in", "on", "onto", "to",
    "at", "for",
})  # fmt: skip


@dataclass(frozen=True, slots=True)
class Edit:
    """Words for a step, by its number and its text: `text` stands for what is at `start` to `end` (nothing, where they
    are equal), as `kind`.

    `again`: the step is then tagged anew, since the words are the user's own.
    """

    step: LabelledStep
    start: int
    end: int
    text: str
    kind: Kind | None
    again: bool = False


def choose(answer: str, asked: Asked, semantic_map: SemanticMap, library: Library) -> tuple[str, ...]:
    """The candidates that an answer names; none where it names something else, or nothing plain."""
    line = " ".join(answer.split())[:_MOST]
    parts = tokens(line)
    while parts and (parts[0].text in _POLITE or not (parts[0].word or parts[0].number is not None)):
        parts = parts[1:]
    while parts and (parts[-1].text in {"please", "thanks", "then"} or not _content(parts[-1])):
        parts = parts[:-1]
    if not parts or not asked.candidates:
        return ()
    texts = [t.text for t in parts if not lexicon().is_(t.text, "articles")]
    if texts and texts[0] in {"any", "either", "whichever", "whatever", "anyone"}:
        return asked.candidates[:1]
    if texts in (["both"], ["all"], ["all", "of", "them"], ["both", "of", "them"]):
        return asked.candidates
    scene = Scene(semantic_map, library)
    ids = _among(parts, line, asked.candidates, scene)
    told = [p.ids for p in meant_places(tokens(line), line, scene) if len(p.ids) == 1]
    if not ids and len(told) == 1:
        ids = told[0]  # "on level 2, the second position from the left"
    if not ids and not relations(parts) and not any(_turned(t) or t.text in _SIDES for t in parts):
        named = [i for i in mentioned_in(line, scene) if i in asked.candidates]
        ids = tuple(named) if len(named) == 1 else ()
    either = len(ids) > 1 and "or" in texts
    return ids if set(ids) <= set(asked.candidates) and not either else ()


def _turned(t: Token) -> bool:
    """Whether a word turns round what is named: "not object 2", "anything but object 2"."""
    return t.text in {"but", "other", "than", "no"} or lexicon().is_(t.text, "negation", "except", "instead")


def _content(t: Token) -> bool:
    return t.word or t.number is not None


def _among(parts: tuple[Token, ...], line: str, candidates: Sequence[str], scene: Scene) -> tuple[str, ...]:
    """What a phrase means where only the candidates are there to be meant."""
    movable = [i for i in candidates if scene[i].movable]
    if parts[0].number is not None and len(parts) == 1:
        hits = [i for i in candidates if scene[i].number == parts[0].number]
        return tuple(hits) if len(hits) == 1 else ()
    where = {o.id: o.place for o in scene.map.objects}
    if movable:
        few = Scene(replace(scene.map, objects=tuple(o for o in scene.map.objects if o.id in movable)), scene.library)
        of = rank_of(parts, 0, len(parts))
        plain = resolve_objects(parts, few, Talk(where))
        if isinstance(plain, Found) and not plain.chosen and not (of is not None and len(plain.ids) > 1):
            return plain.ids
        world = World(few, Ledger(dict(where)), where, Talk(where), line)
        if of is not None and of.stop == len(parts) and not relations(parts):
            pool = world.every(of.core, True)
            found = world.ranked(of, True, pool[0], parts, False) if isinstance(pool, tuple) else None
            return found.ids if isinstance(found, Found) else ()
        exact = resolve_objects(parts, scene, Talk(where))
        return exact.ids if isinstance(exact, Found) and not exact.chosen else ()
    found_place = resolve_places(parts, scene, Talk(where))
    if isinstance(found_place, Found) and not {ANYWHERE, ORIGIN} & set(found_place.ids):
        return found_place.ids
    return ()


def edit_for(
    asked: Asked, answer: str, steps: Sequence[LabelledStep], semantic_map: SemanticMap, library: Library
) -> Edit | None:
    """How an answer changes the step that was asked about; None where it does not settle the question here.

    A place may also be said by other words than a candidate's name ("next to object 3"): those are put in as they are.
    """
    step = next((s for s in steps if s.number == asked.step and asked.line in ("", s.text)), None)
    if step is None or asked.slot in {Slot.MODEL, Slot.REQUEST}:
        return None
    ids = choose(answer, asked, semantic_map, library)
    names = " and ".join(i.replace("_", " ") for i in ids)
    scene = Scene(semantic_map, library)
    if asked.slot is Slot.WORDS:
        if not ids:
            return None
        kind = Kind.TARGET if scene[ids[0]].movable else Kind.DESTINATION
        there = lexicon().is_(step.text[asked.start : asked.end].casefold(), "there")
        return Edit(step, asked.start, asked.end, f"on {names}" if there else names, kind)
    if asked.slot is Slot.TARGET:
        at = _after(step, asked.end, particles=True)
        return Edit(step, at, at, f" {names}", Kind.TARGET) if ids else None
    at = _after(step, asked.end, particles=False) if asked.slot is Slot.DESTINATION else len(step.text.rstrip(" .!"))
    lead = "" if asked.slot is Slot.DESTINATION else " and place it"
    if ids:
        return Edit(step, at, at, f"{lead} on {names}", Kind.DESTINATION, again=bool(lead))
    words = " ".join(answer.split())[:_MOST].rstrip(".!")
    if not relations(tokens(words)):
        return None
    return Edit(step, at, at, f"{lead} {words}", None, again=True)


def _after(step: LabelledStep, end: int, *, particles: bool) -> int:
    """Where words go that belong to the action that ends at `end`: after its particle, or after its phrases."""
    if particles:
        follow = [t for t in tokens(step.text) if t.start >= end]
        while follow and lexicon().is_(follow[0].text, "particles"):
            end = follow.pop(0).end
        return end
    later = [s for s in step.spans if s.start >= end]
    for s in later:
        if s.label is Kind.ACTION:
            break
        end = max(end, s.end)
    rest = step.text[end:]
    return end + len(rest.split(")", 1)[0]) + 1 if rest.lstrip().startswith("(") and ")" in rest else end


def edited(
    steps: Sequence[LabelledStep], edit: Edit, tag: Callable[[Sequence[str]], Sequence[LabelledStep]]
) -> tuple[LabelledStep, ...]:
    """The steps with one of them changed. `tag` labels texts anew."""
    return tuple(_changed(s, edit, tag) if s is edit.step else s for s in steps)


def _changed(step: LabelledStep, edit: Edit, tag: Callable[[Sequence[str]], Sequence[LabelledStep]]) -> LabelledStep:
    text = step.text[: edit.start] + edit.text + step.text[edit.end :]
    runs = _runs(step, edit, len(edit.text) - (edit.end - edit.start))
    if edit.again:
        (fresh,) = tag([text])
        return replace(fresh, number=step.number, reply=step.reply, runs=runs)
    readings = tuple(replace(r, spans=_spans(r.spans, edit, text)) for r in step.readings)
    return replace(step, text=text, spans=_spans(step.spans, edit, text), runs=runs, readings=readings)


def _spans(spans: Sequence[KeywordSpan], edit: Edit, text: str) -> tuple[KeywordSpan, ...]:
    """The keywords of a step once its text has become `text`."""
    shift = len(edit.text) - (edit.end - edit.start)
    hit = [s for s in spans if s.start < edit.end and edit.start < s.end]
    kept = [s for s in spans if s not in hit]
    moved = [replace(s, start=s.start + shift, end=s.end + shift) if s.start >= edit.end else s for s in kept]
    labels = [s.label for s in hit if s.label is not Kind.ACTION]
    kind = labels[0] if labels else edit.kind
    start = edit.start + len(edit.text) - len(edit.text.lstrip())
    for lead in ("on ", "and place it on "):
        if edit.text.lstrip().startswith(lead):
            start += len(lead)
            break
    end = edit.start + len(edit.text)
    made = moved if kind is None else [*moved, KeywordSpan(start, end, kind, text[start:end])]
    return tuple(sorted(made, key=lambda s: s.start))


def _runs(step: LabelledStep, edit: Edit, shift: int) -> tuple[tuple[int, int], ...]:
    """Where the parts of the changed text stand in the reply: the new words where the old ones did."""
    if step.reply is None:
        return step.runs
    old = step.runs or ((0, step.reply.start),)

    def there(at: int) -> int:
        return (step.in_reply(Extent(at, at + 1)) or Extent(0, 1)).start

    before = [r for r in old if r[0] < edit.start]
    after = [(a + shift, b) for a, b in old if a >= edit.end]
    middle = [(edit.start, there(min(edit.start, max(0, len(step.text) - 1))))]
    if edit.end < len(step.text) and not any(a == edit.end + shift for a, _ in after):
        middle.append((edit.end + shift, there(edit.end)))
    return tuple(dict(sorted([*before, *middle, *after])).items())
