"""Asking back and confirming at the command line: exit codes, folders, and a real terminal."""

from __future__ import annotations

import json
import os
import pty
import select
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.e2e.test_stages import DIALOGUES

ROOT = Path(__file__).resolve().parents[2]
WHICH = DIALOGUES["which_green_block"].request
ORDER = [WHICH, "--scene", "cargo_sorting"]


def goals(folder):
    return [
        f"{g['name']}({', '.join(g['args'])})" for g in json.loads((folder / "conditions.json").read_text())["goals"]
    ]


@pytest.fixture
def authored(llmbt, tmp_path):
    """Make a recording of a request from a reply."""

    def make(request, *replies, scene="cargo_sorting", answers=()):
        files = []
        for i, reply in enumerate(replies):
            path = tmp_path / f"reply{i}.txt"
            path.write_text(reply)
            files += ["--reply", path]
        said = [x for a in answers for x in ("--answer", a)]
        tape = tmp_path / "tape.yaml"
        assert llmbt("cassette", "author", request, "--scene", scene, *files, *said, "-o", tape, "--force").code == 0
        return tape

    return make


def test_a_question_is_exit_code_5_with_its_candidates(llmbt, tmp_path):
    answer = llmbt("compile", *ORDER, "-o", tmp_path / "q", "--json")
    assert answer.code == 5
    (question,) = answer.json["diagnostics"]
    assert question["code"] == "E140"
    assert question["candidates"] == ["object_1", "object_2", "object_4"]
    assert not list((tmp_path / "q").glob("tree*"))
    shown = llmbt("compile", *ORDER, "-o", tmp_path / "p")
    assert "Which green block do you mean" in shown.err
    assert "object_1, object_2, object_4" in shown.err


def test_an_answer_goes_on_in_the_folder_and_the_whole_is_kept(llmbt, tmp_path):
    folder = tmp_path / "q"
    assert llmbt("compile", *ORDER, "-o", folder).code == 5
    assert llmbt("compile", *ORDER, "-o", folder).code == 2, "without an answer the folder is in use"
    assert llmbt("compile", *ORDER, "-o", folder, "--answer", "object 2").code == 0
    assert goals(folder) == ["On(object_2, position_21)"]
    turns = json.loads((folder / "dialogue.json").read_text())["turns"]
    assert [(t["by"], t["kind"]) for t in turns] == [
        ("user", "request"), ("model", "reply"), ("model", "question"), ("user", "answer"), ("model", "reply"),
    ]  # fmt: skip


def test_earlier_answers_are_remembered(llmbt, tmp_path, authored):
    tape = authored("Do it.", "1. Place the green block on position 12.\n2. Place the yellow block on position 13.")
    folder, order = tmp_path / "q", ["Do it.", "--scene", "cargo_sorting", "--cassette", tape]
    assert llmbt("compile", *order, "-o", folder).code == 5
    second = llmbt("compile", *order, "-o", folder, "--answer", "object 2", "--json")
    assert second.code == 5
    assert second.json["diagnostics"][0]["candidates"] == ["object_3", "object_5"]
    assert llmbt("compile", *order, "-o", folder, "--answer", "object 5").code == 0
    assert goals(folder) == ["On(object_2, position_12)", "On(object_5, position_13)"]
    both = ["--answer", "object 2", "--answer", "object 5"]
    assert llmbt("compile", *order, "-o", tmp_path / "b", *both).code == 0
    assert goals(tmp_path / "b") == goals(folder)


def test_an_answer_to_no_question_is_told(llmbt, tmp_path):
    order = ["Put the red block on position 32.", "--scene", "cargo_sorting", "--answer", "object 2"]
    answer = llmbt("compile", *order, "-o", tmp_path / "q", "--json")
    assert answer.code == 0
    assert answer.json["unused_answers"] == ["object 2"]


def test_run_asks_too(llmbt, tmp_path):
    folder = tmp_path / "q"
    assert llmbt("run", *ORDER, "--world", "symbolic", "-o", folder).code == 5
    assert llmbt("run", *ORDER, "--world", "symbolic", "-o", folder, "--answer", "object 4").code == 0
    assert json.loads((folder / "result.json").read_text())["goals"][0]["args"] == ["object_4", "position_21"]


