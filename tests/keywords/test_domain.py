"""A library's verbs and types in training, and the worked example of docs/keywords.md."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from llmbt_atl.library import load_library
from llmbt_compiler.keywords.domain import domain_words
from llmbt_compiler.keywords.evaluate import evaluate_file, read_examples
from llmbt_compiler.keywords.grammar import parse_markup
from llmbt_compiler.keywords.labels import Kind
from llmbt_compiler.keywords.tagger import MODEL, OnnxTagger, load_tagger

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"


def test_verbs_go_where_verbs_of_their_kind_stand() -> None:
    words = domain_words(load_library(str(EXAMPLES / "lab_bench.xml")))
    assert words["v_pick"] == ("[A pick]", "[A take]", "[A grip]", "[A uncradle]")
    assert set(words["v_place"]) >= {"[A nest]", "[A seat]", "[A cradle]"}
    assert words["v_act"] == ("[A decap]", "[A uncap]", "[A vortex]", "[A swirl]")
    assert words["noun_real"] == ("vial",)
    assert words["place_real"] == ("nest", "thermoshaker")


def test_the_action_is_the_head_verb_only() -> None:
    marked = domain_words(load_library("cargo_sorting"))["v_place"]
    assert "[A put] down" in marked
    assert all(next(s.kind for s in parse_markup(m)) is Kind.ACTION for m in marked)


@pytest.mark.slow
def test_a_domain_of_ones_own(tmp_path: Path) -> None:
    """`llmbt keywords train --library lab_bench.xml --extra lab_bench.jsonl`, at a quarter of its size."""
    from llmbt_compiler.keywords.train import DOMAIN, train

    dev = EXAMPLES / "lab_bench.dev.jsonl"
    before = evaluate_file(dev, load_tagger())
    train(
        tmp_path / "lab",
        replace(DOMAIN, samples=500, held_out=20),
        extra=read_examples(EXAMPLES / "lab_bench.jsonl"),
        words=domain_words(load_library(str(EXAMPLES / "lab_bench.xml"))),
        start_from=MODEL,
    )
    after = evaluate_file(dev, OnnxTagger(tmp_path / "lab"))
    assert before.whole_step_accuracy < 0.8
    assert after.whole_step_accuracy > 0.9
    assert load_tagger(str(tmp_path / "lab")).tag(["Decap vial 3."])[0].spans[0].text == "Decap"
