"""One faulty file for each code of the linter, as (codes it must give, the file). `body` stands in tree Main.

Each file has been tried on BehaviorTree.CPP 4.10.0 with the leaves of MODEL registered (22 November 2026): it
refuses every T1xx file but those in LOADS, when it loads, builds or first ticks it, and loads every T2xx file (no_main
only where the program itself names the tree) and every clean one.
"""

from __future__ import annotations

MODEL = (
    '<TreeNodesModel><Condition ID="On"><input_port name="target"/><input_port name="place"/></Condition>'
    '<Condition ID="Ok"/><Action ID="act"/><Action ID="go"><input_port name="to" default="home"/></Action>'
    "</TreeNodesModel>"
)


def tree(body: str, rest: str = MODEL, main: str = "Main") -> str:
    """A file whose tree Main holds `body` in line 3."""
    return (
        f'<root BTCPP_format="4" main_tree_to_execute="{main}">\n<BehaviorTree ID="Main">\n{body}\n</BehaviorTree>\n'
        f"{rest}\n</root>\n"
    )


def other(name: str, body: str = "<Ok/>") -> str:
    """A further tree."""
    return f'<BehaviorTree ID="{name}">{body}</BehaviorTree>'


GUARD = "<ReactiveFallback><Ok/><act/></ReactiveFallback>"
SEQ = "<ReactiveSequence>{}</ReactiveSequence>"

CORPUS: dict[str, tuple[tuple[str, ...], str]] = {
    "outermost": (("T101",), "<tree/>"),
    "no_id": (("T103",), f'<root BTCPP_format="4"><BehaviorTree><Ok/></BehaviorTree>{MODEL}</root>'),
    "name_with_a_space": (("T104",), tree("<Ok/><!-- -->", MODEL + other("b c"), "Main")),
    "name_with_a_dot": (("T104",), tree('<SubTree ID="a.b"/>', MODEL + other("a.b"))),
    "reserved_name": (("T104",), tree("<root/>")),
    "tree_twice": (("T105",), tree("<Ok/>", MODEL + other("Main"))),
    "model_twice": (("T105",), tree("<Ok/>", MODEL.replace("</Tree", '<Action ID="act"/></Tree'))),
    "tree_called_as_a_node": (("T106",), tree('<SubTree ID="Sequence"/>', MODEL + other("Sequence"))),
    "two_tops": (("T107",), tree("<Ok/><Ok/>")),
    "no_top": (("T107",), tree("")),
    "too_deep": (("T108",), tree("<Inverter>" * 256 + "<Ok/>" + "</Inverter>" * 256)),
    "unknown_node": (("T109",), tree("<Onn/>")),
    "unknown_composite": (("T109",), tree("<ReactiveSequenc><Ok/></ReactiveSequenc>")),
    "unknown_port": (("T110",), tree('<On target="a" place="b" plac="c"/>')),
    "port_of_a_composite": (("T110",), tree('<ReactiveSequence times="3"><Ok/></ReactiveSequence>')),
    "no_number": (("T111",), tree('<RetryUntilSuccessful num_attempts="many"><Ok/></RetryUntilSuccessful>')),
    "id_missing": (("T112",), tree('<Condition target="a"/>')),
    "id_in_compact_syntax": (("T113",), tree('<Ok ID="Ok"/>')),
    "decorator_of_two": (("T114",), tree("<Inverter><Ok/><Ok/></Inverter>")),
    "empty_composite": (("T114",), tree("<ReactiveSequence/>")),
    "leaf_with_a_child": (("T114",), tree("<Ok><Ok/></Ok>")),
    "subtree_with_a_child": (("T114",), tree('<SubTree ID="B"><Ok/></SubTree>', MODEL + other("B"))),
    "switch_short": (("T114",), tree('<Switch2 variable="{v}" case_1="1" case_2="2"><Ok/></Switch2>')),
    "if_of_one": (("T114",), tree("<IfThenElse><Ok/></IfThenElse>")),
    "explicit_below_reactive": (("T115",), tree(SEQ.format('<Condition ID="Ok"/>'))),
    "no_such_subtree": (("T116",), tree('<SubTree ID="Elsewhere"/>')),
    "circle": (("T117",), tree('<SubTree ID="B"/>', MODEL + other("B", '<SubTree ID="Main"/>'))),
    "itself": (("T117",), tree('<SubTree ID="Main"/>')),
    "same_subtree_name": (
        ("T118",),
        tree(SEQ.format('<SubTree ID="B" name="x"/><SubTree ID="B" name="x"/>'), MODEL + other("B")),
    ),
    "two_models": (("T119",), tree("<Ok/>", MODEL + "<TreeNodesModel/>")),
    "no_such_main": (("T120",), tree("<Ok/>", MODEL, "Mian")),
    "no_tree": (("T120",), f'<root BTCPP_format="4">{MODEL}</root>'),
    "instruction": (("T121",), tree("<Ok/>", MODEL + "<?php ?>")),
    "port_name": (("T122",), tree("<Ok/>", MODEL.replace('"to"', '"1to"'))),
    "model_of_nothing": (("T123",), tree("<Ok/>", MODEL.replace("</Tree", '<Akcion ID="x"/></Tree'))),
    "control_character": (("T124",), tree('<Ok name="a\x7fb"/>')),
    "mandatory_port": (
        ("T125",),
        tree(
            '<SubTree ID="B"/>',
            MODEL.replace("</Tree", '<SubTree ID="B"><input_port name="p"/></SubTree></Tree') + other("B"),
        ),
    ),
    "no_format": (("T201",), tree("<Ok/>").replace('BTCPP_format="4" ', "")),
    "memory": (("T202",), tree(SEQ.format("<Sequence><Ok/></Sequence>"))),
    "after_always_success": (("T203",), tree("<Fallback><AlwaysSuccess/><Ok/></Fallback>")),
    "after_forced_failure": (
        ("T203",),
        tree("<ReactiveSequence><ForceFailure><Ok/></ForceFailure><Ok/></ReactiveSequence>"),
    ),
    "after_a_subtree_that_never_fails": (
        ("T203",),
        tree('<Fallback><SubTree ID="B"/><Ok/></Fallback>', MODEL + other("B", "<AlwaysSuccess/>")),
    ),
    "after_inverted_failure": (
        ("T203",),
        tree("<Fallback><Inverter><AlwaysFailure/></Inverter><Ok/></Fallback>"),
    ),
    "checked_twice": (("T204",), tree(SEQ.format('<On target="a" place="b"/><Ok/><On place="b" target="a"/>'))),
    "never_both": (("T205",), tree(SEQ.format("<Ok/><Inverter><Ok/></Inverter>"))),
    "unguarded": (("T206",), tree(SEQ.format("<Ok/><act/>"))),
    "unguarded_in_a_subtree": (
        ("T206",),
        tree(SEQ.format('<SubTree ID="B"/>'), MODEL + other("B", SEQ.format("<act/>"))),
    ),
    "unused": (("T207",), tree("<Ok/>", MODEL + other("B"))),
    "half_a_pointer": (("T208",), tree('<On target="{a" place="b"/>')),
    "undeclared": (("T209",), tree("<Whatever/>", "")),
    "no_main": (("T210",), tree("<Ok/>", MODEL + other("B")).replace(' main_tree_to_execute="Main"', "")),
    "no_value": (("T211",), tree('<On target="a"/>')),
    "namespace": (("T212",), tree('<Ok x:y="1"/>').replace("<root", '<root xmlns:x="urn:x"')),
    "misspelt": (("T214",), tree('<Ok _skipif="a == 1"/>')),
}
LOADS = ("tree_twice", "model_twice", "port_name", "model_of_nothing")
"""Errors that 4.10.0 itself lets pass: the later of two trees wins, and other declarations than a SubTree's are
not read; Groot2 and the engines that read the model go by them."""

