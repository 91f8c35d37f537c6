"""A run told in words, and as data: its versions with why, and what came of them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from llmbt.history import Event, Run, Stage
from llmbt_ir.condition import Condition, parse_condition
from llmbt_ir.tree import Kind, Tree
from llmbt_runtime.update.local import ALTERNATIVES

__all__ = ["BOLD", "FAINT", "Paint", "alternatives", "log_document", "log_lines", "request_lines", "row", "stage_lines"]

Paint = Callable[[str, str], str]
BOLD, GREEN, RED, YELLOW, FAINT = "1", "32", "31", "33", "2"
FACT = re.compile(r"\w+\([^()]*\)")
RUN = ("problem", "scene", "world", "perception", "disturb", "seed", "planner")
RESULT = {"SUCCESS": GREEN, "FAILURE": RED, "HALTED": YELLOW}


def row(head: str, text: str) -> str:
    """A line of a table of two columns."""
    return f"  {head:<13} {text}"


# -- the log -------------------------------------------------------------------------------------------------------


def request_lines(run: Run) -> Iterator[str]:
    """What was asked for: the request, who answered, the goals with the words that asked for each."""
    if run.request:
        yield f"request  {run.request}"
    said = {
        "authored": "authored by hand, not said by any model",
        "recorded": f"recorded from {run.reply.get('model')}",
    }
    if run.reply.get("provenance"):
        yield f"reply    {said.get(str(run.reply['provenance']), run.reply['provenance'])}"
    if run.result:
        known = (f"{k} {run.result[k]}" for k in RUN if run.result.get(k) is not None)
        yield f"run      {', '.join(known)}"
        yield "times    simulated; an action stands in the line of its end, with its start; in gaps things come to rest"
    for goal in run.stated if run.grew else ():
        words = (
            f'   {goal.words.replace(": ", chr(58) + " " + chr(34), 1)}"' if ": " in goal.words else f"   {goal.words}"
        )
        yield f"goal     {goal.node} {goal.condition}{words if goal.words else ''}"


def stage_lines(run: Run, stage: Stage, paint: Paint) -> Iterator[str]:
    """One version: when and why it was made, how, why it will work, and what happened then."""
    record, at = stage.record, run.stages.index(stage)
    if not run.grew:
        yield paint(f"{stage.name}  the tree as it was given, ticked as it stands", BOLD)
    elif record.get("parent") is None:
        what = "the tree as it was given" if stage.tree.has_actions() else "the goals alone"
        yield paint(f"{stage.name}  {what}, {_count(stage.tree)}", BOLD)
    else:
        when = f"tick {record.get('tick')}, {record.get('sim_time_s')} s"
        before = len(run.stages[at - 1].tree) if at else 0
        grew = len(stage.tree) - before
        size = f"{_count(stage.tree)}, {abs(grew)} {'more' if grew >= 0 else 'fewer'}"
        yield paint(f"{stage.name}  {when}: {record.get('cause')}", BOLD) + f"   ({size})"
        yield from _why(record)
        yield from _steps(stage)
        yield from _certificate(stage)
    hit: list[Event] = []
    for k, event in enumerate(_told(stage.events, _under_way(run, stage))):
        hit += [event] if event.kind == "disturbance" else []
        yield row("then" if k == 0 else "", _event(event, paint) + _with_it(run, stage, event, hit))


def _count(tree: Tree) -> str:
    return _plural(len(tree), "node")


def _why(record: Mapping[str, Any]) -> Iterator[str]:
    observed = record.get("observed", {})
    for head, key in (("began to hold", "began"), ("ceased", "ended")):
        facts = observed.get(key, ())
        if facts:
            yield row(head, ", ".join(facts))
    if record.get("failed_condition"):
        yield row("failed", str(record["failed_condition"]))


def _steps(stage: Stage) -> Iterator[str]:
    for step in stage.steps:
        kind = str(step.get("kind"))
        reason = str(step.get("reason") or step.get("condition") or "")
        before = f", put before node {step['before']}" if step.get("before") else ""
        yield row(kind, f"{reason}   [node {step.get('node')}{before}]")
        if kind in ("chain", "goals") and step.get("action"):
            yield row("", f"plan: {str(step['action']).replace(') ', '), ')}")
        others = alternatives(step, 3)
        if others:
            yield row("", f"rather than {others}")
    planner = stage.record.get("planner", {})
    if planner.get("calls"):
        yield row("search", _search(planner["calls"], planner["expansions"]))


def _search(calls: int, expansions: int) -> str:
    return f"{_plural(calls, 'call')} of the planner, {_plural(expansions, 'state')} expanded"


def _plural(n: object, what: str) -> str:
    return f"{n} {what}{'' if n == 1 else 's'}"


def alternatives(step: Mapping[str, Any], n: int) -> str:
    """What else would have brought the condition about: what could start at once, and what needs other actions before
    it. A move takes no action in place of another; the edit that follows it tells what was chosen."""
    others = tuple(map(str, step.get("alternatives", ()))) if step.get("kind") != "move" else ()
    shown, rest = others[:n], len(others) - n
    more = f", and {'at least ' if len(others) == ALTERNATIVES else ''}{rest} more" if rest > 0 else ""
    if "at_once" not in step:
        return ", ".join(shown) + more
    now, later = shown[: step["at_once"]], shown[step["at_once"] :]
    if not later:
        return ", ".join(now) + more
    after = f"(each only after other actions) {', '.join(later)}"
    return (f"{', '.join(now)}; {after}" if now else after) + more


def _certificate(stage: Stage) -> Iterator[str]:
    """Why the tree will work: from what was observed its actions follow one another, and then the goals hold."""
    certificate = stage.record.get("certificate", {})
    actions = tuple(certificate.get("actions", ()))
    count = len(certificate.get("state", ()))
    if not actions:
        yield row("it will work", f"in the state observed ({count} facts) the goals hold already")
        return
    yield row(
        "it will work", f"if nothing else happens: from the state observed ({count} facts), by the templates' effects:"
    )
    purposes = _purposes(stage.tree)
    width = max(len(a) for a in actions)
    for k, action in enumerate(actions, 1):
        purpose = purposes.get(action)
        yield row("", f"{k:>3}. {action:<{width}}{f'   for {purpose}' if purpose else ''}".rstrip())
    goals = ", ".join(str(g.condition) for g in stage.file.provenance.goals)
    yield row("", f"and then {goals} hold{'' if len(stage.file.provenance.goals) > 1 else 's'}")


def _purposes(tree: Tree) -> dict[str, str]:
    """What each action in a tree is for: the head of the Fallback that it is in."""
    found: dict[str, str] = {}
    for node in tree.preorder():
        if node.action is None:
            continue
        for above in tree.ancestors(node.id):
            if tree[above].kind is Kind.FALLBACK:
                first = tree[tree[above].children[0]]
                if first.condition is not None:
                    found.setdefault(str(node.action), str(first.condition))
                break
    return found


def _under_way(run: Run, stage: Stage) -> Event | None:
    """The start of the action that was running when a version was installed."""
    running: Event | None = None
    for earlier in run.stages[: run.stages.index(stage)]:
        for event in earlier.events:
            if event.kind in ("started", "ended"):
                running = event if event.kind == "started" else None
    return running


def _told(events: Sequence[Event], running: Event | None) -> list[Event]:
    """The events a reader needs, in their order: an action is told when it ends, with its start; one that goes on under
    the next version when it starts."""
    told: list[Event] = []
    at: int | None = None
    for event in events:
        if event.kind == "started":
            running, at = event, len(told)
        elif event.kind == "ended" and running is not None:
            details = {**event.details, "since_s": running.time_s}
            told.append(Event("ended", event.time_s, event.text, details))
            running, at = None, None
        else:
            told.append(event)
    if running is not None and at is not None:
        told.insert(at, Event("goes on", running.time_s, running.text, running.details))
    return told


def _event(event: Event, paint: Paint) -> str:
    since = event.details.get("since_s")
    when = f"{since}-{event.time_s} s" if since is not None else f"{event.time_s} s"
    if event.kind == "ended":
        return f"{when:<13} {paint(event.text, RESULT.get(str(event.details.get('result')), ''))}"
    if event.kind == "disturbance":
        return f"{when:<13} {paint(f'disturbance: {event.text}', YELLOW)}"
    if event.kind == "outcome":
        return f"{when:<13} {paint(event.text, GREEN if event.text == 'SUCCESS' else RED)}"
    if event.kind == "goes on":
        return f"{when:<13} {event.text} began, and went on"
    said = {"deviation": "observed"}.get(event.kind, event.kind)
    return f"{when:<13} {said}: {event.text}"


def _with_it(run: Run, stage: Stage, event: Event, hit: Sequence[Event]) -> str:
    """What belongs to an event: the disturbance before an action was halted, where a disturbed thing was seen next."""
    if event.kind == "ended" and event.details.get("result") == "HALTED":
        since = float(event.details.get("since_s", event.time_s))
        names = [d.text.partition(":")[0] for d in hit if since <= d.time_s <= event.time_s]
        return f", after {' and '.join(names)}" if names else ""
    if event.kind == "disturbance":
        target = event.text.partition(":")[0].rpartition(" of ")[2]
        seen = next((s for s in _seen_after(run, stage, event) if any(target in _args(f) for f in s)), ())
        where = [f for f in seen if target in _args(f)]
        return f"; seen next: {', '.join(where)}" if where else ""
    return ""


def _seen_after(run: Run, stage: Stage, event: Event) -> Iterator[list[str]]:
    """What was seen to have begun, each time something was, from an event on."""
    at = next(k for k, e in enumerate(stage.events) if e is event)
    for later in stage.events[at + 1 :]:
        yield FACT.findall(later.text.rpartition("now ")[2]) if later.kind == "deviation" else []
    for after in run.stages[run.stages.index(stage) + 1 :]:
        yield FACT.findall(str(after.record.get("cause")).rpartition("now ")[2])
        for later in after.events:
            yield FACT.findall(later.text.rpartition("now ")[2]) if later.kind == "deviation" else []


def _args(fact: str) -> tuple[str, ...]:
    condition = parse_condition(fact)
    return condition.args if condition is not None else ()


def log_lines(run: Run, stages: Sequence[Stage], paint: Paint, patch: Callable[[Stage], str] | None) -> Iterator[str]:
    """The whole log; `patch` draws a version's difference to its parent."""
    if stages == run.stages:
        yield from request_lines(run)
    for stage in stages:
        yield ""
        yield from stage_lines(run, stage, paint)
        if patch is not None and run.stages.index(stage):
            yield from ("    " + line for line in patch(stage).splitlines())
    if run.result and stages == run.stages:
        goals = run.result.get("goals", ())
        held = sum(1 for g in goals if g.get("holds"))
        outcome = str(run.result.get("outcome"))
        yield ""
        reason = f": {run.result['reason']}" if run.result.get("reason") else ""
        reached = f"{held} of {len(goals)} goals hold" if goals else "no goals are stated"
        text = f"{outcome}{reason}; {reached}"
        yield paint(text, GREEN if outcome == "SUCCESS" else RED) + _totals(run)
        yield from _tally(run)
        yield from _left(run)
    elif not run.result and stages == run.stages:
        yield ""
        yield "the folder has no result: the tree was not executed here, or the run was killed"


