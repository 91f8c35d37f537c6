"""What a tick costs: ours incremental and naive, py_trees, BehaviorTree.CPP, on one and the same trees.

Each measurement is a process of its own: `python -m tests.bench.engines ENGINE SHAPE SCENARIO [RUN]` prints one.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from llmbt_ir.condition import ActionCall, Condition, Facts
from llmbt_ir.tree import Kind, Node, Tree
from llmbt_ir.tree_xml import read_tree
from llmbt_runtime.engine.incremental import IncrementalEngine
from llmbt_runtime.engine.naive import NaiveEngine
from llmbt_runtime.engine.program import Program, program_of_tree
from llmbt_runtime.facts import FactBase
from llmbt_runtime.tick import NodeStatus, tick
from tests.bench.clock import section

ENGINES = {
    "incremental": "ours, incremental",
    "drive": "the same, by llmbt execute --no-update",
    "execute": "the same, by llmbt execute",
    "naive": "ours, naive (any node)",
    "pure": "ours, naive (reactive trees: rollouts)",
    "py_trees": "py_trees 2.6, memory=False",
    "btcpp": "BehaviorTree.CPP 4.8.2 (behaviortreepy)",
}
LOOPS = ("drive", "execute")
SCENARIOS = ("nothing", "one", "every")
GOALS = {"97": 16, "997": 166, "9997": 1_666}
LIMIT_S = 120
NOTES = """\
Polling the action and finding what changed are included. The leaves of all engines are Python over the same facts;
ours has them from a base that is written to. By llmbt execute: the whole loop of the executor against a world of
facts, with what that world costs; there a fact that flips was not predicted, so that the tree is certified anew (twice
in a tick: for the action to be halted, and for the one to be started), which costs what the tree costs. One fact
flips: a goal is lost in one tick and comes back in the next, so that another action takes over each time. Every node:
all actions end at once; no fact changes (in a world they take time). "-": not to be had, or the tree grows then.
"""


# -- trees and what happens to them ------------------------------------------------------------------------------------


def goals_tree(goals: int) -> Tree:
    """ReactiveSequence of ReactiveFallback(goal, ReactiveSequence(two preconditions, action)), 6 nodes a goal."""
    nodes = [Node("root", Kind.SEQUENCE, tuple(f"f{i}" for i in range(goals)))]
    for i in range(goals):
        nodes += [
            Node(f"f{i}", Kind.FALLBACK, (f"g{i}", f"s{i}")),
            Node(f"g{i}", Kind.CONDITION, condition=Condition("On", (f"object_{i}", f"position_{i}"))),
            Node(f"s{i}", Kind.SEQUENCE, (f"p{i}", f"q{i}", f"a{i}")),
            Node(f"p{i}", Kind.CONDITION, condition=Condition("Holding", (f"object_{i}",))),
            Node(f"q{i}", Kind.CONDITION, condition=Condition("Free", (f"position_{i}",))),
            Node(f"a{i}", Kind.ACTION, action=ActionCall("place", (f"object_{i}", f"position_{i}"))),
        ]
    return Tree("root", {n.id: n for n in nodes})


@dataclass(frozen=True)
class Situation:
    """A tree, the facts that hold, the fact that comes and goes (or None), and what its actions answer."""

    tree: Tree
    facts: Facts
    flip: Condition | None
    answer: NodeStatus


def situation(shape: str, scenario: str, run: str | None) -> Situation:
    """Of a tree of a size, or of the newest version of a real run in a folder.

    nothing: all goals hold but the last, whose action runs; of a run, its action in the state that it recorded. one: a
    goal that holds (the middle one) is lost in one tick and comes back in the next; of a run, the first fact that makes
    a difference. every: each condition has a fact of its own, so set, and every action succeeds at once, so that every
    node is visited.
    """
    if run is None:
        n = GOALS[shape]
        tree = goals_tree(n)
        leaves = [c for node in tree.nodes.values() if (c := node.condition) is not None]
        last = Condition("On", (f"object_{n - 1}", f"position_{n - 1}"))
        facts = frozenset(c for c in leaves if c != last)
        flip = Condition("On", (f"object_{n // 2}", f"position_{n // 2}"))
    else:
        from llmbt.history import read_run

        stage = next(s for s in reversed(read_run(Path(run)).stages) if s.name == shape)
        tree, facts = read_tree(stage.version.path).tree, stage.state
        flip = _wanted_elsewhere(tree, facts)
    if scenario == "every":
        return _every_node(tree)
    return Situation(tree, facts, flip if scenario == "one" else None, NodeStatus.RUNNING)


def _wanted_elsewhere(tree: Tree, facts: Facts) -> Condition:
    """A fact whose loss or arrival makes the tree want another action."""
    here = tick(tree, facts).action
    asked = [n.condition.fact for n in tree.preorder() if n.condition is not None]
    return next(f for f in asked if tick(tree, facts ^ {f}).action not in (here, None))


def _every_node(tree: Tree) -> Situation:
    """The same tree with a fact for each condition leaf, set so that each node is visited and the root succeeds; an
    action that would have to fail for that becomes such a condition."""
    nodes, facts = dict(tree.nodes), set()
    stack = [(tree.root, True)]
    while stack:
        id_, succeeds = stack.pop()
        node = tree[id_]
        if node.condition is not None or (node.action is not None and not succeeds):
            own = Condition("Leaf", (id_,))
            nodes[id_] = Node(id_, Kind.CONDITION, condition=own)
            facts |= {own} if succeeds else set()
        for rank, child in enumerate(node.children):
            goes_on = node.kind is Kind.SEQUENCE
            stack.append((child, goes_on if rank + 1 < len(node.children) else succeeds))
    return Situation(replace(tree, nodes=nodes), frozenset(facts), None, NodeStatus.SUCCESS)


# -- engines -----------------------------------------------------------------------------------------------------------


class Subject(Protocol):
    """An engine under measurement, which counts the conditions that it evaluates."""

    @property
    def evaluations(self) -> int:
        """So far."""

    def tick(self) -> str:
        """Let what happens happen, and tick."""


@dataclass
class Answering:
    """Leaves that always answer the same."""

    answer: NodeStatus

    def start(self, _node: int) -> NodeStatus:
        """The answer."""
        return self.answer

    def poll(self, _node: int) -> NodeStatus:
        """The answer."""
        return self.answer

    def halt(self, _node: int) -> None:
        """Nothing to stop."""


class Told:
    """Ours, over a base of facts that is written to."""

    def __init__(self, given: Situation, engine_of: Callable[[Program, Any], Any]) -> None:
        self.engine = engine_of(program_of_tree(given.tree), Answering(given.answer))
        self.base, self.flip, self.holds = FactBase(given.facts), given.flip, given.flip in given.facts

    @property
    def evaluations(self) -> int:
        """Counted by the engine."""
        return int(self.engine.evaluations)

    def tick(self) -> str:
        """Write, take what changed, tick."""
        if self.flip is not None:
            (self.base.remove if self.holds else self.base.add)(self.flip)
            self.holds = not self.holds
        return str(self.engine.tick(self.base.take(), 0))


class Pure:
    """Ours, the pure function of tree and facts that plans are rolled out with."""

    evaluations = 0

    def __init__(self, given: Situation) -> None:
        self.tree, self.facts, self.flip = given.tree, set(given.facts), given.flip
        self.reports = {n.id: given.answer for n in given.tree.nodes.values() if n.action}

    def tick(self) -> str:
        """Write, tick."""
        if self.flip is not None:
            self.facts ^= {self.flip}
        record = tick(self.tree, self.facts, self.reports)  # type: ignore[arg-type]
        self.evaluations += sum(1 for id_, _ in record.trace if self.tree[id_].condition is not None)
        return str(record.status)


class PyTrees:
    """py_trees: memoryless composites over the same facts."""

    def __init__(self, given: Situation) -> None:
        import py_trees
        from py_trees.common import Status

        self.evaluations = 0
        self.facts, self.flip = set(given.facts), given.flip
        subject, facts = self, self.facts
        answer = Status[given.answer.value]

        class Ask(py_trees.behaviour.Behaviour):
            def __init__(self, condition: Condition) -> None:
                super().__init__(str(condition))
                self.fact, self.negated = condition.fact, condition.negated

            def update(self) -> Status:
                subject.evaluations += 1
                return Status.SUCCESS if (self.fact in facts) != self.negated else Status.FAILURE

        class Act(py_trees.behaviour.Behaviour):
            def update(self) -> Status:
                return answer

        made: dict[str, Any] = {}
        for node in reversed(tuple(given.tree.preorder())):
            if node.condition is not None:
                made[node.id] = Ask(node.condition)
            elif node.action is not None:
                made[node.id] = Act(str(node.action))
            else:
                kind = py_trees.composites.Sequence if node.kind is Kind.SEQUENCE else py_trees.composites.Selector
                made[node.id] = kind(node.id, memory=False, children=[made[c] for c in node.children])
        self.root = made[given.tree.root]

    def tick(self) -> str:
        """Write, tick."""
        if self.flip is not None:
            self.facts ^= {self.flip}
        self.root.tick_once()
        return str(self.root.status.value)


class BehaviorTreeCpp:
    """BehaviorTree.CPP with leaves in Python, over the same facts."""

    def __init__(self, given: Situation) -> None:
        import behaviortreepy as bt

        self.evaluations = 0
        self.facts, self.flip = set(given.facts), given.flip
        succeeds, fails = bt.NodeStatus.SUCCESS, bt.NodeStatus.FAILURE
        answer = getattr(bt.NodeStatus, given.answer.value)
        asked = {n.id: (c.fact, c.negated) for n in given.tree.nodes.values() if (c := n.condition) is not None}

        def ask(node: Any) -> Any:
            self.evaluations += 1
            fact, negated = asked[node.name()]
            return succeeds if (fact in self.facts) != negated else fails

        self.factory = bt.BehaviorTreeFactory()
        self.factory.register_simple_condition("Ask", ask)
        self.factory.register_simple_stateful_action("Act", lambda _: answer, lambda _: answer, lambda _: None)
        self.tree = self.factory.create_tree_from_text(self._xml(given.tree))

    @staticmethod
    def _xml(tree: Tree) -> str:
        lines = ['<root BTCPP_format="4"><BehaviorTree ID="Main">']
        stack = [(tree.root, False)]
        while stack:
            id_, closing = stack.pop()
            node = tree[id_]
            if closing:
                lines.append(f"</{node.kind.value}>")
            elif node.children:
                lines.append(f"<{node.kind.value}>")
                stack.append((id_, True))
                stack.extend((c, False) for c in reversed(node.children))
            else:
                lines.append(f'<{"Ask" if node.condition else "Act"} name="{id_}"/>')
        return "\n".join([*lines, "</BehaviorTree></root>"])

    def tick(self) -> str:
        """Write, tick."""
        if self.flip is not None:
            self.facts ^= {self.flip}
        return str(self.tree.tick_exactly_once().name)


MADE: dict[str, Callable[[Situation], Subject]] = {
    "incremental": lambda s: Told(s, IncrementalEngine),
    "naive": lambda s: Told(s, NaiveEngine),
    "pure": Pure,
    "py_trees": PyTrees,
    "btcpp": BehaviorTreeCpp,
}


# -- measuring ---------------------------------------------------------------------------------------------------------


def measured(engine: str, shape: str, scenario: str, run: str | None) -> dict[str, float]:
    """Microseconds of CPU time and condition evaluations a tick: the least of five rounds, once it runs."""
    given = situation(shape, scenario, run)
    if engine in LOOPS:
        from tests.bench.loops import in_a_world

        return in_a_world(given, run, update=engine == "execute")
    subject = MADE[engine](given)
    wanted = NodeStatus.SUCCESS if scenario == "every" else NodeStatus.RUNNING
    for _ in range(4):  # the first takes all facts in
        assert subject.tick() == wanted, (engine, shape, scenario)
    start = time.process_time()
    subject.tick(), subject.tick()
    rounds = max(2, min(20_000, round(0.08 / max(1e-7, time.process_time() - start)))) * 2
    before = subject.evaluations
    best = float("inf")
    for _ in range(5):
        start = time.process_time()
        for _ in range(rounds):
            subject.tick()
        best = min(best, time.process_time() - start)
    return {"us": 1e6 * best / rounds, "evaluations": (subject.evaluations - before) / (5 * rounds)}


def _apart(*arguments: str) -> dict[str, float] | None:
    """One measurement in a process of its own; None where it is not installed, or takes too long."""
    command = [sys.executable, "-m", "tests.bench.engines", *arguments]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=LIMIT_S)
    except subprocess.TimeoutExpired:
        return None
    if done.returncode != 0 and not any(why in done.stderr for why in ("No module named", "GrowsError")):
        raise RuntimeError(done.stderr[-1000:])
    return dict(json.loads(done.stdout)) if done.returncode == 0 else None


def _row(engine: str, shape: str, run: str | None) -> str:
    cells = []
    for scenario in SCENARIOS:
        possible = engine not in LOOPS or scenario != "every"
        found = _apart(engine, shape, scenario, *([run] if run else [])) if possible else None
        cells.append(f"{found['us']:9.2f} {found['evaluations']:7.0f}" if found else f"{'-':>9} {'-':>7}")
    return f"{ENGINES[engine]:<42}" + " ".join(cells)


def table(shape: str, run: str | None) -> None:
    """What a tick of one tree costs, by engine and scenario."""
    size = len(situation(shape, "nothing", run).tree)
    title = f"{size} nodes" + (f" ({shape} of the run below)" if run else "")
    print(f"{title:<42}{'nothing changed':>17} {'one fact flips':>17} {'every node':>17}", flush=True)
    for engine in ENGINES:
        print(_row(engine, shape, run), flush=True)
    print()


def ticking() -> None:
    """The tables, and beside them a whole physical tick."""
    title = "Ticking: microseconds of CPU time (least of 5 rounds) and condition evaluations a tick"
    with section(title), tempfile.TemporaryDirectory() as folder:
        print(NOTES)
        done = Path(folder, "run")
        physical, share, ticks, versions = _physical(done)
        for shape, run in (*((s, None) for s in GOALS), *((v, str(done)) for v in versions)):
            table(shape, run)
        print(f"a whole physical tick, mean of {ticks} of the canonical run with an obstacle, its start left out:")
        print(f"{physical:.0f} us, of it {share:.0f} us for the tree's tick; the rest is physics, sensing and updates")


def _physical(folder: Path) -> tuple[float, float, int, list[str]]:
    """A physical run: CPU time a tick, and of the tree's tick, in microseconds; the ticks; the versions that act."""
    from llmbt.execution import Order, execute_tree
    from llmbt.history import read_run
    from llmbt.progress import Progress
    from llmbt_ir.scene import load_scene
    from llmbt_ir.tree import goal_tree
    from llmbt_ir.tree_xml import write_tree
    from llmbt_runtime.engine.ticker import Ticker, Wanted
    from llmbt_runtime.record import signatures_of
    from tests.strategies import CANONICAL, cargo_library

    spent, inner, begun = 0.0, Ticker.tick, 0.0

    def timed(self: Ticker, tree: Tree, facts: FactBase) -> Wanted:
        nonlocal spent, begun
        start = time.process_time()
        begun = begun or start
        found = inner(self, tree, facts)
        spent += time.process_time() - start
        return found

    order = Order(load_scene("cargo_sorting"), disturb="obstacle_at_place")
    data = write_tree(goal_tree((CANONICAL,)), signatures_of(cargo_library()))
    Ticker.tick = timed  # type: ignore[method-assign]
    document = execute_tree(data, "tree.xml", folder, order, Progress(quiet=True))
    total = time.process_time() - begun
    Ticker.tick = inner  # type: ignore[method-assign]
    ticks = int(document["ticks"])
    versions = [s.name for s in read_run(folder).stages if s.state]
    return 1e6 * total / ticks, 1e6 * spent / ticks, ticks, versions


if __name__ == "__main__":
    engine, shape, scenario, *run = sys.argv[1:]
    print(json.dumps(measured(engine, shape, scenario, run[0] if run else None)))
