"""Spans, exit codes, words said back, the tree: what a golden line does not show."""

from __future__ import annotations

from dataclasses import replace

import pytest

from llmbt_atl.library import Library
from llmbt_compiler.parsing import Extent, LabelledStep, NoteKind, parse, say, say_goals
from llmbt_ir.condition import Condition
from llmbt_ir.diagnostics import ExitCode, Severity
from llmbt_ir.semantic_map import SemanticMap
from llmbt_ir.tree import Kind, goal_tree
from tests.parsing.labelled import labelled, steps

Place = tuple[SemanticMap, Library]


def test_a_goal_points_at_its_words_in_step_and_reply(cargo: Place) -> None:
    reply = "Sure!\n1. Pick up object 1 and place it on position 12.\nBye."
    step = labelled("A[Pick] up T[object 1] and A[place] T[it] on D[position 12].")
    at = reply.index("Pick")
    step = replace(step, reply=Extent(at, at + len(step.text)))
    (goal,) = parse([step], *cargo).goals
    assert goal.words == goal.span.cut(step.text) == "place it on position 12"
    assert goal.reply is not None
    assert goal.reply.cut(reply) == goal.words


def test_the_reply_is_found_through_runs(cargo: Place) -> None:
    reply = "1. **Place** object 1 on `position 12`"
    text = "Place object 1 on position 12"
    runs = ((0, reply.index("Place")), (5, reply.index(" object")), (18, reply.index("position")))
    step = replace(labelled("A[Place] T[object 1] on D[position 12]"), reply=Extent(3, len(reply)), runs=runs)
    assert step.text == text
    (goal,) = parse([step], *cargo).goals
    assert goal.reply is not None
    assert goal.reply.cut(reply) == "Place** object 1 on `position 12"


def test_a_step_changed_by_the_filter_is_pointed_at_as_a_whole() -> None:
    step = LabelledStep(1, "short", reply=Extent(10, 40))
    assert step.in_reply(Extent(0, 2)) == Extent(10, 40)
    assert LabelledStep(1, "short").in_reply(Extent(0, 2)) is None


def test_columns_count_from_one_and_lines_are_steps(cargo: Place) -> None:
    (fault,) = parse(steps("A[Wait].", "A[Unscrew] the T[cap]."), *cargo).diagnostics
    assert fault.span is not None
    assert (fault.span.source, fault.span.line, fault.span.column, fault.span.end_column) == (
        "steps.json", 2, 1, 8,
    )  # fmt: skip
    assert fault.span.text == "Unscrew the cap."
    assert "llmbt atl show cargo_sorting" in fault.help


@pytest.mark.parametrize(
    ("step", "code"),
    [
        ("A[Place] T[object 1] on D[position 12].", ExitCode.OK),
        ("A[Place] T[banana] on D[position 12].", ExitCode.BAD_INPUT),
        ("A[Place] T[object 9] on D[position 12].", ExitCode.UNCLEAR),
        ("A[Place] the T[green block] on D[position 12].", ExitCode.UNCLEAR),
        ("A[Place] T[object 1].", ExitCode.UNCLEAR),
        ("A[Place] all T[objects] on D[level 1].", ExitCode.NO_SUCCESS),
        ("A[Pour] T[object 1] on D[level 1].", ExitCode.BAD_INPUT),
        ("A[Wait].", ExitCode.BAD_INPUT),
    ],
)
def test_exit_codes(step: str, code: ExitCode, cargo: Place) -> None:
    assert parse(steps(step), *cargo).exit_code is code


def test_all_complaints_at_once(cargo: Place) -> None:
    result = parse(steps("A[Pour] T[tea].", "A[Place] T[object 9] on D[level 1].", "A[Place] T[object 1]."), *cargo)
    assert [d.code for d in result.diagnostics] == ["E303", "E301", "E305"]
    assert result.exit_code is ExitCode.BAD_INPUT


def test_below_the_threshold_is_left_out_on_demand(cargo: Place) -> None:
    given = steps("A[Place] T[object 1] on D[position 12].", "A[Place] T~0.2[object 2] on D[position 13].")
    strict, partial = parse(given, *cargo), parse(given, *cargo, partial=True)
    assert [d.severity for d in strict.diagnostics] == [Severity.ERROR]
    assert [d.severity for d in partial.diagnostics] == [Severity.WARNING]
    assert partial.ok
    assert strict.conditions == partial.conditions == (Condition("On", ("object_1", "position_12")),)
    assert parse(given, *cargo, threshold=0.1).ok


def test_what_is_left_out_is_told(cargo: Place) -> None:
    result = parse(steps("A[Approach] the D[refrigerator].", "A[Pick] up T[object 1]."), *cargo)
    assert result.ok
    assert [n.kind for n in result.notes] == [NoteKind.LEFT_OUT]


def test_goals_said_back(cargo: Place, home: Place) -> None:
    result = parse(steps("A[Place] T[object 1] on D[position 12].", "A[Clear] T[position 13]."), *cargo)
    assert say_goals(result.goals, cargo[1]) == ("object_1 is on position_12", "position_13 is free")
    assert say(Condition("Near", ("bar",)), home[1]) == "the robot is near bar"
    assert say(Condition("Odd", ("x",)), home[1]) == "Odd(x)"


def test_the_initial_tree(cargo: Place) -> None:
    result = parse(steps("A[Place] T[object 1] on D[position 12].", "A[Place] T[object 2] on D[position 13]."), *cargo)
    tree = goal_tree(((*result.conditions, result.conditions[0]),))
    assert tree.root == "root"
    assert tree["root"].kind is Kind.SEQUENCE
    assert tree["root"].children == ("g1", "g2")
    assert tuple(tree[i].condition for i in tree["root"].children) == result.conditions
    with pytest.raises(ValueError, match="at least one goal"):
        goal_tree(())
