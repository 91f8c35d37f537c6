"""The open part stays decided as it is; the blind part is counted by `python -m tests.requests` alone."""

from __future__ import annotations

import pytest

from tests.requests.cases import read_open
from tests.requests.decide import judge

OPEN = read_open()


def test_there_are_enough_of_each_kind():
    kinds = [c.kind for c in OPEN]
    assert len(OPEN) >= 40
    assert min(kinds.count(k) for k in ("complete", "ambiguous", "impossible")) >= 12
    assert len({c.scene for c in OPEN}) >= 4


@pytest.mark.parametrize("case", OPEN, ids=lambda c: c.id)
def test_a_request_is_decided_rightly(case, tmp_path):
    judged = judge(case, tmp_path)
    assert judged.right, f"{judged.wrong}: {judged.first}; {judged.then}"
