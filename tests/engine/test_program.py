"""Files as programs: ports and SubTrees are resolved, and what the engine does not run is named, never passed over."""

from __future__ import annotations

import pytest

from llmbt_ir.btcpp.document import parse_document
from llmbt_ir.btcpp.nodes import BUILTIN, CONDITIONS_OF_NODES, NodeKind
from llmbt_ir.condition import ActionCall, Condition
from llmbt_ir.diagnostics import LlmbtError
from llmbt_ir.signatures import Signatures
from llmbt_runtime.engine.load import BUILT_IN, program_of_document
from llmbt_runtime.engine.program import Op, Program
from tests.engine.cases import Case, ours
from tests.engine.equality import as_told, real

SIGNATURES = Signatures({"On": ("target", "place"), "P0": ()}, {"pick": ("target", "place"), "a0": ()})


def load(body: str, *trees: str, model: str = "") -> Program:
    xml = f'<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M">{body}</BehaviorTree>'
    return program_of_document(parse_document(f"{xml}{''.join(trees)}{model}</root>".encode()), SIGNATURES)


def refused(body: str, *trees: str) -> list[tuple[str, str]]:
    with pytest.raises(LlmbtError) as fault:
        load(body, *trees)
    return [(d.code, d.title) for d in fault.value.diagnostics]


def test_a_table_in_pre_order() -> None:
    program = load(
        '<ReactiveFallback _id="f"><Inverter><P0 _id="g"/></Inverter>'
        '<RetryUntilSuccessful num_attempts="3"><Action ID="a0"/></RetryUntilSuccessful></ReactiveFallback>'
    )
    assert [(n.op, n.id, n.children, n.amount) for n in program.nodes] == [
        (Op.REACTIVE_FALLBACK, "f", (1, 3), 0),
        (Op.INVERTER, "M.1", (2,), 0),
        (Op.CONDITION, "g", (), 0),
        (Op.RETRY, "M.2", (4,), 3),
        (Op.ACTION, "M.2.1", (), 0),
    ]
    assert program.parents == (-1, 0, 1, 0, 3)
    assert program.ranks == (0, 0, 0, 1, 0)
    assert program.readers == {Condition("P0"): (2,)}


def test_subtrees_are_written_out_with_their_ports() -> None:
    """Each instance has its own entries: constants, other names, the same name, what is above by _autoremap."""
    program = load(
        '<Sequence><SubTree ID="Fetch" thing="milk" from="table"/><SubTree ID="Outer" thing="coke"/></Sequence>',
        '<BehaviorTree ID="Outer"><Sequence><SubTree ID="Fetch" thing="{=}" from="{thing}"/>'
        '<SubTree ID="Fetch" from="bar" _autoremap="true"/></Sequence></BehaviorTree>',
        '<BehaviorTree ID="Fetch"><pick target="{thing}" place="{from}"/></BehaviorTree>',
    )
    assert [n.action for n in program.nodes if n.action] == [
        ActionCall("pick", ("milk", "table")),
        ActionCall("pick", ("coke", "coke")),
        ActionCall("pick", ("coke", "bar")),
    ]
    assert len({n.id for n in program.nodes}) == len(program)


def test_a_port_of_a_subtree_has_its_models_default() -> None:
    """And so it has in BehaviorTree.CPP."""
    model = '<TreeNodesModel><SubTree ID="T"><input_port name="n" default="2"/></SubTree></TreeNodesModel>'
    inner = (
        '<BehaviorTree ID="T"><RetryUntilSuccessful num_attempts="{n}"><P0 name="P0_0"/></RetryUntilSuccessful>'
        "</BehaviorTree>"
    )
    assert [n.amount for n in load('<SubTree ID="T"/>', inner, model=model).nodes if n.amount] == [2]
    assert [n.amount for n in load('<SubTree ID="T" n="5"/>', inner, model=model).nodes if n.amount] == [5]
    xml = (
        '<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M"><SubTree ID="T"/></BehaviorTree>'
        f"{inner}{model}</root>"
    )
    case = Case(xml, ((),) * 5, {})
    from llmbt_runtime.engine.naive import NaiveEngine

    _, told = real([case], unit_ms=0, once=False)
    assert as_told(told[0]) == ours(case, NaiveEngine)


def test_what_nothing_writes_is_no_entry() -> None:
    inner = '<BehaviorTree ID="T"><pick target="{_hidden}" place="{place}"/></BehaviorTree>'
    assert refused('<SubTree ID="T" place="table" _autoremap="true"/>', inner) == [
        ("E086", "nothing writes the blackboard entry `_hidden` that `target` points to")
    ]
    assert refused('<pick target="{x}" place="table"/>')[0][0] == "E086"
    assert refused('<pick target="{@x}" place="table"/>')[0][0] == "E086"


@pytest.mark.parametrize("name", sorted(BUILTIN))
def test_every_other_node_is_refused_by_its_name(name: str) -> None:
    model = BUILTIN[name]
    ports = "".join(f' {p}="1"' for p, port in model.ports.items() if port.type != "BT::NodeStatus")
    below = {NodeKind.CONTROL: "<P0/><P0/><P0/>", NodeKind.DECORATOR: "<P0/>"}.get(model.kind, "")
    if name.startswith("Switch"):
        below = "<P0/>" * (int(name[-1]) + 1)
    body = f"<{name}{ports}>{below}</{name}>"
    if name == "SubTree":
        load('<SubTree ID="T"/>', '<BehaviorTree ID="T"><P0/></BehaviorTree>')
    elif name in BUILT_IN:
        load(body)
    else:
        assert refused(body) == [("E052", f"this engine does not run <{name}>")]


@pytest.mark.parametrize("key", sorted(CONDITIONS_OF_NODES - {"_autoremap"}))
def test_scripts_before_and_after_a_node_are_refused(key: str) -> None:
    assert refused(f'<P0 {key}="x == 1"/>') == [("E052", f"`{key}` holds a script, and this engine runs none")]


def test_what_else_is_refused() -> None:
    assert refused("<P1/>") == [("E053", "unknown node `P1`: the library declares no such condition or action")]
    assert refused('<On target="x"/>') == [("E054", "`On` takes target, place")]
    assert refused("<Timeout><P0/></Timeout>") == [("E054", "<Timeout> needs msec")]
    inner = '<BehaviorTree ID="T"><Repeat num_cycles="{n}"><P0/></Repeat></BehaviorTree>'
    assert refused('<SubTree ID="T" n="many"/>', inner) == [
        ("E054", "num_cycles of <Repeat> is `many`, and not a whole number")
    ]
    assert refused('<SubTree ID="M"/>')[0][0] == "T117"
    assert refused("<Sequence/>")[0][0] == "T114"


def test_subtrees_that_stand_for_too_much() -> None:
    """17 levels of two SubTrees each."""
    trees = [
        f'<BehaviorTree ID="T{k}"><Sequence><SubTree ID="T{k + 1}"/><SubTree ID="T{k + 1}"/></Sequence></BehaviorTree>'
        for k in range(17)
    ]
    codes = refused('<SubTree ID="T0"/>', *trees, '<BehaviorTree ID="T17"><P0/></BehaviorTree>')
    assert codes == [("E004", "the tree has more than 100000 nodes")]
