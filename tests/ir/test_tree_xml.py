"""Trees as BehaviorTree.CPP 4 XML: what is written is read back, and hostile files end as diagnostics."""

from __future__ import annotations

import time

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from llmbt_ir.condition import Condition
from llmbt_ir.diagnostics import Diagnostic, LlmbtError
from llmbt_ir.signatures import Signatures
from llmbt_ir.tree import Kind, Tree
from llmbt_ir.tree_xml import SPLIT_DEPTH, GoalRecord, Provenance, parse_tree, write_tree
from tests.strategies import SIGNATURES, deep_tree, trees

TEXT = st.text(st.characters(exclude_categories=("Cs", "Cc"), exclude_characters="\ufffe\uffff"), max_size=20)


def faults(xml: str | bytes, signatures: Signatures | None = SIGNATURES) -> tuple[Diagnostic, ...]:
    """The diagnostics of a file that must not load, in bounded time and without a traceback."""
    began = time.monotonic()
    with pytest.raises(LlmbtError) as caught:
        parse_tree(xml if isinstance(xml, bytes) else xml.encode(), "t.xml", signatures)
    assert time.monotonic() - began < 20
    assert all(d.code[0] == "E" and d.span is not None and d.span.source == "t.xml" for d in caught.value.diagnostics)
    return caught.value.diagnostics


def main(body: str, rest: str = "") -> str:
    return (
        '<root BTCPP_format="4" main_tree_to_execute="Main">\n'
        f'<BehaviorTree ID="Main">\n{body}\n</BehaviorTree>\n{rest}</root>\n'
    )


# -- round trip ----------------------------------------------------------------------------------------------------


@given(trees())
def test_what_is_written_is_read_back(tree: Tree) -> None:
    data = write_tree(tree, SIGNATURES)
    file = parse_tree(data, "t.xml", SIGNATURES)
    assert file.tree == tree
    assert write_tree(file.tree, file.signatures) == data
    assert all(file.lines[id_] > 0 for id_ in tree.nodes)


@given(trees())
def test_a_file_is_read_by_its_own_model(tree: Tree) -> None:
    data = write_tree(tree, SIGNATURES)
    assert parse_tree(data, "t.xml").tree == tree
    assert write_tree(parse_tree(data, "t.xml").tree, parse_tree(data, "t.xml").signatures) == data


@given(
    trees(max_leaves=5),
    TEXT,
    TEXT,
    st.lists(st.tuples(st.sampled_from(["kind", "cause"]), TEXT), max_size=2, unique_by=lambda p: p[0]),
)
def test_provenance_is_read_back(tree: Tree, words: str, sha: str, pairs: list[tuple[str, str]]) -> None:
    goal = Condition("On", ("object_1", "position_12"), True)
    goals = (GoalRecord("g1", goal, words), GoalRecord("g2", ~goal, "", 2))
    given_ = Provenance("v012", sha, goals, (("Step", tuple(pairs)),))
    file = parse_tree(write_tree(tree, SIGNATURES, given_), "t.xml", SIGNATURES)
    assert file.provenance == given_
    assert file.goals == ((goal,), (~goal,))


@pytest.mark.parametrize("words", ["bell \a", "nul \0", "lone \ud800", "\ufffe"])
def test_words_that_xml_cannot_hold_do_not_break_the_file(words: str) -> None:
    provenance = Provenance(goals=(GoalRecord("g1", Condition("HandEmpty"), words),))
    file = parse_tree(write_tree(deep_tree(3), SIGNATURES, provenance), "t.xml", SIGNATURES)
    assert file.provenance.goals[0].words == words[:-1] + "\ufffd"


def test_the_canonical_form() -> None:
    """Attributes in a fixed order, one node a line, the model sorted: a text diff of two versions is small."""
    data = write_tree(deep_tree(3), SIGNATURES, Provenance("v001", "ab", (GoalRecord("g1", Condition("P0"), "p & q"),)))
    assert (
        data.decode()
        == """<?xml version="1.0" encoding="UTF-8"?>
<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main">
    <ReactiveSequence _id="d0">
      <P0 _id="c0"/>
      <ReactiveFallback _id="d1">
        <Inverter><P0 _id="c1"/></Inverter>
        <wave _id="end"/>
      </ReactiveFallback>
    </ReactiveSequence>
  </BehaviorTree>
  <TreeNodesModel>
    <Action ID="wave"/>
    <Condition ID="P0"/>
  </TreeNodesModel>
  <Provenance version="v001" parent_sha256="ab">
    <Goal id="g1" condition="P0" words="p &amp; q"/>
  </Provenance>
</root>
"""
    )


