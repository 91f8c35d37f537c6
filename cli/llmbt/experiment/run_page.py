"""One run as one HTML page that needs nothing else: no network, no file beside it."""

from __future__ import annotations

import base64
import importlib.resources
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from llmbt.experiment.timeline import timeline
from llmbt.exports.svg import svg
from llmbt.history import Run, Stage, read_run
from llmbt.picture import picture_of_tree
from llmbt.story import stage_lines
from llmbt_ir.diagnostics import LlmbtError
from llmbt_ir.xml import read_bytes

__all__ = ["data_uri", "rendered", "run_page", "style"]

GOOD, BAD, WARN = "good", "bad", "warn"
MAX_DRAWN = 1_500
"""Trees of more nodes are not drawn."""


def style() -> str:
    """The style sheet that every page carries in it."""
    return _template("style.css.txt")


def data_uri(picture: bytes, kind: str = "svg+xml") -> str:
    """A picture as an address that holds it, so that its style stays its own."""
    return f"data:image/{kind};base64,{base64.b64encode(picture).decode()}"


def _template(name: str) -> str:
    return (importlib.resources.files(__package__) / "templates" / name).read_text(encoding="utf-8")


def rendered(template: str, values: Mapping[str, Any]) -> bytes:
    """A page from a template of this room; what is not marked safe is escaped."""
    import jinja2

    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True)
    return environment.from_string(_template(template)).render({**values, "style": style()}).encode()


def run_page(folder: Path, *, line: Mapping[str, Any] | None = None, text: str = "", every_tree: bool = True) -> bytes:
    """The page of a run's folder. `line` is that of a trial's ledger and `text` its request, for a run that ended in
    the compiler; without `every_tree` only the newest tree is drawn. E080, E082 where the folder is none and there is
    no line either."""
    line = line or {}
    try:
        run: Run | None = read_run(folder)
    except LlmbtError:
        if not line:
            raise
        run = None
    result = run.result if run is not None else {}
    reply = _reply(folder)
    request = text or (run.request if run is not None else "")
    badge = _badge(line, result)
    actions = list(result.get("actions", ()))
    values = {
        "title": str(line.get("key") or folder.resolve().name),
        "badge": badge,
        "request": request,
        "facts": _facts(line, result),
        "says": _says(line),
        "reply": reply.get("text", ""),
        "source": str(line.get("reply_source") or _source(reply)),
        "goals": _goals(run),
        "timeline": timeline(actions, _marks(run), float(result.get("sim_time_s", 0.0))) if run and actions else "",
        "pictures": _pictures(folder),
        "actions": [_action(a) for a in actions],
        "versions": [_version(run, s, every_tree) for s in run.stages] if run is not None else [],
    }
    return rendered("run.html.jinja2", values)


def _badge(line: Mapping[str, Any], result: Mapping[str, Any]) -> tuple[str, str, str] | None:
    outcome = str(result.get("outcome", ""))
    verdict = str(line.get("verdict", ""))
    word = verdict or outcome
    if not word:
        return None
    tone = GOOD if word in ("success", "SUCCESS") else WARN if word in ("asked", "refused") else BAD
    return word, tone, str(result.get("reason", ""))


def _facts(line: Mapping[str, Any], result: Mapping[str, Any]) -> list[tuple[str, str]]:
    names = {
        "scene": "scene", "world": "world", "seed": "seed", "disturb": "disturbance", "updates": "updates",
        "versions": "versions", "planner_calls": "planner calls", "sim_time_s": "simulated s", "llmbt_version": "llmbt",
    }  # fmt: skip
    found = [(told, str(result[name])) for name, told in names.items() if name in result]
    for d in result.get("disturbances", ()):
        over = f", recovered after {d['recovered_at_s'] - d['fired_at_s']:.1f} s" if d["recovered_at_s"] else ""
        found.append(("it came", f"{d['name']} of {d['target']} at {d['fired_at_s']} s{over}"))
    if "kind" in line:
        found.append(("request", f"{line['kind']}, {line['register']}"))
    if "success_by_truth" in line:
        found.append(("the case's condition holds by the truth", "yes" if line["success_by_truth"] else "no"))
    return found


def _says(line: Mapping[str, Any]) -> str:
    return f"{', '.join(line.get('codes', ()))}: {line['says']}".removeprefix(": ") if line.get("says") else ""


def _reply(folder: Path) -> Mapping[str, Any]:
    path = folder / "reply.json"
    if not path.is_file():
        return {}
    found = json.loads(read_bytes(path, "artifact"))
    return found if isinstance(found, dict) else {}


def _source(reply: Mapping[str, Any]) -> str:
    kind = str(reply.get("provenance", ""))
    said = {"authored": "authored by hand, not said by any model", "recorded": f"recorded from {reply.get('model')}"}
    return said.get(kind, kind)


def _goals(run: Run | None) -> list[dict[str, Any]]:
    if run is None:
        return []
    words = {str(g.condition): g.words for g in run.stages[0].file.provenance.goals}
    found = []
    for goal in run.result.get("goals", ()):
        text = ("not " if goal.get("negated") else "") + f"{goal['name']}({', '.join(goal['args'])})"
        found.append({"text": text, "holds": bool(goal["holds"]), "words": words.get(text, "")})
    return found


def _marks(run: Run | None) -> list[tuple[float, str, str]]:
    if run is None:
        return []
    told = [(e.time_s, "disturbance", e.text) for s in run.stages for e in s.events if e.kind == "disturbance"]
    updates = [(float(s.record.get("sim_time_s", 0.0)), "update", s.name) for s in run.stages if s.record.get("parent")]
    return sorted([*told, *updates])


def _pictures(folder: Path) -> list[tuple[str, str]]:
    return [
        (p.stem.removeprefix("scene."), data_uri(p.read_bytes(), "png"))
        for p in sorted(
            folder.glob("scene.*.png"), key=lambda p: (p.stem != "scene.start", p.stem == "scene.end", p.stem)
        )
    ]


def _action(action: Mapping[str, Any]) -> dict[str, str]:
    return {
        "when": f"{action['started_s']}–{action['ended_s']}",
        "text": f"{action['name']}({', '.join(action['args'])})",
        "result": str(action["result"]),
        "reason": str(action.get("reason", "")),
    }


def _version(run: Run, stage: Stage, every_tree: bool) -> dict[str, str]:
    head, *lines = stage_lines(run, stage, lambda text, _: text)
    newest = stage is run.stages[-1]
    drawn = (every_tree or newest) and len(stage.tree) <= MAX_DRAWN
    return {
        "name": stage.name,
        "head": head,
        "lines": "\n".join(_plain(lines)),
        "picture": data_uri(svg(picture_of_tree(stage.tree), title=stage.name).encode()) if drawn else "",
    }


def _plain(lines: Sequence[str]) -> list[str]:
    return [line.removeprefix("  ") for line in lines]
