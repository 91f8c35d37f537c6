"""The two stages of the shipped weights, and the natural steps of the second."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from llmbt_compiler.keywords.evaluate import Example, read_examples
from llmbt_compiler.keywords.grammar import DATA
from llmbt_compiler.keywords.tagger import MODEL, OnnxTagger, load_tagger

KEYWORDS = Path(__file__).parents[2] / "fixtures" / "keywords"


def natural() -> tuple[Example, ...]:
    """Reading them holds each span to whole words of its text, and to the four labels."""
    return read_examples(DATA / "natural.jsonl")


def test_the_natural_steps_are_steps_each_said_once() -> None:
    steps = natural()
    assert len(steps) == 1510
    assert all(e.text and e.text == e.text.strip() for e in steps)
    said = Counter(" ".join(e.text.lower().split()) for e in steps)
    assert not [text for text, times in said.items() if times > 1]


def test_spans_of_a_natural_step_do_not_overlap() -> None:
    for e in natural():
        ends = [0, *(s.end for s in e.spans)]
        assert all(end <= s.start < s.end <= len(e.text) for end, s in zip(ends, e.spans, strict=False)), e.text


def test_no_natural_step_is_a_blind_one() -> None:
    """How many, not which: nobody reads the blind steps, not even where this fails."""
    shared = len({e.text for e in natural()} & {e.text for e in read_examples(KEYWORDS / "blind.jsonl")})
    assert shared == 0


def test_one_natural_step_is_a_development_step() -> None:
    """Seen after the training: the weights have been trained on it, so that the file tells it, and docs/keywords.md."""
    assert {e.text for e in natural()} & {e.text for e in read_examples(KEYWORDS / "dev.jsonl")} == {"Put it back."}


def test_the_shipped_weights_are_those_of_the_second_stage() -> None:
    from dataclasses import asdict

    from llmbt_compiler.keywords.stages import NATURAL
    from llmbt_compiler.keywords.weights import read_weights

    assert json.loads(read_weights(MODEL / "weights.safetensors").about["settings"]) == asdict(NATURAL)


@pytest.mark.slow
def test_two_stages_are_one_training_after_the_other(tmp_path: Path, dev: tuple[Example, ...]) -> None:
    """Interrupted in the second: the first is not trained again."""
    from llmbt_compiler.keywords.stages import GRAMMAR, NATURAL, train_in_stages
    from llmbt_compiler.keywords.train import Progress, Trained, train

    small = {"seed": 1, "samples": 16, "batch": 8, "learning_rate": 1e-5, "held_out": 10}
    first, second = replace(GRAMMAR, epochs=1, **small), replace(NATURAL, epochs=2, **small)
    steps = natural()[:2]
    one, two, both = tmp_path / "one", tmp_path / "two", tmp_path / "both"
    train(one, first, start_from=MODEL)
    after = train(two, second, extra=steps, start_from=one)

    class StopHereError(Exception):
        pass

    seen: list[Progress] = []

    def run(stop_at: int) -> Trained:
        def watch(p: Progress) -> None:
            seen.append(p)
            if p.stage == "natural" and p.epoch == stop_at:
                raise StopHereError

        return train_in_stages(both, first, second, natural=steps, start_from=MODEL, progress=watch)

    with pytest.raises(StopHereError):
        run(stop_at=1)
    assert list(dict.fromkeys((p.stage, p.epoch) for p in seen)) == [("grammar", 0), ("natural", 0), ("natural", 1)]
    assert (both / "grammar" / "weights.safetensors").read_bytes() == (one / "weights.safetensors").read_bytes()
    seen.clear()
    assert run(stop_at=-1).losses == pytest.approx(after.losses, rel=1e-4)
    assert {(p.stage, p.epoch) for p in seen} == {("natural", 1)}
    assert seen[-1].done == seen[-1].total

    assert {f.name for f in both.iterdir()} == {"weights.safetensors", "vocab.txt", "training.json", "grammar.json"}
    assert json.loads((both / "grammar.json").read_text())["extra"] == 0
    assert json.loads((both / "training.json").read_text())["extra"] == 2
    texts = [e.text for e in dev]
    apart, together = ([[w.label for w in s.words] for s in OnnxTagger(folder).tag(texts)] for folder in (two, both))
    assert apart == together


@pytest.mark.parametrize(
    ("text", "spans"),
    [
        ("Move to the shelf.", [("Action", "Move"), ("Destination", "shelf")]),
        ("Reach for the red cup.", [("Action", "Reach"), ("Target", "red cup")]),
    ],
)
def test_what_was_settled_for_the_natural_steps(text: str, spans: list[tuple[str, str]]) -> None:
    (step,) = load_tagger().tag([text])
    assert [(s.label.value, s.text) for s in step.spans] == spans
