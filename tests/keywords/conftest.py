"""Shared by the keyword tests: the inline markup of golden files, and the shipped tagger."""

from __future__ import annotations

from pathlib import Path

import pytest

from llmbt_compiler.keywords.evaluate import Example, read_examples
from llmbt_compiler.keywords.generate import vocabulary_words
from llmbt_compiler.keywords.grammar import Grammar
from llmbt_compiler.keywords.pieces import read_vocabulary
from llmbt_compiler.keywords.tagger import MODEL, OnnxTagger, TorchTagger

REPOSITORY = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def dev() -> tuple[Example, ...]:
    return read_examples(REPOSITORY / "fixtures" / "keywords" / "dev.jsonl")


@pytest.fixture(scope="session")
def grammar() -> Grammar:
    return Grammar.load(vocabulary_words(list(read_vocabulary(MODEL / "vocab.txt"))))


@pytest.fixture(scope="session")
def fast() -> OnnxTagger:
    return OnnxTagger()


@pytest.fixture(scope="session")
def reference() -> TorchTagger:
    return TorchTagger()
