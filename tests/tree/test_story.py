"""`tree log` and `tree why`: a run can be retold from them alone."""

from __future__ import annotations

import itertools
import json
import re
import shutil
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from llmbt.history import Run, origin, read_run
from llmbt.main import main
from llmbt_ir.condition import ActionCall
from llmbt_ir.diff import apply, diff
from llmbt_ir.tree import goal_tree
from llmbt_ir.tree_xml import GoalRecord, Provenance, read_tree, write_tree
from llmbt_ir.versions import VersionStore
from llmbt_runtime.executor import Change
from llmbt_runtime.record import RunFolder, signatures_of
from llmbt_runtime.symbolic import SymbolicWorld
from llmbt_runtime.update.chain import chain_tree
from llmbt_runtime.update.loop import Grown
from llmbt_runtime.update.rollout import Certificate
from llmbt_runtime.update.step import Step
from llmbt_runtime.world import ActionReport
from tests.strategies import CANONICAL, canonical_cargo, cargo_library, domain_for
from tests.tree.conftest import REQUEST


def told(capsys: pytest.CaptureFixture[str], *arguments: str | Path, code: int = 0) -> str:
    capsys.readouterr()
    assert main(["tree", *map(str, arguments)]) == code
    return capsys.readouterr().out


def test_the_log(kept: Path, golden: Callable[[str, str], None], capsys: pytest.CaptureFixture[str]) -> None:
    golden("log_drop.txt", told(capsys, "log", kept / "drop"))
    golden("log_move.txt", told(capsys, "log", kept / "obstacle_at_place", "v002", "--patch"))
    golden("log_both.txt", told(capsys, "log", kept / "both"))


# -- retold ----------------------------------------------------------------------------------------------------------

ROW = re.compile(r"^  (?P<head>\S.{11} |  {13}) *(?:(?P<since>[\d.]+)-)?(?P<time>[\d.]+) s +(?P<text>.*)$")
VERSION = re.compile(r"^(v\d{3,})  tick (\d+), ([\d.]+) s: (.*?)   \((\d+) nodes")
ENDING = re.compile(r"^([A-Z_]+)(?:: (.*))?; (\d+) of (\d+) goals hold \((\d+) ticks, ([\d.]+) s simulated, (\d+) ver")
DISTURBED = re.compile(r"^  disturbed +(\w+) of (\w+) at ([\d.]+) s was (?:made good at ([\d.]+) s|never made good)$")
HIT = re.compile(r"^disturbance: (\w+) of (\w+)(?:: ended (.*?))?(?:; seen next: .*)?$")
SEARCH = re.compile(r"^  search +(\d+) calls? of the planner, (\d+) states? expanded")
TALLY = re.compile(r"^  actions +(\d+): (.*)$")


def retold(text: str) -> dict[str, Any]:
    """The run as a reader retells it who has nothing but the log."""
    lists = ("versions", "actions", "observed", "disturbances", "goals", "hits", "search")
    found: dict[str, Any] = {key: [] for key in lists} | {"tally": (0, {})}
    for line in text.splitlines():
        if match := VERSION.match(line):
            name, tick, time, cause, nodes = match.groups()
            found["versions"].append((name, int(tick), float(time), cause, int(nodes)))
        elif match := ENDING.match(line):
            found["end"] = match.groups()
        elif match := DISTURBED.match(line):
            name, target, fired, mended = match.groups()
            found["disturbances"].append((name, target, float(fired), float(mended) if mended else None))
        elif match := SEARCH.match(line):
            found["search"].append((int(match[1]), int(match[2])))
        elif match := TALLY.match(line):
            ends = (part.split() for part in match[2].split(", "))
            found["tally"] = (int(match[1]), {end: int(n) for n, end in ends})
        elif line.startswith("goal "):
            found["goals"].append(line.split(None, 2)[2].split("   ")[0])
        elif line.startswith("request  "):
            found["request"] = line.removeprefix("request  ")
        elif match := ROW.match(line):
            said, time = match["text"], float(match["time"])
            if said.startswith("observed: "):
                found["observed"].append((time, said.removeprefix("observed: ")))
            elif hit := HIT.match(said):
                found["hits"].append((*hit.groups()[:2], time, hit[3] or ""))
            elif match["since"]:
                call, _, result = said.partition(": ")
                result, _, reason = result.partition(", after ")[0].partition(" (")
                found["actions"].append((call, float(match["since"]), time, result, reason.removesuffix(")")))
    return found


