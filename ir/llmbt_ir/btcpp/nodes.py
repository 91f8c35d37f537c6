"""The nodes that BehaviorTree.CPP 4.10 brings, the names it allows, and what a file's TreeNodesModel declares."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from llmbt_ir.btcpp.document import Document

__all__ = ["BUILTIN", "CONDITIONS_OF_NODES", "FORBIDDEN", "KINDS", "NodeKind", "NodeModel", "Port"]
__all__ += ["REACTIVE", "REMEMBERING", "declared", "forbidden_character", "is_port_name"]


class NodeKind(StrEnum):
    """What a node is to BehaviorTree.CPP: the tags of the explicit syntax and of TreeNodesModel."""

    ACTION = "Action"
    CONDITION = "Condition"
    CONTROL = "Control"
    DECORATOR = "Decorator"
    SUBTREE = "SubTree"


KINDS = frozenset(k.value for k in NodeKind)


@dataclass(frozen=True, slots=True)
class Port:
    """A port. `required`: an input without a default, which the node asks for when it is ticked. `default`: what a
    TreeNodesModel declares as such."""

    type: str = "std::string"
    required: bool = False
    default: str | None = None


@dataclass(frozen=True, slots=True)
class NodeModel:
    """A node type: its kind, its ports, and the line that declares it (0: built in)."""

    kind: NodeKind
    ports: Mapping[str, Port] = field(default_factory=dict)
    line: int = 0


def _control(**ports: Port) -> NodeModel:
    return NodeModel(NodeKind.CONTROL, ports)


def _decorator(**ports: Port) -> NodeModel:
    return NodeModel(NodeKind.DECORATOR, ports)


def _action(**ports: Port) -> NodeModel:
    return NodeModel(NodeKind.ACTION, ports)


TEXT, INT, UNSIGNED, BOOL, STATUS = "std::string", "int", "unsigned int", "bool", "BT::NodeStatus"
NEEDED = Port(TEXT, True)
LOOP = _decorator(queue=Port("", True), if_empty=Port(STATUS), value=Port("", False))
CODE = {"code": NEEDED}

BUILTIN: Mapping[str, NodeModel] = {
    **{n: _control() for n in ("Fallback", "AsyncFallback", "Sequence", "AsyncSequence", "SequenceWithMemory")},
    **{n: _control() for n in ("ReactiveSequence", "ReactiveFallback", "IfThenElse", "WhileDoElse")},
    "Parallel": _control(success_count=Port(INT), failure_count=Port(INT)),
    "ParallelAll": _control(max_failures=Port(INT)),
    "TryCatch": _control(catch_on_halt=Port(BOOL)),
    **{
        f"Switch{n}": NodeModel(
            NodeKind.CONTROL, {"variable": NEEDED, **{f"case_{k}": NEEDED for k in range(1, n + 1)}}
        )
        for n in range(2, 7)
    },
    **{n: _decorator() for n in ("Inverter", "KeepRunningUntilFailure", "ForceSuccess", "ForceFailure")},
    "RetryUntilSuccessful": _decorator(num_attempts=Port(INT, True)),
    "Repeat": _decorator(num_cycles=Port(INT, True)),
    "Timeout": _decorator(msec=Port(UNSIGNED, True)),
    "Delay": _decorator(delay_msec=Port(UNSIGNED, True)),
    "RunOnce": _decorator(then_skip=Port(BOOL)),
    "Precondition": NodeModel(NodeKind.DECORATOR, {"if": NEEDED, "else": Port(STATUS)}),
    **dict.fromkeys(("LoopInt", "LoopBool", "LoopDouble", "LoopString"), LOOP),
    **dict.fromkeys(("SkipUnlessUpdated", "WaitValueUpdate"), _decorator(entry=Port("", True))),
    "AlwaysSuccess": _action(),
    "AlwaysFailure": _action(),
    "Script": NodeModel(NodeKind.ACTION, CODE),
    "ScriptCondition": NodeModel(NodeKind.CONDITION, CODE),
    "SetBlackboard": _action(value=NEEDED, output_key=NEEDED),
    "UnsetBlackboard": _action(key=NEEDED),
    "Sleep": _action(msec=Port(UNSIGNED, True)),
    "WasEntryUpdated": _action(entry=Port("", True)),
    "SubTree": NodeModel(NodeKind.SUBTREE),
}
REACTIVE = frozenset({"ReactiveSequence", "ReactiveFallback"})
REMEMBERING: Mapping[str, str] = {
    "Sequence": "ReactiveSequence",
    "AsyncSequence": "ReactiveSequence",
    "SequenceWithMemory": "ReactiveSequence",
    "Fallback": "ReactiveFallback",
    "AsyncFallback": "ReactiveFallback",
}
"""The composites that go on where they stopped, and what to write in a reactive tree."""

PRE_CONDITIONS = ("_failureIf", "_successIf", "_skipIf", "_while")
POST_CONDITIONS = ("_onHalted", "_onFailure", "_onSuccess", "_post")
CONDITIONS_OF_NODES = frozenset((*PRE_CONDITIONS, *POST_CONDITIONS, "_autoremap"))
RESERVED = frozenset({"name", "ID", *CONDITIONS_OF_NODES})

FORBIDDEN = frozenset(" \t\n\r<>&\"'/\\:*?|.")


def forbidden_character(name: str) -> str | None:
    """The first character of a name that BehaviorTree.CPP 4.10 refuses."""
    return next((c for c in name if c in FORBIDDEN or ord(c) < 32 or ord(c) == 127), None)


def is_port_name(name: str) -> bool:
    """Whether an attribute is taken for a port; `_anything` and what is reserved are not."""
    return name[:1].isascii() and name[:1].isalpha() and forbidden_character(name) is None and name not in RESERVED


def declared(document: Document) -> dict[str, NodeModel]:
    """The node types of a file's TreeNodesModel; of several declarations of one name the first."""
    found: dict[str, NodeModel] = {}
    for model in document.named(document.root, "TreeNodesModel"):
        for i in document.kids(model):
            element = document[i]
            if element.tag not in KINDS or not element.has("ID"):
                continue
            ports = {}
            for p in document.kids(i):
                port = document[p]
                needed = port.tag in ("input_port", "inout_port") and not port.has("default")
                default = port.get("default") if port.has("default") else None
                ports[port.get("name")] = Port(port.get("type", TEXT), needed, default)
            found.setdefault(element.get("ID"), NodeModel(NodeKind(element.tag), ports, element.line))
    return found
