"""Asking back, correcting, refusing: what is said, by whom, and what comes of it. Only the replies are scripted."""

from __future__ import annotations

from dataclasses import replace

import pytest

from llmbt_atl.library import load_library
from llmbt_compiler.checking import unable
from llmbt_compiler.pipeline import Context, compile_request
from llmbt_compiler.reasoning.chat import Script
from llmbt_ir.diagnostics import ExitCode, LlmbtError
from llmbt_ir.scene import load_scene, to_semantic_map

SCENES = {
    name: (to_semantic_map(load_scene(name)), load_library(load_scene(name).library))
    for name in ("cargo_sorting", "cargo_swap", "cargo_sizes", "cargo_groups", "household")
}


def talk(request, replies, answers=(), *, scene="cargo_sorting", corrections=0, **more):
    """Goals, the kinds of what was said, and the prompts that were asked; or the error."""
    left, heard = list(answers), []
    context = Context(
        request, *SCENES[scene], Script(tuple(replies), heard=heard.append), corrections=corrections, **more
    )
    done = compile_request(context, consult=lambda _: left.pop(0) if left else None)
    assert not left, "every answer was asked for"
    return [str(g.condition) for g in done.goals], [t.kind for t in done.dialogue.turns], heard


def asked(request, replies, answers=(), **more):
    """The question that stays open."""
    with pytest.raises(LlmbtError) as caught:
        talk(request, replies, answers, **more)
    assert caught.value.exit_code is ExitCode.UNCLEAR, caught.value
    first = caught.value.diagnostics[0]
    return first.code, first.candidates


GREEN = ("object_1", "object_2", "object_4")


# -- the model asks ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("question", "candidates"),
    [
        ("Which green block do you mean, object 1, object 2 or object 4?", GREEN),
        ("Which green block?", GREEN),
        ("Do you mean objects 1, 2 or 4?", GREEN),
        ("Which of the yellow blocks should I move: object 3 (at the back) or object 5?", ("object_3", "object_5")),
        ("Should it go on level 1 or level 3?", ("shelf_level_1", "shelf_level_3")),
        (
            "Which level should the red block go to: level 1, 2 or 3?",
            ("shelf_level_1", "shelf_level_2", "shelf_level_3"),
        ),
        ("Which one: object 1 on the workbench, or object 2 in the sorting area?", ("object_1", "object_2")),
        ("On which position should object 6 be placed, position 31 or position 34?", ("position_31", "position_34")),
    ],
)
def test_the_models_question_has_candidates(question, candidates):
    assert asked("Do it.", [f"QUESTION: {question}"]) == ("E140", candidates)


def test_where_asks_for_a_place():
    code, candidates = asked("Bring the milk.", ["QUESTION: Where should I bring the milk?"], scene="household")
    assert (code, set(candidates)) == ("E140", {"bar", "desk", "shelf", "table", "user"})


def test_the_answer_goes_on_with_the_model():
    goals, kinds, heard = talk(
        "Put the green block on position 21.",
        ["QUESTION: Which green block?", "1. Place object 2 on position 21."],
        ["the second one"],
    )
    assert goals == ["On(object_2, position_21)"]
    assert kinds == ["request", "reply", "question", "answer", "reply"]
    assert heard[1][-1] == ("user", 'Answer: "the second one"\nNow give the whole answer, in the same form.')


def test_an_answer_that_names_a_candidate_needs_no_model_where_the_request_reads_as_a_step():
    goals, kinds, heard = talk("Put the green block on position 21.", ["QUESTION: Which green block?"], ["object 4"])
    assert goals == ["On(object_4, position_21)"]
    assert kinds[-1] == "settled"
    assert len(heard) == 1


def test_any_other_answer_needs_one():
    with pytest.raises(LlmbtError) as caught:
        talk("Put the green block on position 21.", ["QUESTION: Which green block?"], ["the heaviest"])
    assert caught.value.exit_code is ExitCode.NO_RECORDING


# -- the parser asks -----------------------------------------------------------------------------------------------