def holds_against(folder: Path, text: str) -> None:
    """The retold run against what the run itself wrote down."""
    story = retold(text)
    result = json.loads((folder / "result.json").read_text())
    events = [json.loads(line) for line in (folder / "events.jsonl").read_text().splitlines()]
    calls = [
        (f"{a['name']}({', '.join(a['args'])})", a["started_s"], a["ended_s"], a["result"], a["reason"])
        for a in result["actions"]
    ]
    assert story["actions"] == calls
    assert story["observed"] == [(e["sim_time_s"], e["text"]) for e in events if e["kind"] == "deviation"]
    assert story["disturbances"] == [
        (d["name"], d["target"], d["fired_at_s"], d["recovered_at_s"]) for d in result["disturbances"]
    ]
    assert story["hits"] == [
        (d["name"], d["target"], d["fired_at_s"], ", ".join(d["broke"])) for d in result["disturbances"]
    ], "at one time, here and there"
    assert story["tally"] == (len(calls), dict(Counter(a["result"] for a in result["actions"])))
    assert sum(n for n, _ in story["search"]) == result["planner_calls"]
    assert sum(n for _, n in story["search"]) == result["expansions"]
    updates = [(e["version"], e["sim_time_s"], e["text"].partition(": ")[2]) for e in events if e["kind"] == "update"]
    assert [(name, time, cause) for name, _, time, cause, _ in story["versions"]] == updates
    records = [json.loads((folder / f"tree.{name}.json").read_text()) for name, _, _ in updates]
    assert [(tick, nodes) for _, tick, _, _, nodes in story["versions"]] == [(r["tick"], r["nodes"]) for r in records]
    holding = sum(g["holds"] for g in result["goals"])
    assert story["end"] == (
        result["outcome"],
        result.get("reason"),
        str(holding),
        str(len(result["goals"])),
        str(result["ticks"]),
        str(result["sim_time_s"]),
        str(result["versions"]),
    )
    assert story["goals"] == [f"{g['name']}({', '.join(g['args'])})" for g in result["goals"]]
    assert story["request"] == result["request"]


DISTURBANCES = ("drop", "obstacle_at_place", "obstacle_at_pick", "placed_object_moved")


