"""Replaying: what answers, what does not, and that nothing reaches the network."""

from __future__ import annotations

import shutil
import socket
import subprocess
import sys
import urllib.request
from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from llmbt_compiler.pipeline import Context, compile_request
from llmbt_compiler.reasoning.author import author, author_all, read_replies
from llmbt_compiler.reasoning.cassette import body_hash, find, read_cassette, render_cassette, session
from llmbt_compiler.reasoning.chat import (
    NetworkBlockedError,
    Replay,
    Settings,
    ask,
    no_network,
    request_body,
)
from llmbt_compiler.reasoning.prompt import build_prompt
from llmbt_ir.diagnostics import ExitCode

REQUEST = "Put the red block on position 32."
REPLY = "Sure!\n\n1. Pick up object 6 and place it on position 32.\n"
ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True)
def _no_way_out(monkeypatch):
    monkeypatch.delenv("LLMBT_CASSETTES", raising=False)
    monkeypatch.delenv("OPENAI_API_KEY", raising=False)
    with no_network():
        yield


@pytest.fixture
def made(cargo, library, tmp_path):
    return author(REQUEST, cargo, library, [REPLY], tmp_path / "red.yaml", date="2026-11-22")


def test_authored_recording_replays(made, cargo, library):
    reply = ask(build_prompt(REQUEST, cargo, library).messages, Settings(), Replay(made.path))
    assert reply.text == REPLY
    assert reply.provenance.authored
    assert reply.provenance.model == ""
    assert reply.provenance.request == REQUEST
    assert reply.as_json()["provenance"] == "authored"
    assert str(made.path.parent) not in str(reply.as_json())


def test_the_file_says_who_wrote_it_and_holds_no_key(made):
    text = made.path.read_text()
    assert text.startswith("# A dialogue for LLM-BT, authored by hand, not said by any model.\n# One writer composed ")
    assert text.endswith("\n")
    assert "provenance: authored" in text
    assert not any(word in text.lower() for word in ("authorization", "bearer", "user-agent", "x-stainless"))
    headers = read_cassette(made.path).turns[0].request["headers"]
    assert set(headers) == {"accept", "content-type"}


def test_authoring_repeats_byte_for_byte(made, cargo, library):
    before = made.path.read_bytes()
    again = author(REQUEST, cargo, library, [REPLY], made.path, date="2026-11-22")
    assert not again.changed
    undated = author(REQUEST, cargo, library, [REPLY], made.path)
    assert not undated.changed
    assert made.path.read_bytes() == before
    assert author(REQUEST, cargo, library, ["1. Put object 6 on position 32."], made.path).changed


def test_plain_vcrpy_reads_the_file(made, cargo, library):
    import vcr

    loaded = vcr.cassette.Cassette.load(path=str(made.path))
    assert len(loaded) == 1
    assert body_hash(loaded.requests[0].body) == made.cassette.turns[0].sha256


def test_the_sdk_sends_the_bytes_that_the_replay_sends(cargo, library):
    import httpx2
    import openai

    sent = []

    def answer(request):
        sent.append(request.read())
        return httpx2.Response(200, json={})

    messages = build_prompt("Grüße: “put” it \\ there \u2028 now", cargo, library).messages
    client = openai.OpenAI(api_key="k", http_client=httpx2.Client(transport=httpx2.MockTransport(answer)))
    client.chat.completions.create(
        messages=[{"role": r, "content": c} for r, c in messages], model="gpt-4o", temperature=0.0
    )
    assert sent == [request_body(messages, Settings())]


def test_replay_through_the_sdk_gives_the_same(made, cargo, library):
    messages = build_prompt(REQUEST, cargo, library).messages
    short = ask(messages, Settings(), Replay(made.path))
    long = ask(messages, Settings(), Replay(made.path, through_sdk=True))
    assert short == long