@given(trees())
def test_no_node_with_memory_is_written(tree: Tree) -> None:
    root = etree.fromstring(write_tree(tree, SIGNATURES))
    assert {n.tag for n in root.iter("Sequence", "Fallback", "SequenceWithMemory", "AsyncSequence")} == set()


def test_a_thousand_levels_are_split_and_read_back() -> None:
    tree = deep_tree(1_000)
    data = write_tree(tree, SIGNATURES)
    root = etree.fromstring(data, etree.XMLParser(huge_tree=True))
    bodies = root.findall("BehaviorTree")
    assert len(bodies) == 6
    for body in bodies:
        assert max(sum(1 for _ in n.iterancestors("ReactiveSequence", "ReactiveFallback")) for n in body.iter()) < 256
        assert max(sum(1 for _ in n.iterancestors()) for n in body.iter()) <= SPLIT_DEPTH + 2
    assert parse_tree(data, "t.xml", SIGNATURES).tree == tree
    assert write_tree(parse_tree(data, "t.xml").tree, SIGNATURES) == data


def test_trees_without_ids_get_them_from_their_place() -> None:
    xml = main(
        '<ReactiveSequence><P0/><ReactiveFallback><P0 name="again"/><wave/></ReactiveFallback></ReactiveSequence>'
    )
    one, two = (parse_tree(xml.encode(), s, SIGNATURES).tree for s in ("a.xml", "b.xml"))
    assert one == two
    assert len(one) == 5


def test_explicit_ids_inverters_and_comments_are_understood() -> None:
    xml = main(
        '<!-- why --><ReactiveSequence><Condition ID="P0"/>'
        "<Inverter><Inverter><P1/></Inverter></Inverter></ReactiveSequence>"
    )
    tree = parse_tree(xml.encode(), "t.xml", SIGNATURES).tree
    assert [n.condition for n in tree.preorder()][1:] == [Condition("P0"), Condition("P1")]


# -- faults: each with its line ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("code", "line", "body"),
    [
        ("E052", 3, "<Sequence><P0/></Sequence>"),
        ("E052", 4, "<ReactiveSequence>\n<Fallback><P0/></Fallback></ReactiveSequence>"),
        ("E052", 3, "<Inverter><ReactiveSequence><P0/></ReactiveSequence></Inverter>"),
        ("E052", 3, "<Inverter><wave/></Inverter>"),
        ("E052", 3, '<Inverter><SubTree ID="Main"/></Inverter>'),
        ("E052", 3, '<Parallel success_count="1"><P0/><P1/></Parallel>'),
        ("E050", 3, "<Inverter/>"),
        ("E050", 3, "<Inverter><P0/><P1/></Inverter>"),
        ("E050", 3, "<ReactiveSequence/>"),
        ("E050", 3, "<P0><P1/></P0>"),
        ("E050", 2, "<P0/><P1/>"),
        ("E050", 2, ""),
        ("E053", 4, "<ReactiveSequence><P0/>\n<Holdin/></ReactiveSequence>"),
        ("E054", 3, "<HandEmpty target='x'/>"),
        ("E054", 3, "<On target='x'/>"),
        ("E051", 3, '<SubTree ID="Nowhere"/>'),
        ("E056", 3, '<SubTree ID="Main"/>'),
        ("E057", 4, '<ReactiveSequence _id="a"><P0 _id="b"/>\n<P1 _id="b"/></ReactiveSequence>'),
    ],
)
def test_a_tree_that_this_engine_does_not_run(code: str, line: int, body: str) -> None:
    found = faults(main(body))
    assert (found[0].code, found[0].span and found[0].span.line) == (code, line)


def test_memory_nodes_are_refused_with_what_to_write() -> None:
    (found,) = faults(main("<ReactiveFallback><P0/><Sequence><P1/><wave/></Sequence></ReactiveFallback>"))
    assert found.candidates == ("ReactiveSequence",)
    assert "memory" in found.title


def test_an_unknown_leaf_is_named_with_the_nearest() -> None:
    (found,) = faults(main('<Holdng target="x"/>'))
    assert found.candidates[0] == "Holding"
    assert "did you mean Holding" in found.help


def test_subtrees_in_a_circle() -> None:
    rest = '<BehaviorTree ID="A"><SubTree ID="B"/></BehaviorTree><BehaviorTree ID="B"><SubTree ID="A"/></BehaviorTree>'
    assert faults(main('<SubTree ID="A"/>', rest))[0].code == "E056"


def test_two_behavior_trees_of_one_name() -> None:
    (found,) = faults(main("<P0/>", '<BehaviorTree ID="Main"><wave/></BehaviorTree>\n'))
    assert (found.code, found.span and found.span.line) == ("E057", 5)


