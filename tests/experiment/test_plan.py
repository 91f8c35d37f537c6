"""What is to be run is settled before anything is run."""

from __future__ import annotations

import pytest

from llmbt.experiment.cases import load_experiment
from llmbt.experiment.plan import Setting, factorial, plan, sample, setting_of, trial_seed
from llmbt.experiment.trial import means
from llmbt_ir.condition import parse_condition

CARGO = load_experiment("cargo_sorting")


def test_the_paper_like_plan_is_every_request_once():
    trials = plan(CARGO, seed=0, repeat=1)
    assert len(trials) == len({t.key for t in trials}) == len({t.seed for t in trials}) == 100


def test_six_seeds_of_each_clear_request_are_450_trials():
    trials = plan(CARGO, seed=0, repeat=6)
    clear = {(c.name, r.id) for c in CARGO.cases for r in c.requests if r.clear}
    assert sum((t.case, t.request) in clear for t in trials) == 450
    assert len(trials) == 475
    assert set(plan(CARGO, seed=0, repeat=1)) <= set(trials)


def test_a_trial_has_one_seed_under_all_settings_and_another_in_another_experiment():
    trials = plan(CARGO, seed=0, repeat=1, settings=(Setting("symbolic"), Setting("bullet")))
    assert len({t.key for t in trials}) == 200
    assert len({t.seed for t in trials}) == 100
    assert {t.seed for t in plan(CARGO, seed=1, repeat=1)}.isdisjoint({t.seed for t in trials})
    assert trial_seed(0, "cargo_sorting", "sort_by_colour", "01", 0) == trials[0].seed == 246597418


def test_a_sample_is_part_of_the_plan_in_its_order_and_repeats():
    trials = plan(CARGO, seed=0, repeat=2)
    some = sample(trials, 30, 5)
    assert len(some) == 30
    assert [t for t in trials if t in some] == list(some)
    assert some == sample(trials, 30, 5) != sample(trials, 30, 6)
    assert sample(trials, 10_000, 5) == trials


def test_the_factorial_has_eight_cells_and_lines_know_theirs():
    settings = list(factorial())
    assert len(set(settings)) == 8
    (trial,) = plan(CARGO, seed=0, repeat=1, settings=settings[3:4])[:1]
    assert setting_of(trial.as_json()) == settings[3]


class TestMeans:
    case = CARGO.cases[0]
    right = (
        "On(object_1, position_11)", "On(object_2, shelf_level_1)", "On(object_4, position_14)",
        "On(object_3, position_21)", "On(object_5, position_24)", "On(object_6, position_33)",
    )  # fmt: skip

    def says(self, *texts: str) -> bool:
        goals = [parse_condition(t) for t in texts]
        return means([g for g in goals if g is not None], self.case.success, self.case.domain())

    def test_positions_of_the_right_levels(self):
        assert self.says(*self.right)

    @pytest.mark.parametrize("gone", range(6))
    def test_one_missing(self, gone):
        assert not self.says(*(t for k, t in enumerate(self.right) if k != gone))

    @pytest.mark.parametrize(
        "more", ["On(object_1, sorting_area)", "Holding(object_1)", "HandEmpty", "not On(object_1, position_21)"]
    )
    def test_one_too_many(self, more):
        assert not self.says(*self.right, more)

    def test_less_than_is_asked_for(self):
        assert not self.says("On(object_1, shelf)", *self.right[1:])

    def test_another_level(self):
        assert not self.says("On(object_1, position_21)", *self.right[1:])
