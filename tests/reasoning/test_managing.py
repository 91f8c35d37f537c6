"""`llmbt cassette`: what there is, whether it still holds, and how another model's replies differ by their goals."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from llmbt.main import main
from llmbt_compiler.drift import Drift, compare, verify
from llmbt_compiler.reasoning.author import author
from llmbt_compiler.reasoning.cassette import read_cassette, write_cassette
from llmbt_compiler.reasoning.prompt import template_version

REQUEST = "Put the red block on position 32."
STEPS = "1. Place object 6 on position 32."
KEY = "sk-very-secret-0123456789"


@pytest.fixture
def llmbt(capfd, monkeypatch):
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    monkeypatch.setenv("NO_COLOR", "1")

    def run(*arguments):
        capfd.readouterr()
        code = main([*map(str, arguments), "--json"])
        out, err = capfd.readouterr()
        assert "Traceback" not in err, err
        return code, json.loads(out)

    return run


@pytest.fixture
def scene():
    """The shipped scene, since a recording names its scene."""
    from llmbt_atl.library import load_library
    from llmbt_ir.scene import load_scene, to_semantic_map

    return to_semantic_map(load_scene("cargo_sorting")), load_library("cargo_sorting")


@pytest.fixture
def tape(scene, tmp_path):
    return author(REQUEST, *scene, [STEPS], tmp_path / "tapes" / "red.yaml", scene="cargo_sorting", date="2026-11-22")


def test_list_tells_where_recordings_come_from(llmbt, tape, endpoint, tmp_path):
    endpoint.says("1. Put object 5 on position 31.")
    made = tmp_path / "tapes" / "model.yaml"
    order = ["--base-url", endpoint.url, "--model", "fake-1", "--cassette", made, "--price", "2/10"]
    code, _ = llmbt(
        "compile", "Put object 5 on position 31.", "--scene", "cargo_sorting", "--record", *order, "-o", tmp_path / "q"
    )
    assert code == 0
    code, document = llmbt("cassette", "list", tape.path.parent)
    assert code == 0
    recorded, authored = document["cassettes"]
    assert (authored["provenance"], authored["model"], authored["outcome"]) == (
        "authored",
        "",
        "On(object_6, position_32)",
    )
    assert (recorded["provenance"], recorded["model"], recorded["endpoint_kind"]) == ("recorded", "fake-1", "local")
    assert (recorded["tokens_in"], recorded["tokens_out"], recorded["cost_usd"]) == (11, 7, "0.000092")
    assert recorded["outcome"] == "On(object_5, position_31)"
    assert recorded["template_version"] == authored["template_version"] == template_version()
    assert KEY not in made.read_text()


def test_a_file_that_is_none_is_listed_as_such(llmbt, tmp_path):
    (tmp_path / "broken.yaml").write_text("version: 1\n")
    code, document = llmbt("cassette", "list", tmp_path)
    assert code == 0
    assert document["cassettes"][0]["fault"].startswith("E102")
    code, document = llmbt("cassette", "verify", tmp_path)
    assert code == 6
    code, _ = llmbt("cassette", "list", tmp_path / "nowhere")
    assert code == 1


def test_what_is_shipped_is_fresh(llmbt):
    code, document = llmbt("cassette", "verify", "fixtures/llm_cassettes/which_green_block.yaml")
    assert code == 0
    (row,) = document["cassettes"]
    assert (row["drift"], row["stale"], row["good"]) == ("identical", False, True)


def edited(tape, **changes):
    """The recording with another provenance or other words."""
    cassette = read_cassette(tape.path)
    if "said" in changes:
        old, new = changes["said"]
        text = tape.path.read_text()
        assert old in text
        tape.path.write_text("\n".join(row for row in text.replace(old, new).splitlines() if "sha256" not in row))
        return read_cassette(tape.path)
    write_cassette(replace(cassette, provenance=replace(cassette.provenance, **changes)))
    return read_cassette(tape.path)


def scene_of(scene):
    return lambda _: scene


def test_verify_tells_identical_harmless_and_meaning_changing_apart(scene, tape):
    assert verify(read_cassette(tape.path), scene_of(scene)).drift is Drift.IDENTICAL
    stale = verify(edited(tape, said=("Rules:", "Laws:")), scene_of(scene))
    assert (stale.drift, stale.stale, stale.turn, stale.good) == (Drift.HARMLESS, True, 1, False)
    other = verify(edited(tape, outcome="On(object_6, position_31)"), scene_of(scene))
    assert other.drift is Drift.MEANING
    assert (other.before, other.now) == ("On(object_6, position_31)", "On(object_6, position_32)")
    assert verify(edited(tape, outcome=""), scene_of(scene)).drift is Drift.UNKNOWN


def test_a_scene_that_changed_is_seen_by_the_goals(scene, tape):
    """The red block has become another one: the recording is stale, and the words mean what they meant."""
    semantic_map, library = scene
    fewer = replace(semantic_map, objects=semantic_map.objects[:5])
    verdict = verify(read_cassette(tape.path), scene_of((fewer, library)))
    assert (verdict.drift, verdict.stale, verdict.now) == (Drift.MEANING, True, "exit 5: E142")


def test_a_dialogue_is_verified_turn_by_turn(scene, tmp_path):
    made = author(
        "Put the green block on position 21.",
        *scene,
        ["QUESTION: Which green block?", "1. Place object 9 on position 21.", "1. Place object 2 on position 21."],
        tmp_path / "which.yaml",
        answers=["the second"],
        scene="cargo_sorting",
    )
    assert [len(t.messages) for t in made.cassette.turns] == [2, 4, 6]
    assert verify(made.cassette, scene_of(scene)).drift is Drift.IDENTICAL
    verdict = verify(edited(made, said=("Answer: ", "The answer: ")), scene_of(scene))
    assert verdict.stale
    assert verdict.turn == 2


def test_compare():
    assert compare("On(a, b)", "On(a, b)", same_words=True) is Drift.IDENTICAL
    assert compare("On(a, b)", "On(a, b)", same_words=False) is Drift.HARMLESS
    assert compare("On(a, b)", "exit 5: E304", same_words=False) is Drift.MEANING
    assert compare("", "On(a, b)", same_words=True) is Drift.UNKNOWN


@pytest.mark.parametrize(
    ("reply", "drift", "code"),
    [
        (STEPS, "identical", 0),
        ("Sure!\n1. Pick up object 6.\n2. Place it on position 32.", "harmless", 0),
        ("1. Place object 6 on position 31.", "meaning-changing", 6),
        ("QUESTION: Which red block?", "meaning-changing", 6),
    ],
)
def test_rerecord_asks_a_model_anew(llmbt, tape, endpoint, tmp_path, reply, drift, code):
    endpoint.says(reply)
    before = tape.path.read_bytes()
    order = ["--base-url", endpoint.url, "--model", "fake-1", "-o", tmp_path / "new"]
    exit_, document = llmbt("cassette", "rerecord", tape.path, *order)
    assert exit_ == code
    (row,) = document["cassettes"]
    assert (row["drift"], row["fault"]) == (drift, "")
    assert tape.path.read_bytes() == before, "nothing of a model is written over an authored recording"
    made = read_cassette(tmp_path / "new" / "red.yaml")
    assert (made.provenance.provenance, made.provenance.request) == ("recorded", REQUEST)
    exit_, document = llmbt("cassette", "verify", tmp_path / "new")
    assert exit_ == 0


def test_rerecord_goes_on_after_a_fault(llmbt, tape, endpoint, tmp_path, scene):
    author("Put object 5 on position 31.", *scene, ["1. Place object 5 on position 31."], tape.path.with_name("b.yaml"))
    endpoint.fails(401)
    order = ["--base-url", endpoint.url, "--model", "fake-1", "-o", tmp_path / "new", "--retries", "0"]
    exit_, document = llmbt("cassette", "rerecord", tape.path.parent, *order)
    assert exit_ == 6
    assert [row["fault"][:4] for row in document["cassettes"]] == ["E107", "E107"]


def test_replacing_says_what_changed(llmbt, endpoint, tmp_path):
    endpoint.says(STEPS)
    made = tmp_path / "red.yaml"
    order = [
        "compile",
        "Put the red block on shelf level 3.",
        "--scene",
        "cargo_sorting",
        "--record",
        "--base-url",
        endpoint.url,
        "--model",
        "fake-1",
    ]
    order += ["--cassette", made]
    assert llmbt(*order, "-o", tmp_path / "a")[0] == 0
    endpoint.answers.clear()
    endpoint.says("1. Place object 6 on position 31.")
    code, document = llmbt(*order, "-o", tmp_path / "b")
    assert (code, document["changed"]) == (0, []), "what is there is played"
    code, document = llmbt(*order, "-o", tmp_path / "c", "--replace")
    assert code == 0
    assert document["changed"][-2:] == [f"-{STEPS}", "+1. Place object 6 on position 31."]
    assert read_cassette(made).provenance.outcome == "On(object_6, position_31)"


def test_a_live_correction_is_recorded_and_replays(llmbt, endpoint, tmp_path, monkeypatch):
    endpoint.says("1. Place object 77 on position 12.")
    endpoint.says("1. Place object 6 on position 12.")
    made = tmp_path / "red.yaml"
    order = ["compile", "Do it.", "--scene", "cargo_sorting", "--cassette", made]
    live = ["--record", "--base-url", endpoint.url, "--model", "fake-1"]
    code, document = llmbt(*order, *live, "-o", tmp_path / "a")
    assert code == 0
    assert "did you mean" in endpoint.requests[1]["messages"][-1]["content"]
    provenance = read_cassette(made).provenance
    assert (provenance.tokens_in, provenance.tokens_out) == (22, 14)
    code, again = llmbt(*order, "-o", tmp_path / "b")
    assert (code, again["goals"]) == (0, document["goals"])
    assert len(endpoint.requests) == 2


def test_the_price_that_the_endpoint_tells_counts(endpoint, tmp_path, llmbt):
    endpoint.says(STEPS)
    status, body, headers = endpoint.answers.pop()
    told = json.loads(body)
    told["usage"]["cost"] = 0.25
    endpoint.answers.append((status, json.dumps(told).encode(), headers))
    made = tmp_path / "red.yaml"
    live = ["--record", "--base-url", endpoint.url, "--model", "fake-1", "--cassette", made, "--price", "1/1"]
    assert llmbt("compile", REQUEST, "--scene", "cargo_sorting", *live, "-o", tmp_path / "a")[0] == 0
    assert read_cassette(made).provenance.cost_usd == "0.250000"
