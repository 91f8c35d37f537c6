"""Faults in replies that may never pass: a small sample of what `python -m tests.requests.faults` counts."""

from __future__ import annotations

import pytest

from tests.requests.faults import FAULTS, MUST, inject, replies, verdict_of

REPLIES = replies(12)


@pytest.mark.slow
@pytest.mark.parametrize("kind", MUST)
def test_these_are_caught_or_harmless(kind):
    seen = 0
    for reply in REPLIES:
        for seed in range(3):
            faulty = inject(reply, kind, seed)
            if faulty is not None:
                seen += 1
                assert verdict_of(reply, kind, faulty).what != "passes", (reply.name, faulty)
    assert seen > 4


def test_the_same_seed_gives_the_same_fault():
    for kind in FAULTS:
        assert inject(REPLIES[0], kind, 3) == inject(REPLIES[0], kind, 3)


@pytest.mark.parametrize(("name", "what"), [("c02", "caught"), ("c11", "passes")])
def test_a_step_that_is_dropped_is_caught_where_the_request_names_what_is_left(name, what):
    """Of "both yellow blocks" the reply places one; of "everything on it" nobody counts what is left."""
    reply = next(r for r in REPLIES if r.name == name)
    faulty = inject(reply, "a step dropped", 0)
    assert faulty is not None
    assert verdict_of(reply, "a step dropped", faulty).what == what
