"""What is named for something else to be next to."""

from __future__ import annotations

from collections.abc import Sequence

from llmbt_compiler.checking.referring.counted import one_there, several
from llmbt_compiler.checking.referring.lists import INDEFINITE, POINTING
from llmbt_compiler.checking.referring.model import Meant
from llmbt_compiler.checking.referring.nouns import noun
from llmbt_compiler.checking.referring.standing import standing_there
from llmbt_compiler.parsing.mentions import mentions_in
from llmbt_compiler.parsing.names import Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import Token, lexicon

__all__ = ["landmark", "pointed_to"]


def pointed_to(words: Sequence[Token], at: int, scene: Scene) -> Meant | None:
    """What "it" right here stands for: the thing named last before it."""
    if [t.text for t in words[at : at + 1]] != ["it"]:
        return None
    mentioned = (m for m in mentions_in(words[:at], scene) if scene[m.id].movable)
    named: dict[int, tuple[str, ...]] = {m.start: (m.id,) for m in mentioned}
    for k, t in enumerate(words[:at]):
        if t.text in scene.colours:
            named.setdefault(k, tuple(e.id for e in scene.objects if t.text in e.colour))
    single = [ids for _, ids in sorted(named.items()) if len(ids) == 1]
    return Meant(at, at + 1, single[-1]) if single else None


def landmark(words: Sequence[Token], at: int, scene: Scene) -> Meant | None:
    """What is named right here for something else to be next to: "object 3", "the green block on the shelf"."""
    where = {o.id: o.place for o in scene.map.objects}
    while at < len(words) and words[at].text in {"of", "to"}:
        at += 1
    if at >= len(words):
        return None
    named = next((m for m in mentions_in(words[at:], scene) if m.start <= int(words[at].text in POINTING)), None)
    if named is not None:
        return Meant(at, at + named.end, (named.id,))
    count = several(words, at, scene, where) or one_there(words, at, scene, where)
    if count is not None:
        return count
    end = noun(words, at, scene) if words[at].text in POINTING | INDEFINITE else 0
    if not end:
        return None
    phrase = [t for t in words[at + 1 : end] if t.text != "one"]
    told = [t for t in phrase if t.text in lexicon().ordinals or t.text in lexicon().sizes]
    found = (
        resolve_objects((Token("all", words[at].start, words[at].start), *phrase), scene, Talk()) if phrase else None
    )
    if not isinstance(found, Found) or told:
        return None
    ids, stop = standing_there(words, end, found.ids, scene, where)
    return Meant(at, max(stop, end), ids)