def test_replay_imports_no_sdk(made):
    code = (
        "import sys; from pathlib import Path\n"
        "from llmbt_compiler.reasoning import chat, cassette, dialogue, author\n"
        "assert not {'vcr', 'openai', 'yaml', 'httpx2', 'jinja2'} & set(sys.modules), 'imported at "
        "start-up'\n"
        f"turn = cassette.read_cassette(Path({str(made.path)!r})).turns[0]\n"
        f"chat.ask(turn.messages, chat.Settings(), chat.Replay(Path({str(made.path)!r})))\n"
        "assert 'vcr' in sys.modules and 'openai' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT)


def test_endpoint_and_host_do_not_matter_for_a_replay(made, cargo, library):
    messages = build_prompt(REQUEST, cargo, library).messages
    settings = Settings(base_url="http://elsewhere.invalid:99/deep/v2/")
    assert ask(messages, settings, Replay(made.path)).text == REPLY


def test_a_changed_prompt_is_exit_code_4_with_the_nearest_and_a_diff(made, cargo, library, refused):
    moved = replace(cargo, objects=(replace(cargo.objects[0], place="position_12"), *cargo.objects[1:]))
    messages = build_prompt(REQUEST, moved, library).messages
    error = refused("E101", lambda: ask(messages, Settings(), Replay(made.path)))
    assert error.exit_code is ExitCode.NO_RECORDING
    diagnostic = error.diagnostics[0]
    assert diagnostic.candidates == ("red.yaml",)
    assert "`red.yaml`" in diagnostic.help
    assert "-    - position_12: empty" in diagnostic.notes
    assert any(n.startswith('+- object_1 "green block"') for n in diagnostic.notes)
    assert len(diagnostic.notes) <= 26
    assert all("\n" not in n for n in diagnostic.notes)


def test_the_nearest_recording_is_the_one_with_the_likest_request(cargo, library, tmp_path, refused):
    for name, request in [("a", "Put the red block on position 31."), ("b", "Swap object 1 and object 3.")]:
        author(request, cargo, library, [REPLY], tmp_path / f"{name}.yaml")
    messages = build_prompt("Please swap object 1 with object 3.", cargo, library).messages
    error = refused("E101", lambda: ask(messages, Settings(), Replay(folders=(tmp_path,))))
    assert error.diagnostics[0].candidates[0] == "b.yaml"


def test_no_recordings_at_all(cargo, library, tmp_path, refused, monkeypatch):
    monkeypatch.setenv("LLMBT_CASSETTES", str(tmp_path / "nowhere"))
    messages = build_prompt("Dance.", cargo, library).messages
    assert refused("E101", lambda: ask(messages, Settings(), Replay(folders=(tmp_path,)))).exit_code == 4
    notes = refused("E101", lambda: ask(messages, Settings(), Replay(folders=()))).diagnostics[0].notes
    assert any("nowhere" in n for n in notes)


def test_folders_of_the_user_are_looked_at(made, cargo, library, monkeypatch):
    monkeypatch.setenv("LLMBT_CASSETTES", str(made.path.parent))
    assert ask(build_prompt(REQUEST, cargo, library).messages, Settings(), Replay()).text == REPLY


def test_a_named_model_must_be_the_recorded_one(made, cargo, library, refused):
    messages = build_prompt(REQUEST, cargo, library).messages
    error = refused("E101", lambda: ask(messages, Settings(model="other"), Replay(made.path)))
    assert "authored by hand" in error.diagnostics[0].notes[0]


def test_header_lines_are_a_short_cut_and_not_the_truth(made, cargo, library):
    messages = build_prompt(REQUEST, cargo, library).messages
    text = made.path.read_text()
    bare = "".join(line for line in text.splitlines(True) if not line.startswith("#"))
    made.path.write_text(bare)
    assert ask(messages, Settings(), Replay(folders=(made.path.parent,))).text == REPLY
    made.path.write_text("# turn 1 sha256 " + "0" * 64 + "\n" + bare)
    assert ask(messages, Settings(), Replay(folders=(made.path.parent,))).text == REPLY


def test_one_of_hundreds_is_found_without_parsing_the_others(made, cargo, library, tmp_path, monkeypatch):
    for i in range(200):
        text = made.path.read_text().replace(made.cassette.turns[0].sha256, f"{i:064x}")
        (tmp_path / f"a{i}.yaml").write_text(text)
    parsed = []
    real = read_cassette
    monkeypatch.setattr("llmbt_compiler.reasoning.cassette.read_cassette", lambda p: parsed.append(p) or real(p))
    body = request_body(build_prompt(REQUEST, cargo, library).messages, Settings())
    assert find(body, where=[tmp_path]).path == made.path
    assert parsed == [made.path]


CORRUPT = {
    "empty": b"",
    "binary": b"\x00\xff\xfe\x80" * 20,
    "no yaml": b"a: [1, 2\nb: }",
    "a list": b"- 1\n- 2\n",
    "no interactions": b"version: 1\n",
    "another version": b"version: 9\ninteractions: []\n",
    "deep": b"[" * 200_000,
    "deep blocks": b"- " * 100_000,
    "an object": b"version: 1\ninteractions: !!python/object/apply:os.system ['true']\n",
    "half an exchange": b"version: 1\ninteractions:\n- request: {method: POST}\n",
    "not an exchange": b"version: 1\ninteractions:\n- request: {method: POST, uri: [], body: 3, headers: {}}\n"
    b"  response: {status: {code: x}, headers: {}, body: {string: 1}}\n",
    "a bomb": b"a: &a [x,x,x,x,x,x,x,x]\nb: &b [*a,*a,*a,*a,*a,*a]\nc: &c [*b,*b,*b,*b,*b,*b]\n"
    b"version: 1\ninteractions: *c\n",
    "odd metadata": b"version: 1\ninteractions: []\nmetadata: 3\n",
}


@pytest.mark.parametrize("name", CORRUPT)
def test_a_corrupt_cassette_is_a_diagnostic(name, cargo, library, tmp_path, refused):
    path = tmp_path / "corrupt.yaml"
    path.write_bytes(CORRUPT[name])
    messages = build_prompt(REQUEST, cargo, library).messages
    error = refused("E102", lambda: ask(messages, Settings(), Replay(path)))
    assert error.exit_code is ExitCode.BAD_INPUT
    assert error.diagnostics[0].span.source == str(path)


def test_a_corrupt_neighbour_does_no_harm_and_is_told(made, cargo, library, tmp_path, refused):
    (tmp_path / "a.yaml").write_bytes(b"[" * 100_000)
    where = Replay(folders=(tmp_path,))
    assert ask(build_prompt(REQUEST, cargo, library).messages, Settings(), where).text == REPLY
    messages = build_prompt("Dance.", cargo, library).messages
    notes = refused("E101", lambda: ask(messages, Settings(), where)).diagnostics[0].notes
    assert any("a.yaml` cannot be used" in n for n in notes)


def test_a_truncated_file_is_corrupt_at_every_length(made, cargo, library, refused):
    data = made.path.read_bytes()
    messages = build_prompt(REQUEST, cargo, library).messages
    from llmbt_ir.diagnostics import LlmbtError

    for size in range(0, len(data) - 40, 97):
        made.path.write_bytes(data[:size])
        with pytest.raises(LlmbtError) as caught:
            ask(messages, Settings(), Replay(made.path))
        assert caught.value.diagnostics[0].code in ("E101", "E102", "E109"), (size, caught.value)


def test_a_missing_cassette_is_told(cargo, library, tmp_path, refused):
    messages = build_prompt(REQUEST, cargo, library).messages
    refused("E001", lambda: ask(messages, Settings(), Replay(tmp_path / "missing.yaml")))


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (('finish_reason": "stop', 'finish_reason": "length'), "E103"),
        (('finish_reason": "stop', 'finish_reason": "content_filter'), "E104"),
        (('"choices"', '"choosings"'), "E109"),
        (("code: 200", "code: 500"), "E107"),
        (("chat/completions", "embeddings"), "E102"),
        (("method: POST", "method: GET"), "E102"),
    ],
)
def test_a_recorded_answer_of_no_use_is_told(change, code, made, cargo, library, refused):
    made.path.write_text(made.path.read_text().replace(*change))
    messages = build_prompt(REQUEST, cargo, library).messages
    refused(code, lambda: ask(messages, Settings(), Replay(made.path)))


