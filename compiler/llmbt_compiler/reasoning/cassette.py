"""Recordings of dialogues with a language model: vcrpy cassettes with their provenance, found by what was
asked.

One file is one dialogue; its turns are vcrpy interactions and its provenance is vcrpy's `metadata`. Comment
lines at the top carry the hash of each turn's canonical body, so that one file in hundreds is found without
parsing them all. The hashes are a short cut and never the truth: vcrpy matches on the body.

What matches: the method, the operation (.../chat/completions) and the body as canonical JSON. Host and model
stand in the provenance, so that any endpoint's recording serves; a model that the user names must be the
recorded one.
"""

from __future__ import annotations

import contextlib
import difflib
import hashlib
import json
import os
import re
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from llmbt_compiler.reasoning.prompt import Messages, clean, request_of
from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError, Span
from llmbt_ir.shipped import shipped
from llmbt_ir.xml import read_bytes

__all__ = [
    "AUTHORED",
    "RECORDED",
    "Cassette",
    "Provenance",
    "Turn",
    "all_cassettes",
    "body_hash",
    "canonical_body",
    "find",
    "folders",
    "parse_cassette",
    "read_cassette",
    "recorded",
    "render_cassette",
    "session",
    "write_cassette",
]

RECORDED, AUTHORED = "recorded", "authored"
FOLDERS_VARIABLE = "LLMBT_CASSETTES"
MAX_CASSETTE_BYTES = 8 * 1024 * 1024
MAX_YAML_DEPTH = 24
MAX_DIFF_LINES = 24
MAX_VALUE = 20_000
HEADER_BYTES = 8192
REQUEST_HEADERS = ("content-type", "accept")
RESPONSE_HEADERS = ("content-type",)
OPERATION = "/chat/completions"
_WRITTEN = """\
# One writer composed the request and the replies; nobody asked a model. The model that a request names is the one that
# would have been asked, and all that stands in a response is the writer's.
"""
_HASH_LINE = re.compile(rb"^# turn \d+ sha256 ([0-9a-f]{64})\s*$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Provenance:
    """Where a recording comes from. `provenance` is `recorded` or `authored`; an authored one has no model.

    `outcome` is what the replies came to when they were recorded: the goals, or the code that refused them. `cost_usd`
    is empty where neither the endpoint nor the user said what tokens cost.
    """

    provenance: str
    request: str = ""
    scene: str = ""
    model: str = ""
    endpoint_kind: str = ""
    endpoint: str = ""
    date: str = ""
    template_version: str = ""
    reply_format: str = ""
    tokens_in: int = 0
    tokens_out: int = 0
    cost_usd: str = ""
    outcome: str = ""

    @property
    def authored(self) -> bool:
        """Whether the replies were composed, not said by a model that was asked."""
        return self.provenance == AUTHORED

    def words(self) -> str:
        """For reports: where the replies come from, in one clause."""
        if self.authored:
            return "authored by hand, not said by any model"
        if self.provenance == RECORDED:
            kind = self.endpoint_kind or "endpoint unknown"
            return f"recorded from {self.model or 'an unnamed model'} ({kind})"
        return "of unknown provenance"


@dataclass(frozen=True, slots=True)
class Turn:
    """One exchange: the request's body and the response, as vcrpy stores them."""

    sha256: str
    body: str
    request: Mapping[str, Any] = field(repr=False)
    response: Mapping[str, Any] = field(repr=False)

    @property
    def messages(self) -> Messages:
        """What was asked; empty where the body is none of ours."""
        return _messages(self.body)


@dataclass(frozen=True, slots=True)
class Cassette:
    """A dialogue. `path` is where it was read from."""

    path: Path
    provenance: Provenance
    turns: tuple[Turn, ...] = ()

    def turn(self, sha256: str) -> Turn | None:
        """The first turn that asked this."""
        return next((t for t in self.turns if t.sha256 == sha256), None)


# --- what is matched ----------------------------------------------------------------------------------------


def canonical_body(body: bytes | str) -> bytes:
    """JSON with sorted keys and no spaces, without the model; a body that is no JSON object stays as it
    is."""
    try:
        parsed = json.loads(body)
    except (ValueError, RecursionError):
        parsed = None
    if not isinstance(parsed, dict):
        return body.encode("utf-8", "replace") if isinstance(body, str) else bytes(body)
    parsed.pop("model", None)
    text = json.dumps(parsed, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return text.encode("utf-8", "surrogatepass")


def body_hash(body: bytes | str) -> str:
    """The sha256 of the canonical body, in hex."""
    return hashlib.sha256(canonical_body(body)).hexdigest()


def _messages(body: str) -> Messages:
    try:
        listed = json.loads(body)["messages"]
        return tuple((str(m["role"]), str(m["content"])) for m in listed)
    except (ValueError, KeyError, TypeError, RecursionError):
        return ()


# --- the file -----------------------------------------------------------------------------------------------


def read_cassette(path: Path) -> Cassette:
    """Read a recording. Errors: E001, E002 it cannot be read, E102 it is none."""
    return parse_cassette(read_bytes(path, "cassette"), path)


def parse_cassette(data: bytes, path: Path) -> Cassette:
    """Parse and check a recording: bounded in size and depth, plain YAML without tags that build objects.
    E102."""
    import yaml

    if len(data) > MAX_CASSETTE_BYTES:
        raise _corrupt(path, f"it is larger than {MAX_CASSETTE_BYTES // 2**20} MiB")
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as fault:
        raise _corrupt(path, "it is not UTF-8", data[: fault.start].count(b"\n") + 1) from None
    try:
        _check_depth(text, path)
        document = yaml.load(text, Loader=yaml.CSafeLoader)
    except yaml.MarkedYAMLError as fault:
        at: Any = fault.problem_mark
        line = at.line + 1 if at is not None else 0
        raise _corrupt(path, f"it is not the YAML of a cassette: {fault.problem}", line) from None
    except (yaml.YAMLError, ValueError, RecursionError) as fault:
        raise _corrupt(path, f"it is not the YAML of a cassette: {str(fault).splitlines()[0]}") from None
    if not isinstance(document, dict) or not isinstance(document.get("interactions"), list):
        raise _corrupt(path, "it has no list of `interactions`")
    if document.get("version") != 1:
        raise _corrupt(path, f"its version is {document.get('version')!r}, where vcrpy's is 1")
    turns = tuple(_turn(i, raw, path) for i, raw in enumerate(document["interactions"], 1))
    return Cassette(path, _provenance(document.get("metadata"), path), turns)


def _corrupt(path: Path, why: str, line: int = 0) -> LlmbtError:
    return LlmbtError(
        Diagnostic(
            "E102",
            f"the cassette cannot be used: {why}",
            Span(str(path), line),
            help="restore it (git checkout), record it again, or make it again: llmbt cassette author",
        )
    )


def _check_depth(text: str, path: Path) -> None:
    """libyaml's composer recurses and would overflow the stack; its event stream does not."""
    import yaml

    depth = 0
    for event in yaml.parse(text, Loader=yaml.CSafeLoader):
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
            if depth > MAX_YAML_DEPTH:
                mark: Any = event.start_mark
                raise _corrupt(path, f"it is nested more than {MAX_YAML_DEPTH} levels deep", mark.line + 1)
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1


def _turn(number: int, raw: Any, path: Path) -> Turn:
    try:
        request, response = raw["request"], raw["response"]
        body, method, uri = request["body"], request["method"], request["uri"]
        code, content = response["status"]["code"], response["body"]["string"]
        headers = [request["headers"], response["headers"]]
    except (KeyError, TypeError, IndexError) as fault:
        raise _corrupt(path, f"interaction {number} lacks {fault}") from None
    body = body.decode("utf-8", "replace") if isinstance(body, bytes) else body
    good = (
        isinstance(body, str)
        and isinstance(method, str)
        and isinstance(uri, str)
        and isinstance(code, int)
        and isinstance(content, str | bytes)
        and all(isinstance(h, dict) for h in headers)
        and all(isinstance(k, str) and isinstance(v, list | str) for h in headers for k, v in h.items())
    )
    if not good:
        raise _corrupt(path, f"interaction {number} is no HTTP exchange")
    return Turn(body_hash(body), body, request, response)


def _provenance(metadata: Any, path: Path) -> Provenance:
    if metadata is None:
        return Provenance("unknown")
    if not isinstance(metadata, dict):
        raise _corrupt(path, "its `metadata` is no mapping")
    numbers = {"tokens_in", "tokens_out"}
    known = {f.name for f in fields(Provenance)} - numbers
    values: dict[str, Any] = {k: clean(str(v), MAX_VALUE) for k, v in metadata.items() if k in known and v is not None}
    values |= {k: v for k, v in metadata.items() if k in numbers and type(v) is int and 0 <= v < 2**40}
    return replace(Provenance("unknown"), **values)


def render_cassette(cassette: Cassette) -> str:
    """The file: a header of comments, the provenance, the turns. The same dialogue always gives the same
    bytes."""
    import yaml

    class Dumper(yaml.CSafeDumper):
        pass

    def string(dumper: Any, value: str) -> Any:
        return dumper.represent_scalar("tag:yaml.org,2002:str", value, style="|" if "\n" in value else None)

    Dumper.add_representer(str, string)
    document = {
        "version": 1,
        "metadata": {k: v for k, v in asdict(cassette.provenance).items() if v},
        "interactions": [{"request": dict(t.request), "response": dict(t.response)} for t in cassette.turns],
    }
    head = f"# A dialogue for LLM-BT, {clean(cassette.provenance.words(), 200)}.\n"
    if cassette.provenance.authored:
        head += _WRITTEN
    head += "".join(f"# turn {i} sha256 {t.sha256}\n" for i, t in enumerate(cassette.turns, 1))
    body = yaml.dump(document, Dumper=Dumper, sort_keys=False, allow_unicode=True, width=110)
    return head + body.rstrip("\n") + "\n"


def write_cassette(cassette: Cassette) -> None:
    """Write the file whole or not at all; missing folders are made."""
    cassette.path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=cassette.path.parent, prefix=f".{cassette.path.name}.")
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as file:
            file.write(render_cassette(cassette))
            file.flush()
            os.fsync(file.fileno())
        Path(name).chmod(0o644)
        Path(name).replace(cassette.path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


# --- finding ------------------------------------------------------------------------------------------------


def folders() -> tuple[Path, ...]:
    """Where recordings are looked for: the folders of $LLMBT_CASSETTES first, then the shipped ones."""
    own = [Path(p) for p in os.environ.get(FOLDERS_VARIABLE, "").split(os.pathsep) if p]
    return (*own, shipped("llm_cassettes"))


def all_cassettes(where: Iterable[Path]) -> tuple[Path, ...]:
    """The recordings in folders (at any depth) and single files, in the order given and then by name."""
    found: dict[Path, None] = {}
    for place in where:
        if place.is_dir():
            hits = [p for p in place.rglob("*") if p.suffix in (".yaml", ".yml") and p.is_file()]
            found.update(dict.fromkeys(p for p in sorted(hits) if not p.name.startswith(".")))
        elif place.exists():
            found[place] = None
    return tuple(found)


def _header_hashes(path: Path) -> tuple[str, ...]:
    try:
        with path.open("rb") as file:
            head = file.read(HEADER_BYTES)
    except OSError:
        return ()
    comments = re.match(rb"(?:#[^\n]*\n)*", head)
    return tuple(h.decode() for h in _HASH_LINE.findall(comments.group() if comments else b""))


def find(body: bytes, *, cassette: Path | None = None, where: Iterable[Path] = (), model: str = "") -> Cassette:
    """The recording that answers a body. `cassette` is the only one looked at where given (a file or a folder);
    `model`, where given, must be the recorded one.

    Errors: E001, E102 as `read_cassette`; E101, exit code 4, where no recording answers, with the nearest
    one.
    """
    wanted = body_hash(body)
    if cassette is not None and not cassette.is_dir():
        single = read_cassette(cassette)
        if _answers(single, wanted, model):
            return single
        raise _miss(body, (single,), (), model)
    paths = all_cassettes([cassette] if cassette is not None else where)
    for path in paths:
        if wanted in _header_hashes(path):
            found = read_cassette(path)
            if _answers(found, wanted, model):
                return found
    pool: list[Cassette] = []
    broken: list[Path] = []
    for path in paths:
        try:
            candidate = read_cassette(path)
        except LlmbtError:
            broken.append(path)
            continue
        if _answers(candidate, wanted, model):
            return candidate
        pool.append(candidate)
    raise _miss(body, tuple(pool), tuple(broken), model)


def recorded(body: bytes, cassette: Path | None, where: Iterable[Path], model: str) -> bool:
    """Whether a recording answers a body; a file that says by its comments what it answers is taken at its word, so
    that hundreds of them are not parsed for a no."""
    wanted = body_hash(body)
    for path in all_cassettes([cassette] if cassette is not None else where):
        hashes = _header_hashes(path)
        if hashes and wanted not in hashes:
            continue
        try:
            if _answers(read_cassette(path), wanted, model):
                return True
        except LlmbtError:
            continue
    return False


def _answers(cassette: Cassette, wanted: str, model: str) -> bool:
    return cassette.turn(wanted) is not None and model in ("", cassette.provenance.model)


def _miss(body: bytes, pool: tuple[Cassette, ...], broken: tuple[Path, ...], model: str) -> LlmbtError:
    asked = _messages(body.decode("utf-8", "replace"))
    notes: list[str] = []
    title = "no recording answers this prompt, and replaying never asks a model"
    record = "record one: --record --base-url URL --model NAME; or write the reply: llmbt cassette author"
    ranked = sorted(
        ((_likeness(asked, t.messages), c.path.name, c, t) for c in pool for t in c.turns),
        key=lambda row: (-row[0], row[1]),
    )
    help_, names = f"no recordings were found; {record}", tuple(dict.fromkeys(row[1] for row in ranked))[:3]
    if ranked:
        _, _, near, turn = ranked[0]
        help_ = f"the nearest is `{near.path.name}` (scene `{near.provenance.scene}`); {record}"
        if turn.sha256 == body_hash(body):
            notes.append(
                f"`{near.path.name}` answers it, {near.provenance.words()}; `{clean(model)}` was asked for: "
                "leave --model out to use any"
            )
        else:
            notes.append(f"its request: {clean(request_of(turn.messages), 300)}")
            notes += _diff(turn.messages, asked, near.path.name)
    notes += [f"`{p}` cannot be used" for p in broken[:3]]
    notes += [
        f"`{f}` of ${FOLDERS_VARIABLE} does not exist"
        for f in os.environ.get(FOLDERS_VARIABLE, "").split(os.pathsep)
        if f and not Path(f).exists()
    ]
    return LlmbtError(
        Diagnostic("E101", title, Span("prompt"), help=help_, candidates=names, notes=tuple(notes)),
        exit_code=ExitCode.NO_RECORDING,
    )


def _likeness(asked: Messages, recorded: Messages) -> float:
    """Between 0 and 3: as many turns, alike in the request's words, alike in the lines of the prompt."""
    if not recorded:
        return 0.0
    words = difflib.SequenceMatcher(None, request_of(asked).lower().split(), request_of(recorded).lower().split())
    ours, theirs = set(_lines(asked)), set(_lines(recorded))
    return (
        (1.0 if len(asked) == len(recorded) else 0.0) + words.ratio() + len(ours & theirs) / max(1, len(ours | theirs))
    )


def _lines(messages: Messages) -> list[str]:
    return [line for role, content in messages for line in (f"[{role}]", *content.splitlines())]


def _diff(recorded: Messages, asked: Messages, name: str) -> list[str]:
    lines = list(difflib.unified_diff(_lines(recorded), _lines(asked), name, "this prompt", lineterm="", n=0))
    if not lines:
        return ["the messages are the same; the parameters differ"]
    shown = [line if len(line) <= 160 else line[:159] + "…" for line in lines[:MAX_DIFF_LINES]]
    more = len(lines) - len(shown)
    return [*shown, f"... {more} more lines"] if more else shown


# --- vcrpy --------------------------------------------------------------------------------------------------


@contextlib.contextmanager
def session(
    cassette: Cassette,
    *,
    record: bool = False,
    keep: Callable[[bytes], bool] = lambda _: True,
    secret: str = "",
) -> Iterator[list[Cassette]]:
    """HTTP within answers from `cassette`, by vcrpy. With `record`, what it lacks goes out, and comes back as
    a new cassette in the list yielded (once the session ends, and only if something was added); nothing is
    written here.

    `keep` decides by a response's content whether it is worth recording; an error status never is. `secret`
    is blotted out of whatever is kept.
    """
    import vcr

    machine = vcr.VCR()
    machine.register_matcher("body", _same_body)
    machine.register_matcher("operation", _same_operation)
    shelf = _Shelf(cassette)
    machine.register_persister(shelf)
    with machine.use_cassette(
        str(cassette.path),
        record_mode="new_episodes" if record else "none",
        match_on=["method", "operation", "body"],
        allow_playback_repeats=True,
        decode_compressed_response=True,
        before_record_request=lambda request: _tidy_request(request, secret),
        before_record_response=lambda response: shelf.tidy(response, keep, secret),
    ):
        shelf.loaded = True
        yield shelf.saved


class _Shelf:
    """vcrpy's persister, over a value instead of a file."""

    def __init__(self, cassette: Cassette) -> None:
        self.cassette = cassette
        self.saved: list[Cassette] = []
        self.loaded = False

    def tidy(self, response: dict[str, Any], keep: Callable[[bytes], bool], secret: str) -> Any:
        """What becomes of a response that vcrpy takes in: one from the file stays as it is."""
        return _tidy_response(response, keep, secret) if self.loaded else response

    def load_cassette(self, *_: object, **__: object) -> tuple[list[Any], list[Any]]:
        """What vcrpy starts from."""
        from vcr.request import Request

        requests = [
            Request(str(t.request["method"]), str(t.request["uri"]), t.body.encode(), dict(t.request["headers"]))
            for t in self.cassette.turns
        ]
        return requests, [_with_bytes(t.response) for t in self.cassette.turns]

    def save_cassette(self, _path: object, content: Mapping[str, Any], **_: object) -> None:
        """What vcrpy ends with; turns that were there before keep their form."""
        turns = []
        for request, response in zip(content["requests"], content["responses"], strict=True):
            body = bytes(request.body or b"").decode("utf-8", "replace")
            text = response["body"]["string"]
            text = text.decode("utf-8", "replace") if isinstance(text, bytes) else text
            turns.append(
                Turn(
                    body_hash(body),
                    body,
                    {
                        "method": request.method,
                        "uri": request.uri,
                        "headers": {k: [v] for k, v in sorted(request.headers.items())},
                        "body": body,
                    },
                    {
                        "status": dict(response["status"]),
                        "headers": {k: list(v) for k, v in sorted(response["headers"].items())},
                        "body": {"string": text},
                    },
                )
            )
        old = self.cassette.turns
        self.saved.append(Cassette(self.cassette.path, self.cassette.provenance, (*old, *turns[len(old) :])))


def _with_bytes(response: Mapping[str, Any]) -> dict[str, Any]:
    text, status = response["body"]["string"], response["status"]
    wanted = (*RESPONSE_HEADERS, "content-encoding") if isinstance(text, bytes) else RESPONSE_HEADERS
    headers = {
        k.lower(): [_ascii(x) for x in (v if isinstance(v, list) else [v])]
        for k, v in response["headers"].items()
        if k.lower() in wanted
    }
    return {
        "status": {"code": status["code"], "message": _ascii(status.get("message") or "OK")},
        "headers": headers,
        "body": {"string": text.encode("utf-8", "replace") if isinstance(text, str) else text},
    }


def _ascii(value: object) -> str:
    return clean(str(value), 200).encode("ascii", "replace").decode("ascii")


def _same_body(ours: Any, theirs: Any) -> None:
    if canonical_body(ours.body or b"") != canonical_body(theirs.body or b""):
        raise AssertionError("the bodies differ")


def _same_operation(ours: Any, theirs: Any) -> None:
    if not (_path(ours.uri).endswith(OPERATION) and _path(theirs.uri).endswith(OPERATION)):
        raise AssertionError(f"not the operation {OPERATION}")


def _path(uri: str) -> str:
    return urlsplit(uri).path.rstrip("/")


def _tidy_request(request: Any, secret: str) -> Any:
    """Only what a replay needs: no key, no user info or query in the address, few headers, the body in
    lines."""
    from vcr.request import Request

    parts = urlsplit(request.uri)
    host = parts.hostname or ""
    if ":" in host:
        host = f"[{host}]"
    port = f":{parts.port}" if parts.port is not None else ""
    headers = {k.lower(): v for k, v in request.headers.items() if k.lower() in REQUEST_HEADERS}
    path = parts.path.replace(secret, "key-removed") if secret else parts.path
    body = bytes(request.body or b"").decode("utf-8", "replace")
    return Request(request.method, f"{parts.scheme}://{host}{port}{path}", _pretty(body), headers)


def _tidy_response(response: dict[str, Any], keep: Callable[[bytes], bool], secret: str) -> dict[str, Any] | None:
    if response["status"]["code"] != 200 or not keep(bytes(response["body"]["string"])):
        return None
    text = bytes(response["body"]["string"]).decode("utf-8", "replace")
    if secret:
        text = text.replace(secret, "[key removed]").replace(json.dumps(secret)[1:-1], "[key removed]")
    headers = {k.lower(): v for k, v in response["headers"].items() if k.lower() in RESPONSE_HEADERS}
    return {**response, "headers": headers, "body": {"string": _pretty(text).encode()}}


def _pretty(text: str) -> str:
    """JSON in lines, for a person's eye and a diff; anything else as it is. No lone surrogate gets into a
    file."""
    try:
        parsed = json.loads(text)
    except (ValueError, RecursionError):
        return text
    try:
        shown = json.dumps(parsed, indent=1, ensure_ascii=False)
        shown.encode("utf-8")
    except UnicodeEncodeError:
        return json.dumps(parsed, indent=1)
    return shown
