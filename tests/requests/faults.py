"""`python -m tests.requests.faults`: random faults put into authored replies, and what becomes of them.

Every reply that compiles without a question gets one fault of each kind. Caught: no tree, and a reason. Harmless: the
goals of the whole reply. Passes: a tree with other goals: what the reply says, and nobody who has not read the request
can tell that it is not what was asked for.
"""

from __future__ import annotations

import argparse
import random
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from llmbt.experiment.cases import experiment_names, load_experiment
from llmbt.rehearsal import rehearse
from llmbt_atl.library import Library, load_library
from llmbt_atl.state import domain_of
from llmbt_compiler.pipeline import Context, compile_request
from llmbt_compiler.reasoning.chat import Script
from llmbt_ir.condition import Condition
from llmbt_ir.diagnostics import LlmbtError
from llmbt_ir.scene import load_scene, to_semantic_map
from llmbt_ir.semantic_map import SemanticMap
from tests.requests.cases import read_open

__all__ = ["FAULTS", "MUST", "Reply", "Verdict", "counted", "inject", "replies", "verdict_of"]

MUST = ("an object that is not there", "a place that is not there", "two objects on one position", "a truncated end")
"""These may never pass."""
_STEP = re.compile(r"^\s*(?:\d+[.)]|[-*])\s+\S", re.MULTILINE)
_FROM = re.compile(r"\b(?:from|off|of)\s+(?:the\s+)?$")
Goals = frozenset[Condition]


@dataclass(frozen=True, slots=True)
class Reply:
    """A reply that compiles, with its scene, its request and its goals."""

    name: str
    request: str
    text: str
    semantic_map: SemanticMap
    library: Library
    goals: Goals


@dataclass(frozen=True, slots=True)
class Verdict:
    """What became of a fault: caught, harmless or passes; and the code or the goals."""

    kind: str
    what: str
    told: str


def outcome(request: str, text: str, semantic_map: SemanticMap, library: Library) -> Goals | str:
    """The goals, proved and rehearsed, or the code of what refused them."""
    domain = domain_of(library, semantic_map)
    context = Context(request, semantic_map, library, Script((text,)), corrections=0)
    try:
        done = compile_request(context, check=lambda c: void(rehearse(c.goals, domain, semantic_map, context.where)))
    except LlmbtError as fault:
        return fault.diagnostics[0].code
    return frozenset(g.condition for g in done.goals)


def void(_: object) -> None:
    """Only the errors count."""


def sources() -> Iterator[tuple[str, str, str, SemanticMap, Library]]:
    """Every authored reply of a clear request: of the open part, and of the experiments."""
    for case in read_open():
        if case.kind == "complete":
            scene = load_scene(case.scene)
            yield case.id, case.text, case.replies[0], to_semantic_map(scene), load_library(scene.library)
    for name in experiment_names():
        for case_ in load_experiment(name).cases:
            for request in case_.requests:
                if request.clear and request.reply:
                    told = f"{case_.name}/{request.id}"
                    yield told, request.text, request.reply, to_semantic_map(case_.scene), case_.library


def replies(most: int | None = None) -> tuple[Reply, ...]:
    """The replies that compile without a question."""
    found = []
    for name, request, text, semantic_map, library in sources():
        if most is not None and len(found) >= most:
            break
        goals = outcome(request, text, semantic_map, library)
        if isinstance(goals, frozenset):
            found.append(Reply(name, request, text, semantic_map, library, goals))
    return tuple(found)


# -- the faults ----------------------------------------------------------------------------------------------------

Fault = Callable[[Reply, random.Random], str | None]


def lines_of(text: str) -> tuple[list[str], list[int]]:
    """The lines, and which of them begin a step."""
    lines = text.rstrip("\n").split("\n")
    return lines, [i for i, line in enumerate(lines) if _STEP.match(line)]


def _dropped(reply: Reply, rng: random.Random) -> str | None:
    lines, steps = lines_of(reply.text)
    if len(steps) < 2:
        return None
    gone = rng.choice(steps)
    return _numbered([line for i, line in enumerate(lines) if i != gone])


def _doubled(reply: Reply, rng: random.Random) -> str | None:
    lines, steps = lines_of(reply.text)
    if not steps:
        return None
    again = rng.choice(steps)
    return _numbered([*lines[: again + 1], lines[again], *lines[again + 1 :]])


