"""Goals stated as JSON or PDDL: the same names and the same complaints as for steps, each with its place."""

from __future__ import annotations

import json
from importlib.resources import files

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from llmbt_atl.library import load_library
from llmbt_compiler.goals import ground, read_reply, read_stated
from llmbt_compiler.reasoning.steps import Question
from llmbt_ir.diagnostics import ExitCode, LlmbtError
from llmbt_ir.scene import load_scene, to_semantic_map

SCENES = {
    name: (to_semantic_map(load_scene(name)), load_library(load_scene(name).library))
    for name in ("cargo_sorting", "cargo_swap", "household")
}


def stated(text, scene="cargo_sorting"):
    return ground(read_stated(text, "my.json"), *SCENES[scene])


def goal(name, *args, **more):
    return {"name": name, "args": list(args), **more}


def document(*goals, **more):
    return json.dumps({"goals": list(goals), **more}, indent=1)


GOOD = [
    (document(goal("On", "object_1", "position_12")), "On(object_1, position_12)"),
    (document(goal("on", "Object 1", "P12")), "On(object_1, position_12)"),
    (document(goal("On", "red block", "level 3")), "On(object_6, shelf_level_3)"),
    (document(goal("Holding", "object_2", negated=True)), "not Holding(object_2)"),
    (document(goal("HandEmpty"), goal("Free", "position_12")), "HandEmpty; Free(position_12)"),
    (document(goal("HandEmpty"), goal("HandEmpty")), "HandEmpty"),
    ("(and (on object_1 position_12) (not (holding object_2)))", "On(object_1, position_12); not Holding(object_2)"),
    ("(:goal (on OBJECT_1 position-12))", "On(object_1, position_12)"),
    ("; a problem\n(define (problem p) (:domain d)\n (:init (handempty))\n (:goal (and (on object_6 position_31))))",
     "On(object_6, position_31)"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "expected"), GOOD)
def test_goals_are_read_and_grounded(text, expected):
    found = stated(text)
    assert found.ok, found.diagnostics
    assert "; ".join(map(str, found.conditions)) == expected


def test_the_household_has_its_own():
    found = stated("(and (on milk user) (near table))", "household")
    assert [str(c) for c in found.conditions] == ["On(milk, user)", "Near(table)"]


BAD = [
    (document(goal("Over", "object_1", "position_12")), "E152", 1),
    (document(goal("Clear", "object_1")), "E152", 1),
    (document(goal("On", "object_1")), "E153", 1),
    (document(goal("On", "", "position_12")), "E153", 1),
    (document(goal("On", "object_9", "position_12")), "E301", 5),
    (document(goal("On", "unicorn", "position_12")), "E301", 1),
    (document(goal("On", "object_1", "position_99")), "E302", 5),
    (document(goal("On", "green block", "position_12")), "E304", 5),
    (document(goal("On", "object_1", "position")), "E304", 5),
    (document(goal("On", "position_12", "object_1")), "E311", 1),
    (document(goal("On", "object_1", "object_2")), "E311", 1),
    (document(goal("Free", "shelf")), "E311", 1),
]


@pytest.mark.parametrize(("text", "code", "exit_"), BAD)
def test_names_are_complained_about_as_in_steps(text, code, exit_):
    found = stated(text)
    assert not found.ok
    assert found.diagnostics[0].code == code
    assert found.exit_code == exit_
    span = found.diagnostics[0].span
    assert (span.source, span.line) == ("my.json", 3)


def test_every_complaint_at_once():
    found = stated(document(goal("Over"), goal("On", "object_1", "position_12"), goal("On", "object_9", "position_12")))
    assert [d.code for d in found.diagnostics] == ["E152", "E301"]