QUESTIONS = [
    ("1. Place the green block on position 12.", "E304", GREEN, "object 2", "On(object_2, position_12)"),
    ("1. Place the green block on position 12.", "E304", GREEN, "the one nearest to me, please", None),
    ("1. Place the green block on position 12.", "E304", GREEN, "4", "On(object_4, position_12)"),
    ("1. Pick up object 6 and place it.", "E305", None, "position 12", "On(object_6, position_12)"),
    ("1. Pick up object 6 and place it.", "E305", None, "on the top level", "On(object_6, position_31)"),
    ("1. Pick up object 6 and place it.", "E305", None, "to the left of position 13", "On(object_6, position_12)"),
    ("1. Pick up object 6 and place it. Then pick up object 5 and place it on position 21.", "E305", None,
     "position 32", "On(object_6, position_32); On(object_5, position_21)"),
    ("1. Place object 77 on position 12.", "E301", None, "object 6", "On(object_6, position_12)"),
    ("1. Place object 6 on position 55.", "E302", None, "position 34", "On(object_6, position_34)"),
    ("1. Place object 6 on the empty position next to position 12.", "E304", ("position_11", "position_13"), "13",
     "On(object_6, position_13)"),
    ("1. Put the leftmost yellow block on position 12.", "E304", ("object_3", "object_5"), "object 3",
     "On(object_3, position_12)"),
    ("1. Place object 6 to the left of the green block.", "E304", GREEN, "object 1", None),
]  # fmt: skip


@pytest.mark.parametrize(("reply", "code", "candidates", "answer", "expected"), QUESTIONS)
def test_an_open_step_is_asked_about_and_an_answer_settles_it(reply, code, candidates, answer, expected):
    found = asked("Do as I said.", [reply])
    assert found[0] == code
    assert found[1], "a question has its candidates"
    assert candidates is None or found[1] == candidates
    if expected is None:
        with pytest.raises(LlmbtError):
            talk("Do as I said.", [reply], [answer])
        return
    goals, kinds, heard = talk("Do as I said.", [reply], [answer])
    assert "; ".join(goals) == expected
    assert kinds == ["request", "reply", "question", "answer", "settled"]
    assert len(heard) == 1, "no model was asked again"


@pytest.mark.parametrize(
    "answer", ["not object 2", "anything but object 2", "object 2 or object 4", "object 6", "the pink one", "?"]
)
def test_an_answer_that_is_not_plain_is_not_taken(answer):
    with pytest.raises(LlmbtError) as caught:
        talk("Do as I said.", ["1. Place the green block on position 12."], [answer])
    assert caught.value.exit_code is ExitCode.NO_RECORDING


def test_several_questions_one_after_the_other():
    reply = "1. Place the green block on position 12.\n2. Place the yellow block on position 13."
    goals, kinds, _ = talk("Do as I said.", [reply], ["object 2", "object 5"])
    assert goals == ["On(object_2, position_12)", "On(object_5, position_13)"]
    assert kinds.count("question") == 2


def test_an_answer_that_settles_nothing_goes_to_the_model_with_the_question():
    goals, _, heard = talk(
        "Do as I said.",
        ["1. Place the green block on position 12.", "1. Place object 4 on position 12."],
        ["the one I like best"],
    )
    assert goals == ["On(object_4, position_12)"]
    assert heard[1][-1][1].startswith('Asked back: "`green block` fits 3 things"\nAnswer: "the one I like best"\n')


def test_spans_still_point_into_the_reply():
    reply = "Sure!\n\n1. Place the green block on position 12.\n2. Place object 3 on position 13."
    left = ["object 4"]
    context = Context("Do it.", *SCENES["cargo_sorting"], Script((reply,)))
    done = compile_request(context, consult=lambda _: left.pop(0) if left else None)
    first, second = done.goals
    assert second.reply.cut(reply) == "Place object 3 on position 13"
    assert first.reply.cut(reply).startswith("Place the green block")


def test_nothing_is_asked_where_the_map_leaves_one_reading():
    for step in ("the red block", "the rightmost red block", "the yellow block from the shelf", "object 2"):
        goals, kinds, _ = talk("Do it.", [f"1. Place {step} on position 34."], scene="cargo_swap")
        assert len(goals) == 1
        assert kinds == ["request", "reply"]


# -- the check of the request asks ---------------------------------------------------------------------------------


