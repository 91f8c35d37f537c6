"""Asking the language model: from a recording, or, when told to record, from an OpenAI-compatible endpoint.

Recording goes through the openai SDK. Replaying sends the very bytes the SDK would send, through the HTTP
library it is built on and through vcrpy, without importing the SDK (half a second); a test holds the two
bodies together, and `Replay(through_sdk=True)` takes the long way. While a replay runs no socket can be
connected.
"""

from __future__ import annotations

import contextlib
import dataclasses
import difflib
import json
import os
import socket
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from llmbt_compiler.reasoning import cassette as tape
from llmbt_compiler.reasoning.cassette import RECORDED, Cassette, Provenance
from llmbt_compiler.reasoning.prompt import GOALS, STEPS, Messages, clean
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Span

__all__ = [
    "DEFAULT_BASE_URL",
    "DEFAULT_MODEL",
    "Completion",
    "NetworkBlockedError",
    "Record",
    "Replay",
    "Reply",
    "Script",
    "Settings",
    "answerable",
    "ask",
    "endpoint_kind",
    "no_network",
    "parse_completion",
    "request_body",
    "through_the_sdk",
]

DEFAULT_BASE_URL = "https://api.openai.com/v1"
DEFAULT_MODEL = "gpt-4o"
KEY_VARIABLE = "OPENAI_API_KEY"
DUMMY_KEY = "replay-needs-no-key"
MIN_SECRET = 8
"""Shorter keys are no secrets ("none", "test"), and blotting them out would eat words."""
JSON_REPLY = {"type": "json_object"}
ASK_AGAIN = "ask again (--record --replace), or write the reply by hand: llmbt cassette author"


@dataclass(frozen=True, slots=True)
class Settings:
    """How a model is asked. An empty `model` is the default one when recording, and any recorded one on replay.
    `price`: dollars for a million tokens in and out, as "2.5/10"; empty where it is not known."""

    model: str = ""
    base_url: str = DEFAULT_BASE_URL
    temperature: float = 0.0
    timeout_s: float = 60.0
    retries: int = 4
    reply_format: str = STEPS
    price: str = ""


@dataclass(frozen=True, slots=True)
class Replay:
    """From recordings: the one at `cassette` (file or folder), else those in `folders`, else those of the
    user and the shipped ones."""

    cassette: Path | None = None
    folders: tuple[Path, ...] | None = None
    through_sdk: bool = False


@dataclass(frozen=True, slots=True)
class Record:
    """From an endpoint, adding a turn to the recording at `cassette`. A turn that is there already is played,
    unless `replace`: then it and what follows it are asked anew. `date` (ISO) is today's where it is
    empty."""

    cassette: Path
    request: str
    scene: str
    template_version: str
    replace: bool = False
    date: str = ""


@dataclass(frozen=True, slots=True)
class Script:
    """From texts, turn by turn, whatever is asked: to see what replies come to without a recording that answers.
    `heard` is told each prompt as it is asked."""

    replies: tuple[str, ...]
    provenance: Provenance = field(default_factory=lambda: Provenance("scripted"))
    heard: Callable[[Messages], None] = lambda _: None


Transport = Replay | Record | Script


@dataclass(frozen=True, slots=True)
class Completion:
    """What a chat completion says, out of its JSON."""

    text: str
    finish_reason: str = ""
    model: str = ""
    tokens_in: int = 0
    tokens_out: int = 0
    cost_usd: float | None = None