MALFORMED = [
    ("", "E090"), ("hello", "E090"), ("{", "E150"), ('{"goals": 3}', "E150"), ('{"goals": []}', "E155"),
    ('{"goal": []}', "E150"), ("[]", "E150"), ('{"goals": [3]}', "E150"), ('{"goals": [{"name": "On"}]}', "E150"),
    ('{"goals": [{"name": "On", "args": "x"}]}', "E150"), ('{"goals": [{"name": 1, "args": []}]}', "E150"),
    ('{"goals": [{"name": "On", "args": [], "negate": true}]}', "E150"),
    ('{"goals": [{"name": "On", "args": [], "negated": "yes"}]}', "E150"),
    ('{"goals": [{"name": "HandEmpty", "args": []}]} and more', "E150"),
    ('{"schema_version": 2, "goals": [{"name": "HandEmpty", "args": []}]}', "E150"),
    ("[" * 100_000, "E150"), ('{"goals": [' + "1" * 5000 + "]}", "E150"),
    ("(or (on a b) (on c d))", "E092"), ("(not (and (on a b)))", "E092"), ("(forall (?x) (on ?x b))", "E092"),
    ("(on a b", "E090"), ("(on a b))", "E090"), ("(and)", "E155"), ("()", "E092"), ("(define (problem p))", "E155"),
    ("(" * 1000, "E090"), ("(on (a) b)", "E090"), ("(and x)", "E090"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "code"), MALFORMED)
def test_what_is_no_goals_has_a_code_and_a_place(text, code):
    with pytest.raises(LlmbtError) as caught:
        read_stated(text, "my.json")
    assert caught.value.diagnostics[0].code == code
    assert caught.value.exit_code is ExitCode.BAD_INPUT


@pytest.mark.parametrize(
    ("reply", "code"),
    [
        ('{"goals": [{"name": "On", "args": ["object_1"', "E151"),
        ('```json\n{"goals": [{"name": "On",\n```', "E151"),
        ("I cannot do that.", "E150"),
        ('{"question": "..."}', "E150"),
        ('{"question": "Which?", "goals": [{"name": "HandEmpty", "args": []}]}', "E150"),
        ('{"goals": []}', "E155"),
    ],
)
def test_a_models_json_that_is_none(reply, code):
    with pytest.raises(LlmbtError) as caught:
        read_reply(reply)
    assert caught.value.diagnostics[0].code == code


def test_a_models_json_may_have_words_around_it():
    text = 'Sure!\n```json\n{"goals": [{"name": "HandEmpty", "args": []}]}\n```\nDone.'
    found = read_reply(text)
    (literal,) = found.literals
    assert literal.extent.cut(text) == '{"name": "HandEmpty", "args": []}'
    assert read_reply('{"question": "Which one?", "candidates": ["object_1"]}') == Question(
        "Which one?", 0, 54, 1, ("object_1",)
    )


def test_what_the_parser_writes_can_be_read_again():
    """conditions.json is such a document."""
    from llmbt_compiler.reasoning.chat import Replay
    from llmbt_compiler.stages import PARSE, Context

    found = stated(document(goal("On", "object_1", "position_12"), goal("Free", "position_13")))
    context = Context("", *SCENES["cargo_sorting"], Replay())
    assert stated(PARSE.write(found, context).decode()).conditions == found.conditions


JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.text(max_size=8)
    | st.sampled_from(["On", "object_1", "position_12"]),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.sampled_from(["goals", "name", "args", "negated", "x"]), inner, max_size=4)
    ),
    max_leaves=12,
)


@given(JSON | st.text(max_size=60))
def test_any_document_gives_goals_over_the_map_or_diagnostics(value):
    text = value if isinstance(value, str) else json.dumps(value)
    semantic_map, library = SCENES["cargo_sorting"]
    known = {o.id for o in semantic_map.objects} | {p.id for p in semantic_map.places}
    try:
        found = stated(text)
    except LlmbtError as fault:
        assert fault.diagnostics
        return
    assert found.ok or found.diagnostics
    assert all(set(c.args) <= known and c.name in library.conditions for c in found.conditions)


def goals_by_schema():
    name = st.sampled_from(["On", "Holding", "HandEmpty", "x"])
    one = st.fixed_dictionaries(
        {"name": name, "args": st.lists(st.text(max_size=5), max_size=3)}, optional={"negated": st.booleans()}
    )
    return st.fixed_dictionaries({"goals": st.lists(one, min_size=1, max_size=3)})


@given(goals_by_schema() | JSON)
def test_the_schema_and_the_reader_agree(value):
    schema = json.loads((files("llmbt_compiler.goals") / "goals.schema.json").read_text("utf-8"))
    valid = jsonschema.Draft202012Validator(schema).is_valid(value)
    if not isinstance(value, dict):
        assert not valid
        return
    try:
        read_stated(json.dumps(value))
        read = True
    except LlmbtError:
        read = False
    assert read == valid