def test_recorded_corrections_replay(llmbt, tmp_path, authored):
    tape = authored("Do it.", "1. Place object 77 on position 12.", "1. Place object 6 on position 12.")
    order = ["Do it.", "--scene", "cargo_sorting", "--cassette", tape]
    answer = llmbt("compile", *order, "-o", tmp_path / "q", "--json")
    assert answer.code == 0
    assert [t["kind"] for t in answer.json["dialogue"]] == ["request", "reply", "complaint", "reply"]
    refused = llmbt("compile", *order, "-o", tmp_path / "n", "--corrections", "0", "--json")
    assert (refused.code, refused.json["diagnostics"][0]["code"]) == (5, "E301")


@pytest.mark.parametrize(
    ("reply", "code", "exit_"),
    [
        ("1. Place object 77 on position 12.", "E301", 5),
        ("1. Fly object 1 to position 12.", "E303", 1),
        ("1. Place object 1 on position 12.\n2. Place object 2 on position 12.", "E343", 3),
    ],
)
def test_without_a_recording_of_the_turn_the_first_diagnostic_stands(llmbt, tmp_path, authored, reply, code, exit_):
    tape = authored("Do it.", reply)
    answer = llmbt("compile", "Do it.", "--scene", "cargo_sorting", "--cassette", tape, "-o", tmp_path / "q", "--json")
    assert (answer.code, answer.json["diagnostics"][0]["code"]) == (exit_, code)


# -- confirming ----------------------------------------------------------------------------------------------------

RED = ["Put the red block on position 32.", "--scene", "cargo_sorting"]


def test_goals_are_said_back_and_wait_for_a_yes(llmbt, tmp_path):
    refused = llmbt("compile", *RED, "-o", tmp_path / "q", "--confirm")
    assert refused.code == 5
    assert "object 6 will be on position 32" in refused.err
    assert not list((tmp_path / "q").glob("tree*"))
    told = llmbt("compile", *RED, "-o", tmp_path / "j", "--confirm", "--json")
    assert (told.code, told.json["diagnostics"][0]["code"]) == (5, "E145")
    assert told.json["diagnostics"][0]["notes"] == ["object 6 will be on position 32"]
    assert llmbt("compile", *RED, "-o", tmp_path / "y", "--confirm", "--yes").code == 0
    assert list((tmp_path / "y").glob("tree.v000.xml"))


# -- goals without a model -----------------------------------------------------------------------------------------


def test_goals_from_a_file_go_the_same_way(llmbt, tmp_path, monkeypatch):
    monkeypatch.setenv("LLMBT_CASSETTES", str(tmp_path / "none"))
    file = tmp_path / "goals.json"
    file.write_text('{"goals": [{"name": "On", "args": ["object_6", "position_32"]}]}')
    order = ["--goals", file, "--scene", "cargo_sorting"]
    answer = llmbt("compile", *order, "-o", tmp_path / "q", "--json")
    assert answer.code == 0
    assert answer.json["reply"] is None
    assert not (tmp_path / "q" / "prompt.json").exists()
    assert llmbt("compile", *RED, "-o", tmp_path / "r").code == 0
    same = [llmbt("tree", "show", tmp_path / d / "tree.v000.xml").out for d in ("q", "r")]
    assert same[0] == same[1]
    assert llmbt("run", *order, "-o", tmp_path / "x", "--world", "symbolic").code == 0
    again = tmp_path / "r" / "conditions.json"
    assert llmbt("compile", "--goals", again, "--scene", "cargo_sorting", "-o", tmp_path / "again").code == 0


@pytest.mark.parametrize(
    ("text", "code", "exit_"),
    [
        ("(and (on object_1 position_12) (on object_2 position_12))", "E343", 3),
        ("(and (on object_1 position_12) (on object_1 position_13))", "E343", 3),
        ("(and (on object_1 position_12) (holding object_1))", "E343", 3),
        ("(not (on object_1 sorting_area))\n", "", 0),
        ("(on object_9 position_12)", "E301", 5),
        ("(over object_1 position_12)", "E152", 1),
    ],
)
def test_stated_goals_are_checked(llmbt, tmp_path, text, code, exit_):
    file = tmp_path / "goals.pddl"
    file.write_text(text)
    answer = llmbt("compile", "--goals", file, "--scene", "cargo_sorting", "-o", tmp_path / "q", "--json")
    assert answer.code == exit_
    assert [d["code"] for d in answer.json["diagnostics"]][:1] == ([code] if code else [])


