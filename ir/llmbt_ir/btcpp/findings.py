"""What the rules of the linter share: the file with its node types, and the list that findings are put on."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from llmbt_ir.btcpp.document import Document
from llmbt_ir.btcpp.nodes import BUILTIN, KINDS, NodeKind, NodeModel, declared
from llmbt_ir.diagnostics import Diagnostic, Severity, nearest

__all__ = ["Effect", "File"]


@dataclass(frozen=True, slots=True)
class Effect:
    """What an action brings about: a condition's type and ports; `{port}` stands for the action's port."""

    type: str
    ports: tuple[tuple[str, str], ...] = ()
    negated: bool = False


@dataclass
class File:
    """A file under check. `effects` of its actions, where a library tells."""

    document: Document
    effects: Mapping[str, tuple[Effect, ...]] = field(default_factory=dict)
    found: list[Diagnostic] = field(default_factory=list)

    @cached_property
    def declared(self) -> Mapping[str, NodeModel]:
        """The node types of TreeNodesModel."""
        return declared(self.document)

    @cached_property
    def types(self) -> Mapping[str, NodeModel]:
        """All node types that are known."""
        return {**self.declared, **BUILTIN}

    @cached_property
    def calls(self) -> Mapping[int, int]:
        """The tree that each <SubTree> element names, where the file has it."""
        d = self.document
        subtrees = (i for t in d.trees for i in d.below(t) if d[i].tag == "SubTree")
        return {i: d.by_id[d[i].get("ID")] for i in subtrees if d[i].get("ID") in d.by_id}

    @cached_property
    def called_from(self) -> Mapping[int, tuple[int, ...]]:
        """The <SubTree> elements that name each tree."""
        found: dict[int, list[int]] = {}
        for i, tree in self.calls.items():
            found.setdefault(tree, []).append(i)
        return {k: tuple(v) for k, v in found.items()}

    @cached_property
    def tree_of(self) -> Mapping[int, int]:
        """The <BehaviorTree> in which each element stands."""
        return {i: t for t in self.document.trees for i in self.document.below(t)}

    def type_of(self, index: int) -> str:
        """The node type of an element: its tag, or the ID of the explicit syntax."""
        element = self.document[index]
        explicit = element.tag in KINDS and element.tag != NodeKind.SUBTREE
        return element.get("ID", element.tag) if explicit else element.tag

    def kind_of(self, index: int) -> NodeKind | None:
        """What an element is; None where nothing tells."""
        tag = self.document[index].tag
        model = self.types.get(self.type_of(index))
        return model.kind if model else NodeKind(tag) if tag in KINDS else None

    def say(
        self,
        code: str,
        title: str,
        index: int,
        help_: str = "",
        *,
        attribute: str = "",
        label: str = "",
        near: tuple[str, Iterable[str]] | None = None,
    ) -> None:
        """Put a finding on the list; codes T1xx are errors, T2xx warnings. `near` is a word and what was meant."""
        close = nearest(near[0], near[1]) if near else ()
        if close and not help_:
            help_ = f"did you mean {', '.join(close)}?"
        severity = Severity.ERROR if code[1] == "1" else Severity.WARNING
        span = self.document.span(index, attribute)
        self.found.append(Diagnostic(code, title, span, label, help_, severity, close))