def test_a_reply_that_guesses_is_asked_about():
    request, guess = "Put the green block on position 21.", "1. Place object 1 on position 21."
    assert asked(request, [guess]) == ("E141", GREEN)
    goals, kinds, _ = talk(request, [guess], ["object 4"])
    assert goals == ["On(object_4, position_21)"]
    assert kinds == ["request", "reply", "question", "answer", "settled"]


@pytest.mark.parametrize(
    ("request_", "reply"),
    [
        ("Put the red block on position 21.", "1. Place object 6 on position 21."),
        ("Put the green blocks on level 1.", "1. Place object 1, object 2 and object 4 on level 1."),
        ("Put any green block on position 21.", "1. Place object 1 on position 21."),
        ("Put a green block on position 21, I don't care which.", "1. Place object 1 on position 21."),
        ("Put two blocks, object 1 and object 2, on level 1.", "1. Place object 1 and object 2 on level 1."),
        ("Put the red block on level 1.", "1. Place object 6 on position 12."),
        ("Put the red block on a free position of level 1.", "1. Place object 6 on position 12."),
        ("Put the green block on position 21. Which is left to your discretion.", "1. Place object 1 on position 21."),
        ("Put the green block 4 on position 21.", "1. Place object 4 on position 21."),
        ("Put the green block (object 4) on position 21.", "1. Place object 4 on position 21."),
        ("Put the frontmost green block on position 21.", "1. Place object 4 on position 21."),
        ("Move the yellow block at the back to position 22.", "1. Place object 3 on position 22."),
        ("Bring the yellow one in front to position 22.", "1. Place object 5 on position 22."),
        ("Put object 6 on position 21. Not the wine.", "1. Place object 6 on position 21."),
        ("Put the stuff on the right side of level 3.", "1. Place object 6 on position 34."),
        ("Tidy up: the red block belongs on the top.", "1. Place object 6 on position 31."),
        ("Take object 4. Put the green block on position 21.", "1. Place object 4 on position 21."),
        ("Put the green block that is nearest to you on position 21.", "1. Place object 4 on position 21."),
        ("Take the red block. Put the block on position 21.", "1. Place object 6 on position 21."),
        ("Sort the cargo by colour.", "1. Place object 6 on position 32."),
        ("If a blue box comes, ignore it: put object 6 on position 32.", "1. Place object 6 on position 32."),
    ],
)
def test_no_guess_is_seen_where_there_is_none(request_, reply):
    assert talk(request_, [reply])[1] == ["request", "reply"]


@pytest.mark.parametrize(
    ("request_", "reply", "candidates"),
    [
        ("Put the leftmost green block on position 21.", "1. Place object 4 on position 21.", "124"),
        ("Put the yellow one on position 32.", "1. Place object 3 on position 32.", "35"),
        ("Swap the yellow block with the red block.", "1. Place object 3 on position 11.", "35"),
        ("Take the green block off the workbench, put it on position 21.", "1. Place object 2 on position 21.", "124"),
        ("Put object 6 to the left of the yellow block.", "1. Place object 3 on position 22.", "35"),
        ("Put a green block on position 21.", "1. Place object 1 on position 21.", "124"),
        ("Put one of the green blocks on position 21.", "1. Place object 1 on position 21.", "124"),
        ("Put two of the green blocks on level 1.", "1. Place object 1 and object 2 on level 1.", "124"),
        ("Put the block at the back of the sorting area on position 21.", "1. Place object 1 on position 21.", "13"),
        ("Put the green block next to a yellow one on position 21.", "1. Place object 1 on position 21.", "12"),
    ],
)
def test_a_guess_is_seen(request_, reply, candidates):
    assert asked(request_, [reply]) == ("E141", tuple(f"object_{n}" for n in candidates))


@pytest.mark.parametrize(
    ("request_", "reply", "noun", "candidates"),
    [
        ("Bring me the wine.", "1. Give the juice to the user.", "wine", ("juice",)),
        ("Could you fetch my newspapers?", "1. Give the tea to the user.", "newspapers", ("tea",)),
        ("Put the cookies on the balcony.", "1. Put the cookies on the desk.", "balcony", ("desk",)),
    ],
)
def test_what_nothing_in_the_scene_goes_by_is_asked_about(request_, reply, noun, candidates):
    code, found = asked(request_, [reply], scene="household")
    assert (code, found) == ("E142", candidates)


