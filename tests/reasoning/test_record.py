"""Recording from an OpenAI-compatible endpoint on the loopback; the key never reaches a file."""

from __future__ import annotations

import gzip
import json
import socket

import pytest

from llmbt_compiler.reasoning.author import author
from llmbt_compiler.reasoning.cassette import read_cassette
from llmbt_compiler.reasoning.chat import Record, Replay, Settings, ask, endpoint_kind, request_body
from llmbt_compiler.reasoning.prompt import build_prompt

REQUEST = "Put the red block on position 32."
KEY = "sk-very-secret-0123456789"
STEPS = "1. Put object 6 on position 32."


@pytest.fixture(autouse=True)
def _key(monkeypatch):
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    monkeypatch.setenv("OPENAI_ORG_ID", "org-nosy")
    monkeypatch.setenv("OPENAI_PROJECT_ID", "proj-nosy")


@pytest.fixture
def prompt(cargo, library):
    return build_prompt(REQUEST, cargo, library)


@pytest.fixture
def tape(tmp_path, prompt):
    return Record(tmp_path / "deep/er/red.yaml", REQUEST, "cargo_sorting", prompt.template_version)


def settings(endpoint, **values):
    return Settings(**{"model": "fake-1", "base_url": endpoint.url, "retries": 0, "timeout_s": 5.0, **values})


def test_recorded_then_replayed_with_the_server_gone(endpoint, prompt, tape, monkeypatch):
    endpoint.says(STEPS)
    reply = ask(prompt.messages, settings(endpoint), tape)
    assert (reply.text, reply.replayed) == (STEPS, False)
    assert (reply.completion.tokens_in, reply.completion.tokens_out) == (11, 7)
    assert endpoint.requests == [json.loads(request_body(prompt.messages, settings(endpoint)))]
    assert {k.lower(): v for k, v in endpoint.headers[0].items()}["authorization"] == f"Bearer {KEY}"
    endpoint.fails(500)
    monkeypatch.delenv("OPENAI_API_KEY")
    for chosen in (Settings(), settings(endpoint), Settings(model="fake-1")):
        again = ask(prompt.messages, chosen, Replay(tape.cassette))
        assert (again.text, again.replayed) == (STEPS, True)
    assert len(endpoint.requests) == 1


def test_provenance(endpoint, prompt, tape):
    endpoint.says(STEPS)
    said = ask(prompt.messages, settings(endpoint), tape).provenance
    assert (said.provenance, said.model, said.endpoint_kind) == ("recorded", "fake-1", "local")
    assert said.endpoint == endpoint.url.removesuffix("/v1")
    assert len(said.date) == 10
    assert (said.request, said.scene, said.template_version) == (
        REQUEST,
        "cargo_sorting",
        prompt.template_version,
    )
    assert read_cassette(tape.cassette).provenance == said
    assert "recorded from fake-1 (local)" in tape.cassette.read_text().splitlines()[0]
    assert [endpoint_kind(u) for u in ("https://api.openai.com/v1", "https://x.org/v1", "http://[::1]:1/v1")] == [
        "openai",
        "openai-compatible",
        "local",
    ]


def test_no_secret_reaches_the_file(endpoint, prompt, tape):
    """Not from our headers, not from the address, not from a server that echoes what it got."""
    endpoint.says(f"{STEPS} Your key is {KEY}.", echo={KEY: f"Bearer {KEY}"})
    url = endpoint.url.replace("http://", "http://user:pass-word@") + f"/{KEY}/v1"
    chosen = settings(endpoint, base_url=url)
    reply = ask(prompt.messages, chosen, tape)
    text = tape.cassette.read_text()
    for secret in (KEY, "pass-word", "user:", "nosy", "cookie-crumb", "req-4711", "Bearer sk", "fake/1", "stainless"):
        assert secret not in text, secret
    assert KEY not in reply.text
    assert "[key removed]" in reply.text
    assert list(tape.cassette.parent.iterdir()) == [tape.cassette]
    turn = read_cassette(tape.cassette).turns[0]
    assert set(turn.request["headers"]) <= {"accept", "content-type"}
    assert set(turn.response["headers"]) <= {"content-type"}
    assert ask(prompt.messages, chosen, Replay(tape.cassette)).text == reply.text


def test_a_key_in_the_request_is_refused(endpoint, cargo, library, tape, refused):
    endpoint.says(STEPS)
    messages = build_prompt(f"Use {KEY}.", cargo, library).messages
    refused("E133", lambda: ask(messages, settings(endpoint), tape))
    assert not tape.cassette.exists()


def test_compressed_answers_are_stored_readable(endpoint, prompt, tape):
    endpoint.says(STEPS)
    status, body, _ = endpoint.answers.pop()
    endpoint.answers.append((status, gzip.compress(body), {"content-encoding": "gzip"}))
    assert ask(prompt.messages, settings(endpoint), tape).text == STEPS
    assert STEPS in tape.cassette.read_text()
    assert ask(prompt.messages, Settings(), Replay(tape.cassette)).text == STEPS


@pytest.mark.parametrize(
    ("content", "finish", "message", "code"),
    [
        ("1. Put obj", "length", {}, "E103"),
        (None, "stop", {"refusal": "I cannot help with that."}, "E104"),
        ("", "content_filter", {}, "E104"),
        ("", "stop", {}, "E105"),
        (None, "tool_calls", {}, "E105"),
        ("  \n", "stop", {}, "E105"),
    ],
)
def test_useless_replies_are_told_apart_and_not_kept(content, finish, message, code, endpoint, prompt, tape, refused):
    endpoint.says(content, finish, **message)
    refused(code, lambda: ask(prompt.messages, settings(endpoint), tape))
    assert not tape.cassette.exists()


