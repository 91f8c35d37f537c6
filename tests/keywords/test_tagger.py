"""The shipped tagger: steps that must come out right, the fast path against the reference, hostile texts."""

from __future__ import annotations

import os
import subprocess
import sys
from itertools import islice
from pathlib import Path

import pytest

from llmbt_compiler.keywords.evaluate import Example, evaluate, read_examples
from llmbt_compiler.keywords.generate import generate
from llmbt_compiler.keywords.grammar import DATA, Grammar, parse_markup
from llmbt_compiler.keywords.labels import TaggedStep, follows
from llmbt_compiler.keywords.tagger import OnnxTagger, TorchTagger, UnknownTaggerError, load_tagger, tagger_names

CANONICAL = (Path(__file__).parent / "golden" / "canonical.txt").read_text("utf-8").splitlines()


def marked(step: TaggedStep) -> str:
    out, at = "", 0
    for s in step.spans:
        out += step.text[at : s.start] + f"[{s.label[0]} {s.text}]"
        at = s.end
    return out + step.text[at:]


@pytest.mark.parametrize("line", CANONICAL)
def test_canonical_steps(fast: OnnxTagger, line: str) -> None:
    (step,) = fast.tag(["".join(s.text for s in parse_markup(line))])
    assert marked(step) == line


def test_the_development_steps(fast: OnnxTagger, dev: tuple[Example, ...]) -> None:
    figures = evaluate(dev, [t.spans for t in fast.tag([e.text for e in dev])])
    assert figures.scores.f1 >= 0.95
    assert figures.whole_step_accuracy >= 0.85


def test_the_fast_path_gives_the_references_labels(
    fast: OnnxTagger, reference: TorchTagger, dev: tuple[Example, ...], grammar: Grammar
) -> None:
    """Eight bits against float32: a word gets another label only where the reference itself wavers, and seldom: hardly
    ever in steps as they are written, one word in 500 in the generator's, of random nouns and typing errors."""
    samples = [Example(s.text, s.spans) for s in islice(generate(grammar, 300, 77), 300)]
    written = tuple(read_examples(DATA / "natural.jsonl"))[::5]
    for truth, one_in in ((dev, 1000), (written, 2000), (samples, 500)):
        taken, truly = (t.tag([e.text for e in truth]) for t in (fast, reference))
        words = [w for x, y in zip(taken, truly, strict=True) for w in zip(x.words, y.words, strict=True)]
        differing = [b for a, b in words if a.label is not b.label]
        assert len(differing) <= len(words) / one_in
        assert all(w.confidence < 0.7 for w in differing)
        ours, theirs = (evaluate(truth, [t.spans for t in tagged]).scores.f1 for tagged in (taken, truly))
        assert ours == pytest.approx(theirs, abs=2e-3)


HOSTILE = [
    "",
    " \n\t",
    "\x00\u200b\ufffd",
    "(((",
    "*" * 600,
    "a" * 100_000,
    "Pick up the cup. " * 80,
    "杯子を取る",
    "a-" * 5000,
]


@pytest.mark.parametrize("text", HOSTILE, ids=range(len(HOSTILE)))
def test_no_text_breaks_it(fast: OnnxTagger, text: str) -> None:
    (step,) = fast.tag([text])
    labels = [w.label for w in step.words]
    assert all(follows(a, b) for a, b in zip((None, *labels), labels, strict=False))
    assert 0 <= step.confidence <= 1


def test_a_step_does_not_depend_on_its_company(fast: OnnxTagger, dev: tuple[Example, ...]) -> None:
    texts = [e.text for e in dev[:20]]
    assert [s.spans for s in fast.tag(texts)] != []
    assert fast.tag(texts) == tuple(fast.tag([t])[0] for t in texts)
    assert fast.tag([]) == ()


def test_confidence_is_that_of_the_worst_word(fast: OnnxTagger) -> None:
    (step,) = fast.tag(["Place object 6 on position 32."])
    assert step.confidence == min(w.confidence for w in step.words)
    for span in step.spans:
        inside = [w.confidence for w in step.words if span.start <= w.start < span.end]
        assert span.confidence == min(inside)


def test_names() -> None:
    assert {"default", "torch"} <= set(tagger_names())
    with pytest.raises(UnknownTaggerError, match="there are default"):
        load_tagger("bert")


def test_the_default_imports_neither_torch_nor_transformers() -> None:
    code = (
        "import sys; from llmbt_compiler.keywords.tagger import load_tagger;"
        "load_tagger().tag(['Pick up the cup.']);"
        "assert not {'torch', 'transformers', 'jinja2'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)})