@pytest.mark.parametrize(
    ("request_", "reply"),
    [
        ("Bring me a drink, any of them.", "1. Give the juice to the user."),
        ("Get me a snack, please, whichever you like.", "1. Give the cookies to the user."),
        ("Bring me the cola.", "1. Give the coke to the user."),
        ("Bring me the wine or the juice.", "1. Give the juice to the user."),
        ("If there is no beer, bring me the coke.", "1. Give the coke to the user."),
        ("Bring the guest a glass of water.", "1. Give the water to the user."),
    ],
)
def test_a_sort_of_things_is_no_name(request_, reply):
    assert talk(request_, [reply], scene="household")[1] == ["request", "reply"]


@pytest.mark.parametrize(
    ("scene", "request_", "reply", "candidates"),
    [
        ("cargo_sorting", "Put the red block on the leftmost position of the shelf.",
         "1. Place object 6 on position 11.", ("position_11", "position_21", "position_31")),
        ("cargo_sorting", "Put the red block in the middle position of level 2.",
         "1. Place object 6 on position 22.", ("position_22", "position_23")),
        ("cargo_sorting", "Put the red block at an end of level 2.",
         "1. Place object 6 on position 21.", ("position_21", "position_24")),
        ("cargo_swap", "Put the red block in the empty spot next to the green block on the shelf.",
         "1. Place object 6 on position 13.", ("position_11", "position_13")),
        ("cargo_swap", "Put the yellow block on the shelf on the other level.",
         "1. Place object 3 on position 31.", ("shelf_level_1", "shelf_level_3")),
        ("household", "Put the apple on the piece of furniture with nothing on it.",
         "1. Put the apple on the desk.", ("desk", "shelf")),
    ],
)  # fmt: skip
def test_a_place_that_several_are_is_asked_about(scene, request_, reply, candidates):
    assert asked(request_, [reply], scene=scene) == ("E141", candidates)


