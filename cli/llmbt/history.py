"""The story of a run, from its folder: what each version was made for, what happened under it, where a node is from."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from llmbt_atl.library import load_library
from llmbt_ir.condition import Facts, parse_condition
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Span, nearest
from llmbt_ir.scene import load_scene
from llmbt_ir.signatures import Signatures
from llmbt_ir.tree import Kind, Tree, node_id
from llmbt_ir.tree_xml import GoalRecord, TreeFile, read_tree
from llmbt_ir.versions import Version, VersionStore
from llmbt_runtime.record import signatures_of

__all__ = ["Event", "Link", "Run", "Stage", "origin", "read_run", "state_of"]


@dataclass(frozen=True, slots=True)
class Event:
    """One line of `events.jsonl`."""

    kind: str
    time_s: float
    text: str
    details: Mapping[str, Any]


@dataclass(frozen=True)
class Stage:
    """One version with what happened until the next: the events after it was installed. `library`: the leaves that the
    run's library has, where the folder tells which that is."""

    version: Version
    events: tuple[Event, ...]
    library: Signatures | None = None

    @property
    def name(self) -> str:
        """As `v007`."""
        return self.version.name

    @property
    def record(self) -> Mapping[str, Any]:
        """Its record."""
        return self.version.record

    @cached_property
    def file(self) -> TreeFile:
        """Its tree file."""
        try:
            return read_tree(self.version.path)
        except LlmbtError:  # written by hand, without a TreeNodesModel
            if self.library is None:
                raise
            return read_tree(self.version.path, self.library)

    @property
    def tree(self) -> Tree:
        """Its tree."""
        return self.file.tree

    @property
    def steps(self) -> Sequence[Mapping[str, str]]:
        """The edits that made it."""
        return tuple(self.record.get("steps", ()))

    @property
    def state(self) -> Facts:
        """What was observed when it was installed; empty for a version that no run made."""
        return state_of(self.record)


@dataclass(frozen=True)
class Run:
    """A run's folder, read. What a folder lacks is empty: a run that was killed has versions and no story."""

    folder: Path
    stages: tuple[Stage, ...]
    result: Mapping[str, Any]
    reply: Mapping[str, Any]
    goals: tuple[Mapping[str, Any], ...]
    steps: tuple[Mapping[str, Any], ...]

    @property
    def request(self) -> str:
        """The words of the request, where it is known."""
        return str(self.stages[0].record.get("request") or self.reply.get("request") or "")

    @property
    def stated(self) -> tuple[GoalRecord, ...]:
        """The goals, as the first version that names them does: a tree written by hand does not."""
        return next((goals for s in self.stages if (goals := s.file.provenance.goals)), ())

    @property
    def grew(self) -> bool:
        """Whether its tree could grow: not where it was ticked as it stands (`execute --no-update`)."""
        return self.result.get("update", self.stages[0].record.get("update", True)) is not False

    def stage(self, name: str) -> Stage:
        """A version by its name, as `v002` or `2`. E081 where there is none."""
        wanted = name if name.startswith("v") else f"v{name:0>3}"
        for stage in self.stages:
            if stage.name == wanted:
                return stage
        names = tuple(s.name for s in self.stages)
        close = nearest(wanted, names)
        title = f"the run has no version `{name}`"
        raise LlmbtError(
            Diagnostic(
                "E081", title, Span(str(self.folder)), help=f"it has {names[0]} to {names[-1]}", candidates=close
            )
        )


def read_run(folder: Path) -> Run:
    """Read a run's folder. E080 where it holds no version; E082 where a file of it is damaged."""
    versions = VersionStore(folder).versions() if folder.is_dir() else ()
    if not versions:
        hint = "give the folder that `llmbt run -o DIR` or `llmbt execute -o DIR` wrote"
        raise LlmbtError(
            Diagnostic("E080", f"`{folder}` holds no run: no tree.vNNN.json", Span(str(folder)), help=hint)
        )
    story = _events(folder / "events.jsonl")
    under: dict[str, list[Event]] = {v.name: [] for v in versions}
    now = versions[0].name
    for event in story:
        if event.kind == "update" and event.details.get("version") in under:
            now = str(event.details["version"])
        else:
            under[now].append(event)
    result = _json(folder / "result.json")
    library = _leaves(str(result["scene"])) if result.get("scene") else None
    return Run(
        folder,
        tuple(Stage(v, tuple(under[v.name]), library) for v in versions),
        result,
        _json(folder / "reply.json"),
        tuple(_json(folder / "conditions.json").get("goals", ())),
        tuple(_json(folder / "steps.json").get("steps", ())),
    )


