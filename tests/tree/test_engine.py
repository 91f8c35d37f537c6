"""What is exported runs in BehaviorTree.CPP itself (`behaviortreepy`), in subprocesses with a time limit."""

from __future__ import annotations

import json
import random
import subprocess
import sys
from pathlib import Path

import pytest

from llmbt.exports.btlog import number, read_btlog, transitions
from llmbt.exports.plugin import plugin_files
from llmbt.main import main
from llmbt.replay import Moment
from llmbt_ir.condition import ActionCall, Condition
from llmbt_ir.signatures import Signatures
from llmbt_ir.tree import Kind, Node, Tree
from llmbt_ir.tree_xml import parse_tree, write_tree
from tests.strategies import FLAGS, SIGNATURES, deep_tree

# -- .btlog --------------------------------------------------------------------------------------------------------

RECORD = """
import json, sys, time
import behaviortreepy as b
cases = json.load(open(sys.argv[1]))
for k, case in enumerate(cases):
    facts = {}
    factory = b.BehaviorTreeFactory()
    for name in case["conditions"]:
        factory.register_simple_condition(
            name, lambda n, name=name: b.NodeStatus.SUCCESS if name in facts["now"] else b.NodeStatus.FAILURE)
    for name in case["actions"]:
        factory.register_simple_stateful_action(
            name, lambda n: b.NodeStatus.RUNNING, lambda n: b.NodeStatus.RUNNING, lambda n: None)
    factory.register_behavior_tree_from_text(case["xml"])
    tree = factory.create_tree("Main")
    logger = b.FileLogger(tree, f"{sys.argv[2]}/{k}.btlog")
    time.sleep(0.02)
    for now in case["ticks"]:
        facts["now"] = now
        tree.tick_exactly_once()
    time.sleep(0.06)
    logger.flush()
    del logger, tree, factory
"""


def random_tree(rng: random.Random, levels: int) -> Tree:
    """Composites and leaves without arguments, at most `levels` deep."""
    nodes: dict[str, Node] = {}
    pending = [("n", levels)]
    while pending:
        id_, left = pending.pop()
        kind = rng.random()
        if left == 1 or (kind < 0.5 and id_ != "n"):
            if kind < 0.35:
                condition = Condition(rng.choice(FLAGS).name, (), rng.random() < 0.3)
                nodes[id_] = Node(id_, Kind.CONDITION, condition=condition)
            else:
                nodes[id_] = Node(id_, Kind.ACTION, action=ActionCall(f"a{rng.randrange(6)}"))
            continue
        children = tuple(f"{id_}.{i}" for i in range(rng.randint(1, 4)))
        nodes[id_] = Node(id_, rng.choice((Kind.SEQUENCE, Kind.FALLBACK)), children)
        pending += [(c, left - 1) for c in children]
    return Tree("n", nodes)


def test_our_recordings_are_those_of_the_engine(tmp_path: Path) -> None:
    """Every transition of every node in its order, over random trees and facts, and through a SubTree."""
    rng = random.Random(4)
    trees = [random_tree(rng, 5) for _ in range(40)] + [deep_tree(205)]
    cases, stories = [], []
    for tree in trees:
        states = [frozenset(f for f in FLAGS if rng.random() < 0.5) for _ in range(8)]
        stories.append([Moment(float(k), s) for k, s in enumerate(states)])
        cases.append(
            {
                "xml": write_tree(tree, SIGNATURES).decode(),
                "conditions": [f.name for f in FLAGS],
                "actions": [*(f"a{i}" for i in range(6)), "wave"],
                "ticks": [[f.name for f in s] for s in states],
            }
        )
    (tmp_path / "cases.json").write_text(json.dumps(cases))
    command = [sys.executable, "-c", RECORD, str(tmp_path / "cases.json"), str(tmp_path)]
    subprocess.run(command, check=True, timeout=60, capture_output=True)
    for k, (tree, story) in enumerate(zip(trees, stories, strict=True)):
        theirs = read_btlog((tmp_path / f"{k}.btlog").read_bytes())[2]
        numbered = number(parse_tree(write_tree(tree, SIGNATURES), "t", SIGNATURES))
        ours = tuple(transitions(tree, numbered.numbers, story))
        assert [t[1:] for t in ours] == [t[1:] for t in theirs], cases[k]["xml"]


