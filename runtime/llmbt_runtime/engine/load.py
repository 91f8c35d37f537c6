"""Any BehaviorTree.CPP 4 file as a program: SubTrees written out, ports resolved.

No node that this engine runs writes to the blackboard, so what an entry holds is known when the file is read: what a
<SubTree> above gives it, through remappings and `_autoremap`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from llmbt_ir.btcpp.blackboard import Scope, unwritten
from llmbt_ir.btcpp.check import check_document
from llmbt_ir.btcpp.document import Document
from llmbt_ir.btcpp.findings import File
from llmbt_ir.btcpp.nodes import CONDITIONS_OF_NODES, is_port_name
from llmbt_ir.condition import ActionCall, Condition
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Severity, nearest
from llmbt_ir.signatures import Signatures
from llmbt_runtime.engine.program import Op, Program, ProgramNode

__all__ = ["program_of_document"]

MAX_NODES = 100_000
MAX_NESTED = 1_000
"""Limits with the SubTrees written out: n levels of two SubTrees each stand for 2**n nodes."""
AMOUNTS = {Op.RETRY: "num_attempts", Op.REPEAT: "num_cycles", Op.TIMEOUT: "msec", Op.DELAY: "delay_msec"}
BUILT_IN = {op.value: op for op in Op if op not in (Op.CONDITION, Op.ACTION)}


@dataclass(frozen=True)
class _Place:
    """An element to be turned into a node: below which node, in whose blackboard, in which SubTrees."""

    index: int
    parent: int
    id: str
    scope: Scope
    within: tuple[str, ...]


def program_of_document(document: Document, signatures: Signatures) -> Program:
    """The program of a file's main tree. `signatures` are the robot's conditions and actions.

    Ids are the nodes' `_id`, or else (where there is none, or it is taken) their places, as `Main.2.1`. Errors: T1xx,
    E004 too large, E051 no main tree, E052 a node or attribute that the engine does not run, E053 an unknown leaf,
    E054 wrong ports, E086 an entry that nothing writes.
    """
    # which leaves there are, the library tells, not the file's TreeNodesModel (T109)
    faults = [d for d in check_document(document) if d.severity is Severity.ERROR and d.code != "T109"]
    if faults:
        raise LlmbtError(*faults[:10])
    return _Loader(document, signatures).load()


class _Loader:
    def __init__(self, document: Document, signatures: Signatures) -> None:
        self.document = document
        self.file = File(document)
        self.signatures = signatures
        self.nodes: list[ProgramNode] = []
        self.children: list[list[int]] = []
        self.ids: set[str] = set()
        self.faults: list[Diagnostic] = []

    def fault(
        self, code: str, title: str, index: int, hint: str = "", attribute: str = "", near: tuple[str, ...] = ()
    ) -> None:
        """Note what is wrong with an element."""
        if near and not hint:
            hint = f"did you mean {', '.join(near)}?"
        self.faults.append(Diagnostic(code, title, self.document.span(index, attribute), "", hint, candidates=near))

    def load(self) -> Program:
        """The program, or all that is wrong."""
        d = self.document
        if d.main is None or d.main not in d.by_id:
            hint = f"the file has {', '.join(sorted(d.by_id)) or 'none'}"
            self.fault("E051", "main_tree_to_execute names no tree", d.root, hint)
            raise LlmbtError(*self.faults)
        stack = [self.inside(d.main, -1, d.main, Scope(), ())]
        while stack:
            here = stack.pop()
            if len(self.nodes) >= MAX_NODES or len(here.within) > MAX_NESTED:
                what = f"{MAX_NODES} nodes" if len(self.nodes) >= MAX_NODES else f"{MAX_NESTED} nested SubTrees"
                self.fault("E004", f"the tree has more than {what}", here.index)
                raise LlmbtError(self.faults[-1])
            self.conditions(here.index)
            if d[here.index].tag == "SubTree":
                if d[here.index].get("ID") in d.by_id:
                    stack.append(self.called(here))
                else:  # where an <include> was not followed, the linter says nothing
                    self.fault("E051", f"no <BehaviorTree> named `{d[here.index].get('ID')}`", here.index)
                continue
            number = self.add(here)
            below = d.kids(here.index)
            stack.extend(
                _Place(below[k], number, self.name(here, k + 1), here.scope, here.within)
                for k in range(len(below) - 1, -1, -1)
            )
        if self.faults:
            raise LlmbtError(*self.faults[:10])
        return Program(
            tuple(
                ProgramNode(n.op, n.id, tuple(kids), n.condition, n.action, n.amount, n.line)
                for n, kids in zip(self.nodes, self.children, strict=True)
            )
        )

    # -- where things are ---------------------------------------------------------------------------------------------

    def inside(self, tree: str, parent: int, id_: str, scope: Scope, within: tuple[str, ...]) -> _Place:
        """The node at the top of a <BehaviorTree>."""
        top = self.document.kids(self.document.by_id[tree])[0]
        return _Place(top, parent, id_, scope, (*within, tree))

    def name(self, above: _Place, rank: int) -> str:
        """The place of a child."""
        short = above.id if len(above.id) < 80 else f"{above.id[:12]}~{len(self.nodes)}"
        return f"{short}.{rank}"

    def called(self, here: _Place) -> _Place:
        """What a <SubTree> stands for, with the blackboard that it makes."""
        element = self.document[here.index]
        tree = element.get("ID")
        model = self.file.declared.get(tree)
        ports = model.ports.items() if model is not None else ()
        defaults = {port: wanted.default for port, wanted in ports if wanted.default is not None}
        scope = here.scope.below(element.attributes, defaults)
        return self.inside(tree, here.parent, f"{here.id}/{tree}", scope, here.within)

    # -- nodes --------------------------------------------------------------------------------------------------------

    def conditions(self, index: int) -> None:
        """Pre- and post-conditions are scripts, which are not run."""
        for key, _ in self.document[index].attributes:
            if key in CONDITIONS_OF_NODES and key != "_autoremap":
                hint = "write the condition as a node of its own"
                self.fault("E052", f"`{key}` holds a script, and this engine runs none", index, hint, key)

    def add(self, here: _Place) -> int:
        """Put a node into the table; its number."""
        number = len(self.nodes)
        own = self.document[here.index].get("_id")
        id_ = own if own and own not in self.ids else here.id
        while id_ in self.ids:
            id_ += "'"
        self.ids.add(id_)
        self.nodes.append(self.node(here, id_))
        self.children.append([])
        if here.parent >= 0:
            self.children[here.parent].append(number)
        return number

    def node(self, here: _Place, id_: str) -> ProgramNode:
        index = here.index
        name, line = self.file.type_of(index), self.document[index].line
        if name in self.signatures.conditions:
            args = self.args(here, name, self.signatures.conditions[name])
            return ProgramNode(Op.CONDITION, id_, condition=Condition(name, args), line=line)
        if name in self.signatures.actions:
            args = self.args(here, name, self.signatures.actions[name])
            return ProgramNode(Op.ACTION, id_, action=ActionCall(name, args), line=line)
        op = BUILT_IN.get(name)
        if op is not None:
            return ProgramNode(op, id_, amount=self.amount(here, op), line=line)
        if name in self.file.types and name not in self.file.declared:
            runs = ", ".join(sorted(BUILT_IN))
            self.fault("E052", f"this engine does not run <{name}>", index, f"it runs {runs}, SubTree")
        else:
            known = (*self.signatures.conditions, *self.signatures.actions, *BUILT_IN)
            title = f"unknown node `{name}`: the library declares no such condition or action"
            self.fault("E053", title, index, near=nearest(name, known))
        return ProgramNode(Op.ALWAYS_FAILURE, id_, line=line)

    def args(self, here: _Place, name: str, ports: tuple[str, ...]) -> tuple[str, ...]:
        """A leaf's arguments, in the order of its ports."""
        element = self.document[here.index]
        given = {k for k, _ in element.attributes if is_port_name(k) or k in ports}
        if given != set(ports):
            self.fault("E054", f"`{name}` takes {', '.join(ports) or 'no ports'}", here.index)
            return ports
        return tuple(self.value(here, port, element.get(port)) for port in ports)

    def amount(self, here: _Place, op: Op) -> int:
        """What a decorator counts."""
        port = AMOUNTS.get(op)
        if port is None:
            return 0
        element = self.document[here.index]
        if not element.has(port):
            self.fault("E054", f"<{op}> needs {port}", here.index, f'write {port}="..."')
            return 0
        text = self.value(here, port, element.get(port))
        signed = op in (Op.RETRY, Op.REPEAT)
        if re.fullmatch(r"-?\d{1,9}" if signed else r"\d{1,9}", text) is None:
            kind = "a whole number" if signed else "a number of milliseconds"
            self.fault("E054", f"{port} of <{op}> is `{text}`, and not {kind}", here.index, "", port)
            return 0
        return int(text)

    def value(self, here: _Place, port: str, text: str) -> str:
        """A port's value: as it stands, or the entry that it points to."""
        found = here.scope.value(port, text)
        if found is None:
            title, hint = unwritten(port, text, in_subtree=len(here.within) > 1)
            self.fault("E086", title, here.index, hint, port)
            return ""
        return found