@pytest.mark.parametrize("disturb", [*DISTURBANCES, "random:3"])
def test_a_run_is_retold_from_its_log_alone(disturb: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for seed in range(3):
        out = tmp_path / str(seed)
        command = ["run", REQUEST, "--scene", "cargo_sorting", "-o", str(out), "--world", "symbolic", "-q"]
        assert main([*command, "--disturb", disturb, "--seed", str(seed)]) == 0
        holds_against(out, told(capsys, "log", out))


def test_a_run_that_cannot_succeed_is_retold_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With what was seen last, and why no tree is found."""
    command = ["run", REQUEST, "--scene", "cargo_sorting", "-o", str(tmp_path), "--world", "symbolic", "-q"]
    assert main([*command, "--disturb", "impossible"]) == 3
    text = told(capsys, "log", tmp_path)
    holds_against(tmp_path, text)
    assert re.search(r"disturbance: impossible of (\w+): ended Free\(\1\); seen next: On\(obstacle_\d, \1\)\n", text)
    assert ": no tree is found\n" in text


def test_a_run_that_was_interrupted_is_retold_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    advance = SymbolicWorld.advance

    def interrupted(self: SymbolicWorld) -> ActionReport:
        if self.time_s == 2.0:
            raise KeyboardInterrupt
        return advance(self)

    monkeypatch.setattr(SymbolicWorld, "advance", interrupted)
    command = ["run", REQUEST, "--scene", "cargo_sorting", "-o", str(tmp_path), "--world", "symbolic", "-q"]
    assert main(command) == 130
    text = told(capsys, "log", tmp_path)
    holds_against(tmp_path, text)
    assert "  not reached   On(object_6, position_32)" in text


@pytest.mark.slow
@pytest.mark.parametrize("disturb", DISTURBANCES)
def test_a_physical_run_is_retold_from_its_log_alone(
    disturb: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["run", REQUEST, "--scene", "cargo_sorting", "-o", str(tmp_path / "run"), "-q", "--disturb", disturb]
    assert main(command) == 0
    holds_against(tmp_path / "run", told(capsys, "log", tmp_path / "run"))


def test_the_log_as_json(kept: Path, capsys: pytest.CaptureFixture[str]) -> None:
    document = json.loads(told(capsys, "log", kept / "drop", "--json", "--patch"))
    names = [v["version"] for v in document["versions"]]
    assert names == ["v000", "v001", "v002"]
    last = document["versions"][-1]
    assert (last["tick"], last["failed_condition"]) == (12, "Holding(object_1)")
    assert last["observed"]["ended"] == ["Holding(object_1)"]
    assert last["steps"][0]["action"] == "pick(object_1, workbench)"
    assert last["certificate"]["actions"][0] == "pick(object_1, workbench)"
    assert [e["node"] for e in last["patch"]["added"]][-1] == "[pick(object_1, workbench)]"
    assert [e["kind"] for e in last["events"]][-1] == "outcome"
    trees = [read_tree(kept / "drop" / f"tree.{n}.xml").tree for n in names]
    for before, after in itertools.pairwise(trees):
        assert apply(diff(before, after), before) == after


def test_why_leads_back_to_the_words(
    kept: Path, golden: Callable[[str, str], None], capsys: pytest.CaptureFixture[str]
) -> None:
    golden("why_drop.txt", told(capsys, "why", kept / "drop", "pick(object_1, workbench)"))
    golden("why_move.txt", told(capsys, "why", kept / "obstacle_at_place", "[put_down(object_1, sorting_area)]"))
    golden("why_moved.txt", told(capsys, "why", kept / "both", "Free(position_13)"))
    document = json.loads(told(capsys, "why", kept / "drop", "g1.e2e24976f11d", "--json"))
    (chain,) = document["chains"]
    assert [link["label"] for link in chain["links"]] == [
        "pick(object_1, workbench)",
        "Holding(object_1)",
        "On(object_1, position_12)",
    ]
    assert chain["asked_for_by"]["reply_text"] == "place it on position 12"
    reply = json.loads((kept / "drop" / "reply.json").read_text())["text"]
    start, end = chain["asked_for_by"]["reply_span"]
    assert reply[start:end] == "place it on position 12"


def test_every_node_of_every_version_has_an_origin(runs: Path) -> None:
    """Each chain ends at a goal, or at the root, and each link names the edit that made its node."""
    for folder in sorted(runs.iterdir()):
        run = read_run(folder)
        goals = {g.node for g in run.stages[0].file.provenance.goals}
        for stage in run.stages:
            for node in stage.tree.preorder():
                (chain,) = origin(run, node.id)
                assert chain[-1].node in goals or chain[-1].node == "root"
                assert all(link.step is not None for link in chain[:-1])


def test_nodes_that_are_not_there(kept: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told(capsys, "why", kept / "drop", "pick(object_1, workbrench)", code=5)
    told(capsys, "why", kept / "drop", "\x00", code=1)
    told(capsys, "why", kept / "drop", "root")
    assert told(capsys, "why", kept / "drop", "HandEmpty").count("asked for by") == 5


def test_folders_that_are_no_runs(kept: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told(capsys, "log", tmp_path, code=1)
    told(capsys, "log", tmp_path / "none", code=1)
    told(capsys, "log", kept / "drop", "v009", code=1)
    assert "v002" in told(capsys, "log", kept / "drop", "2")


def test_a_killed_run_is_told_as_far_as_it_went(kept: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(kept / "drop", tmp_path / "killed")
    for name in ("events.jsonl", "result.json", "reply.json", "conditions.json", "steps.json"):
        (tmp_path / "killed" / name).unlink()
    text = told(capsys, "log", tmp_path / "killed")
    assert "v002  tick 12" in text and "the run was killed" in text
    assert "step 1: place it on position 12" in told(capsys, "why", tmp_path / "killed", "g1")


def test_a_damaged_folder_is_a_diagnostic(kept: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(kept / "drop", tmp_path / "x")
    (tmp_path / "x" / "events.jsonl").write_text('{"kind": "started"}\n')
    told(capsys, "log", tmp_path / "x", code=1)
    (tmp_path / "x" / "events.jsonl").unlink()
    (tmp_path / "x" / "result.json").write_text("{")
    told(capsys, "log", tmp_path / "x", code=1)
    with (tmp_path / "x" / "tree.v001.xml").open("a") as out:
        out.write(" ")
    told(capsys, "log", tmp_path / "x", code=1)


def test_a_tree_executed_elsewhere(runs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its goals keep the words; the folder has no request."""
    tree = runs / "drop" / "tree.v001.xml"
    assert (
        main(["execute", str(tree), "--scene", "cargo_sorting", "-o", str(tmp_path / "y"), "--world", "symbolic", "-q"])
        == 0
    )
    assert "SUCCESS; 6 of 6 goals hold" in told(capsys, "log", tmp_path / "y")
    assert "place it on position 12" in told(capsys, "why", tmp_path / "y", "g1")


@pytest.fixture
def planned(tmp_path: Path) -> Path:
    """A run whose v001 is the chain of a plan, and whose v002 was grown anew with its goals in another order."""
    domain = domain_for(canonical_cargo())
    facts = canonical_cargo().facts()
    goals = CANONICAL[:2]
    calls = ("pick", "object_2", "sorting_area"), ("place", "object_2", "position_13")
    plan = tuple(a for name, *args in calls if (a := domain.action(ActionCall(name, tuple(args)))) is not None)
    signatures = signatures_of(cargo_library())
    records = tuple(GoalRecord(f"g{k}", g, f"step {k}: put it there") for k, g in enumerate(goals, 1))
    xml = write_tree(goal_tree((goals,)), signatures, Provenance(goals=records))
    store = VersionStore(tmp_path / "run")
    store.append(xml, {"parent": None, "request": "put them there"}, 0)
    folder = RunFolder(tmp_path / "run", signatures, records, 0, "", "tree.v000.xml")
    certificate = Certificate(plan, (facts,), ())
    calls_text = " ".join(str(a) for a in plan)
    for kind, tree in (("chain", chain_tree(goals, plan)), ("goals", goal_tree((goals[::-1],)))):
        steps = (Step(kind, "root", "", calls_text, reason="because"),)
        grown = Grown(tree, certificate, steps, 1, 42)
        folder.keep(Change(3, 0.3, "it failed", frozenset(), frozenset(), facts, grown, 1, 42))
    return tmp_path / "run"


def test_plans_are_told_and_traced(planned: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = told(capsys, "log", planned)
    assert "plan: pick(object_2, sorting_area), place(object_2, position_13)" in text
    assert "1 call of the planner, 42 states expanded" in text
    run = read_run(planned)
    chain = run.stages[1].tree
    for node in chain.preorder():
        (links,) = origin(Run(run.folder, run.stages[:2], {}, {}, (), ()), node.id)
        wanted = "goal" if node.id in ("g1", "g2") else "goals together" if node.id == "root" else "chain"
        assert wanted in links[-1].role, node
    (links,) = origin(run, "g1")
    assert links[-1].label == str(CANONICAL[1])
    assert "step 2: put it there" in told(capsys, "why", planned, "g1")
