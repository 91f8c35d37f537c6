"""The real BehaviorTree.CPP (behaviortreepy 0.1.4, BehaviorTree.CPP 4.8.2) as the oracle of our files and our ticks.

Two things differ, by nature:

* Python nodes of behaviortreepy cannot declare ports, so `for_the_oracle` writes `_target=` in place of `target=` on
  leaves, and gives each leaf its id as instance name. Everything structural is loaded as written.
* When a higher branch takes over, BehaviorTree.CPP starts the new action before it halts the old one, in the same tick.
  Our tick says which action is wanted; the executor halts first and starts then, since there is one robot.
"""

from __future__ import annotations

import json
import random
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from lxml import etree

from llmbt_ir.condition import ActionCall, Condition, Facts, holds
from llmbt_ir.tree import Kind, Node, Tree, goal_tree
from llmbt_ir.tree_xml import GoalRecord, Provenance, write_tree
from llmbt_runtime.record import signatures_of
from llmbt_runtime.tick import NodeStatus, tick
from llmbt_runtime.update.loop import Grown, update
from tests.oracle import Cargo
from tests.strategies import CANONICAL, FLAGS, SHELF, SIGNATURES, canonical_cargo, cargo_library, deep_tree, domain_for

INNER = {"ReactiveSequence", "ReactiveFallback", "Inverter", "SubTree", "BehaviorTree"}
Case = dict[str, Any]


def for_the_oracle(xml: bytes) -> str:
    """The file with ports of leaves underscored and leaves named by their id; nothing else is touched."""
    root = etree.fromstring(xml, etree.XMLParser(huge_tree=True))
    for body in root.iterfind("BehaviorTree"):
        for node in body.iter():
            if node.tag not in INNER:
                attributes = dict(node.attrib)
                node.attrib.clear()
                node.attrib.update({"_" + k.removeprefix("_"): v for k, v in attributes.items()})
                node.set("name", attributes["_id"])
    return str(etree.tostring(root, encoding="unicode"))


def case(xml: bytes, tree: Tree, ticks: list[Case]) -> Case:
    return {
        "xml": for_the_oracle(xml),
        "conditions": sorted({n.condition.name for n in tree.nodes.values() if n.condition}),
        "actions": sorted({n.action.name for n in tree.nodes.values() if n.action}),
        "ticks": ticks,
    }


