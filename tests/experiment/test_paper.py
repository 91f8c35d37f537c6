"""The paper's way of counting, and everything counted, from lines made up for it."""

from __future__ import annotations

import pytest

from llmbt.experiment.cases import load_experiment
from llmbt.experiment.paper import counts, paper_tables
from llmbt.experiment.trial import Verdict

CARGO = load_experiment("cargo_sorting")
CASE = CARGO.cases[0].name
EXECUTED = {Verdict.SUCCESS, Verdict.UPDATE, Verdict.ACTION, Verdict.RECOGNITION, Verdict.TRUTH}


def line(number: int, verdict: Verdict, kind: str = "clear", **more) -> dict:
    found = {
        "key": str(number), "experiment": CARGO.name, "case": CASE, "request": f"{number:02}", "repeat": 0, "seed": 7,
        "world": "bullet", "perception": "truth", "scenes": "nominal", "kind": kind, "reply": "authored",
        "verdict": verdict.value,
    }  # fmt: skip
    if verdict in EXECUTED | {Verdict.PARSER}:
        found |= {
            "goals_right": verdict in EXECUTED, "drawn": ["drop"], "updates": 2, "actions": 5, "planner_calls": 0,
            "sim_time_s": 40.0,
            "disturbances": [{"name": "drop", "fired_at_s": 10.0, "recovered_at_s": 14.0 if number % 2 else None}],
        }  # fmt: skip
    return found | more


def rows(lines, name: str) -> dict[str, tuple[str, ...]]:
    tables = {t.name: t for t in paper_tables(CARGO, lines, 0)}
    return {r[0]: r[1:] for r in tables[name].rows}


LINES = (
    [line(k, Verdict.SUCCESS) for k in range(9)]
    + [line(9, Verdict.ACTION), line(10, Verdict.RECOGNITION), line(11, Verdict.UPDATE), line(12, Verdict.PARSER)]
    + [line(13, Verdict.REFUSED, says="x"), line(14, Verdict.ASKED, by="check")]
    + [line(k, Verdict.ASKED, "unclear", by="reply") for k in (15, 16)]
    + [line(17, Verdict.REFUSED, "unclear"), line(18, Verdict.ASKED, "unclear", by="check")]
    + [line(19, Verdict.SUCCESS, "unclear")]
)
"""Twenty requests as a case has them."""


def test_as_the_paper_counts_failures_of_actions_and_recognition_are_left_out():
    overall, reasoning, parser, update, asked, refused, left_out, *theirs = rows(LINES, "cargo_sorting_as_the_paper")[
        f"1 {CASE}"
    ]
    assert overall.startswith("9/18 ")  # the lucky guess at an unclear request is none of them
    assert reasoning == "authored"
    assert parser.startswith("12/15 ")
    assert update.startswith("9/10 ")
    assert (asked, refused, left_out) == ("4", "2", "2")
    assert theirs == ["18/20", "18/20", "18/18", "18/18"]


def test_everything_counted_leaves_nothing_out():
    success, _, *others = rows(LINES, "cargo_sorting_everything")[f"1 {CASE}"]
    assert success.startswith("9/15 ")
    assert others == ["1", "1", "1", "1", "1", "1", "0", "0"]


def test_unclear_requests_are_asked_about_or_refused_and_acting_is_told():
    assert rows(LINES, "cargo_sorting_unclear")[CASE][0].startswith("4/5 ")
    assert rows(LINES, "cargo_sorting_unclear")[CASE][1:] == ("2", "1", "1", "1")


def test_recovery_is_censored_where_a_run_ended_first():
    assert rows(LINES, "by_disturbance")["drop"][1:4] == ("12/12", "4.0", "6")


def test_with_recorded_replies_the_reasoning_column_has_figures_and_the_title_says_so():
    recorded = [x | {"reply": "recorded"} for x in LINES]
    table = paper_tables(CARGO, recorded, 0)[0]
    assert "given recorded replies" in table.title
    assert table.rows[0][2] == "12/20"


def test_only_the_first_seed_is_the_paper_s_table_and_all_are_everything():
    more = [x | {"repeat": 1, "key": x["key"] + "r"} for x in LINES if x["kind"] == "clear"]
    assert rows([*LINES, *more], "cargo_sorting_as_the_paper")[f"1 {CASE}"][0].startswith("9/18 ")
    assert rows([*LINES, *more], "cargo_sorting_everything")["all"][0].startswith("18/30 ")


def test_the_factorial_has_a_line_for_each_setting_and_says_why_trials_failed():
    wrong = line(0, Verdict.RECOGNITION)
    camera = [x | {"perception": "camera"} for x in (wrong, *LINES[1:])]
    tables = {t.name: t for t in paper_tables(CARGO, [*[x | {"world": "symbolic"} for x in LINES], *LINES, *camera], 0)}
    found = {r[:3]: r[3:] for r in tables["factorial"].rows}
    assert len(found) == 8
    assert found["bullet", "truth", "nominal"][0].startswith("9/15 ")
    assert found["bullet", "camera", "nominal"][0].startswith("8/15 ")
    assert "2 recognition" in found["bullet", "camera", "nominal"][1]
    assert found["symbolic", "truth", "varied"] == ("not run", "–")
    # The other tables are those of physics by the truth, whatever was run last.
    assert tables["cargo_sorting_everything"].rows[0][1].startswith("9/15 ")


def test_every_failure_is_told_with_what_it_says():
    found = rows(LINES, "failures")
    assert set(found) == {str(k) for k in range(9, 15)}
    assert found["13"] == ("–", "refused", "–", "x")
    assert found["11"][:2] == ("drop", "update")


def test_what_is_to_be_read_with_the_rates_stands_below_them():
    tables = {t.name: t for t in paper_tables(CARGO, LINES, 0)}
    assert any("Errata" in n for n in tables["cargo_sorting_everything"].notes)


def test_household_footnotes_are_found_by_adding():
    household = load_experiment("household")
    lines = [x | {"experiment": "household", "case": household.cases[0].name} for x in LINES]
    notes = " ".join(paper_tables(household, lines, 0)[0].notes)
    assert "case 1: 16 right trees, but 15 of them executed" in notes
    assert "77 of 100" in notes


@pytest.mark.parametrize("verdict", Verdict)
def test_every_verdict_is_counted_once(verdict):
    assert counts(CARGO, [line(0, verdict)])[CASE]["clear"] == {verdict.value: 1}
