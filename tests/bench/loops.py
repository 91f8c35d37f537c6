"""What a whole tick of `llmbt execute` costs against a world of facts: the loop, the world, the engine."""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from llmbt.history import read_run
from llmbt.replay import domain_of_run
from llmbt_atl.library import load_library
from llmbt_atl.state import Domain
from llmbt_ir.condition import Condition, Goals
from llmbt_runtime.engine import incremental, ticker
from llmbt_runtime.engine.drive import drive
from llmbt_runtime.engine.program import program_of_tree
from llmbt_runtime.engine.values import Values
from llmbt_runtime.executor import Settings, execute
from llmbt_runtime.symbolic import SymbolicWorld
from llmbt_runtime.world import ActionReport
from tests.bench.engines import Situation

FOR_EVER = 10**9
LIBRARY = """<library name="bench"><types><type name="thing"/></types><conditions>
<condition name="On" goal="true"><param name="target" type="thing"/><param name="place" type="thing"/></condition>
<condition name="Holding"><param name="target" type="thing"/></condition>
<condition name="Free"><param name="place" type="thing"/></condition></conditions>
<templates><template name="place"><param name="target" type="thing"/><param name="place" type="thing"/>
<hold><Holding target="{target}"/><Free place="{place}"/></hold><post><On target="{target}" place="{place}"/></post>
</template></templates></library>"""


class Flipping(SymbolicWorld):
    """A world of facts with a fact that comes and goes, and a meter that hears of each tick."""

    def watch(self, flip: Condition | None, meter: Iterator[None]) -> None:
        """Before the first tick."""
        self.flip, self.meter = flip, meter

    def advance(self) -> ActionReport:
        """One tick."""
        next(self.meter)
        report = super().advance()
        if self.flip is not None:
            (self._state.remove if self.flip in self._state else self._state.add)(self.flip)
        return report


def _metered(found: dict[str, float], count: Callable[[], int]) -> Iterator[None]:
    """Measures the time between ticks as `measured` does, then interrupts."""
    for _ in range(4):
        yield
    start = time.process_time()
    yield
    yield
    rounds = max(2, min(20_000, round(0.08 / max(1e-7, time.process_time() - start)))) * 2
    before, best = count(), float("inf")
    for _ in range(5):
        start = time.process_time()
        for _ in range(rounds):
            yield
        best = min(best, time.process_time() - start)
    found |= {"us": 1e6 * best / rounds, "evaluations": (count() - before) / (5 * rounds)}
    raise KeyboardInterrupt


def in_a_world(given: Situation, run: str | None, *, update: bool) -> dict[str, float]:
    """Microseconds and evaluations of a whole tick of the executor against a world of facts."""
    domain, goals = _of_run(given, Path(run)) if run else _of_goals(given)
    engines: list[Values] = []

    class Counted(Values):
        def __init__(self, *arguments: Any) -> None:
            engines.append(self)
            super().__init__(*arguments)

    world = Flipping(domain, given.facts, np.random.default_rng(0), ticks=(FOR_EVER, FOR_EVER))
    found: dict[str, float] = {}
    world.watch(given.flip, _metered(found, lambda: sum(v.evaluations for v in engines)))
    with patch.object(ticker, "Values", Counted), patch.object(incremental, "Values", Counted):
        if update:
            settings = Settings(max_ticks=FOR_EVER)
            execute(world, domain, given.tree, goals, keep=_no_version, settings=settings)
        else:
            drive(world, domain, program_of_tree(given.tree), (), max_ticks=FOR_EVER)
    return found


def _of_goals(given: Situation) -> tuple[Domain, Goals]:
    """The domain in which a tree of goals is at home, and the goals."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "bench.xml").write_text(LIBRARY)
        library = load_library(str(Path(folder, "bench.xml")))
    asked = [c for n in given.tree.preorder() if (c := n.condition) is not None]
    return Domain(library, {}).for_state(frozenset(asked)), (tuple(c for c in asked if c.name == "On"),)


def _of_run(given: Situation, run: Path) -> tuple[Domain, Goals]:
    """The domain of a run, and its goals."""
    domain = domain_of_run(read_run(run))
    assert domain is not None
    told = json.loads((run / "result.json").read_text())["goals"]
    return domain.for_state(given.facts), (tuple(Condition(g["name"], tuple(g["args"])) for g in told),)


class GrowsError(Exception):
    """The tree does not serve."""


def _no_version(_: object) -> str:
    raise GrowsError