def test_rendering_and_parsing_are_inverse(made):
    again = read_cassette(made.path)
    assert again == made.cassette
    assert render_cassette(again) == made.path.read_text()
    assert yaml.safe_load(made.path.read_text())["metadata"]["provenance"] == "authored"


# --- the network --------------------------------------------------------------------------------------------


def test_a_stray_request_fails_in_replay(made):
    """Inside a session that replays, another request is refused by vcrpy; outside vcrpy's reach, by the
    socket."""
    import httpx2
    from vcr.errors import CannotOverwriteExistingCassetteException

    with session(made.cassette):
        with pytest.raises(CannotOverwriteExistingCassetteException):
            httpx2.post("https://api.openai.com/v1/chat/completions", json={"model": "x", "messages": []})
        with pytest.raises(CannotOverwriteExistingCassetteException):
            httpx2.get("https://example.org/")
        with pytest.raises(CannotOverwriteExistingCassetteException):
            urllib.request.urlopen("http://example.org/")
        with pytest.raises(NetworkBlockedError):
            socket.create_connection(("127.0.0.1", 9))


def test_no_network_means_none(endpoint):
    port = int(endpoint.url.split(":")[2].split("/")[0])
    sock = socket.socket()
    with pytest.raises(NetworkBlockedError):
        sock.connect(("127.0.0.1", port))
    with pytest.raises(NetworkBlockedError):
        socket.getaddrinfo("example.org", 443)
    with pytest.raises(OSError, match="closed"):
        urllib.request.urlopen(endpoint.url)
    assert endpoint.requests == []
    sock.close()


def test_a_miss_never_asks_the_endpoint(endpoint, made, cargo, library, refused):
    endpoint.says("1. Drop it.")
    messages = build_prompt("Something else.", cargo, library).messages
    refused("E101", lambda: ask(messages, Settings(base_url=endpoint.url), Replay(made.path)))
    assert endpoint.requests == []


def test_no_network_gives_back_what_it_took():
    before = (socket.socket.connect, socket.getaddrinfo)
    with no_network():
        pass
    assert (socket.socket.connect, socket.getaddrinfo) == before


# --- dialogues and the shipped recordings -------------------------------------------------------------------