CLEAN: dict[str, str] = {
    "guarded": tree(GUARD),
    "chain": tree(
        "<ReactiveFallback><ReactiveSequence><Ok/><On target='a' place='b'/></ReactiveSequence>"
        "<ReactiveSequence><Ok/><act/></ReactiveSequence><ReactiveSequence><On target='a' place='c'/><act/>"
        "</ReactiveSequence></ReactiveFallback>"
    ),
    "memory_alone": tree("<Sequence><Ok/><act/></Sequence>"),
    "subtree": tree(
        '<ReactiveFallback><Ok/><SubTree ID="B" x="{y}" _autoremap="true"/></ReactiveFallback>',
        MODEL + other("B", SEQ.format("<act/>")),
    ),
    "remarks": tree('<Ok _id="a" _note="{x"/>', MODEL + "<Provenance><Goal words='a {b'/></Provenance>"),
    "script": tree('<Sequence><Script code="a:=1; b:=2"/><Ok _skipIf="a == 1"/></Sequence>'),
    "twice_around_an_action": tree("<Sequence><Ok/><act/><Ok/></Sequence>"),
    "skipped": tree('<Fallback><AlwaysSuccess _skipIf="1 == 2"/><Ok/></Fallback>'),
    "at_the_limit": tree("<Inverter>" * 255 + "<Ok/>" + "</Inverter>" * 255),
    "defaults": tree(SEQ.format("<ReactiveFallback><Ok/><go/></ReactiveFallback>")),
    "unicode": tree('<Ok name="Prüfung 1: läuft?"/>'),
}
