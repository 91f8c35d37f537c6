"""The statistics against their closed forms and against scipy."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from llmbt.experiment.statistics import bootstrap_by_group, holm, mcnemar, median_time, wilson

COUNTS = st.integers(1, 400).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n)))


class TestWilson:
    def test_the_design_note_s_intervals_of_the_paper_s_sums(self):
        assert [round(100 * x) for x in wilson(87, 100)] == [79, 92]
        assert [round(100 * x) for x in wilson(77, 100)] == [68, 84]

    def test_nothing_tried_says_nothing(self):
        assert wilson(0, 0) == (0.0, 1.0)

    @given(COUNTS)
    def test_it_holds_the_rate_and_mirrors(self, counts):
        good, n = counts
        low, high = wilson(good, n)
        assert 0 <= low <= good / n <= high <= 1
        other = wilson(n - good, n)
        assert math.isclose(low, 1 - other[1], abs_tol=1e-9)

    @given(COUNTS)
    def test_as_scipy(self, counts):
        theirs = stats.binomtest(*counts).proportion_ci(method="wilson")
        assert wilson(*counts) == pytest.approx((theirs.low, theirs.high), abs=1e-9)


class TestMcNemar:
    def test_by_hand(self):
        assert mcnemar(0, 0) == 1.0
        assert mcnemar(0, 5) == 2 / 32
        assert mcnemar(1, 5) == 2 * 7 / 64
        assert mcnemar(3, 3) == 1.0

    @given(st.integers(0, 60), st.integers(0, 60))
    def test_as_scipy(self, b, c):
        if b + c:
            assert mcnemar(b, c) == pytest.approx(stats.binomtest(b, b + c, 0.5).pvalue, rel=1e-9)


class TestHolm:
    def test_by_hand(self):
        assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx((0.03, 0.06, 0.06, 0.02))
        assert holm([]) == ()

    @given(st.lists(st.floats(0, 1), min_size=1, max_size=12))
    def test_it_never_lowers_a_p_and_keeps_their_order(self, ps):
        adjusted = holm(ps)
        assert all(a >= p - 1e-12 for a, p in zip(adjusted, ps, strict=True))
        pairs = sorted(zip(ps, adjusted, strict=True))
        assert [a for _, a in pairs] == sorted(a for _, a in pairs)


class TestMedianTime:
    def test_without_censoring_it_is_the_median(self):
        assert median_time([1, 2, 3], []) == 2

    def test_by_hand_with_censoring(self):
        # at 1: 4 of 5 left; at 3: 3 at risk, 4/5 x 2/3 = 0.53; at 5: 1 at risk, 0
        assert median_time([1, 3, 5], [2, 4]) == 5

    def test_half_never_ended(self):
        assert median_time([1], [9, 9]) is None
        assert median_time([], []) is None


class TestBootstrap:
    def test_groups_all_alike_leave_no_doubt(self):
        assert bootstrap_by_group({"a": [True] * 4, "b": [True] * 4}, seed=0) == (1.0, 1.0)

    def test_groups_that_differ_are_as_wide_as_the_groups(self):
        assert bootstrap_by_group({"a": [True] * 50, "b": [False] * 50}, seed=0) == (0.0, 1.0)

    def test_it_repeats(self):
        groups = {"a": [True, False], "b": [True, True], "c": [False, False]}
        assert bootstrap_by_group(groups, seed=3) == bootstrap_by_group(groups, seed=3)