def _totals(run: Run) -> str:
    r = run.result
    return f" ({r.get('ticks')} ticks, {r.get('sim_time_s')} s simulated, {_plural(r.get('versions'), 'version')})"


def _tally(run: Run) -> Iterator[str]:
    """How many actions ended how, and what was searched for besides the versions."""
    ends = Counter(str(a.get("result")) for a in run.result.get("actions", ()))
    if ends:
        yield row("actions", f"{ends.total()}: {', '.join(f'{ends[end]} {end}' for end in RESULT if ends[end])}")
    planners = [s.record.get("planner", {}) for s in run.stages]
    calls = run.result.get("planner_calls", 0) - sum(p.get("calls", 0) for p in planners)
    if calls > 0:
        expansions = run.result.get("expansions", 0) - sum(p.get("expansions", 0) for p in planners)
        yield row("search", f"{_search(calls, expansions)}, which led to no version")


def _left(run: Run) -> Iterator[str]:
    """What the end leaves to be told: goals that do not hold, and how the disturbances were dealt with."""
    for goal in run.result.get("goals", ()):
        if not goal.get("holds"):
            yield row("not reached", str(Condition(goal["name"], tuple(goal["args"]), bool(goal.get("negated")))))
    hit = run.result.get("disturbances", ())
    for entry in hit:
        mended = entry.get("recovered_at_s")
        end = "was never made good" if mended is None else f"was made good at {mended} s"
        yield row("disturbed", f"{entry['name']} of {entry['target']} at {entry['fired_at_s']} s {end}")
    if hit:
        yield row("", "made good: by the truth what it ended holds again, or a goal about what it happened to")


def log_document(run: Run, stages: Sequence[Stage], patch: Callable[[Stage], Any] | None) -> dict[str, Any]:
    """The log as data."""
    versions = []
    for stage in stages:
        entry = {k: v for k, v in stage.record.items() if k != "schema_version"}
        if run.grew:
            entry["nodes"] = len(stage.tree)
        entry["events"] = [dict(e.details) for e in stage.events]
        if patch is not None and run.stages.index(stage):
            entry["patch"] = patch(stage)
        versions.append(entry)
    return {"request": run.request, "versions": versions, "result": dict(run.result)}