@pytest.mark.parametrize(
    ("scene", "request_", "reply", "code"),
    [
        ("household", "Open the milk and bring it to me.", "1. Give the milk to the user.", "E144"),
        ("household", "Bring me two apples.", "1. Give the apple to the user.", "E142"),
        ("household", "Take the milk from the table to the desk.", "1. Put the milk on the desk.", "E142"),
        ("household", "Put the tea on the desk and on the shelf.", "1. Put the tea on the desk.", "E343"),
        ("household", "Bring me the coke, but it must not leave the bar.", "1. Give the coke to the user.", "E343"),
        ("cargo_swap", "Put object 6 on position 12. The green block there stays.",
         "1. Place object 6 on position 12.", "E343"),
        ("cargo_swap", "Put all four blocks from the sorting area on level 1.",
         "1. Place object 2 on position 11.\n2. Place object 4 on position 12.\n3. Place object 5 on position 13.",
         "E308"),
        ("cargo_sorting", "Object 1 and object 2 both belong on position 24.",
         "1. Place object 1 on position 24.\n2. Place object 2 on position 23.", "E308"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_though_the_reply_goes_along(scene, request_, reply, code):
    with pytest.raises(LlmbtError) as caught:
        talk(request_, [reply], scene=scene)
    assert caught.value.diagnostics[0].code == code


def test_what_a_library_can_do_is_not_refused():
    semantic_map, household = SCENES["household"]
    said = "Open the milk and bring it to me."
    assert [d.code for d in unable(said, semantic_map, household)] == ["E144"]
    opens = replace(household.templates["place"], name="uncork", verbs=("open",), words="open {target}")
    able = replace(household, templates={**household.templates, "uncork": opens})
    assert not list(unable(said, semantic_map, able))


def test_an_answer_on_which_other_goals_hang_goes_to_the_model():
    """Where the white block is to go follows from which red one is meant."""
    first = "1. Place object 5 on position 11.\n2. Move object 1 to the sorting area."
    then = "1. Move object 2 to the sorting area.\n2. Place object 5 on position 12."
    request = "Exchange the red block with the white block."
    goals, kinds, _ = talk(request, [first, then], ["object 2"], scene="cargo_groups")
    assert goals == ["On(object_2, sorting_area)", "On(object_5, position_12)"]
    assert kinds.count("reply") == 2


def test_a_green_block_that_the_place_tells_is_no_guess():
    reply = ["1. Place object 1 on position 34."]
    assert talk("Put the green block on position 12 on position 34.", reply, scene="cargo_swap")[0]
    assert talk("Put the green block from the shelf on position 34.", reply, scene="cargo_swap")[0]
    guess = ["1. Place object 2 on position 34."]
    found = asked("Put the green block in the sorting area on position 34.", guess, scene="cargo_swap")
    assert found == ("E141", ("object_2", "object_4"))


@pytest.mark.parametrize(
    ("request_", "nearest"),
    [
        ("Put the blue block on position 21.", "object_"),
        ("Put object 9 on position 21.", "object_"),
        ("Put object 1 on position 55.", "position_"),
        ("Put object 1 on level 7.", "shelf_level_"),
    ],
)
def test_a_reply_that_passes_over_what_the_scene_lacks_is_asked_about(request_, nearest):
    code, candidates = asked(request_, ["1. Place object 1 on position 21."])
    assert code == "E142"
    assert candidates
    assert all(c.startswith(nearest) for c in candidates)


def test_a_relation_that_the_request_asks_for_is_not_left_open_silently():
    """The bar has no positions of its own: that it is beside the milk is no goal, and the user is asked."""
    request, reply = "Put the apple next to the milk on the bar.", "1. Place the apple on the bar, next to the milk."
    assert asked(request, [reply], scene="household") == ("E309", ("bar",))
    assert talk(request, [reply], ["the bar is fine"], scene="household")[0] == ["On(apple, bar)"]
    assert talk("Put the apple on the bar.", [reply], scene="household")[0] == ["On(apple, bar)"]


# -- contradictions ------------------------------------------------------------------------------------------------

CONTRADICTIONS = [
    "1. Place object 1 on position 12.\n2. Place object 2 on position 12.",
    "1. Place object 1 on position 12.\n2. Place object 1 on position 13.",
    "1. Place object 1 on position 12.\n2. Place object 2 on position 13.\n3. Place object 1 on position 14.",
]


@pytest.mark.parametrize("reply", CONTRADICTIONS)
def test_contradictions_are_told_with_both_steps(reply):
    with pytest.raises(LlmbtError) as caught:
        talk("Do it.", [reply])
    assert caught.value.exit_code is ExitCode.NO_SUCCESS
    first = caught.value.diagnostics[0]
    assert first.code == "E343"
    assert [n.split(":")[0] for n in first.notes] in (["step 1", "step 2"], ["step 1", "step 3"])


@pytest.mark.parametrize(
    "reply",
    [
        "1. Place object 1 in the sorting area.\n2. Place object 3 on position 12.\n3. Place object 1 on position 22.",
        "1. Place object 1 on position 34.\n2. Place object 3 on position 12.\n3. Place object 1 on position 22.",
        "1. Place object 2 on level 3.\n2. Place object 2 on position 34.",
        "1. Place object 2 on position 13.\n2. Place object 2 on position 13.",
        "1. Move object 2 to level 1.\n2. Arrange object 2 and object 4 from left to right on level 1.",
    ],
)
def test_a_stop_on_the_way_is_no_contradiction(reply):
    assert talk("Do it.", [reply], scene="cargo_swap")[0]


# -- corrections ---------------------------------------------------------------------------------------------------

WRONG, RIGHT = "1. Fly object 6 to position 32.", "1. Place object 6 on position 32."


def test_a_faulty_reply_goes_back_with_the_complaint():
    goals, kinds, heard = talk("Do it.", [WRONG, RIGHT], corrections=2)
    assert goals == ["On(object_6, position_32)"]
    assert kinds == ["request", "reply", "complaint", "reply"]
    assert [role for role, _ in heard[1]] == ["system", "user", "assistant", "user"]
    assert "- unknown action `fly`" in heard[1][-1][1]


@pytest.mark.parametrize(
    ("faulty", "code"),
    [
        ("1. Place object 77 on position 32.", "E301"),
        ("1. Place object 6 on", "E116"),
        ("I would rather not.", "E114"),
        ("1. Place object 1 on position 12.\n2. Place object 2 on position 12.", "E343"),
        ("1. Place the green block on position 12.", "E304"),
    ],
)
def test_every_failed_check_may_be_corrected(faulty, code):
    assert talk("Do it.", [faulty, RIGHT], corrections=1)[0] == ["On(object_6, position_32)"]
    with pytest.raises(LlmbtError) as caught:
        talk("Do it.", [faulty], corrections=1)
    assert caught.value.diagnostics[0].code == code, "without a recording the first diagnostic stands"


def test_at_most_so_many_corrections():
    with pytest.raises(LlmbtError) as caught:
        talk("Do it.", [WRONG, WRONG, WRONG, RIGHT], corrections=2)
    assert caught.value.diagnostics[0].code == "E303"
    assert talk("Do it.", [WRONG, WRONG, WRONG, RIGHT], corrections=3)[0]


def test_a_guess_may_be_corrected_into_a_question():
    code, candidates = asked(
        "Put the green block on position 21.",
        ["1. Place object 1 on position 21.", "QUESTION: Which green block?"],
        corrections=1,
    )
    assert (code, candidates) == ("E140", GREEN)


def test_what_the_callers_check_refuses_goes_back_too():
    said = []

    def check(compiled):
        said.append([str(g.condition) for g in compiled.goals])
        if len(said) == 1:
            from llmbt_ir.diagnostics import Diagnostic

            raise LlmbtError(Diagnostic("E341", "cannot be"), exit_code=ExitCode.NO_SUCCESS)

    context = Context("Do it.", *SCENES["cargo_sorting"], Script((RIGHT, "1. Place object 5 on position 31.")))
    compile_request(context, check=check)
    assert said == [["On(object_6, position_32)"], ["On(object_5, position_31)"]]


# -- another front end ---------------------------------------------------------------------------------------------


def test_one_replaced_stage():
    """The paper's claim of modularity: the keyword stage alone is another one here, a few patterns in place of BERT."""
    import re

    from llmbt_compiler.keywords.labels import KeywordSpan, Kind
    from llmbt_compiler.parsing import LabelledStep
    from llmbt_compiler.pipeline import FRONT_ENDS

    def patterns(steps, _context):
        found = []
        for s in steps.steps:
            m = re.match(r"(?P<Action>\w+) (?P<Target>object \d) on (?P<Destination>position \d+)", s.text)
            spans = [KeywordSpan(*m.span(k), Kind(k), m[k]) for k in m.groupdict()]
            found.append(LabelledStep(s.number, s.text, tuple(spans)))
        return tuple(found)

    usual = FRONT_ENDS["steps"]
    stages = tuple(replace(s, run=patterns) if s.name == "keywords" else s for s in usual.stages)
    other = talk("Do it.", [RIGHT], front_end=replace(usual, stages=stages))
    assert other[0] == talk("Do it.", [RIGHT])[0] == ["On(object_6, position_32)"]


def test_the_second_front_end_reads_goals_as_json():
    from llmbt_compiler.pipeline import FRONT_ENDS

    json_ = FRONT_ENDS["json"]
    reply = 'Here you are:\n```json\n{"goals": [{"name": "On", "args": ["object_6", "position 32"]}]}\n```'
    goals, _, heard = talk("Do it.", [reply], front_end=json_)
    assert goals == ["On(object_6, position_32)"]
    assert "one JSON object" in heard[0][0][1]
    question = '{"question": "Which one?", "candidates": ["object_1", "object 2"]}'
    assert asked("Do it.", [question], front_end=json_) == ("E140", ("object_1", "object_2"))
    goals, _, _ = talk("Do it.", [question, reply], ["object 1"], front_end=json_)
    assert goals == ["On(object_6, position_32)"]
    wrong = '{"goals": [{"name": "Over", "args": ["object_6"]}]}'
    goals, kinds, heard = talk("Do it.", [wrong, reply], corrections=1, front_end=json_)
    assert "complaint" in kinds
    assert "`Over` is no goal" in heard[1][-1][1]