def _swapped(reply: Reply, rng: random.Random) -> str | None:
    lines, steps = lines_of(reply.text)
    if len(steps) < 2:
        return None
    a, b = sorted(rng.sample(steps, 2))
    lines[a], lines[b] = lines[b], lines[a]
    return _numbered(lines)


def _numbered(lines: list[str]) -> str:
    """The numbers of the steps made good, so that they do not tell what was done."""
    out, n = [], 0
    for line in lines:
        m = re.match(r"^(\s*)\d+([.)]\s)", line)
        n += m is not None
        out.append(f"{m[1]}{n}{m[2]}{line[m.end() :]}" if m is not None else line)
    return "\n".join(out) + "\n"


def _names(reply: Reply, *, objects: bool) -> list[tuple[int, int, str]]:
    """Where the reply's steps name objects or positions by their ids or names, with the id."""
    things = reply.semantic_map.objects if objects else reply.semantic_map.places
    found = []
    for thing in things:
        for words in {thing.id.replace("_", " "), thing.id}:
            pattern = re.compile(rf"\b{re.escape(words)}\b", re.IGNORECASE)
            found += [(m.start(), m.end(), thing.id) for m in pattern.finditer(reply.text)]
    lines, steps = lines_of(reply.text)
    starts = [sum(len(x) + 1 for x in lines[:i]) for i in range(len(lines))]
    inside = [(starts[i], starts[i] + len(lines[i])) for i in steps]
    return sorted(f for f in found if any(a <= f[0] < b for a, b in inside))


def _exchanged(reply: Reply, rng: random.Random, *, objects: bool) -> str | None:
    """One name in one step made another one of the scene's."""
    named = _names(reply, objects=objects)
    if not named:
        return None
    start, end, id_ = rng.choice(named)
    everything = reply.semantic_map.objects if objects else reply.semantic_map.places
    old = next(x for x in everything if x.id == id_)
    others = [x.id for x in everything if x.id != id_ and (objects or x.type == old.type)]
    if not others:
        return None
    return reply.text[:start] + rng.choice(others).replace("_", " ") + reply.text[end:]


def _another_object(reply: Reply, rng: random.Random) -> str | None:
    return _exchanged(reply, rng, objects=True)


def _another_place(reply: Reply, rng: random.Random) -> str | None:
    return _exchanged(reply, rng, objects=False)


def _no_object(reply: Reply, rng: random.Random) -> str | None:
    return _replaced(reply, rng, ("object 77", "the toaster", "object 0", "the violin"), objects=True)


def _no_place(reply: Reply, rng: random.Random) -> str | None:
    return _replaced(reply, rng, ("position 99", "shelf level 9", "the windowsill", "the balcony"), objects=False)


def _replaced(reply: Reply, rng: random.Random, names: tuple[str, ...], *, objects: bool) -> str | None:
    named = _names(reply, objects=objects)
    if not named:
        return None
    start, end, _ = rng.choice(named)
    head = reply.text[:start]
    name = rng.choice(names)
    name = name.removeprefix("the ") if re.search(r"\b(?:the|a|an)\s+$", head) else name
    return head + name + reply.text[end:]


def _on_one_position(reply: Reply, rng: random.Random) -> str | None:
    """The position of one step given to another one too, where both are about other objects."""
    slots = {p.id for p in reply.semantic_map.places if p.type == "slot"}
    taken = {c.args[1]: c.args[0] for c in reply.goals if c.name == "On" and c.args[1] in slots}
    named = [n for n in _names(reply, objects=False) if n[2] in taken and not _FROM.search(reply.text[: n[0]])]
    pairs = [(a, b) for a in named for b in named if a[2] != b[2]]
    if not pairs:
        return None
    (start, end, _), (_, _, other) = rng.choice(pairs)
    return reply.text[:start] + other.replace("_", " ") + reply.text[end:]


def _prose(reply: Reply, rng: random.Random) -> str | None:
    lines, steps = lines_of(reply.text)
    if len(steps) < 2:
        return None
    at = rng.choice(steps[1:])
    said = rng.choice((
        "By the way, this is a common way to do it, and the robot will be careful.",
        "Note that the blocks are quite light.",
        "I hope this is what you had in mind so far!",
        "The weather is nice today.",
    ))  # fmt: skip
    return "\n".join([*lines[:at], "", said, "", *lines[at:]]) + "\n"


