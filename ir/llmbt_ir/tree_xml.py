"""Trees as BehaviorTree.CPP 4 XML: written canonically, read with a line number for every complaint.

Compact syntax, one node a line, attributes in a fixed order, so that a text diff of two versions is small. A leaf's
own id stands in `_id`, which BehaviorTree.CPP ignores. A branch deeper than `SPLIT_DEPTH` levels goes into a
<SubTree>, since BehaviorTree.CPP allows 256 levels in one <BehaviorTree>.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path

from llmbt_ir.btcpp.blackboard import Scope, unwritten
from llmbt_ir.btcpp.nodes import BUILTIN, CONDITIONS_OF_NODES
from llmbt_ir.condition import ActionCall, Condition, Goals, parse_condition
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Span, nearest
from llmbt_ir.quoting import escape, quoteattr
from llmbt_ir.signatures import Signatures
from llmbt_ir.tree import Kind, Node, Tree, node_id
from llmbt_ir.xml import Element, line_of, parse_xml, read_bytes

__all__ = ["SPLIT_DEPTH", "GoalRecord", "Provenance", "TreeFile", "parse_tree", "read_tree", "write_tree"]

SPLIT_DEPTH = 200
MAIN = "Main"
INVERTER = "Inverter"
MAX_NODES = 100_000
MAX_NESTED = 1_000
"""Limits of one tree with its SubTrees written out: n levels of two SubTrees each stand for 2**n nodes."""
MEMORY = {"Sequence": "ReactiveSequence", "Fallback": "ReactiveFallback"}
AS_IT_STANDS = "tick the tree as it stands, ungrown: llmbt execute --no-update"


@dataclass(frozen=True, slots=True)
class GoalRecord:
    """A goal: the node that stands for it in v000, the words that asked for it, and of which alternative it is."""

    node: str
    condition: Condition
    words: str = ""
    alternative: int = 1


@dataclass(frozen=True, slots=True)
class Provenance:
    """What a tree file says of where it comes from: its version, its parent, its goals, and what changed and why.

    `entries` are (element, attributes), written in order.
    """

    version: str = "v000"
    parent_sha256: str = ""
    goals: tuple[GoalRecord, ...] = ()
    entries: tuple[tuple[str, tuple[tuple[str, str], ...]], ...] = ()

    @property
    def stated(self) -> Goals:
        """The goals that are named, by alternatives; empty where none is."""
        table: dict[int, list[Condition]] = {}
        for goal in self.goals:
            table.setdefault(goal.alternative, []).append(goal.condition)
        return tuple(tuple(table[k]) for k in sorted(table))


@dataclass(frozen=True, slots=True)
class TreeFile:
    """A tree as read: the tree, the line of each node, the leaves' ports, and what it says of where it comes from."""

    tree: Tree
    lines: Mapping[str, int]
    source: str
    signatures: Signatures
    provenance: Provenance = field(default_factory=Provenance)

    @property
    def goals(self) -> Goals:
        """The goals that the provenance names; empty where it names none."""
        return self.provenance.stated

    def line(self, id_: str) -> Span:
        """The span of a node."""
        return Span(self.source, self.lines.get(id_, 0))


# -- writing -------------------------------------------------------------------------------------------------------


def write_tree(tree: Tree, signatures: Signatures, provenance: Provenance | None = None) -> bytes:
    """The canonical XML of a tree: the same tree and provenance give the same bytes. Precondition: no argument is of
    the form `{key}`, which would point to the blackboard."""
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<root BTCPP_format="4" main_tree_to_execute="{MAIN}">',
    ]
    pending = [(MAIN, tree.root)]
    used_conditions: set[str] = set()
    used_actions: set[str] = set()
    for node in tree.nodes.values():
        if node.condition is not None:
            used_conditions.add(node.condition.name)
        if node.action is not None:
            used_actions.add(node.action.name)
    while pending:
        name, top = pending.pop(0)
        lines.append(f'  <BehaviorTree ID="{name}">')
        lines.extend(_branch(tree, top, signatures, pending))
        lines.append("  </BehaviorTree>")
    lines.extend(_model(signatures, used_conditions, used_actions))
    if provenance is not None:
        lines.extend(_provenance(provenance))
    lines.append("</root>")
    return ("\n".join(lines) + "\n").encode()


