"""Stated goals held against the library and the map: the same names, and the same complaints, as for steps."""

from __future__ import annotations

from collections.abc import Sequence

from llmbt_atl.library import Library
from llmbt_compiler.goals.document import Literal, Stated
from llmbt_compiler.parsing import Goal, Note, NoteKind, ParseResult
from llmbt_compiler.parsing.names import ANYWHERE, ORIGIN, Fault, Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.places import resolve_places
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import Token, tokens
from llmbt_ir.condition import Condition
from llmbt_ir.diagnostics import Diagnostic, nearest
from llmbt_ir.semantic_map import SemanticMap

__all__ = ["ground"]


def ground(stated: Stated, semantic_map: SemanticMap, library: Library) -> ParseResult:
    """Goals over the map's ids, numbered from 1 as their steps; every complaint at once.

    Diagnostics: E152 no such goal, E153 wrong arguments, E301, E302, E304, E311 as for steps.
    """
    work = _Grounding(stated, Scene(semantic_map, library))
    goals = tuple(g for i, literal in enumerate(stated.literals, 1) if (g := work.goal(i, literal)) is not None)
    first: dict[Condition, Goal] = {}
    for g in goals:
        first.setdefault(g.condition, g)
    return ParseResult(tuple(first.values()), tuple(work.notes), tuple(work.diagnostics))


class _Grounding:
    def __init__(self, stated: Stated, scene: Scene) -> None:
        self.stated, self.scene = stated, scene
        self.diagnostics: list[Diagnostic] = []
        self.notes: list[Note] = []
        self.names = {n.lower(): n for n, c in scene.library.conditions.items() if c.goal}

    def complain(self, code: str, title: str, literal: Literal, hint: str = "", near: tuple[str, ...] = ()) -> None:
        span = literal.span(self.stated.source, self.stated.text)
        self.diagnostics.append(Diagnostic(code, title, span, help=hint, candidates=near))

    def goal(self, number: int, literal: Literal) -> Goal | None:
        name = self.names.get(literal.name.lower())
        if name is None:
            near = nearest(literal.name, self.names.values())
            hint = f"did you mean {near[0]}?" if near else f"there is {', '.join(self.names.values())}"
            self.complain(
                "E152", f"`{literal.name}` is no goal of library `{self.scene.library.name}`", literal, hint, near
            )
            return None
        params = self.scene.library.conditions[name].params
        if len(params) != len(literal.args):
            wanted = ", ".join(p.name for p in params)
            self.complain(
                "E153", f"`{name}` takes {len(params)} arguments, not {len(literal.args)}", literal, f"{name}({wanted})"
            )
            return None
        args = [self.thing(a, p.type, literal, number) for a, p in zip(literal.args, params, strict=True)]
        if None in args:
            return None
        condition = Condition(name, tuple(str(a) for a in args), literal.negated)
        return Goal(condition, number, str(condition), literal.extent, literal.extent)

    def thing(self, name: str, type_: str, literal: Literal, number: int) -> str | None:
        """The one thing that a name means, of a type; None where there is none, which has been told."""
        movable = any(self.scene.library.is_a(e.type, type_) for e in self.scene.objects)
        placed = any(self.scene.is_a(e.id, type_) for e in self.scene.places)
        parts = tokens(name)
        if not parts:
            self.complain("E153", "an argument is empty", literal)
            return None
        ways = [r for r, apt in ((resolve_objects, movable), (resolve_places, placed)) if apt] or [resolve_objects]
        found = [r(parts, self.scene, Talk()) for r in ways]
        hit = next((f for f in found if isinstance(f, Found) and not {ANYWHERE, ORIGIN} & set(f.ids)), None)
        if hit is None:
            hit = self.another_kind(parts, ways)
        if hit is None:
            self.fault(next((f for f in found if isinstance(f, Fault)), None), name, literal)
            return None
        if len(hit.ids) != 1:
            listed = ", ".join(hit.ids[:6])
            self.complain("E304", f"`{name}` fits {len(hit.ids)} things", literal, f"say which of {listed}", hit.ids)
            return None
        (id_,) = hit.ids
        if not (self.scene.is_a(id_, type_) or self.scene.library.is_a(self.scene[id_].type, type_)):
            self.complain("E311", f"{id_} is a {self.scene[id_].type}, not a {type_}", literal)
            return None
        self.notes += [Note(number, NoteKind.CORRECTED, t, literal.extent) for t in hit.corrected]
        self.notes += [Note(number, NoteKind.CHOSEN, t, literal.extent) for t in hit.chosen]
        return id_

    def another_kind(self, parts: tuple[Token, ...], ways: Sequence[object]) -> Found | None:
        """A thing of the wrong kind is told as such, not as unknown."""
        for resolve in (resolve_objects, resolve_places):
            if resolve not in ways:
                found = resolve(parts, self.scene, Talk())
                if isinstance(found, Found) and not found.corrected and not {ANYWHERE, ORIGIN} & set(found.ids):
                    return found
        return None

    def fault(self, fault: Fault | None, name: str, literal: Literal) -> None:
        if fault is None:
            self.complain("E302", f"`{name}` names no particular place", literal, "give an id of the map")
        else:
            self.complain(fault.code or "E301", fault.title, literal, fault.help, fault.candidates)