def test_the_recording_of_a_run(runs: Path, tmp_path: Path) -> None:
    out = tmp_path / "o.btlog"
    for run in ("drop", "obstacle_at_place"):
        assert main(["tree", "export", str(runs / run), "--format", "btlog", "-o", str(out)]) == 0
        xml, start, found = read_btlog(out.read_bytes())
        assert start == 0
        assert b"_uid" in xml and b"TreeNodesModel" in xml
        last: dict[int, int] = {}
        assert list(found) == sorted(found, key=lambda t: t[0])
        for usec, uid, status in found:
            assert last.get(uid, 0) != status, (usec, uid)
            last[uid] = status
        assert found[-2][1:] == (1, 2)  # the root succeeds,
        assert found[-1][1:] == (1, 0)  # and is idle again
    succeeded = sum(1 for _, uid, status in found if status == 2 and f'_uid="{uid}"'.encode() in xml)
    assert succeeded > 10
    assert main(["tree", "export", str(runs / "drop" / "tree.v001.xml"), "--format", "btlog", "-o", str(out)]) == 0
    assert read_btlog(out.read_bytes())[2][-1][0] <= 1_200_000


def test_a_tree_without_a_story_has_no_recording(runs: Path, tmp_path: Path) -> None:
    lone = tmp_path / "t.xml"
    lone.write_bytes((runs / "drop" / "tree.v001.xml").read_bytes())
    assert main(["tree", "export", str(lone), "--format", "btlog"]) == 1


# -- plugin --------------------------------------------------------------------------------------------------------

ROBOT = """
import json, sys
sys.path.insert(0, sys.argv[1])
from behaviortreepy import NodeStatus
from engine import Engine
from leaves import Robot, CONDITIONS, ACTIONS
from pathlib import Path
from llmbt.history import read_run
from llmbt.replay import domain_of_run
from llmbt_atl.state import apply
from llmbt_ir.condition import ActionCall, Condition

run = read_run(Path(sys.argv[2]))
domain = domain_of_run(run)

class World(Robot):
    def __init__(self):
        self.facts, self.left, self.stopped = run.stage("v001").state, 0, []

def condition(name):
    return lambda self, *values: Condition(name, values) in self.facts
def start(name):
    def begin(self, *values):
        self.left = 2
    return begin
def poll(name):
    def ask(self, *values):
        self.left -= 1
        if self.left:
            return NodeStatus.RUNNING
        action = domain.action(ActionCall(name, values))
        self.facts = apply(action, self.facts)
        return NodeStatus.SUCCESS
    return ask
def stop(name):
    return lambda self, *values: self.stopped.append((name, *values))

for name in CONDITIONS:
    setattr(World, CONDITIONS[name][0], condition(name))
for name in ACTIONS:
    for verb, made in (("start", start), ("poll", poll), ("stop", stop)):
        setattr(World, f"{verb}_{ACTIONS[name][0]}", made(name))

world = World()
engine = Engine(world, str(Path(sys.argv[2]) / "tree.v001.xml"))
told = []
dropped = swapped = False
for _ in range(300):
    status = engine.tick()
    told.append(status.name)
    if not dropped and ("start", "place", ["object_1", "position_12"]) in engine.log:
        world.facts, dropped = run.stage("v002").state, True
    if status == NodeStatus.FAILURE and not swapped:
        engine.swap(str(Path(sys.argv[2]) / "tree.v002.xml"))
        swapped = True
    if status == NodeStatus.SUCCESS:
        break
halfway = len(engine.log)
world.facts = run.stage("v002").state
engine.tick()
engine.swap(str(Path(sys.argv[2]) / "tree.v001.xml"))
print(json.dumps({"told": told, "log": engine.log[:halfway], "after": engine.log[halfway:], "stopped": world.stopped}))
"""


