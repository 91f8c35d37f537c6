"""Random trees of every node that the engine runs, with what happens to them: facts, and what the actions answer."""

from __future__ import annotations

import random
from dataclasses import dataclass, field
from functools import cached_property
from xml.sax.saxutils import quoteattr

from llmbt_ir.btcpp.document import parse_document
from llmbt_ir.condition import Condition, Facts
from llmbt_ir.signatures import Signatures
from llmbt_runtime.engine.engine import Engine, Leaves, tick_once
from llmbt_runtime.engine.load import program_of_document
from llmbt_runtime.engine.program import Op, Program
from llmbt_runtime.facts import change_between
from llmbt_runtime.tick import NodeStatus

FLAGS = tuple(f"P{i}" for i in range(6))
ACTS = tuple(f"a{i}" for i in range(4))
SIGNATURES = Signatures(dict.fromkeys(FLAGS, ()), dict.fromkeys(ACTS, ()))
COMPOSITES = ("Sequence", "Fallback", "ReactiveSequence", "ReactiveFallback")
PLAIN = ("Inverter", "ForceSuccess", "ForceFailure")
COUNTING = {"RetryUntilSuccessful": "num_attempts", "Repeat": "num_cycles"}
TIMED = {"Timeout": "msec", "Delay": "delay_msec"}
ANSWERS = ("SUCCESS", "FAILURE", "RUNNING", "RUNNING", "RUNNING")

Event = tuple[str, str, str]
"""What was done with which leaf and what it returned: tick (a condition), start, run, halt."""
Told = list[tuple[str, list[Event]]]
"""For each tick the root's status and the events; at the end what halting the tree brought about."""


@dataclass(frozen=True)
class Case:
    """A file, the facts at each tick, and each action's answers: the next one each time it is asked, in a circle."""

    xml: str
    facts: tuple[tuple[str, ...], ...]
    answers: dict[str, list[str]]

    @cached_property
    def program(self) -> Program:
        """The file as the engines tick it."""
        return program_of_document(parse_document(self.xml.encode()), SIGNATURES)

    @cached_property
    def names(self) -> list[str]:
        """The instance name of each node, '' where it has none."""
        document = parse_document(self.xml.encode())
        order: list[str] = []
        stack = [document.kids(document.trees[0])[0]]
        while stack:
            index = stack.pop()
            element = document[index]
            call = element.tag == "SubTree"
            stack.extend(reversed(document.kids(document.by_id[element.get("ID")] if call else index)))
            order += [] if call else [element.get("name")]
        assert len(order) == len(self.program)
        return order


