"""Destinations and referents in scenes made at random, against the oracle of tests/relations; and any words at all."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from llmbt_atl.library import load_library
from llmbt_compiler.keywords.labels import KeywordSpan, Kind
from llmbt_compiler.parsing import LabelledStep, parse
from llmbt_ir.geometry import Pose, Viewpoint
from llmbt_ir.scene import load_scene, to_semantic_map
from tests.parsing.labelled import steps
from tests.relations.oracle import Oracle

LIBRARY = load_library("cargo_sorting")
CARGO = to_semantic_map(load_scene("cargo_sorting"))
SLOTS = tuple(p for p in CARGO.places if p.type == "slot")
SIDES = {"left": "to the left of", "right": "to the right of", "front": "in front of", "back": "behind"}
NAMES = {"left": "left_of", "right": "right_of", "front": "in_front_of", "back": "behind"}


@st.composite
def scenes(draw):
    """The cargo scene with its blocks on positions drawn at random, looked at from one of the four sides."""
    chosen = draw(st.permutations(SLOTS))[:6]
    objects = tuple(
        replace(o, place=p.id, pose=Pose((*p.surface_m[:2], p.surface_m[2] + 0.0225)))
        for o, p in zip(CARGO.objects, chosen, strict=True)
    )
    turned = draw(st.sampled_from([0.0, np.pi / 2, np.pi, -np.pi / 2]))
    return replace(CARGO, objects=objects, viewpoint=Viewpoint("somebody", (0.0, 0.0, 0.0), turned))


def places_as_objects(semantic_map):
    """An oracle that knows the positions too."""
    oracle = Oracle(semantic_map)
    for p in SLOTS:
        centre = (np.array(p.surface_m) - oracle.eye) @ oracle.basis.T
        oracle.centre[p.id] = oracle.low[p.id] = oracle.high[p.id] = centre
    return oracle


@settings(max_examples=200, deadline=None)
@given(scenes(), st.sampled_from(sorted(SIDES)), st.permutations(range(1, 7)))
def test_a_destination_beside_an_object(semantic_map, side, order):
    """The nearest free position on that side, on the same level if there is any there; a refusal if there is none."""
    a, b = (f"object_{n}" for n in order[:2])
    found = parse(steps(f"A[Place] T[{a}] {SIDES[side]} D[{b}]."), semantic_map, LIBRARY)
    oracle = places_as_objects(semantic_map)
    at = {o.id: o.place for o in semantic_map.objects}
    fitting = [p.id for p in SLOTS if p.id != at[b] and getattr(oracle, NAMES[side])(p.id, b)]
    level = [p for p in fitting if abs(oracle.low[p][2] - oracle.low[b][2]) <= 0.035]
    fitting = level or fitting
    free = [p for p in fitting if p not in at.values() or at[a] == p]
    if not free:
        assert not found.ok
        assert found.diagnostics[0].code == ("E308" if fitting else "E309")
        return
    nearest = min(round(float(np.linalg.norm((oracle.centre[p] - oracle.centre[b])[:2])), 6) for p in free)
    (goal,) = found.conditions
    assert goal.args[0] == a
    assert goal.args[1] in free
    assert round(float(np.linalg.norm((oracle.centre[goal.args[1]] - oracle.centre[b])[:2])), 6) == nearest


@settings(max_examples=200, deadline=None)
@given(scenes(), st.sampled_from(["leftmost", "rightmost"]), st.sampled_from(["green", "yellow", "red"]))
def test_a_referent_by_its_side(semantic_map, word, colour):
    """The one that is farthest on that side by more than the margin, else a question about those that are level."""
    found = parse(steps(f"A[Pick] up the T[{word} {colour} block]."), semantic_map, LIBRARY)
    oracle = Oracle(semantic_map)
    ids = [o.id for o in semantic_map.objects if o.colour == colour]
    sign = 1 if word == "leftmost" else -1
    groups = oracle.groups(ids, lambda i: sign * oracle.centre[i][0], 0.025)
    if len(groups[0]) == 1:
        assert [str(c) for c in found.conditions] == [f"Holding({groups[0][0]})"]
    else:
        assert found.diagnostics[0].code == "E304"
        assert found.diagnostics[0].candidates == groups[0]


WORDS = tuple(
    "left right of to the on in front behind next between and nearest top above its it leftmost second from smallest "  # noqa: SIM905
    "largest object block position level 1 2 12 red green free empty arrange place pick row size order . , that is "
    "robot".split()
)


@settings(max_examples=400, deadline=None)
@given(
    st.lists(st.sampled_from(WORDS), min_size=1, max_size=14),
    st.lists(st.tuples(st.integers(0, 13), st.integers(1, 4), st.sampled_from(list(Kind))), max_size=5),
)
def test_any_words_of_space(words, spans):
    """Never an exception, never a goal about something that is not in the map."""
    text = " ".join(words)
    starts = [sum(len(w) + 1 for w in words[:i]) for i in range(len(words))]
    marked = [
        KeywordSpan(starts[i], starts[min(i + n, len(words)) - 1] + len(words[min(i + n, len(words)) - 1]), kind, "")
        for i, n, kind in spans
        if i < len(words)
    ]
    marked = [replace(s, text=text[s.start : s.end]) for s in marked]
    found = parse([LabelledStep(1, text, tuple(marked))], CARGO, LIBRARY)
    known = {o.id for o in CARGO.objects} | {p.id for p in CARGO.places}
    assert all(a in known for c in found.conditions for a in c.args)
    assert found.ok or found.diagnostics