@dataclass(frozen=True, slots=True)
class Reply:
    """The model's words and where they come from. `changed` is the diff against the reply it replaced."""

    text: str
    provenance: Provenance
    cassette: Path
    sha256: str
    completion: Completion
    replayed: bool = True
    changed: tuple[str, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """The artifact `reply.json`; the cassette goes by its name, so that no path gets in."""
        return {
            "schema_version": 1,
            "text": self.text,
            "finish_reason": self.completion.finish_reason,
            "cassette": self.cassette.name,
            "prompt_sha256": self.sha256,
            **dataclasses.asdict(self.provenance),
        }


def ask(messages: Messages, settings: Settings, transport: Transport) -> Reply:
    """The reply to messages.

    Errors: E101 (exit code 4) no recording, E102 a corrupt one, E103 the reply was cut off, E104 refused,
    E105 empty, E106 the endpoint cannot be reached, E107 it answered with an error, E108 no key, E109 it is
    no chat completion, E130 the recording is of another model or written by hand, E133 the key would have got
    into the file.
    """
    if isinstance(transport, Script):
        return _scripted(messages, settings, transport)
    if isinstance(transport, Replay):
        body = request_body(messages, settings)
        where = transport.folders if transport.folders is not None else tape.folders()
        found = tape.find(body, cassette=transport.cassette, where=where, model=settings.model)
        return _replay(found, messages, settings, through_sdk=transport.through_sdk)
    return _record(messages, settings, transport)


def answerable(messages: Messages, settings: Settings, transport: Transport) -> bool:
    """Whether `ask` would get an answer: an endpoint always, otherwise a recording of just these messages."""
    if isinstance(transport, Record):
        return True
    if isinstance(transport, Script):
        return _turn(messages) < len(transport.replies)
    where = transport.folders if transport.folders is not None else tape.folders()
    return tape.recorded(request_body(messages, settings), transport.cassette, where, settings.model)


def _turn(messages: Messages) -> int:
    return sum(1 for role, _ in messages if role == "assistant")


def _scripted(messages: Messages, settings: Settings, script: Script) -> Reply:
    turn = _turn(messages)
    if turn >= len(script.replies):
        raise LlmbtError(
            Diagnostic("E101", f"there is no reply for turn {turn + 1}", Span("prompt")),
            exit_code=ExitCode.NO_RECORDING,
        )
    script.heard(messages)
    text = script.replies[turn].encode("utf-8", "replace").decode("utf-8")
    sha256 = tape.body_hash(request_body(messages, settings))
    return Reply(text, script.provenance, Path("script"), sha256, Completion(text))


def request_body(messages: Messages, settings: Settings) -> bytes:
    """The body that the openai SDK sends, byte for byte."""
    body: dict[str, Any] = {
        "model": settings.model or DEFAULT_MODEL,
        "messages": [{"role": role, "content": content} for role, content in messages],
        "temperature": settings.temperature,
    }
    if settings.reply_format == GOALS:
        body["response_format"] = JSON_REPLY
    return json.dumps(body, ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode("utf-8", "replace")


def endpoint_kind(base_url: str) -> str:
    """`openai`, `local` (this machine) or `openai-compatible`."""
    host = urlsplit(base_url).hostname or ""
    if host == "api.openai.com":
        return "openai"
    return "local" if host in ("localhost", "127.0.0.1", "::1") else "openai-compatible"


def parse_completion(data: bytes, source: str) -> Completion:
    """Read a chat completion; E103 cut off, E104 refused, E105 empty, E109 none at all."""
    try:
        parsed = json.loads(data)
        choice = parsed["choices"][0]
        message = choice["message"]
        content, refusal = message.get("content"), message.get("refusal")
        finish = str(choice.get("finish_reason") or "")
    except (ValueError, KeyError, IndexError, TypeError, AttributeError, RecursionError):
        raise _fault(
            "E109", "the answer is no chat completion", source, "is the base URL the one that ends with /v1?"
        ) from None
    if isinstance(content, list):
        content = "".join(str(p.get("text", "")) for p in content if isinstance(p, dict))
    text = content if isinstance(content, str) else ""
    text = text.encode("utf-8", "replace").decode("utf-8")
    if (isinstance(refusal, str) and refusal) or finish == "content_filter":
        said = refusal if isinstance(refusal, str) and refusal else "its content filter stopped the reply"
        raise _fault("E104", f"the model refused: {clean(said, 200)}", source, "put the request in other words")
    if finish == "length":
        raise _fault(
            "E103",
            "the reply was cut off: the model ran into its limit of tokens",
            source,
            ASK_AGAIN,
            _tail(text),
        )
    if not text.strip():
        raise _fault("E105", "the model's reply is empty", source, ASK_AGAIN)
    raw = parsed.get("usage")
    usage: dict[str, Any] = raw if isinstance(raw, dict) else {}
    return Completion(
        text,
        finish,
        str(parsed.get("model") or ""),
        _count(usage.get("prompt_tokens")),
        _count(usage.get("completion_tokens")),
        float(cost) if isinstance(cost := usage.get("cost"), int | float) and 0 <= cost < 1e6 else None,
    )


def _count(value: object) -> int:
    return value if isinstance(value, int) else 0


def _tail(text: str) -> str:
    return f"it ends: ...{clean(text[-80:], 80)}"


def _fault(code: str, title: str, source: str, help_: str, *notes: str) -> LlmbtError:
    return LlmbtError(Diagnostic(code, title, Span(source), help=help_, notes=notes))


# --- replaying ----------------------------------------------------------------------------------------------


class NetworkBlockedError(OSError):
    """Something tried to reach the network while a recording was being played."""


@contextlib.contextmanager
def no_network() -> Iterator[None]:
    """Within, nothing in this process can resolve a name, connect a socket or send from an unconnected
    one."""

    def blocked(*_: object, **__: object) -> Any:
        raise NetworkBlockedError("the network is closed while a recording is played")

    methods = ("connect", "connect_ex", "sendto", "sendmsg")
    functions = ("getaddrinfo", "gethostbyname", "gethostbyname_ex", "create_connection")
    absent = object()
    of_class = {name: socket.socket.__dict__.get(name, absent) for name in methods}
    of_module = {name: getattr(socket, name) for name in functions}
    for name in methods:
        setattr(socket.socket, name, blocked)
    for name in functions:
        setattr(socket, name, blocked)
    try:
        yield
    finally:
        for name, method in of_class.items():
            delattr(socket.socket, name) if method is absent else setattr(socket.socket, name, method)
        for name, function in of_module.items():
            setattr(socket, name, function)


def _replay(found: Cassette, messages: Messages, settings: Settings, *, through_sdk: bool = False) -> Reply:
    """Play the turn of a recording that answers; the caller made sure that there is one."""
    body = request_body(messages, settings)
    with no_network(), tape.session(found):
        if through_sdk:
            data = through_the_sdk(messages, settings, DUMMY_KEY, None)
        else:
            data = _through_http(body, settings, found)
    completion = parse_completion(data, str(found.path))
    return Reply(completion.text, found.provenance, found.path, tape.body_hash(body), completion)


def _through_http(body: bytes, settings: Settings, found: Cassette) -> bytes:
    import httpx2
    from vcr.errors import CannotOverwriteExistingCassetteException

    def stray(_: object) -> Any:
        raise NetworkBlockedError("vcrpy let a request through")

    headers = {"accept": "application/json", "content-type": "application/json"}
    try:
        with httpx2.Client(transport=httpx2.MockTransport(stray), trust_env=False) as client:
            response = client.post(f"{settings.base_url.rstrip('/')}{tape.OPERATION}", content=body, headers=headers)
            data = response.content
    except CannotOverwriteExistingCassetteException:
        raise _fault(
            "E102", "the cassette's request is no chat completion", str(found.path), "record it again"
        ) from None
    except (httpx2.HTTPError, httpx2.InvalidURL, ValueError) as fault:
        raise _fault("E102", f"the cassette cannot be played: {fault}", str(found.path), "record it again") from None
    if response.status_code != 200:
        raise _fault(
            "E107",
            f"the recorded answer is an error: HTTP {response.status_code}",
            str(found.path),
            "record it again",
        )
    return data


# --- recording ----------------------------------------------------------------------------------------------


def _record(messages: Messages, settings: Settings, transport: Record) -> Reply:
    path, source = transport.cassette, str(transport.cassette)
    model = settings.model or DEFAULT_MODEL
    old = tape.read_cassette(path) if path.exists() else None
    body = request_body(messages, settings)
    sha256 = tape.body_hash(body)
    provenance = Provenance(
        RECORDED,
        clean(transport.request, 2000),
        transport.scene,
        model,
        endpoint_kind(settings.base_url),
        _host(settings.base_url),
        transport.date or datetime.now(UTC).date().isoformat(),
        transport.template_version,
    )
    if old is not None and not transport.replace:
        other = "a reply written by hand" if old.provenance.authored else f"of the model `{old.provenance.model}`"
        if old.provenance.provenance != RECORDED or model != old.provenance.model:
            raise _fault(
                "E130",
                f"the recording is {other}; nothing is recorded over it",
                source,
                "name another file, or give --replace",
            )
        if old.turn(sha256) is not None:
            return _replay(old, messages, settings)
        provenance = old.provenance
    before = old.turn(sha256) if old is not None else None
    kept = old.turns if old is not None else ()
    if old is not None and transport.replace:
        same = old.provenance.provenance == RECORDED and old.provenance.model == model
        kept = tuple(t for t in kept if same and len(t.messages) < len(messages))
    data, saved = _fetch(messages, settings, Cassette(path, provenance, kept))
    completion = parse_completion(data, source)
    saved = replace(saved, provenance=_with_usage(saved, completion, settings))
    tape.write_cassette(saved)
    changed = _changes(before, completion) if before is not None else ()
    return Reply(completion.text, saved.provenance, path, sha256, completion, replayed=False, changed=changed)


def _with_usage(saved: Cassette, now: Completion, settings: Settings) -> Provenance:
    """The provenance with the tokens of all turns, and what they cost: as the endpoint says, or by the price given."""
    old = saved.provenance
    fresh = len(saved.turns) == 1
    tokens_in = (0 if fresh else old.tokens_in) + now.tokens_in
    tokens_out = (0 if fresh else old.tokens_out) + now.tokens_out
    cost = now.cost_usd if now.cost_usd is not None else _priced(now, settings.price)
    before = 0.0 if fresh or not old.cost_usd else float(old.cost_usd)
    known = cost is not None and (fresh or bool(old.cost_usd))
    total = f"{before + cost:.6f}" if known and cost is not None else ""
    return replace(old, tokens_in=tokens_in, tokens_out=tokens_out, cost_usd=total)


def _priced(now: Completion, price: str) -> float | None:
    into, _, out = price.partition("/")
    try:
        return (now.tokens_in * float(into) + now.tokens_out * float(out)) / 1e6
    except ValueError:
        return None


def _fetch(messages: Messages, settings: Settings, start: Cassette) -> tuple[bytes, Cassette]:
    """Ask the endpoint through vcrpy; the answer, and the recording with it, in which the key is nowhere."""
    key = os.environ.get(KEY_VARIABLE, "")
    kind = endpoint_kind(settings.base_url)
    if not key and kind != "local":
        raise _fault(
            "E108",
            f"recording needs a key, and ${KEY_VARIABLE} is not set",
            str(start.path),
            f"export {KEY_VARIABLE}=...; it is read from the environment alone and never written anywhere",
        )
    secret = key if len(key) >= MIN_SECRET else ""
    with tape.session(start, record=True, keep=_usable, secret=secret) as saved:
        data = through_the_sdk(messages, settings, key or DUMMY_KEY, None)
    result = saved[-1] if saved else start
    if secret and secret in tape.render_cassette(result):
        raise _fault(
            "E133",
            "the key would have got into the recording; nothing was written",
            str(start.path),
            "see the request",
        )
    if secret:
        data = data.replace(secret.encode(), b"[key removed]")
    return data, result


def _usable(data: bytes) -> bool:
    """Only a whole reply is kept: one that was cut off, refused or empty is told, and asked for anew the next
    time."""
    try:
        parse_completion(data, "")
    except LlmbtError:
        return False
    return True


def through_the_sdk(messages: Messages, settings: Settings, key: str, http_client: Any) -> bytes:
    """Ask with the openai SDK, with an HTTP client of one's own or the SDK's; the answer's bytes. E106,
    E107."""
    import openai

    endpoint = _host(settings.base_url)
    listed: list[Any] = [{"role": role, "content": content} for role, content in messages]
    try:
        with openai.OpenAI(
            api_key=key,
            base_url=settings.base_url,
            timeout=settings.timeout_s,
            max_retries=settings.retries,
            http_client=http_client,
        ) as client:
            more: dict[str, Any] = {"response_format": JSON_REPLY} if settings.reply_format == GOALS else {}
            raw = client.chat.completions.with_raw_response.create(
                messages=listed, model=settings.model or DEFAULT_MODEL, temperature=settings.temperature, **more
            )
            return bytes(raw.content)
    except openai.APIStatusError as fault:
        said = clean(fault.message.replace(key, "[key removed]"), 300)
        raise _fault(
            "E107", f"{endpoint} answered with an error: {said}", endpoint, _advice(fault.status_code)
        ) from None
    except openai.APITimeoutError:
        raise _fault(
            "E106", f"{endpoint} did not answer within {settings.timeout_s:g} s", endpoint, "try again later"
        ) from None
    except (openai.OpenAIError, OSError, ValueError) as fault:
        said = clean(str(fault.__cause__ or fault).replace(key, "[key removed]"), 200)
        raise _fault("E106", f"{endpoint} cannot be reached: {said}", endpoint, "is --base-url right?") from None


def _advice(status: int) -> str:
    if status in (401, 403):
        return f"is ${KEY_VARIABLE} valid for this endpoint?"
    if status == 404:
        return "does the endpoint have this --model, and does --base-url end with /v1?"
    return "try again later" if status == 429 or status >= 500 else "see what the endpoint accepts"


def _host(base_url: str) -> str:
    """Scheme and host without user info, path or query, in which keys have been seen."""
    parts = urlsplit(base_url)
    try:
        port = f":{parts.port}" if parts.port is not None else ""
    except ValueError:
        port = ""
    return f"{parts.scheme}://{parts.hostname or ''}{port}"


def _changes(before: tape.Turn, now: Completion) -> tuple[str, ...]:
    try:
        old = parse_completion(str(before.response["body"]["string"]).encode(), "").text
    except LlmbtError:
        old = ""
    return tuple(difflib.unified_diff(old.splitlines(), now.text.splitlines(), "before", "now", lineterm="", n=0))