def _leaves(scene: str) -> Signatures | None:
    """The leaves of a scene's library; None where there is no such scene any more."""
    try:
        found = load_scene(scene)
        return signatures_of(load_library(found.library, beside=Path(found.source).parent))
    except LlmbtError:
        return None


def _json(path: Path) -> Mapping[str, Any]:
    if not path.is_file():
        return {}
    try:
        found = json.loads(path.read_bytes())
    except (ValueError, OSError) as fault:
        raise LlmbtError(Diagnostic("E082", f"not the JSON of a run: {fault}", Span(str(path)))) from None
    return found if isinstance(found, dict) else {}


def _events(path: Path) -> tuple[Event, ...]:
    if not path.is_file():
        return ()
    found = []
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
        if not line.strip():
            continue
        try:
            raw = json.loads(line)
            found.append(Event(str(raw["kind"]), float(raw["sim_time_s"]), str(raw["text"]), raw))
        except (ValueError, KeyError, TypeError) as fault:
            span = Span(str(path), number, text=line[:200])
            raise LlmbtError(Diagnostic("E082", f"not an event of a run: {fault!r}", span)) from None
    return tuple(found)


def state_of(record: Mapping[str, Any]) -> Facts:
    """The state that a version's record holds."""
    certificate = record.get("certificate")
    texts = certificate.get("state", ()) if isinstance(certificate, Mapping) else ()
    return frozenset(c for t in texts if (c := parse_condition(str(t))) is not None)


# -- where a node is from ------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Link:
    """One link of the chain from a node to the request: the node, its part, the version and edit that made it, and
    those that moved it since."""

    node: str
    label: str
    role: str
    version: str = ""
    step: Mapping[str, Any] | None = None
    moves: tuple[tuple[str, Mapping[str, Any]], ...] = ()


def origin(run: Run, node: str) -> tuple[tuple[Link, ...], ...]:
    """The chains of the nodes that `node` names, by id, by the beginning of one, or by label (of several equal ones
    in the newest version that has it, each). E083 where it names none, or the tree did not grow."""
    if not run.grew:
        title = "the tree of this run was ticked as it stands: where a node is from, only its author can tell"
        raise LlmbtError(Diagnostic("E083", title, Span(str(run.folder))))
    stage, ids = _find(run, node)
    return tuple(_chain(run, stage, id_) for id_ in ids)


def _find(run: Run, node: str) -> tuple[Stage, tuple[str, ...]]:
    for stage in reversed(run.stages):
        if node in stage.tree.nodes:
            return stage, (node,)
    bare = node.strip("()[] ") + (")" if node.rstrip("]").endswith(")") else "")
    wanted = {_plain(node), _plain(bare), _plain(node.strip("[] ")), _plain(node[1:-1]) if node[:1] == "(" else ""}
    for stage in reversed(run.stages):
        same = tuple(n.id for n in stage.tree.preorder() if not n.children and _plain(n.label()) in wanted)
        begun = tuple(n.id for n in stage.tree.preorder() if len(node) >= 4 and n.id.startswith(node))
        if same or len(begun) == 1:
            return stage, same or begun
    known = {n.label(): n.id for s in run.stages for n in s.tree.preorder() if not n.children}
    close = nearest(node, (*known, *known.values()))
    hint = (
        f"did you mean {' or '.join(f'`{c}`' for c in close)}?"
        if close
        else "give an id or a label of `tree show --ids`"
    )
    fault = Diagnostic(
        "E083", f"no version of this run has a node `{node}`", Span(str(run.folder)), "", hint, candidates=close
    )
    raise LlmbtError(fault, exit_code=ExitCode.UNCLEAR if close else ExitCode.BAD_INPUT)


def _plain(text: str) -> str:
    return "".join(text.split())


