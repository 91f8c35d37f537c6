"""Bad input: a diagnostic with file, line and a suggestion, the right exit code, no traceback, no tree."""

from __future__ import annotations

import time

import pytest

from tests.e2e.conftest import CANONICAL

SCENE = ["--scene", "cargo_sorting"]
HEAD = '<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M">'
TAIL = "</BehaviorTree></root>"
LOL = "".join(f'<!ENTITY l{i} "{f"&l{i - 1};" * 10}">' for i in range(1, 10))
BAD_TREES = {
    "external entity": ('<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]><root>&a;</root>', "E005"),
    "billion laughs": (f'<!DOCTYPE x [<!ENTITY l0 "lol">{LOL}]><root>&l9;</root>', "E005"),
    "deep": (HEAD + "<ReactiveSequence>" * 100_000 + "</ReactiveSequence>" * 100_000 + TAIL, "E004"),
    "not well-formed": (HEAD + "\n<ReactiveSequence>\n</Reactive>" + TAIL, "E003"),
    "empty": ("", "E003"),
    "binary": ("\x00\x01\x02", "E003"),
    "another root": ("<scene/>", "E050"),
    "no such main tree": ('<root BTCPP_format="4" main_tree_to_execute="X"/>', "E051"),
    "memory": (HEAD + '<Sequence><On target="object_1" place="position_12"/></Sequence>' + TAIL, "E052"),
    "unknown leaf": (HEAD + '\n<Om target="object_1" place="position_12"/>' + TAIL, "E053"),
    "wrong ports": (HEAD + '\n<On target="object_1"/>' + TAIL, "E054"),
    "unknown object": (HEAD + '\n<On target="object_11" place="position_12"/>' + TAIL, "E055"),
    "wrong type": (HEAD + '\n<On target="position_11" place="position_12"/>' + TAIL, "E059"),
    "no goals": (HEAD + "<ReactiveSequence/>" + TAIL, "E050"),
}


@pytest.mark.parametrize("name", sorted(BAD_TREES))
def test_a_bad_tree(llmbt, tmp_path, name):
    text, code = BAD_TREES[name]
    (tmp_path / "bad.xml").write_text(text)
    start = time.monotonic()
    answer = llmbt("execute", tmp_path / "bad.xml", *SCENE, "-o", tmp_path / "out", "--world", "symbolic")
    assert time.monotonic() - start < 10
    assert answer.code == 1
    assert f"error[{code}]" in answer.err
    assert "bad.xml" in answer.err
    assert not list((tmp_path / "out").glob("tree*")), "no tree is left"
    assert "root:" not in answer.out + answer.err, "no file of this machine is read into the answer"


def test_a_line_and_a_suggestion(llmbt, tmp_path):
    (tmp_path / "bad.xml").write_text(BAD_TREES["unknown object"][0])
    answer = llmbt("execute", tmp_path / "bad.xml", *SCENE, "-o", tmp_path / "out", "--json")
    (found,) = answer.json["diagnostics"]
    assert answer.json["exit_code"] == answer.code == 1
    assert found["span"]["line"] == 2
    assert "object_1" in found["candidates"]


def replied(llmbt, tmp_path, reply):
    (tmp_path / "reply.txt").write_text(reply)
    tape = tmp_path / "tape.yaml"
    made = llmbt("cassette", "author", "My own request.", *SCENE, "--reply", tmp_path / "reply.txt", "-o", tape)
    assert made.code == 0, made.err
    return llmbt("run", "My own request.", *SCENE, "--cassette", tape, "-o", tmp_path / "out", "--world", "symbolic")


@pytest.mark.parametrize(
    ("reply", "exit_code", "code", "words"),
    [
        ("1. Unscrew object 1.", 1, "E303", "unscrew"),
        ("1. Place object 77 on position 12.", 5, "E301", "object_"),
        ("1. Place object 1 on position 99.", 5, "E302", "position_"),
        ("1. Place the green block on position 12.", 5, "E304", "object_1"),
        ("1. Place object 1 on position 12.\n2. Place object 2 on position 12.", 3, "E343", "object_2"),
        ("QUESTION: Which block do you mean?", 5, "E140", "Which block"),
        ("Thank you, have a nice day!", 1, "E11", ""),
        ("1. Wait for ten seconds.", 1, "E340", ""),
    ],
)
def test_a_bad_reply(llmbt, tmp_path, reply, exit_code, code, words):
    answer = replied(llmbt, tmp_path, reply)
    assert f"error[{code}" in answer.err
    assert words in answer.err
    assert answer.code == exit_code
    assert not (tmp_path / "out" / "tree.v000.xml").exists()


def test_an_unknown_scene(llmbt, tmp_path):
    answer = llmbt("run", CANONICAL, "--scene", "cargo_sortin", "-o", tmp_path / "out")
    assert answer.code == 1
    assert "cargo_sorting" in answer.err


@pytest.mark.parametrize(
    "change", [('type="slot"', 'type="slott"'), ('parent="shelf"', 'parent="shelff"'), ("<Objects>", "<Objekts>")]
)
def test_a_bad_scene(llmbt, tmp_path, change):
    from llmbt_ir.shipped import shipped

    text = (shipped("scenes") / "cargo_sorting.xml").read_text().replace(*change, 1)
    (tmp_path / "mine.xml").write_text(text)
    answer = llmbt("run", CANONICAL, "--scene", tmp_path / "mine.xml", "-o", tmp_path / "out")
    assert answer.code == 1
    assert "mine.xml, line" in answer.err


def test_a_changed_prompt_has_no_recording(llmbt, tmp_path):
    answer = llmbt("run", "Make me a coffee.", *SCENE, "-o", tmp_path / "out", "--json")
    assert answer.code == 4
    (found,) = answer.json["diagnostics"]
    assert found["candidates"]
    assert any("coffee" in n for n in found["notes"]), "the difference is shown"


def test_a_folder_that_is_not_empty(llmbt, tmp_path):
    (tmp_path / "mine.txt").write_text("keep me")
    for extra in ([], ["--force"]):
        answer = llmbt("run", CANONICAL, *SCENE, "-o", tmp_path, *extra)
        assert answer.code == 2
    assert (tmp_path / "mine.txt").read_text() == "keep me"


def test_usage_is_2_and_json_all_the_same(llmbt):
    assert llmbt("compile").code == 2
    assert llmbt("compile", "x", *SCENE, "--json").json["exit_code"] == 2


def test_our_own_bug_is_70(llmbt, monkeypatch, tmp_path):
    from llmbt import folders

    def broken(*_, **__):
        raise RuntimeError("a wheel came off")

    monkeypatch.setattr(folders, "fresh_folder", broken)
    answer = llmbt("run", CANONICAL, *SCENE, "-o", tmp_path / "out")
    assert answer.code == 70
    assert "LLMBT_TRACEBACK" in answer.err