def _truncated(reply: Reply, rng: random.Random) -> str | None:
    """Cut within a step's words, anywhere but at their ends."""
    lines, steps = lines_of(reply.text)
    if not steps:
        return None
    last = rng.choice(steps)
    whole = lines[last]
    begin = re.match(r"^\s*(?:\d+[.)]|[-*])\s+", whole)
    low = begin.end() + 1 if begin is not None else 1
    high = len(whole.rstrip(" .!*")) - 1
    if high <= low:
        return None
    return "\n".join([*lines[:last], whole[: rng.randint(low, high)]])


FAULTS: dict[str, Fault] = {
    "a step dropped": _dropped,
    "a step doubled": _doubled,
    "two steps swapped": _swapped,
    "another object": _another_object,
    "another place": _another_place,
    "an object that is not there": _no_object,
    "a place that is not there": _no_place,
    "two objects on one position": _on_one_position,
    "prose in the middle": _prose,
    "a truncated end": _truncated,
}


def inject(reply: Reply, kind: str, seed: int) -> str | None:
    """A reply with one fault; None where the kind does not apply to it. The same seed gives the same fault."""
    faulty = FAULTS[kind](reply, random.Random(f"{reply.name} {kind} {seed}"))
    return None if faulty is None or faulty.strip() == reply.text.strip() else faulty


def verdict_of(reply: Reply, kind: str, faulty: str) -> Verdict:
    """What becomes of it."""
    found = outcome(reply.request, faulty, reply.semantic_map, reply.library)
    if isinstance(found, str):
        return Verdict(kind, "caught", found)
    told = "; ".join(sorted(map(str, found)))
    return Verdict(kind, "harmless" if found == reply.goals else "passes", told)


def main() -> int:
    """Inject, count, print; 1 where something passes that may not."""
    parser = argparse.ArgumentParser(prog="python -m tests.requests.faults", description=__doc__)
    parser.add_argument("--replies", type=int, default=None, help="so many replies at most")
    parser.add_argument("--seeds", type=int, default=1, help="so many faults of each kind a reply")
    parser.add_argument("--kind", choices=FAULTS, default=None)
    parser.add_argument("--verbose", action="store_true", help="show what passes")
    options = parser.parse_args()
    kinds = [options.kind] if options.kind else list(FAULTS)
    text, good = counted(replies(options.replies), kinds, options.seeds, verbose=options.verbose)
    print(text)
    return int(not good)


def counted(
    used: Sequence[Reply], kinds: Sequence[str] = tuple(FAULTS), seeds: int = 1, *, verbose: bool = False
) -> tuple[str, bool]:
    """The table, and whether nothing passed that may not; what did is shown on stderr."""
    counts: dict[str, Counter[str]] = {k: Counter() for k in kinds}
    codes: dict[str, Counter[str]] = {k: Counter() for k in counts}
    for reply in used:
        for kind, count in counts.items():
            for seed in range(seeds):
                faulty = inject(reply, kind, seed)
                if faulty is None:
                    continue
                found = verdict_of(reply, kind, faulty)
                count[found.what] += 1
                if found.what == "caught":
                    codes[kind][found.told] += 1
                if verbose or (kind in MUST and found.what == "passes"):
                    print(f"{reply.name}, {kind}: {found.what}\n{faulty}\n  -> {found.told}\n", file=sys.stderr)
    return table(len(used), seeds, counts, codes), not any(counts[k]["passes"] for k in MUST if k in counts)


def table(n: int, seeds: int, counts: dict[str, Counter[str]], codes: dict[str, Counter[str]]) -> str:
    """Markdown: a row for each kind of fault."""
    rows = ["| fault | faults | caught | harmless | pass | caught by |", "|---|---|---|---|---|---|"]
    for kind, found in counts.items():
        by = ", ".join(f"{c} {m}" for c, m in codes[kind].most_common(5))
        star = "" if kind in MUST else " *"
        rows.append(
            f"| {kind}{star} | {found.total()} | {found['caught']} | {found['harmless']} | {found['passes']} | {by} |"
        )
    told = (
        f"Faults of each kind in each of {n} authored replies that compile, wherever the kind applies: {seeds}. "
        "No model was asked.\n\n"
        "Caught: no tree, and a reason. Harmless: the goals of the whole reply. Pass: other goals.\n"
        "* Nobody can catch these who has not read the request: what is left is a reply that says something else."
    )
    return "\n".join([told, "", *rows])


if __name__ == "__main__":
    raise SystemExit(main())
