"""The generator: the same steps for the same seed, every keyword well formed, the grammar plain data."""

from __future__ import annotations

from collections import Counter
from itertools import islice
from pathlib import Path

import pytest

from llmbt_compiler.keywords.generate import Sample, generate
from llmbt_compiler.keywords.grammar import DATA, Grammar, GrammarError, gerund, parse_markup, third_person
from llmbt_compiler.keywords.labels import Kind, decode, encode
from llmbt_compiler.keywords.noise import NO_NOISE

GOLDEN = Path(__file__).parent / "golden" / "generated.txt"


def marked(sample: Sample) -> str:
    """The sample with its keywords in brackets."""
    out, at = "", 0
    for s in sample.spans:
        out += sample.text[at : s.start] + f"[{s.label[0]} {s.text}]"
        at = s.end
    return out + sample.text[at:]


def test_the_same_seed_gives_the_same_steps(grammar: Grammar) -> None:
    assert list(generate(grammar, 200, 3)) == list(generate(grammar, 200, 3))
    assert list(generate(grammar, 50, 3)) == list(islice(generate(grammar, 200, 3), 50))
    assert list(generate(grammar, 50, 3)) != list(generate(grammar, 50, 4))


def test_forty_samples_as_they_were(grammar: Grammar) -> None:
    """Changes with the grammar; look at the difference, then write the new lines into the file."""
    found = [f"{s.structure}: {marked(s)}" for s in generate(grammar, 40, 2026)]
    assert found == GOLDEN.read_text("utf-8").splitlines()


def test_every_keyword_is_well_formed(grammar: Grammar) -> None:
    kinds: Counter[Kind] = Counter()
    structures: Counter[str] = Counter()
    for sample in generate(grammar, 2000, 11):
        assert decode(sample.text, encode(sample.text, sample.spans)) == sample.spans
        assert sample.text == sample.text.strip()
        kinds.update(s.label for s in sample.spans)
        structures[sample.structure] += 1
    assert set(kinds) == set(Kind)
    assert set(structures) == set(grammar.structures)


def test_every_rule_can_be_drawn(grammar: Grammar) -> None:
    """A line that names a rule that does not exist is found here, not in the middle of training."""
    for structure in grammar.structures:
        for sample in generate(grammar, 300, 5, NO_NOISE, {s: float(s == structure) for s in grammar.structures}):
            assert sample.structure == structure
            assert "{" not in sample.text


def test_a_structure_is_a_line_in_a_file(tmp_path: Path) -> None:
    (tmp_path / "structures").mkdir()
    (tmp_path / "words").mkdir()
    (tmp_path / "structures" / "mine.txt").write_text("# mine\n3| [A juggle] the [T {{ fruit() }}]\n")
    (tmp_path / "words" / "fruit.txt").write_text("kiwi ; kiwi\n")
    grammar = Grammar.load((), tmp_path)
    (sample,) = generate(grammar, 1, 0, NO_NOISE)
    assert marked(sample) == "[A Juggle] the [T kiwi]."


def test_words_of_a_users_own(grammar: Grammar) -> None:
    mine = Grammar.load(("word",), DATA, {"noun_real": ["flux capacitor"]})
    assert any("flux capacitor" in s.text for s in generate(mine, 100, 0))


@pytest.mark.parametrize(
    ("structure", "word", "complaint"),
    [
        ("[A pick] {{ nothing() }}", "a", r"mine\.txt:1.*nothing"),
        ("[A pick] {{ thing( }}", "a", r"mine\.txt:1"),
        ("[A pick] [X cup]", "a", "bracket"),
        ("{{ thing() }}", "{{ thing() }}", "without end"),
        ("a ;  ; b", "a", r"mine\.txt:1"),
    ],
)
def test_a_faulty_line_is_named(tmp_path: Path, structure: str, word: str, complaint: str) -> None:
    (tmp_path / "structures").mkdir()
    (tmp_path / "words").mkdir()
    (tmp_path / "structures" / "mine.txt").write_text(structure)
    (tmp_path / "words" / "thing.txt").write_text(word)
    with pytest.raises(GrammarError, match=complaint):
        list(generate(Grammar.load(("word",), tmp_path), 3, 0))


def test_markup() -> None:
    assert [(s.text, s.kind) for s in parse_markup("[A grab] the [T cup] ([L x])")] == [
        ("grab", Kind.ACTION),
        (" the ", None),
        ("cup", Kind.TARGET),
        (" (", None),
        ("x", Kind.LOCATION),
        (")", None),
    ]


@pytest.mark.parametrize(
    ("verb", "third", "ing"),
    [("pick", "picks", "picking"), ("put", "puts", "putting"), ("push", "pushes", "pushing"),
     ("carry", "carries", "carrying"), ("place", "places", "placing"), ("go", "goes", "going"),
     ("free", "frees", "freeing"), ("load", "loads", "loading"), ("say", "says", "saying")],
)  # fmt: skip
def test_inflection(verb: str, third: str, ing: str) -> None:
    assert (third_person(verb), gerund(verb)) == (third, ing)