def _chain(run: Run, stage: Stage, id_: str) -> tuple[Link, ...]:
    found: list[Link] = []
    seen: set[tuple[str, str]] = set()
    here: str | None = id_
    newest = stage
    while here is not None and (stage.name, here) not in seen:
        seen.add((stage.name, here))
        moves = _moves(run, newest, here)
        stage, link, here = _link(run, stage, here)
        found.append(replace(link, moves=moves))
    return tuple(found)


def _moves(run: Run, stage: Stage, id_: str) -> tuple[tuple[str, Mapping[str, Any]], ...]:
    """The edits up to a version that moved a node, or the Fallback that it heads, in their order."""
    mine = {id_, node_id(id_, "?")}
    until = run.stages[: run.stages.index(stage) + 1]
    return tuple((s.name, e) for s in until for e in s.steps if e.get("kind") == "move" and e.get("node") in mine)


def _link(run: Run, stage: Stage, id_: str) -> tuple[Stage, Link, str | None]:
    """Where one node is from: the version that brought it, the edit, and the condition that was edited."""
    label = stage.tree[id_].label()
    first = _brought_by(run, stage, id_)
    for step in first.steps:
        role = _role(step, first.tree, id_)
        if role:
            before = _before(run, first)
            above = step["node"] if step["node"] in first.tree.nodes else None
            next_stage = before if above and before and above in before.tree.nodes else first
            return next_stage, Link(id_, label, role, first.name, step), above
    whole = next((s for s in first.steps if s.get("kind") in ("chain", "goals")), None)
    if first.tree[id_].condition is not None and _is_goal(run, first, id_):
        return first, Link(id_, label, "a goal of the request" if run.request else "a goal", run.stages[0].name), None
    chained = whole is not None and whole.get("kind") == "chain"
    if id_ == first.tree.root and not chained:
        return first, Link(id_, label, "the root, which holds the goals together", first.name, whole), None
    if chained:
        return first, Link(id_, label, _row_role(first.tree, id_), first.name, whole), None
    return first, Link(id_, label, "there from the first version", first.name, whole), None


def _row_role(tree: Tree, id_: str) -> str:
    node = tree[id_]
    goal = tree.nodes.get(id_.split(".", maxsplit=1)[0])
    towards = f", on the way to {goal.condition}" if goal is not None and goal.condition is not None else ""
    leaf = "the action of a row" if node.kind is Kind.ACTION else "what has to hold in a row or a group of rows"
    rows = "rows, the one nearest the goals first," if node.kind is Kind.FALLBACK else "a row or a group of rows"
    return f"{rows if node.children else leaf} of the chain that a plan was turned into{towards}"


def _brought_by(run: Run, stage: Stage, id_: str) -> Stage:
    """The newest version up to `stage` that has a node which its predecessor has not, or has as something else (where
    a tree is grown anew, its goals are numbered in another order)."""
    at = run.stages.index(stage)
    label = stage.tree[id_].label()
    while at > 0 and id_ in (earlier := run.stages[at - 1].tree).nodes and earlier[id_].label() == label:
        at -= 1
    return run.stages[at]


def _before(run: Run, stage: Stage) -> Stage | None:
    at = run.stages.index(stage)
    return run.stages[at - 1] if at else None


def _role(step: Mapping[str, Any], tree: Tree, id_: str) -> str:
    """The part that a node has in what an edit made; empty where the edit did not make it."""
    if step.get("kind") not in ("expand", "re-expand"):
        return ""
    of, action, condition = str(step["node"]), str(step["action"]), str(step["condition"])
    label = tree[id_].label()
    if id_ == node_id(of, action, "!"):
        return f"the action that brings {condition} about"
    if id_ == node_id(of, action, label):
        return f"what {action} needs"
    if id_ == node_id(of, action):
        return f"the way to {condition} by {action}"
    if id_ == node_id(of, "?"):
        return f"{condition}, or else a way to bring it about"
    return ""


def _is_goal(run: Run, stage: Stage, id_: str) -> bool:
    """Whether a node stands for a goal: it has a goal's id (goals grown anew share those out in another order)."""
    goals = [g for s in (stage, run.stages[0]) for g in s.file.provenance.goals]
    if not goals:
        return stage.version.number == 0 and stage.tree.parents.get(id_) == stage.tree.root
    return id_ in {g.node for g in goals} and str(stage.tree[id_].condition) in {str(g.condition) for g in goals}
