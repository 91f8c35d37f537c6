"""WordPiece against transformers' own tokenizer, and windows."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from llmbt_compiler.keywords.evaluate import Example
from llmbt_compiler.keywords.labels import split
from llmbt_compiler.keywords.pieces import CLS, SEP, UNK, WordPiece, read_vocabulary, windows
from llmbt_compiler.keywords.tagger import MODEL


@pytest.fixture(scope="module")
def cut() -> WordPiece:
    return WordPiece(read_vocabulary(MODEL / "vocab.txt"))


@pytest.fixture(scope="module")
def theirs():  # type: ignore[no-untyped-def]
    from llmbt_compiler.keywords.torch_model import word_cutter

    return word_cutter(MODEL / "vocab.txt")


@settings(max_examples=400, deadline=None)
@given(st.text(min_size=1, max_size=14) | st.text("abcdefghijklmnopqrstuvwxyzÄé-_.'’0123456789", min_size=1))
def test_any_text_is_cut_as_transformers_cut_it(cut, theirs, text: str) -> None:  # type: ignore[no-untyped-def]
    for word in split(text):
        assert list(cut(word.text)) == theirs(word.text)


def test_the_development_steps_are_cut_as_transformers_cut_them(cut, theirs, dev: tuple[Example, ...]) -> None:  # type: ignore[no-untyped-def]
    for example in dev:
        for word in split(example.text):
            assert list(cut(word.text)) == theirs(word.text)


def test_a_word_always_has_a_piece(cut: WordPiece) -> None:
    assert cut("\u200b") == (UNK,)
    assert cut("x" * 5000) == (UNK,)


@given(st.lists(st.integers(1, 60), max_size=80))
def test_windows_hold_every_word_once_in_order(lengths: list[int]) -> None:
    numbered = {str(i): tuple([1000 + i] * n) for i, n in enumerate(lengths)}
    found = windows(list(numbered), lambda w: numbered[w])
    assert [w.ids[f] for w in found for f in w.first] == [1000 + i for i in range(len(lengths))]
    assert all(w.ids[0] == CLS and w.ids[-1] == SEP and len(w.ids) <= 256 for w in found)
