"""The cargo scene as a map, a library of one's own, and an endpoint on the loopback that speaks like
OpenAI's."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import pytest

from llmbt_atl.library import Library, load_library
from llmbt_compiler.pipeline import Context, compile_request
from llmbt_compiler.reasoning.chat import Reply, Settings, Transport
from llmbt_compiler.reasoning.dialogue import Dialogue
from llmbt_compiler.reasoning.steps import Steps
from llmbt_ir.geometry import Pose
from llmbt_ir.semantic_map import MapObject, MapPlace, SemanticMap

COLOURS = {1: "green", 2: "green", 3: "yellow", 4: "green", 5: "yellow", 6: "red"}


@pytest.fixture(scope="session")
def library() -> Library:
    return load_library("cargo_sorting")


@pytest.fixture(scope="session")
def cargo() -> SemanticMap:
    """Six blocks in the sorting area."""
    places = [
        MapPlace("workbench", "workbench", "region"),
        MapPlace("sorting_area", "sorting area", "buffer", "workbench", buffer=True),
        MapPlace("shelf", "shelf", "container"),
    ]
    for level in (1, 2, 3):
        places.append(MapPlace(f"shelf_level_{level}", f"level {level}", "level", "shelf"))
        places += [
            MapPlace(f"position_{level}{i}", f"position {level}{i}", "slot", f"shelf_level_{level}")
            for i in (1, 2, 3, 4)
        ]
    objects = tuple(
        MapObject(
            f"object_{i}",
            f"{colour} block",
            colour,
            "cube",
            (0.045, 0.045, 0.045),
            Pose((0.1 * i, 0, 0)),
            "sorting_area",
        )
        for i, colour in COLOURS.items()
    )
    return SemanticMap("cargo_sorting", "cargo_sorting", objects, tuple(places))


@dataclass
class Endpoint:
    """An OpenAI-compatible endpoint: `answers` are played in order, the last one again and again."""

    url: str = ""
    answers: list[tuple[int, bytes, dict[str, str]]] = field(default_factory=list)
    requests: list[dict[str, Any]] = field(default_factory=list)
    headers: list[dict[str, str]] = field(default_factory=list)

    def says(self, content: str | None, finish: str = "stop", **message: Any) -> None:
        body = {
            "id": "chatcmpl-1",
            "object": "chat.completion",
            "created": 1,
            "model": "fake-1",
            "choices": [
                {
                    "index": 0,
                    "finish_reason": finish,
                    "message": {"role": "assistant", "content": content, **message},
                }
            ],
            "usage": {"prompt_tokens": 11, "completion_tokens": 7, "total_tokens": 18},
        }
        self.answers.append((200, json.dumps(body).encode(), {}))

    def fails(self, status: int, body: bytes = b'{"error": {"message": "no"}}', **headers: str) -> None:
        self.answers.append((status, body, headers))


@pytest.fixture
def endpoint() -> Iterator[Endpoint]:
    state = Endpoint()

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            state.requests.append(json.loads(self.rfile.read(int(self.headers["content-length"]))))
            state.headers.append(dict(self.headers))
            status, body, headers = state.answers.pop(0) if len(state.answers) > 1 else state.answers[0]
            self.send_response(status)
            for name, value in {
                "content-type": "application/json",
                "set-cookie": "session=cookie-crumb",
                "x-request-id": "req-4711",
                "openai-organization": "org-nosy",
                "server": "fake/1",
                **headers,
            }.items():
                self.send_header(name, value)
            self.send_header("content-length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_: object) -> None:
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    state.url = f"http://127.0.0.1:{server.server_port}/v1"
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    yield state
    server.shutdown()
    server.server_close()
    thread.join()


@dataclass(frozen=True)
class Talk:
    """A dialogue as far as the text filter: what it came to, every turn, and the answers that were not asked for."""

    result: Steps
    reply: Reply
    dialogue: Dialogue
    unused: tuple[str, ...]


@pytest.fixture
def talk(cargo: SemanticMap, library: Library) -> Callable[..., Talk]:
    """Have the dialogue about a request; a question that stays open is the error E140."""

    def run(request: str, answers: list[str], settings: Settings, transport: Transport) -> Talk:
        left = list(answers)
        context = Context(request, cargo, library, transport, settings, corrections=0)
        done = compile_request(context, stop_after="filter", consult=lambda _: left.pop(0) if left else None)
        return Talk(done.values["filter"], done.values["reason"], done.dialogue, tuple(left))

    return run


@pytest.fixture
def refused() -> Callable[..., Any]:
    """Run something that must end in diagnostics; the error comes back."""
    from llmbt_ir.diagnostics import LlmbtError

    def run(code: str, call: Callable[[], object]) -> LlmbtError:
        with pytest.raises(LlmbtError) as caught:
            call()
        assert caught.value.diagnostics[0].code == code, caught.value
        return caught.value

    return run