NOT_XML = re.compile("[\0-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
REPLACEMENT = "\ufffd"


def _attributes(pairs: Iterable[tuple[str, str]]) -> str:
    return "".join(f" {k}={quoteattr(NOT_XML.sub(REPLACEMENT, v))}" for k, v in pairs)


def _branch(tree: Tree, top: str, signatures: Signatures, pending: list[tuple[str, str]]) -> Iterator[str]:
    """The lines of one <BehaviorTree>; branches below SPLIT_DEPTH are put on `pending`."""
    stack: list[tuple[str, int, bool]] = [(top, 2, False)]
    while stack:
        id_, level, closing = stack.pop()
        node, indent = tree[id_], "  " * level
        if closing:
            yield f"{indent}</{node.kind.value}>"
        elif node.condition is not None:
            leaf = _leaf(node.condition.name, node.condition.args, signatures.conditions, id_)
            yield f"{indent}<{INVERTER}>{leaf}</{INVERTER}>" if node.condition.negated else indent + leaf
        elif node.action is not None:
            yield indent + _leaf(node.action.name, node.action.args, signatures.actions, id_)
        elif level >= SPLIT_DEPTH:
            name = "Branch_" + id_.replace(".", "_")
            pending.append((name, id_))
            yield f"{indent}<SubTree{_attributes([('ID', name), ('_id', id_)])}/>"
        else:
            yield f"{indent}<{node.kind.value}{_attributes([('_id', id_)])}>"
            stack.append((id_, level, True))
            stack.extend((c, level + 1, False) for c in reversed(node.children))


def _leaf(name: str, args: tuple[str, ...], table: Mapping[str, tuple[str, ...]], id_: str) -> str:
    return f"<{name}{_attributes([*zip(table[name], args, strict=True), ('_id', id_)])}/>"


def _model(signatures: Signatures, conditions: set[str], actions: set[str]) -> Iterator[str]:
    yield "  <TreeNodesModel>"
    for kind, names, table in (
        ("Action", actions, signatures.actions),
        ("Condition", conditions, signatures.conditions),
    ):
        for name in sorted(names):
            if table[name]:
                yield f'    <{kind} ID="{name}">'
                yield from (f'      <input_port name="{port}" type="std::string"/>' for port in table[name])
                yield f"    </{kind}>"
            else:
                yield f'    <{kind} ID="{name}"/>'
    yield "  </TreeNodesModel>"


def _provenance(provenance: Provenance) -> Iterator[str]:
    head = [("version", provenance.version)]
    if provenance.parent_sha256:
        head.append(("parent_sha256", provenance.parent_sha256))
    yield f"  <Provenance{_attributes(head)}>"
    for goal in provenance.goals:
        pairs = [("id", goal.node), ("condition", str(goal.condition))]
        pairs += [("alternative", str(goal.alternative))] if goal.alternative > 1 else []
        yield f"    <Goal{_attributes([*pairs, ('words', goal.words)])}/>"
    for element, attributes in provenance.entries:
        yield f"    <{escape(element)}{_attributes(attributes)}/>"
    yield "  </Provenance>"


# -- reading -------------------------------------------------------------------------------------------------------


def read_tree(path: Path, signatures: Signatures | None = None) -> TreeFile:
    """Read a tree file (see `parse_tree`)."""
    return parse_tree(read_bytes(path, "tree"), str(path), signatures)


def parse_tree(data: bytes, source: str, signatures: Signatures | None = None) -> TreeFile:
    """Parse a BehaviorTree.CPP 4 file of reactive nodes, conditions and actions.

    Leaves are told apart by `signatures`, or else by the file's own TreeNodesModel. Nodes without `_id` get one from
    their position. SubTrees are written out, their ports resolved. Errors: E004 too many nodes, E050 not a BT.CPP 4
    file, E051 no such tree, E052 a node this engine does not run, E053 an unknown leaf, E054 wrong ports, E056 SubTrees
    in a circle, E057 an id twice, E086 an entry that nothing writes.
    """
    root = parse_xml(data, source)
    return _TreeReader(root, source, signatures).read()


class _TreeReader:
    def __init__(self, root: Element, source: str, signatures: Signatures | None) -> None:
        self.root, self.source = root, source
        self.signatures = signatures or _model_of(root)
        self.known_from = "the library" if signatures else "the file's TreeNodesModel"
        self.defaults = _defaults_of(root)
        self.nodes: dict[str, Node] = {}
        self.lines: dict[str, int] = {}
        self.faults: list[Diagnostic] = []

    def fault(self, code: str, title: str, node: Element, help_: str = "", candidates: tuple[str, ...] = ()) -> None:
        span = Span(self.source, line_of(node))
        self.faults.append(Diagnostic(code, title, span, help=help_, candidates=candidates))

    def read(self) -> TreeFile:
        if self.root.tag != "root" or self.root.get("BTCPP_format") != "4":
            self.fault("E050", 'not a BehaviorTree.CPP 4 file: the root is <root BTCPP_format="4">', self.root)
            raise LlmbtError(*self.faults)
        trees: dict[str, Element] = {}
        for n in self.root.iterfind("BehaviorTree"):
            name = str(n.get("ID"))
            if name in trees:
                first = line_of(trees[name])
                self.fault("E057", f"<BehaviorTree> `{name}` is there twice, first in line {first}", n)
            trees[name] = n
        wanted = self.root.get("main_tree_to_execute") or (next(iter(trees)) if len(trees) == 1 else None)
        if wanted is None or wanted not in trees:
            self.fault(
                "E051",
                f"no <BehaviorTree> named `{wanted}`" if wanted else "main_tree_to_execute names no tree",
                self.root,
                f"the file has {', '.join(trees) or 'none'}",
            )
            raise LlmbtError(*self.faults)
        top = self.build(trees, wanted)
        if self.faults or top is None:
            raise LlmbtError(*self.faults[:10])
        provenance = self.provenance()
        tree = Tree(top, self.nodes)
        return TreeFile(tree, self.lines, self.source, self.signatures, provenance)

    def build(self, trees: Mapping[str, Element], main: str) -> str | None:
        """Build the table without recursing: elements are visited in pre-order, children filled in as they end."""
        children: dict[str, list[str]] = {}
        top: str | None = None
        stack = self.body(trees, main, None, "n", (), trees[main], Scope())
        visited = 0
        while stack:
            element, parent, path, within, negated, scope = stack.pop()
            visited += 1
            self.limits(element, visited, len(within))
            if not self.shape(element, negated):
                continue
            if element.tag == "SubTree":
                name = str(element.get("ID"))
                inside = scope.below(_pairs(element), self.defaults.get(name, {}))
                stack.extend(self.body(trees, name, parent, path, within, element, inside))
                continue
            if element.tag == INVERTER:
                stack.append((element[0], parent, path, within, not negated, scope))
                continue
            node = self.node(element, path, negated, scope)
            if node is None:
                continue
            if node.id in self.nodes:
                self.fault("E057", f"id `{node.id}` is used twice, first in line {self.lines[node.id]}", element)
                continue
            self.nodes[node.id] = node
            self.lines[node.id] = line_of(element)
            if parent is None:
                top = node.id
            else:
                children[parent].append(node.id)
            if node.kind in (Kind.SEQUENCE, Kind.FALLBACK):
                children[node.id] = []
                below = list(element)
                if len(path) > 200:
                    path = sha256(path.encode()).hexdigest()
                stack.extend(
                    (below[i], node.id, f"{path}.{i + 1}", within, False, scope) for i in range(len(below) - 1, -1, -1)
                )
        for id_, found in children.items():
            node = self.nodes[id_]
            self.nodes[id_] = Node(id_, node.kind, tuple(found))
        return top

    def body(
        self,
        trees: Mapping[str, Element],
        name: str,
        parent: str | None,
        path: str,
        within: tuple[str, ...],
        at: Element,
        scope: Scope,
    ) -> list[tuple[Element, str | None, str, tuple[str, ...], bool, Scope]]:
        """What stands in the <BehaviorTree> of a name, to be built where `at` is; nothing where that is a fault."""
        if name not in trees:
            self.fault("E051", f"no <BehaviorTree> named `{name}`", at)
        elif name in within:
            self.fault("E056", f"SubTree `{name}` contains itself", at)
        elif len(trees[name]) != 1:
            self.fault("E050", f"<BehaviorTree ID={name!r}> must have exactly one child, not {len(trees[name])}", at)
        else:
            return [(trees[name][0], parent, path, (*within, name), False, scope)]
        return []

    def limits(self, element: Element, visited: int, nested: int) -> None:
        """Stop where SubTrees in SubTrees stand for more than anyone can mean."""
        if visited > MAX_NODES or nested > MAX_NESTED:
            what = f"{MAX_NODES} nodes" if visited > MAX_NODES else f"{MAX_NESTED} nested SubTrees"
            self.fault("E004", f"the tree has more than {what}", element)
            raise LlmbtError(self.faults[-1])

    def shape(self, element: Element, negated: bool) -> bool:
        """Whether an element has the children that its kind has to have; otherwise a fault."""
        tag, n = str(element.tag), len(element)
        script = next((k for k in element.attrib if k in CONDITIONS_OF_NODES and k != "_autoremap"), None)
        if script is not None:
            self.fault("E052", f"`{script}` holds a script, and none is run", element, "write a condition of its own")
        elif negated and tag in (Kind.SEQUENCE, Kind.FALLBACK, "SubTree"):
            self.fault("E052", f"<{INVERTER}> goes with one condition", element)
        elif tag == INVERTER and n != 1:
            self.fault("E050", f"<{INVERTER}> has one child, not {n}", element)
        elif tag in (Kind.SEQUENCE, Kind.FALLBACK) and n == 0:
            self.fault("E050", f"<{tag}> needs a child", element)
        elif n and (tag in self.signatures.conditions or tag in self.signatures.actions):
            self.fault("E050", f"<{tag}> has no children", element)
        else:
            return True
        return False

    def node(self, element: Element, path: str, negated: bool, scope: Scope) -> Node | None:
        tag = str(element.tag)
        id_ = element.get("_id") or node_id("n", path)
        if tag in (Kind.SEQUENCE.value, Kind.FALLBACK.value):
            return Node(id_, Kind(tag))
        if tag in MEMORY:
            self.fault(
                "E052",
                f"<{tag}> has memory: an earlier condition that changes would not be looked at again",
                element,
                f"write <{MEMORY[tag]}>, or {AS_IT_STANDS}",
                (MEMORY[tag],),
            )
            return None
        name = str(element.get("ID")) if tag in ("Condition", "Action") else tag
        ports = {str(k): str(v) for k, v in element.attrib.items() if not str(k).startswith("_")}
        for extra in ("name", "ID"):
            if extra not in self.ports(name):
                ports.pop(extra, None)
        for kind, table in (
            (Kind.CONDITION, self.signatures.conditions),
            (Kind.ACTION, self.signatures.actions),
        ):
            if name not in table:
                continue
            if set(ports) != set(table[name]):
                self.fault("E054", f"`{name}` takes {', '.join(table[name]) or 'no ports'}", element)
                return None
            args = tuple(self.value(element, p, ports[p], scope) for p in table[name])
            if kind is Kind.CONDITION:
                return Node(id_, kind, condition=Condition(name, args, negated))
            if negated:
                self.fault("E052", f"<{INVERTER}> goes with one condition", element)
                return None
            return Node(id_, kind, action=ActionCall(name, args))
        if name in BUILTIN:
            self.fault("E052", f"<{name}> is no part of a tree that grows", element, AS_IT_STANDS)
            return None
        known = [*self.signatures.conditions, *self.signatures.actions, *(k.value for k in Kind)]
        close = nearest(name, known)
        self.fault(
            "E053" if not len(element) else "E052",
            f"unknown node `{name}`: {self.known_from} declares no such condition or action",
            element,
            f"did you mean {', '.join(close)}?" if close else "",
            close,
        )
        return None

    def value(self, element: Element, port: str, text: str, scope: Scope) -> str:
        found = scope.value(port, text)
        if found is None:
            title, hint = unwritten(port, text, in_subtree=scope.above is not None)
            self.fault("E086", f"<{element.tag}>: {title}", element, hint)
        return found or ""

    def ports(self, name: str) -> tuple[str, ...]:
        return self.signatures.conditions.get(name) or self.signatures.actions.get(name) or ()

    def provenance(self) -> Provenance:
        node = self.root.find("Provenance")
        if node is None:
            return Provenance()
        goals = []
        for g in node.iterfind("Goal"):
            text, alternative = str(g.get("condition")), str(g.get("alternative", "1"))
            found = parse_condition(text)
            ports = self.signatures.conditions.get(found.name) if found else None
            if found is None or ports is None or len(ports) != len(found.args) or not alternative.isdigit():
                self.fault("E055", f"the provenance names an unknown goal `{text}`", g)
                continue
            goals.append(GoalRecord(str(g.get("id")), found, str(g.get("words", "")), int(alternative)))
        if self.faults:
            raise LlmbtError(*self.faults)
        return Provenance(
            node.get("version", "v000"),
            node.get("parent_sha256", ""),
            tuple(goals),
            tuple((str(e.tag), tuple((str(k), str(v)) for k, v in e.attrib.items())) for e in node if e.tag != "Goal"),
        )


def _model_of(root: Element) -> Signatures:
    conditions: dict[str, tuple[str, ...]] = {}
    actions: dict[str, tuple[str, ...]] = {}
    for kind, table in (("Condition", conditions), ("Action", actions)):
        for n in root.iterfind(f"TreeNodesModel/{kind}"):
            table[str(n.get("ID"))] = tuple(str(p.get("name")) for p in n if p.tag in ("input_port", "inout_port"))
    return Signatures(conditions, actions)


def _pairs(element: Element) -> list[tuple[str, str]]:
    return [(str(k), str(v)) for k, v in element.attrib.items()]


def _defaults_of(root: Element) -> dict[str, dict[str, str]]:
    """The defaults that a file's TreeNodesModel gives the ports of each SubTree."""
    return {
        str(n.get("ID")): {str(p.get("name")): str(p.get("default")) for p in n if p.get("default") is not None}
        for n in root.iterfind("TreeNodesModel/SubTree")
    }