def test_a_request_or_goals_are_needed(llmbt, tmp_path):
    assert llmbt("compile", "--scene", "cargo_sorting", "-o", tmp_path / "q").code == 2
    missing = llmbt("compile", "--goals", tmp_path / "no.json", "--scene", "cargo_sorting", "-o", tmp_path / "q")
    assert missing.code == 1


def test_json_is_asked_for_and_read(llmbt, tmp_path):
    prompt = llmbt("compile", *RED, "--reply-format", "json", "--stop-after", "prompt").out
    assert "one JSON object" in prompt
    reply = tmp_path / "reply.txt"
    reply.write_text('{"goals": [{"name": "On", "args": ["object_6", "position_32"]}]}')
    tape, form = tmp_path / "tape.yaml", ["--reply-format", "json"]
    assert llmbt("cassette", "author", *RED, "--reply", reply, "-o", tape, *form).code == 0
    assert llmbt("compile", *RED, "--cassette", tape, *form, "-o", tmp_path / "q").code == 0
    assert goals(tmp_path / "q") == ["On(object_6, position_32)"]
    assert llmbt("compile", *RED, "--cassette", tape, "-o", tmp_path / "n").code == 4, "it is another prompt"
    assert llmbt("compile", *RED, "--cassette", tape, *form, "--stop-after", "keywords").code == 2


# -- a terminal ----------------------------------------------------------------------------------------------------


def on_a_terminal(order, said, timeout_s=60.0):
    """Run `llmbt` on a pseudo-terminal and type a line at each prompt that ends in `: ` or `] `; code and screen."""
    primary, secondary = pty.openpty()
    code = "import sys; from llmbt.main import main; sys.exit(main(sys.argv[1:]))"
    environment = {**os.environ, "NO_COLOR": "1", "TERM": "dumb", "COLUMNS": "200"}
    process = subprocess.Popen(
        [sys.executable, "-c", code, *map(str, order)],
        stdin=secondary, stdout=secondary, stderr=secondary, close_fds=True, env=environment, cwd=ROOT,
    )  # fmt: skip
    os.close(secondary)
    screen, left, ends = "", list(said), time.monotonic() + timeout_s
    while time.monotonic() < ends:
        ready, _, _ = select.select([primary], [], [], 0.2)
        if ready:
            try:
                data = os.read(primary, 4096)
            except OSError:
                break
            if not data:
                break
            screen += data.decode("utf-8", "replace")
            if left and screen.endswith(("open): ", "[y/N] ")):
                os.write(primary, (left.pop(0) + "\n").encode())
        elif process.poll() is not None:
            break
    os.close(primary)
    return process.wait(timeout=10), screen


def test_on_a_terminal_it_asks_and_goes_on(tmp_path):
    code, screen = on_a_terminal(["compile", *ORDER, "-o", tmp_path / "q", "--confirm"], ["object 2", "y"])
    assert code == 0, screen
    assert "? the request is unclear: Which green block do you mean" in screen
    assert "object 2 will be on position 21" in screen
    assert goals(tmp_path / "q") == ["On(object_2, position_21)"]
    kinds = [t["kind"] for t in json.loads((tmp_path / "q" / "dialogue.json").read_text())["turns"]]
    assert kinds == ["request", "reply", "question", "answer", "reply"]


@pytest.mark.parametrize(("said", "code"), [(["", ""], "E140"), (["object 2", "n"], "E145")])
def test_on_a_terminal_nothing_is_taken_for_granted(tmp_path, said, code):
    exit_, screen = on_a_terminal(["compile", *ORDER, "-o", tmp_path / "q", "--confirm"], said)
    assert exit_ == 5
    assert code in screen
    assert not list((tmp_path / "q").glob("tree*"))
