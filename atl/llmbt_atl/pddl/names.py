"""PDDL names as the names of conditions, templates and parameters, and back.

A name that XML, BehaviorTree.CPP or the library would take for something else gets an underscore at its end. The PDDL
name is kept as the first of the `words` of the condition or template, so that it is still known when the library has
been written and read again.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from llmbt_atl.library import Library
from llmbt_ir.btcpp.nodes import BUILTIN
from llmbt_ir.condition import ActionCall, Condition

__all__ = ["EQUAL", "mangled", "pddl_call", "pddl_fact", "words_of"]

EQUAL = "="
"""The first word of a condition that stands for an equality."""

_TAKEN = frozenset(
    n.lower()
    for n in (*BUILTIN, "Action", "Condition", "Control", "Decorator", "BehaviorTree", "root", "param", "include")
)
_RESERVED = frozenset({"name", "id"})
_ODD = re.compile(r"[^A-Za-z0-9_-]")


def mangled(name: str, taken: Iterable[str], *, parameter: bool = False) -> str:
    """A name that can be an XML element (or attribute), not in `taken`, without regard to capitals."""
    name = _ODD.sub("_", name)[:90]
    if not name[:1].isascii() or not name[:1].isalpha():
        name = f"p{name}" if name[:1] in "_-" else f"p_{name}"
    used = {t.lower() for t in taken} | (_RESERVED if parameter else _TAKEN)
    if name.lower().startswith("xml"):
        name = f"p_{name}"
    while name.lower() in used:
        name += "_"
    return name


def words_of(name: str, params: Iterable[str]) -> str:
    """The PDDL form, as `stack {ob} {underob}`."""
    return " ".join((name, *(f"{{{p}}}" for p in params)))


def pddl_call(library: Library, call: ActionCall) -> str:
    """A ground action as a PDDL plan has it: `(pick-up a)`."""
    return _pddl(library.templates[call.name].words, call.name, library.parameters(call.name), call.args)


def pddl_fact(library: Library, condition: Condition) -> str:
    """A ground literal as PDDL has it: `(not (on a b))`."""
    declared = library.conditions[condition.name]
    fact = _pddl(declared.words, condition.name, library.parameters(condition.name), condition.args)
    return f"(not {fact})" if condition.negated else fact


def _pddl(words: str, name: str, params: tuple[str, ...], args: tuple[str, ...]) -> str:
    said = words.split() or [name, *(f"{{{p}}}" for p in params)]
    of = {f"{{{p}}}": a for p, a in zip(params, args, strict=True)}
    return f"({' '.join(of.get(w, w) for w in said)})"
