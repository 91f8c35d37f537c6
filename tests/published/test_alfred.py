"""The rules of scoring, on made-up sentences: no text of ALFRED is here."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from llmbt_compiler.keywords.tagger import Tagger, load_tagger
from tests.published.alfred import Sentence, Standing, read_sentences, standing, words_of


@pytest.fixture(scope="module")
def tagger() -> Tagger:
    return load_tagger()


def test_sentences_are_paired_with_actions(tmp_path: Path) -> None:
    plan = [
        {"discrete_action": {"action": "GotoLocation", "args": ["sidetable"]}, "planner_action": {}},
        {"discrete_action": {"action": "PickupObject", "args": ["alarmclock"]}, "planner_action": {}},
        {"discrete_action": {"action": "NoOp", "args": []}, "planner_action": {}},
    ]
    told = [{"high_descs": ["Walk to the nightstand.", "Take  the clock."]}, {"high_descs": ["Take the clock."]}]
    (tmp_path / "a").mkdir()
    record = {"plan": {"high_pddl": plan}, "turk_annotations": {"anns": told}}
    (tmp_path / "a" / "traj_data.json").write_text(json.dumps(record))
    assert list(read_sentences(tmp_path)) == [
        Sentence("Walk to the nightstand.", "GotoLocation", "", "SideTable"),
        Sentence("Take the clock.", "PickupObject", "AlarmClock"),
    ]


def test_words_of_a_class() -> None:
    assert {"clock", "alarmclock"} <= words_of("AlarmClock")
    assert "couch" in words_of("Sofa")


@pytest.mark.parametrize(
    ("sentence", "expected"),
    [
        (Sentence("Take the mug from the counter.", "PickupObject", "Mug"), Standing.FOUND),
        (Sentence("Pick it up.", "PickupObject", "Mug"), Standing.NOT_NAMED),
        (Sentence("Rinse the mug.", "PickupObject", "Mug"), Standing.OTHER_ACTION),
        (Sentence("Put the mug in the fridge.", "PutObject", "Mug", "Fridge"), Standing.FOUND),
        (Sentence("Put the mug down.", "PutObject", "Mug", "Fridge"), Standing.NOT_NAMED),
        (Sentence("Put the mug in the bowl on the shelf.", "PutObject", "Mug", "Shelf"), Standing.ELSEWHERE),
        (Sentence("Walk to the sofa.", "GotoLocation", "", "Sofa"), Standing.FOUND),
    ],
)
def test_standing(sentence: Sentence, expected: Standing, tagger: Tagger) -> None:
    (tagged,) = tagger.tag([sentence.text])
    assert standing(sentence, tagged) is expected


def test_a_keyword_with_another_thing_is_a_miss(tagger: Tagger) -> None:
    sentence = Sentence("Take the mug from the counter.", "PickupObject", "Mug")
    (other,) = tagger.tag(["Take the counter."])
    assert standing(sentence, other) is Standing.MISSED