@pytest.mark.parametrize(
    ("status", "body", "code"),
    [
        (401, json.dumps({"error": {"message": f"Incorrect API key provided: {KEY}"}}).encode(), "E107"),
        (404, b"{}", "E107"),
        (429, b"slow down", "E107"),
        (500, b"<html>", "E107"),
        (200, b"<html>hello</html>", "E109"),
        (200, b'{"choices": []}', "E109"),
        (200, b"[" * 100_000, "E109"),
        (200, b'{"choices": [{"message": 3}]}', "E109"),
    ],
)
def test_what_an_endpoint_can_do_wrong(status, body, code, endpoint, prompt, tape, refused):
    endpoint.fails(status, body)
    error = refused(code, lambda: ask(prompt.messages, settings(endpoint), tape))
    assert KEY not in f"{error} {error.diagnostics}"
    assert not tape.cassette.exists()


def test_retries_record_only_what_came_of_them(endpoint, prompt, tape):
    endpoint.fails(500, b"{}", **{"retry-after-ms": "1"})
    endpoint.fails(429, b"{}", **{"retry-after-ms": "1"})
    endpoint.says(STEPS)
    assert ask(prompt.messages, settings(endpoint, retries=2), tape).text == STEPS
    assert len(endpoint.requests) == 3
    assert len(read_cassette(tape.cassette).turns) == 1


def test_nobody_there(endpoint, prompt, tape, refused):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        url = f"http://127.0.0.1:{free.getsockname()[1]}/v1"
    refused("E106", lambda: ask(prompt.messages, settings(endpoint, base_url=url), tape))
    for odd in ("not a url", "", "http://", "ftp://x/v1", "http://127.0.0.1:99999/v1"):
        refused("E106", lambda u=odd: ask(prompt.messages, settings(endpoint, base_url=u), tape))
    assert not tape.cassette.exists()


def test_time_limit(prompt, tape, refused, endpoint):
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        url = f"http://127.0.0.1:{silent.getsockname()[1]}/v1"
        error = refused("E106", lambda: ask(prompt.messages, settings(endpoint, base_url=url, timeout_s=0.2), tape))
    assert "0.2 s" in error.diagnostics[0].title


def test_a_key_is_needed_except_on_this_machine(endpoint, prompt, tape, refused, monkeypatch):
    monkeypatch.delenv("OPENAI_API_KEY")
    error = refused("E108", lambda: ask(prompt.messages, Settings(), tape))
    assert "OPENAI_API_KEY" in error.diagnostics[0].title
    endpoint.says(STEPS)
    assert ask(prompt.messages, settings(endpoint), tape).text == STEPS


def test_a_recording_is_added_and_never_silently_replaced(endpoint, prompt, tape, refused):
    endpoint.says(STEPS)
    ask(prompt.messages, settings(endpoint), tape)
    before = tape.cassette.read_bytes()
    endpoint.answers.clear()
    endpoint.says("1. Put object 6 on position 31.")
    again = ask(prompt.messages, settings(endpoint), tape)
    assert (again.text, again.replayed) == (STEPS, True)
    assert tape.cassette.read_bytes() == before
    refused("E130", lambda: ask(prompt.messages, settings(endpoint, model="fake-2"), tape))
    assert tape.cassette.read_bytes() == before
    forced = Record(tape.cassette, REQUEST, "cargo_sorting", prompt.template_version, replace=True)
    new = ask(prompt.messages, settings(endpoint, model="fake-2"), forced)
    assert new.text == "1. Put object 6 on position 31."
    assert new.changed[-2:] == ("-1. Put object 6 on position 32.", "+1. Put object 6 on position 31.")
    assert read_cassette(tape.cassette).provenance.model == "fake-2"
    assert len(read_cassette(tape.cassette).turns) == 1


def test_a_failed_replacement_leaves_the_old_one(endpoint, prompt, tape, refused):
    endpoint.says(STEPS)
    ask(prompt.messages, settings(endpoint), tape)
    before = tape.cassette.read_bytes()
    endpoint.answers.clear()
    endpoint.says("1. Put", "length")
    forced = Record(tape.cassette, REQUEST, "cargo_sorting", prompt.template_version, replace=True)
    refused("E103", lambda: ask(prompt.messages, settings(endpoint), forced))
    assert tape.cassette.read_bytes() == before


def test_authored_words_are_not_mixed_with_a_models(endpoint, prompt, tape, cargo, library, refused):
    author(REQUEST, cargo, library, [STEPS], tape.cassette)
    endpoint.says("1. Put object 6 on position 31.")
    refused("E130", lambda: ask(prompt.messages, settings(endpoint), tape))
    forced = Record(tape.cassette, REQUEST, "cargo_sorting", prompt.template_version, replace=True)
    assert ask(prompt.messages, settings(endpoint), forced).provenance.provenance == "recorded"
    refused("E132", lambda: author(REQUEST, cargo, library, [STEPS], tape.cassette))


def test_a_dialogue_is_recorded_as_one(endpoint, talk, tape, refused):
    endpoint.says("QUESTION: Which green block?")
    endpoint.says("1. Put object 2 on position 21.")
    request = "Put the green block on position 21."
    refused("E140", lambda: talk(request, [], settings(endpoint), tape))
    done = talk(request, ["object 2"], settings(endpoint), tape)
    assert [s.text for s in done.result.steps] == ["Put object 2 on position 21."]
    assert len(endpoint.requests) == 2, "the first turn was in the file by then"
    assert [m["role"] for m in endpoint.requests[1]["messages"]] == ["system", "user", "assistant", "user"]
    assert len(read_cassette(tape.cassette).turns) == 2
    played = talk(request, ["object 2"], Settings(), Replay(tape.cassette))
    assert played.result == done.result