@dataclass
class _Grower:
    """Grows a file. `unit_ms`: how far ticks are apart, 0 for trees without timers; `endless`: counts of -1 too."""

    rng: random.Random
    unit_ms: int
    endless: bool
    trees: list[str] = field(default_factory=list)
    leaves: list[tuple[str, str]] = field(default_factory=list)

    def leaf(self) -> str:
        if self.rng.random() < 0.08:
            return self.rng.choice(["<AlwaysSuccess/>", "<AlwaysFailure/>"])
        tag = self.rng.choice(ACTS) if self.rng.random() < 0.45 else self.rng.choice(FLAGS)
        name = f"{tag}_{len(self.leaves)}"
        self.leaves.append((tag, name))
        explicit = self.rng.random() < 0.1
        kind = "Action" if tag in ACTS else "Condition"
        # straight under a ReactiveSequence the explicit syntax is refused, so it goes with an Inverter
        return f'<Inverter><{kind} ID="{tag}" name="{name}"/></Inverter>' if explicit else f'<{tag} name="{name}"/>'

    def amount(self, tag: str, entries: dict[str, str]) -> str:
        """A decorator's port: a number, or an entry of the blackboard that holds one."""
        timed = tag in TIMED
        known = [k for k in entries if k.startswith("t" if timed else "n")]
        if known and self.rng.random() < 0.7:
            key = self.rng.choice(known)
            return f"{{{key}}}"
        return self.number(timed=timed)

    def number(self, *, timed: bool) -> str:
        if timed:
            return str(self.rng.randint(0, 3) * self.unit_ms + self.unit_ms // 2)
        return str(self.rng.choice([0, 1, 2, 2, 3, *([-1] if self.endless else [])]))

    def node(self, depth: int, entries: dict[str, str]) -> str:
        draw = self.rng.random()
        if depth == 0 or draw < 0.12:
            return self.leaf()
        if self.rng.random() < 0.3:
            return self.guarded(depth, entries)
        if draw < 0.62:
            tag = self.rng.choice(COMPOSITES)
            below = "".join(self.node(depth - 1, entries) for _ in range(self.rng.randint(1, 4)))
            return f"<{tag}>{below}</{tag}>"
        if draw < 0.70:
            return self.subtree(depth, entries)
        if draw < 0.78:
            tag = self.rng.choice(PLAIN)
            return f"<{tag}>{self.node(depth - 1, entries)}</{tag}>"
        ports = TIMED if self.unit_ms and self.rng.random() < 0.6 else COUNTING
        tag = self.rng.choice(list(ports))
        return f'<{tag} {ports[tag]}="{self.amount(tag, entries)}">{self.node(depth - 1, entries)}</{tag}>'

    def guarded(self, depth: int, entries: dict[str, str]) -> str:
        """The shape that our trees have: of several goals each holds, or something is done about it."""
        rows = []
        for _ in range(self.rng.randint(2, 4)):
            self.leaves.append((self.rng.choice(FLAGS), f"g_{len(self.leaves)}"))
            tag, name = self.leaves[-1]
            way = self.node(depth - 1, entries)
            rows.append(f'<ReactiveFallback><{tag} name="{name}"/>{way}</ReactiveFallback>')
        return f"<ReactiveSequence>{''.join(rows)}</ReactiveSequence>"

    def subtree(self, depth: int, entries: dict[str, str]) -> str:
        """A branch in a <BehaviorTree> of its own: entries given as constants, under other names, or by _autoremap."""
        autoremap = self.rng.random() < 0.4
        inside = dict(entries) if autoremap else {}
        given = {}
        for key in ("n1", "n2", "t1", "t2"):
            if key[0] == "t" and not self.unit_ms:
                continue
            same = [k for k in entries if k[0] == key[0]]
            draw = self.rng.random()
            if draw < 0.35:
                inside[key] = given[key] = self.number(timed=key[0] == "t")
            elif draw < 0.7 and same:
                outer = self.rng.choice(same)
                inside[key] = entries[outer]
                given[key] = "{=}" if outer == key else f"{{{outer}}}"
        name = f"T{len(self.trees)}"
        self.trees.append("")
        at = len(self.trees) - 1
        body = self.node(depth - 1, inside)
        self.trees[at] = f'<BehaviorTree ID="{name}">{body}</BehaviorTree>'
        ports = "".join(f" {k}={quoteattr(v)}" for k, v in given.items())
        return f'<SubTree ID="{name}"{" _autoremap=" + chr(34) + "true" + chr(34) if autoremap else ""}{ports}/>'


def random_case(seed: int, *, unit_ms: int = 0, endless: bool = True, ticks: int = 8) -> Case:
    """A tree and what happens to it; equal seeds give equal ones."""
    rng = random.Random(seed)
    grower = _Grower(rng, unit_ms, endless)
    body = grower.node(rng.randint(2, 6), {})
    trees = "".join(grower.trees)
    xml = f'<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M">{body}</BehaviorTree>{trees}</root>'
    held = {f for f in FLAGS if rng.random() < 0.5}
    facts = []
    for _ in range(ticks):
        held ^= {f for f in FLAGS if rng.random() < 0.2}
        facts.append(tuple(sorted(held)))
    answers = {n: [rng.choice(ANSWERS) for _ in range(rng.randint(1, 5))] for tag, n in grower.leaves if tag in ACTS}
    return Case(xml, tuple(facts), answers)


# -- ours ----------------------------------------------------------------------------------------------------------


class Script:
    """Leaves that answer as a case says, and note what is done with them."""

    def __init__(self, program: Program, names: list[str], answers: dict[str, list[str]]) -> None:
        self.program, self.names, self.answers = program, names, answers
        self.asked = dict.fromkeys(answers, 0)
        self.events: list[Event] = []

    def start(self, node: int) -> NodeStatus:
        """The next answer."""
        return self._answer("start", node)

    def poll(self, node: int) -> NodeStatus:
        """The next answer."""
        return self._answer("run", node)

    def halt(self, node: int) -> None:
        """Noted."""
        self.events.append(("halt", self.names[node], ""))

    def _answer(self, verb: str, node: int) -> NodeStatus:
        name = self.names[node]
        row = self.answers[name]
        status = NodeStatus(row[self.asked[name] % len(row)])
        self.asked[name] += 1
        self.events.append((verb, name, status.value))
        return status


class Telling(list[tuple[int, NodeStatus]]):
    """A trace that is told among the events: the actions are there already."""

    def __init__(self, script: Script) -> None:
        super().__init__()
        self.script = script

    def append(self, row: tuple[int, NodeStatus]) -> None:
        """Note a condition."""
        node, status = row
        if self.script.program.nodes[node].op is Op.CONDITION:
            self.script.events.append(("tick", self.script.names[node], status.value))

    def extend(self, rows: object) -> None:
        """Note several."""
        for row in rows:  # type: ignore[attr-defined]
            self.append(row)


def facts_of(names: tuple[str, ...]) -> Facts:
    """The facts that hold, from their names."""
    return frozenset(Condition(n) for n in names)


def ours(
    case: Case,
    engine_of: type,
    *,
    unit_ms: int = 0,
    once: bool = False,
    told: bool = True,
    wrap: object = None,
    limit: int = 200,
) -> Told:
    """What one of our engines does. `told`: with the conditions. `wrap` goes around the leaves."""
    program = case.program
    script = Script(program, case.names, case.answers)
    leaves: Leaves = wrap(script) if callable(wrap) else script
    engine: Engine = engine_of(program, leaves)
    if told:
        engine.trace = Telling(script)
    before: Facts = frozenset()
    found: Told = []
    for k, names in enumerate(case.facts):
        facts = facts_of(names)
        change, before = change_between(before, facts), facts
        now = k * unit_ms
        status = tick_once(engine, change, now, limit=limit) if once else engine.tick(change, now)
        found.append((status.value, script.events[:]))
        script.events.clear()
    engine.halt()
    found.append(("", script.events[:]))
    return found
