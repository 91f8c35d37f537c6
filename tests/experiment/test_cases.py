"""Cases as files: what the shipped ones hold, and what a faulty one is told."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from llmbt.experiment.cases import cassette_of, experiment_names, load_experiment, read_case, read_experiment
from llmbt_compiler.reasoning.cassette import read_cassette
from llmbt_compiler.reasoning.chat import Replay, Settings, ask
from llmbt_compiler.reasoning.prompt import build_prompt
from llmbt_ir.condition import Condition
from llmbt_ir.diagnostics import LlmbtError
from llmbt_ir.scene import to_semantic_map
from llmbt_runtime.initial import facts_of_map

REGISTERS = {"terse", "wordy", "polite", "slips", "indirect", "formal", "spoken"}
SHIPPED = [(name, case) for name in experiment_names() for case in load_experiment(name).cases]


@pytest.mark.parametrize("name", experiment_names())
def test_an_experiment_has_five_cases_beside_five_reported_rows(name):
    experiment = load_experiment(name)
    assert len(experiment.cases) == 5
    assert experiment.reported is not None
    assert len(experiment.reported.rows) == 5


@pytest.mark.parametrize(("name", "case"), SHIPPED, ids=[c.name for _, c in SHIPPED])
class TestShipped:
    def test_twenty_requests_of_which_five_are_marked_unclear(self, name, case):
        assert [r.id for r in case.requests] == [f"{k:02}" for k in range(1, 21)]
        assert sum(not r.clear for r in case.requests) == 5
        registers = Counter(r.register for r in case.requests if r.clear)
        assert set(registers) == REGISTERS
        assert min(registers.values()) >= 2
        assert len({r.text for r in case.requests}) == 20

    def test_success_is_not_there_from_the_start(self, name, case):
        facts = facts_of_map(case.domain(), to_semantic_map(case.scene))
        assert not any(all(c in facts for c in alternative) for alternative in case.success)

    def test_every_request_is_answered_by_its_own_recording_marked_authored(self, name, case):
        for request in case.requests:
            path = cassette_of(case, request)
            assert read_cassette(path).provenance.authored
            prompt = build_prompt(request.text, to_semantic_map(case.scene), case.library)
            reply = ask(prompt.messages, Settings(), Replay(path))
            assert reply.text == request.reply


def test_the_paper_s_figures_add_up_to_what_the_design_note_says():
    rows = load_experiment("cargo_sorting").reported.rows
    sums = [(sum(r[k][0] for r in rows), sum(r[k][1] for r in rows)) for k in range(4)]
    assert sums == [(87, 100), (90, 100), (88, 90), (87, 88)]


CASE = """<Case name="one" experiment="mine" scene="cargo_sorting" date="2026-01-01">
  <Description>One.</Description>
  <Success><All><On target="object_1" place="shelf_level_1"/></All></Success>
  <Requests>
    <Request id="01" kind="clear" register="terse"><Text>Do it.</Text><Reply>1. Do it.</Reply></Request>
  </Requests>
</Case>
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "one.xml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_case_is_read(tmp_path):
    case = read_case(written(tmp_path, CASE))
    assert case.success == ((Condition("On", ("object_1", "shelf_level_1")),),)
    assert case.requests[0].clear
    assert cassette_of(case, case.requests[0]) == tmp_path / "llm_cassettes/mine/one/01.yaml"


@pytest.mark.parametrize(
    ("old", "new", "code", "line", "says"),
    [
        ('register="terse"', 'register="rude"', "E006", 5, "register"),
        ('kind="clear"', 'kind="unclear"', "E006", 5, "Request"),
        ("object_1", "object_7", "E402", 3, "no movable `object_7`"),
        ("shelf_level_1", "shelf_level_9", "E402", 3, "shelf_level_1"),
        ("<On ", "<Upon ", "E402", 3, "On"),
        ('place="', 'plaice="', "E402", 3, "place"),
        ("<Text>Do it.</Text>", "<Text> </Text>", "E401", 5, "says nothing"),
        ("</Requests>", '<Request id="01" kind="clear" register="terse"><Text>x</Text></Request></Requests>', "E401", 6,
         "twice"),
        ('scene="cargo_sorting"', 'scene="cargo_sortin"', "E040", 0, "cargo_sorting"),
        ("</Case>", "", "E003", 8, ""),
    ],
)  # fmt: skip
def test_a_faulty_case_is_told_with_its_line(tmp_path, old, new, code, line, says):
    with pytest.raises(LlmbtError) as caught:
        read_case(written(tmp_path, CASE.replace(old, new, 1)))
    (first, *_) = caught.value.diagnostics
    assert first.code == code
    assert (first.span.line if first.span else 0) == line
    assert says in f"{first.title} {first.help} {first.span}"


def test_a_case_of_another_experiment_is_refused(tmp_path):
    written(tmp_path, CASE)
    listed = '<Experiment name="{}" title="t"><Cases><Case file="one.xml"/>{}</Cases></Experiment>'
    for text, says in (
        (listed.format("other", ""), "belongs"),
        (listed.format("mine", '<Case file="one.xml"/>'), "twice"),
    ):
        (tmp_path / "all.xml").write_text(text)
        with pytest.raises(LlmbtError, match=f"E401.*{says}"):
            read_experiment(tmp_path / "all.xml")
    with pytest.raises(LlmbtError, match="E403"):
        load_experiment("cargo_sort")
