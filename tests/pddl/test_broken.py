"""Texts with a few words lost, doubled, exchanged or misspelt: each ends as a diagnostic, or as a problem that ends."""

from __future__ import annotations

import random
import re
from collections import Counter
from pathlib import Path

import pytest

from llmbt.progress import Progress
from llmbt.solving import read_problem, solve_problem
from llmbt_ir.diagnostics import LlmbtError
from tests.pddl.awkward import AWKWARD
from tests.pddl.domains import CLASSICS
from tests.pddl.flavours import FLAVOURS
from tests.pddl.generated import generated

TEXTS = [*AWKWARD.values(), *CLASSICS.values(), *((d, p) for d, p, _ in FLAVOURS.values())]
WORDS = ("(", ")", "-", "?x", "and", "not", "or", "=", "()", "either", "object", ":typing", "(and)", ".", "(not (p))",
         "forall", "when", ";", "{", "*", "?")  # fmt: skip


def broken(seed: int) -> tuple[str, str]:
    """A domain and a problem with one to three faults."""
    rng = random.Random(seed)
    texts = list(rng.choice(TEXTS) if rng.random() < 0.6 else generated(seed))
    for _ in range(rng.choice([1, 1, 2, 3])):
        i = rng.randrange(2)
        words = re.findall(r"\s+|[()]|[^\s()]+", texts[i])
        at, other = rng.sample([k for k, w in enumerate(words) if not w.isspace()], 2)
        match rng.randrange(6):
            case 0:
                del words[at]
            case 1:
                words.insert(at, words[other])
            case 2:
                words[at], words[other] = words[other], words[at]
            case 3:
                words[at] = words[other]
            case 4:
                words[at] = rng.choice(WORDS)
            case _:
                words[at] += rng.choice("x-?:é")
        texts[i] = "".join(words)
    return texts[0], texts[1]


@pytest.mark.parametrize("block", range(2))
def test_whatever_is_wrong_is_said_with_its_place(block: int, tmp_path: Path) -> None:
    said: Counter[str] = Counter()
    for seed in range(300 * block, 300 * block + 300):
        try:
            stated = read_problem(broken(seed), ("d.pddl", "p.pddl"))
            document = solve_problem(
                stated, tmp_path / str(seed), Progress(quiet=True), seed=0, budget=500, failure_rate=0.0
            )
            said[document["outcome"]] += 1
        except LlmbtError as fault:
            (found,) = fault.diagnostics
            assert found.span is not None and found.span.source in ("d.pddl", "p.pddl") and found.span.line > 0, seed
            said[found.code] += 1
    assert set(said) <= {"SUCCESS", "UNSOLVABLE", "BUDGET", *(f"E09{n}" for n in range(7))}
    assert said["E090"] > 50 and said["E093"] > 20 and said["SUCCESS"] > 2