def test_a_question_an_answer_and_the_steps(cargo, library, tmp_path, refused, talk):
    path = tmp_path / "which.yaml"
    author(
        "Put the green block on position 21.",
        cargo,
        library,
        ["QUESTION: Which green block?", "1. Put object 2 on position 21."],
        path,
        answers=["object 2"],
    )
    request = "Put the green block on position 21."
    error = refused("E140", lambda: talk(request, [], Settings(), Replay(path)))
    assert error.exit_code is ExitCode.UNCLEAR
    assert "Which green block?" in error.diagnostics[0].title
    assert error.diagnostics[0].candidates == ("object_1", "object_2", "object_4")
    done = talk(request, ["object 2"], Settings(), Replay(path))
    assert [t.kind for t in done.dialogue.turns] == ["request", "reply", "question", "answer", "reply"]
    assert [s.text for s in done.result.steps] == ["Put object 2 on position 21."]
    assert talk(request, ["object 2", "left"], Settings(), Replay(path)).unused == ("left",)
    refused("E101", lambda: talk(request, ["object 4"], Settings(), Replay(path)))


def test_turns_must_alternate(cargo, library, tmp_path, refused):
    """A second reply needs a question and its answer, or a first one that cannot be carried out."""
    path = tmp_path / "x.yaml"
    for replies, answers in (([REPLY, REPLY], []), ([REPLY], ["object 2"]), (["QUESTION: Which?", REPLY], [])):
        error = refused("E131", lambda r=replies, a=answers: author(REQUEST, cargo, library, r, path, answers=a))
        assert error.exit_code is ExitCode.USAGE
    made = author(REQUEST, cargo, library, ["1. Put object 9 on position 32.", REPLY], path)
    assert [len(t.messages) for t in made.cassette.turns] == [2, 4]
    assert "the scene has no object `object 9`" in made.cassette.turns[1].messages[-1][1]
    assert made.cassette.provenance.outcome == "On(object_6, position_32)"


def test_authoring_spares_what_is_no_authored_cassette(cargo, library, tmp_path, refused):
    path = tmp_path / "notes.yaml"
    path.write_text("my notes\n")
    refused("E132", lambda: author(REQUEST, cargo, library, [REPLY], path))
    assert path.read_text() == "my notes\n"
    assert author(REQUEST, cargo, library, [REPLY], path, overwrite=True).changed


@pytest.mark.parametrize(
    "text",
    ["", "\x00\x01", "a\u2028b\ufeff\x85c", "\U0001f600 \\n 'q' \"d\" #x: [y]", "\t x\r\ny  \n\n", "\ud800"],
)
def test_odd_replies_survive_the_file(text, cargo, library, tmp_path):
    made = author(REQUEST, cargo, library, [text], tmp_path / "odd.yaml")
    again = read_cassette(made.path)
    assert again == made.cassette
    if text.strip():
        reply = ask(build_prompt(REQUEST, cargo, library).messages, Settings(), Replay(made.path))
        assert reply.text == text.replace("\ud800", "?")


def _scene(name):
    from llmbt_atl.library import load_library
    from llmbt_ir.scene import load_scene, to_semantic_map

    semantic_map = to_semantic_map(load_scene(name))
    return semantic_map, load_library(semantic_map.library)


def test_shipped_recordings_are_what_the_replies_make(tmp_path):
    """`make cassettes` would change nothing: no recording is stale, and none was edited by hand."""
    made = author_all(ROOT / "fixtures/replies", tmp_path, _scene)
    shipped = {p.name: p.read_text() for p in (ROOT / "fixtures/llm_cassettes").glob("*.yaml")}
    assert {a.path.name: a.path.read_text() for a in made} == shipped
    assert all(a.cassette.provenance.authored for a in made)


@pytest.mark.parametrize("dialogue", read_replies(ROOT / "fixtures/replies/replies.xml"), ids=lambda d: d.name)
def test_shipped_recordings_answer(dialogue):
    left = list(dialogue.answers)
    context = Context(dialogue.request, *_scene(dialogue.scene), Replay(), corrections=0)
    done = compile_request(context, stop_after="filter", consult=lambda _: left.pop(0) if left else None)
    assert done.values["filter"].steps
    assert done.reply.provenance.authored
    assert left == []


def test_faults_in_the_list_of_replies_have_lines(tmp_path, refused):
    shutil.copytree(ROOT / "fixtures/replies", tmp_path / "r")
    path = tmp_path / "r/replies.xml"
    text = path.read_text()
    path.write_text(text.replace('name="swap_two"', 'name="sort_by_colour"'))
    assert refused("E134", lambda: read_replies(path)).diagnostics[0].span.line > 10
    path.write_text(text.replace("<Reply file", "<Replies file"))
    assert refused("E006", lambda: read_replies(path)).diagnostics[0].span.line > 3