def test_a_running_tree_is_swapped_for_its_next_version(runs: Path, tmp_path: Path) -> None:
    """The exported Python stubs over the exact effects of the templates: the object is dropped, v001 fails, v002 takes
    over and reaches the goals; and an action that runs is halted before its tree is taken away."""
    out = tmp_path / "plugin"
    assert main(["tree", "export", str(runs / "drop"), "--format", "btcpp", "-o", str(out)]) == 0
    command = [sys.executable, "-c", ROBOT, str(out), str(runs / "drop")]
    done = subprocess.run(command, check=False, timeout=60, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["told"].count("FAILURE") == 1
    assert told["told"][-1] == "SUCCESS"
    log = [f"{what} {name}({', '.join(args)})" for what, name, args in told["log"]]
    assert log[:6] == [
        "start pick(object_1, sorting_area)",
        "SUCCESS pick(object_1, sorting_area)",
        "start place(object_1, position_12)",
        "halt place(object_1, position_12)",
        "start pick(object_1, workbench)",
        "SUCCESS pick(object_1, workbench)",
    ]
    assert [line for line in log if line.startswith("SUCCESS")][-1] == "SUCCESS place(object_6, position_32)"
    assert [e[0] for e in told["after"]] == ["start", "halt"]
    assert told["stopped"][-1] == ["pick", "object_1", "workbench"]


def test_the_exported_folder(runs: Path, tmp_path: Path) -> None:
    out = tmp_path / "p"
    assert main(["tree", "export", str(runs / "drop"), "--format", "btcpp"]) == 2
    assert main(["tree", "export", str(runs / "drop"), "--btcpp", "-o", str(out)]) == 0
    assert main(["tree", "export", str(runs / "drop"), "--format", "btcpp", "-o", str(out)]) == 2
    assert main(["tree", "export", str(runs / "drop"), "--format", "btcpp", "-o", str(out), "--force"]) == 0
    assert (out / "tree.xml").read_bytes() == (runs / "drop" / "tree.v002.xml").read_bytes()
    plugin = (out / "plugin.cpp").read_text()
    assert 'registerNodeType<llmbt::Pick>("pick")' in plugin
    assert 'registerNodeType<llmbt::HandEmpty>("HandEmpty")' in plugin
    assert 'BT::InputPort<std::string>("place")' in (out / "leaves.hpp").read_text()


def test_names_that_are_no_identifiers() -> None:
    odd = Signatures({"is-on": ("class", "2nd"), "is_on": ()}, {"Skill": ("self",), "skill": (), "löffel": ("für",)})
    found = plugin_files(b"", odd)
    compile(found["leaves.py"], "leaves.py", "exec")
    header = found["leaves.hpp"].decode()
    classes = [line.split()[1] for line in header.splitlines() if line.startswith("class ")]
    assert len(classes) == len(set(classes)) == 6
    assert all(c.isidentifier() and c.isascii() for c in classes)
    compile(found["engine.py"], "engine.py", "exec")


def test_the_cpp_stubs_compile(runs: Path, tmp_path: Path) -> None:
    """Against BehaviorTree.CPP's headers where BTCPP_INCLUDE names them (tried on 4.10.0 with -Wall -Wextra)."""
    import os

    include = os.environ.get("BTCPP_INCLUDE")
    if not include:
        pytest.skip("BTCPP_INCLUDE does not name BehaviorTree.CPP's headers")
    assert main(["tree", "export", str(runs / "drop"), "--format", "btcpp", "-o", str(tmp_path / "p")]) == 0
    for name in ("plugin.cpp", "main.cpp"):
        command = ["g++", "-std=c++17", "-fsyntax-only", "-Wall", "-Wextra", "-DBT_PLUGIN_EXPORT", f"-I{include}", name]
        done = subprocess.run(command, cwd=tmp_path / "p", check=False, timeout=120, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert done.stderr == ""


def test_the_form_is_what_the_files_name_ends_in(runs, tmp_path):
    assert main(["tree", "export", str(runs / "drop"), "-o", str(tmp_path / "a.svg")]) == 0
    assert (tmp_path / "a.svg").read_bytes().startswith(b"<svg")
    assert main(["tree", "export", str(runs / "drop"), "-o", str(tmp_path / "a.png")]) == 2
    assert main(["tree", "export", str(runs / "drop")]) == 2
