"""What a step names on the side of its keywords, and the map does not have: "(object 77)", "(the violin)", "on the
windowsill level 2"."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from llmbt_compiler.parsing.model import Extent, LabelledStep
from llmbt_compiler.parsing.names import Fault, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.space.expressions import rank_of
from llmbt_compiler.parsing.words import Token, lexicon, tokens

__all__ = ["lacking"]

_PLAIN = frozenset({
    "correct", "right", "appropriate", "proper", "matching", "corresponding", "next", "other", "one",
    "medium", "former", "latter",
})  # fmt: skip


def lacking(step: LabelledStep, scene: Scene, told: Sequence[Extent]) -> Iterator[Fault]:
    """E301, E302 for an object's number in parentheses that the map does not have, for a single noun there, and for a
    noun before a numbered place, that is no word of the scene. Nothing twice: `told` has been complained about."""
    line = tokens(step.text)
    for i in range(len(line) - 1):
        fault = _number(line, i, scene) or _noun(line, i, scene)
        if fault is not None and not any(e.start < fault.extent.end and fault.extent.start < e.end for e in told):
            yield fault


def _number(line: Sequence[Token], i: int, scene: Scene) -> Fault | None:
    """An object's number in parentheses. What stands elsewhere is a keyword; places may be counted ("position 2")."""
    name, number = line[i], line[i + 1]
    pool = [e for e in scene.objects if e.number is not None and name.text in e.stem]
    if i == 0 or line[i - 1].text != "(" or not number.digits or not pool:
        return None
    found = resolve_objects((name, number), scene, Talk())
    return found if isinstance(found, Fault) and found.code == "E301" else None


def _noun(line: Sequence[Token], i: int, scene: Scene) -> Fault | None:
    if i == 0 or not lexicon().is_(line[i].text, "articles") or i + 2 >= len(line):
        return None
    noun, after = line[i + 1], line[i + 2]
    if not noun.word or noun.number is not None or _known(noun, scene):
        return None
    extent = Extent(noun.start, noun.end)
    if line[i - 1].text == "(" and after.text == ")":
        return Fault("E301", f"the scene has no object `{noun.text}`", extent, "not in the map", "name the object")
    numbered = i + 3 < len(line) and line[i + 3].digits and any(after.text in e.stem for e in scene.places)
    if numbered and line[i - 1].text in {"on", "in", "at", "("}:
        said = f"{noun.text} {after.text} {line[i + 3].text}"
        return Fault("E302", f"the scene has no place `{said}`", extent, "not in the map", "name the place")
    return None


def _known(noun: Token, scene: Scene) -> bool:
    if noun.text in lexicon().known | _PLAIN or noun.text in lexicon().sizes or rank_of((noun,), 0, 1) is not None:
        return True
    return any(scene.word(noun, movable).text or scene.word(noun, movable).near for movable in (True, False))
