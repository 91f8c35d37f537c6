"""What entries of a blackboard hold where no node writes to it: what a <SubTree> above gives, by remapping. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from llmbt_ir.btcpp.nodes import is_port_name

__all__ = ["Scope", "pointer", "unwritten"]

TRUE = ("1", "true", "True", "TRUE")


@dataclass(frozen=True)
class Scope:
    """A tree's blackboard: constants that its <SubTree> gives, entries of the one above under other names."""

    above: Scope | None = None
    constants: Mapping[str, str] = field(default_factory=dict)
    names: Mapping[str, str] = field(default_factory=dict)
    autoremap: bool = False

    def below(self, attributes: Iterable[tuple[str, str]], defaults: Mapping[str, str]) -> Scope:
        """The blackboard that a <SubTree> with these attributes makes; `defaults` of TreeNodesModel count where it has
        no `_autoremap`."""
        given = dict(attributes)
        autoremap = given.get("_autoremap") in TRUE
        ports = {k: f"{{{k}}}" if v == "{=}" else v for k, v in given.items() if is_port_name(k)}
        if not autoremap:
            ports = {**defaults, **ports}
        constants = {k: v for k, v in ports.items() if pointer(v) is None}
        names = {k: p for k, v in ports.items() if (p := pointer(v)) is not None}
        return Scope(self, constants, names, autoremap)

    def entry(self, key: str) -> str | None:
        """What an entry holds; None where nothing writes it."""
        scope: Scope | None = self
        while scope is not None:
            if key[:1] == "@":  # the outermost blackboard, into which nothing writes
                return None
            if key in scope.constants:
                return scope.constants[key]
            if key in scope.names:
                key = scope.names[key]
            elif not scope.autoremap or key[:1] == "_":
                return None
            scope = scope.above
        return None

    def value(self, port: str, text: str) -> str | None:
        """A port's value: as it stands, or the entry that it points to; None where nothing writes that."""
        key = port if text in ("{=}", "=") else pointer(text)
        return text if key is None else self.entry(key)


def pointer(text: str) -> str | None:
    """The entry that a port's value points to: `{key}`, blanks around it allowed."""
    bare = text.strip(" ")
    return bare[1:-1] if len(bare) >= 3 and bare[0] == "{" and bare[-1] == "}" else None


def unwritten(port: str, text: str, *, in_subtree: bool) -> tuple[str, str]:
    """What is wrong with a port whose value points to what nothing writes, and what helps."""
    key = port if text in ("{=}", "=") else pointer(text)
    hint = f'give it where the SubTree is named: <SubTree ... {key}="...">' if in_subtree else "write the value itself"
    return f"nothing writes the blackboard entry `{key}` that `{port}` points to", hint