def engine(cases: list[Case], timeout_s: float = 60) -> list[Case]:
    """What the real engine does, in a process of its own: it can hang and it can crash."""
    script = Path(__file__).with_name("engine.py")
    done = subprocess.run(
        [sys.executable, str(script)],
        input=json.dumps(cases),
        capture_output=True,
        text=True,
        timeout=timeout_s,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    told: list[Case] = json.loads(done.stdout.splitlines()[-1])
    return told


def true_leaves(tree: Tree, facts: Facts) -> list[str]:
    """The condition nodes whose positive literal holds: an <Inverter> turns it in the engine."""
    return [n.id for n in tree.nodes.values() if n.condition and holds(n.condition.fact, facts)]


def our_events(tree: Tree, facts: Facts, reports: dict[str, str]) -> tuple[str, list[tuple[str, str]]]:
    """Our tick, as the engine's leaves would tell it."""
    record = tick(tree, facts, {k: NodeStatus(v) for k, v in reports.items()})
    leaves = []
    for id_, status in record.trace:
        condition = tree[id_].condition
        if condition is not None:
            leaves.append((id_, "SUCCESS" if holds(condition.fact, facts) else "FAILURE"))
        elif tree[id_].action is not None:
            leaves.append((id_, status.value))
    return record.status.value, leaves


def their_events(told: Case) -> tuple[str, list[tuple[str, str]]]:
    return told["status"], [(id_, status) for verb, id_, status in told["events"] if verb != "halt"]


# -- loading ---------------------------------------------------------------------------------------------------------


def compiled() -> bytes:
    goals = tuple(GoalRecord(f"g{i}", c, f'put <it> & "there" {i}') for i, c in enumerate(CANONICAL, 1))
    return write_tree(goal_tree((CANONICAL,)), signatures_of(cargo_library()), Provenance("v000", "", goals))


def expanded() -> Tree:
    cargo = canonical_cargo()
    at = (*(e for e in cargo.at if e[0] != "object_1"), ("obstacle_1", "position_12"))
    start = Cargo(SHELF, at, "object_1")
    found = update(goal_tree((CANONICAL,)), domain_for(start), start.facts(), (CANONICAL,))
    assert isinstance(found, Grown)
    return found.tree


def test_a_compiled_tree_loads_and_ticks() -> None:
    tree = goal_tree((CANONICAL,))
    told = engine([case(compiled(), tree, [{"holds": list(tree["root"].children)}, {"holds": ["g1"]}])])[0]["ticks"]
    assert [t["status"] for t in told] == ["SUCCESS", "FAILURE"]
    assert [e[1] for e in told[1]["events"]] == ["g1", "g2"]


def test_an_expanded_tree_does_in_the_engine_what_its_certificate_predicts() -> None:
    tree = expanded()
    cargo = Cargo(
        SHELF, (*(e for e in canonical_cargo().at if e[0] != "object_1"), ("obstacle_1", "position_12")), "object_1"
    )
    found = update(tree, domain_for(cargo), cargo.facts(), (CANONICAL,))
    states, actions = found.certificate.states, found.certificate.actions  # type: ignore[union-attr]
    xml = write_tree(tree, signatures_of(cargo_library()), Provenance("v001", "ab" * 32))
    told = engine([case(xml, tree, [{"holds": true_leaves(tree, s)} for s in states])])[0]["ticks"]
    started = [e[1] for t in told for e in t["events"] if e[0] == "start"]
    assert [tree[s].action for s in started] == [a.call for a in actions]
    assert [t["status"] for t in told] == ["RUNNING"] * len(actions) + ["SUCCESS"]


def test_a_thousand_levels_load_and_tick() -> None:
    tree = deep_tree(1_000)
    alternating = true_leaves(tree, frozenset({Condition("P0")}))
    told = engine([case(write_tree(tree, SIGNATURES), tree, [{"holds": alternating}])])[0]
    assert their_events(told["ticks"][0]) == our_events(tree, frozenset({Condition("P0")}), {})


@pytest.mark.parametrize(
    "body",
    ["<Gone/>", "<ReactiveSequence/>", "<P0/><P0/>", '<SubTree ID="Nowhere"/>', "<Inverter/>", "<P0 undeclared='1'/>"],
)
def test_what_we_refuse_the_engine_refuses_too(body: str) -> None:
    xml = f'<root BTCPP_format="4" main_tree_to_execute="Main"><BehaviorTree ID="Main">{body}</BehaviorTree></root>'
    told = engine([{"xml": xml, "conditions": ["P0"], "actions": [], "ticks": [{"holds": []}]}])[0]
    assert "error" in told


# -- ticking ---------------------------------------------------------------------------------------------------------


def random_tree(rng: random.Random, depth: int = 4) -> Tree:
    nodes: dict[str, Node] = {}

    def grow(id_: str, level: int) -> str:
        if level == 0 or (level < depth and rng.random() < 0.3):
            if rng.random() < 0.3:
                nodes[id_] = Node(id_, Kind.ACTION, action=ActionCall(f"a{rng.randrange(6)}"))
            else:
                flag = Condition(rng.choice(FLAGS).name, (), rng.random() < 0.3)
                nodes[id_] = Node(id_, Kind.CONDITION, condition=flag)
            return id_
        below = tuple(grow(f"{id_}.{i}", level - 1) for i in range(1, rng.randint(1, 4) + 1))
        nodes[id_] = Node(id_, rng.choice([Kind.SEQUENCE, Kind.FALLBACK]), below)
        return id_

    return Tree(grow("n", depth), nodes)


def compare(seeds: range) -> int:
    cases, ours = [], []
    for seed in seeds:
        rng = random.Random(seed)
        tree = random_tree(rng)
        ticks, expected = [], []
        for _ in range(6):
            facts = frozenset(f for f in FLAGS if rng.random() < 0.5)
            actions = [n.id for n in tree.nodes.values() if n.action]
            reports = {a: rng.choice(["SUCCESS", "FAILURE", "RUNNING", "RUNNING"]) for a in actions}
            ticks.append({"holds": true_leaves(tree, facts), "reports": reports})
            expected.append(our_events(tree, facts, reports))
        cases.append(case(write_tree(tree, SIGNATURES), tree, ticks))
        ours.append(expected)
    for seed, expected, told in zip(seeds, ours, engine(cases), strict=True):
        assert [their_events(t) for t in told["ticks"]] == expected, f"seed {seed}"
    return sum(len(e) for e in ours)


def test_status_and_ticked_leaves_agree_over_random_trees_and_facts() -> None:
    assert compare(range(300)) == 1_800


@pytest.mark.slow
def test_status_and_ticked_leaves_agree_over_many_random_trees_and_facts() -> None:
    assert compare(range(1_000, 6_000)) == 30_000


def test_the_scripted_sequence_and_the_order_of_halting() -> None:
    """Seq[Fb(g1, Seq(p1, a1)), Fb(g2, Seq(p2, a2))]: an action further up starts before the one below is halted."""
    leaves = [Node(c, Kind.CONDITION, condition=Condition(c.upper())) for c in ("g1", "p1", "g2", "p2")]
    acts = [Node(a, Kind.ACTION, action=ActionCall(a)) for a in ("a1", "a2")]
    inner = [
        Node("root", Kind.SEQUENCE, ("f1", "f2")),
        Node("f1", Kind.FALLBACK, ("g1", "s1")),
        Node("s1", Kind.SEQUENCE, ("p1", "a1")),
        Node("f2", Kind.FALLBACK, ("g2", "s2")),
        Node("s2", Kind.SEQUENCE, ("p2", "a2")),
    ]
    tree = Tree("root", {n.id: n for n in (*inner, *leaves, *acts)})
    signatures = type(SIGNATURES)({c.condition.name: () for c in leaves if c.condition}, {"a1": (), "a2": ()})
    script = ["g1 p1 p2", "p1 p2", "g1 p1 p2", "g1 p1 p2", "g1 p1", "g1 p2", "g1 g2"]
    told = engine([case(write_tree(tree, signatures), tree, [{"holds": s.split()} for s in script])])[0]["ticks"]
    assert [(t["status"], [f"{v} {i}" for v, i, _ in t["events"] if v != "tick"]) for t in told] == [
        ("RUNNING", ["start a2"]),
        ("RUNNING", ["start a1", "halt a2"]),
        ("RUNNING", ["halt a1", "start a2"]),
        ("RUNNING", ["run a2"]),
        ("FAILURE", ["halt a2"]),
        ("RUNNING", ["start a2"]),
        ("SUCCESS", ["halt a2"]),
    ]
    for text, t in zip(script, told, strict=True):
        facts = frozenset(Condition(s.upper()) for s in text.split())
        assert our_events(tree, facts, {}) == their_events(t)