@pytest.mark.parametrize(
    ("code", "xml"),
    [
        ("E050", "<tree/>"),
        ("E050", '<root BTCPP_format="3"><BehaviorTree ID="Main"><P0/></BehaviorTree></root>'),
        ("E050", '<a:root xmlns:a="u" BTCPP_format="4"/>'),
        (
            "E051",
            '<root BTCPP_format="4" main_tree_to_execute="Gone"><BehaviorTree ID="Main"><P0/></BehaviorTree></root>',
        ),
        ("E051", '<root BTCPP_format="4"/>'),
        ("E003", ""),
        ("E003", "<root"),
        ("E003", b"\x00\x01\x02\xff"),
        ("E003", b"PK\x03\x04" + bytes(range(256))),
        ("E003", '<?xml version="1.0" encoding="utf-7"?><root/>'),
        ("E003", '<?xml version="1.0" encoding="nonsense"?><root/>'),
        ("E003", '<root BTCPP_format="4">&undefined;</root>'),
        ("E005", '<!DOCTYPE root [<!ENTITY x SYSTEM "file:///etc/passwd">]><root>&x;</root>'),
        ("E005", '<!DOCTYPE root SYSTEM "http://example.invalid/x.dtd"><root/>'),
    ],
)
def test_what_is_no_tree_file_at_all(code: str, xml: str | bytes) -> None:
    assert faults(xml)[0].code == code


def test_a_billion_laughs() -> None:
    entities = "".join(f'<!ENTITY l{i} "{f"&l{i - 1};" * 10}">' for i in range(1, 10))
    xml = f'<?xml version="1.0"?>\n<!DOCTYPE lolz [<!ENTITY l0 "lol">{entities}]>\n<root>&l9;</root>'
    (found,) = faults(xml)
    assert (found.code, found.span and found.span.line) == ("E005", 2)


def test_a_billion_laughs_of_subtrees() -> None:
    """30 trees of two SubTrees each stand for 2**30 nodes."""
    twice = '<SubTree ID="T{1}"/><SubTree ID="T{1}"/>'
    level = f'<BehaviorTree ID="T{{0}}"><ReactiveSequence>{twice}</ReactiveSequence></BehaviorTree>\n'
    rest = "".join(level.format(i, i + 1) for i in range(30)) + '<BehaviorTree ID="T30"><P0/></BehaviorTree>'
    assert faults(main('<SubTree ID="T0"/>', rest))[-1].code == "E004"


def test_a_chain_of_very_many_subtrees() -> None:
    rest = "".join(f'<BehaviorTree ID="T{i}"><SubTree ID="T{i + 1}"/></BehaviorTree>' for i in range(20_000))
    assert faults(main('<SubTree ID="T0"/>', rest + '<BehaviorTree ID="T20000"><P0/></BehaviorTree>'))[0].code == "E004"


@pytest.mark.parametrize("levels", [5_000, 100_000])
def test_very_many_levels(levels: int) -> None:
    xml = main("<ReactiveSequence>" * levels + "<P0/>" + "</ReactiveSequence>" * levels)
    (found,) = faults(xml)
    assert found.code == "E004"
    assert "SubTree" in found.help


def test_very_many_attributes() -> None:
    assert faults(main("<P0 " + " ".join(f'a{i}=""' for i in range(100_000)) + "/>"))[0].code == "E004"


def test_very_many_faults_are_cut_short() -> None:
    assert len(faults(main("<ReactiveSequence>" + "<Nope/>" * 500 + "</ReactiveSequence>"))) == 10


@given(st.binary(max_size=200) | st.text(max_size=200).map(lambda t: t.encode("utf-8", "replace")))
def test_noise_is_a_diagnostic(data: bytes) -> None:
    assert faults(data)


@given(trees(max_leaves=6), st.data())
def test_a_damaged_file_loads_or_is_a_diagnostic(tree: Tree, data: st.DataObject) -> None:
    xml = bytearray(write_tree(tree, SIGNATURES))
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(xml) - 1))
        xml[at : at + data.draw(st.integers(0, 9))] = data.draw(
            st.binary(max_size=4) | st.sampled_from([b"<", b"/>", b'"'])
        )
    try:
        parse_tree(bytes(xml), "t.xml", SIGNATURES)
    except LlmbtError as fault:
        assert all(d.code.startswith("E") for d in fault.diagnostics)


def test_every_kind_that_is_written_is_reactive() -> None:
    assert {k.value for k in Kind} == {"Condition", "Action", "ReactiveSequence", "ReactiveFallback"}
