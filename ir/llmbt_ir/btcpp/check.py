"""The linter for BehaviorTree.CPP 4 files: T1xx are errors, T2xx warnings; nothing recurses on depth."""

from __future__ import annotations

from collections.abc import Mapping

from llmbt_ir.btcpp.document import Document
from llmbt_ir.btcpp.findings import Effect, File
from llmbt_ir.btcpp.loading import check_loading
from llmbt_ir.btcpp.smells import check_smells
from llmbt_ir.diagnostics import Diagnostic

__all__ = ["RULES", "Effect", "check_document"]

RULES: Mapping[str, str] = {
    "T101": "the outermost element is not <root>",
    "T103": "a <BehaviorTree> without an ID among other elements",
    "T104": "a name that BehaviorTree.CPP refuses",
    "T105": "the same ID twice",
    "T106": "a tree with the name of a node type",
    "T107": "a <BehaviorTree> without exactly one node at its top",
    "T108": "nested more than 256 levels deep",
    "T109": "an unknown node type",
    "T110": "a port that the node type does not declare",
    "T111": "a value that is not of the port's type",
    "T112": "an ID is missing",
    "T113": "an ID where the tag is the type",
    "T114": "a wrong number of children",
    "T115": "explicit syntax straight under a ReactiveSequence",
    "T116": "a SubTree that the file does not have",
    "T117": "SubTrees in a circle",
    "T118": "two SubTrees of one name in one tree",
    "T119": "more than one TreeNodesModel",
    "T120": "no tree to execute",
    "T121": "a processing instruction",
    "T122": "a port name that BehaviorTree.CPP refuses",
    "T123": "an unknown element in TreeNodesModel",
    "T124": "a control character in an instance's name",
    "T125": "a SubTree's mandatory port is not given",
    "T126": "an <include> that cannot be read",
    "T127": "files that include one another in a circle",
    "T201": "BTCPP_format is not 4",
    "T202": "a node with memory in a reactive tree",
    "T203": "a child that is never reached",
    "T204": "a condition checked twice in one composite",
    "T205": "a condition and its opposite in one composite",
    "T206": "an action without its post-condition before it",
    "T207": "a tree that is never used",
    "T208": "a brace that makes no blackboard entry",
    "T209": "a node type that no TreeNodesModel declares",
    "T210": "several trees, and none is named to be executed",
    "T211": "an input without a value and without a default",
    "T212": "an attribute with a namespace",
    "T214": "a misspelt pre- or post-condition, which is ignored",
    "T215": "an <include> that is not followed",
    "T216": "`&` or `<` as such in a value: not XML, though BehaviorTree.CPP reads it",
}


def check_document(
    document: Document, *, effects: Mapping[str, tuple[Effect, ...]] | None = None
) -> tuple[Diagnostic, ...]:
    """All findings, by line. `effects` are what the actions bring about, where a library tells."""
    file = File(document, effects or {})
    check_loading(file)
    if document[document.root].tag == "root":
        check_smells(file)
    return tuple(
        sorted(file.found, key=lambda d: (d.span.line if d.span else 0, d.span.column if d.span else 0, d.code))
    )
