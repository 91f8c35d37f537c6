"""What a library adds to the training grammar: its verbs, by what they do, and the names of its types as nouns."""

from __future__ import annotations

from collections.abc import Mapping

from llmbt_atl.library import Library
from llmbt_atl.template import Role
from llmbt_compiler.parsing.verbs import Shape, shape_of

__all__ = ["domain_words"]

_RULES = {
    Shape.PICK: ("v_pick",),
    Shape.PLACE: ("v_place", "v_move"),
    Shape.FREE: ("v_remove",),
    Shape.TRAVEL: ("v_go",),
    Shape.CHANGE: ("v_act",),
    Shape.OTHER: ("v_act",),
}
_ROOTS = frozenset({"movable", "object", "place"})


def domain_words(library: Library) -> Mapping[str, tuple[str, ...]]:
    """Entries for the grammar's rules, as `train` takes them: each verb where verbs of its kind stand ("v_pick",
    "v_place", "v_act", ...), each type's name among the things ("noun_real") or the places ("place_real").

    What a template does follows from its roles and its Post; a type is a place where a template goes to or takes from
    one, or where it is below one that is.
    """
    words: dict[str, list[str]] = {}
    for template in library.templates.values():
        shape = shape_of(template, library)
        if template.verbs and not (shape is Shape.OTHER and template.param(Role.TARGET) is None):
            for rule in _RULES[shape]:
                words.setdefault(rule, []).extend(map(_marked, template.verbs))
    places = {
        p.type
        for t in library.templates.values()
        for p in t.params
        if p.role in {Role.DESTINATION, Role.LOCATION} or library.is_a(p.type, "place")
    }
    for name in library.types:
        if name not in _ROOTS:
            rule = "place_real" if any(library.is_a(name, p) for p in places) else "noun_real"
            words.setdefault(rule, []).append(name.replace("_", " "))
    return {rule: tuple(dict.fromkeys(found)) for rule, found in words.items()}


def _marked(verb: str) -> str:
    """``pick_up`` as ``[A pick] up``: the action is the head verb only."""
    head, _, rest = verb.partition("_")
    return f"[A {head}] {rest.replace('_', ' ')}".strip()
