"""Action template libraries: every fault has a line and a suggestion; what cannot be meant is a warning."""

from __future__ import annotations

from pathlib import Path

import pytest

from llmbt_atl.library import Library, check_library, library_names, load_library, parse_library
from llmbt_ir.diagnostics import Diagnostic, LlmbtError, Severity

HEAD = """<library name="l">
<types><type name="thing"/><type name="cup" parent="thing"/><type name="spot"/></types>
<conditions>
<condition name="On" goal="true"><param name="target" type="thing"/><param name="spot" type="spot"/></condition>
<condition name="Held"><param name="target" type="thing"/></condition>
<condition name="Empty"/>
</conditions>
<constants><constant name="home" type="spot"/></constants>
<variables>
<variable name="hand"><Empty/><Held target="*"/></variable>
<variable name="seat"><param name="spot" type="spot"/><On target="*" spot="{spot}"/></variable>
</variables>
<templates>
"""
PUT = """<template name="put"><param name="target" type="thing"/><param name="spot" type="spot"/>
<hold><Held target="{target}"/></hold>
<post><On target="{target}" spot="{spot}"/><Empty/></post></template>
<template name="take"><param name="target" type="thing"/><param name="spot" type="spot"/>
<start><Empty/></start><hold><On target="{target}" spot="{spot}"/></hold>
<post><Held target="{target}"/></post></template>
"""


def library(templates: str, head: str = HEAD) -> Library:
    return parse_library(f"{head}{templates}</templates></library>".encode(), "l.xml")


def faults(templates: str, head: str = HEAD) -> tuple[Diagnostic, ...]:
    with pytest.raises(LlmbtError) as caught:
        library(templates, head)
    return caught.value.diagnostics


def template(hold: str = "", post: str = "<Empty/>", more: str = "") -> str:
    params = '<param name="t" type="thing"/><param name="s" type="spot"/>'
    return f'<template name="x">\n{params}\n{more}<hold>{hold}</hold>\n<post>{post}</post>\n</template>'


def test_the_shipped_libraries_load_without_a_warning() -> None:
    assert "cargo_sorting" in library_names()
    for name in library_names():
        assert list(check_library(load_library(name))) == []


def test_cargo_sorting_can_what_the_paper_asks_for() -> None:
    lib = load_library("cargo_sorting")
    assert {"pick", "place", "move_aside", "clear_away", "put_down", "release", "recover"} <= set(lib.templates)
    assert [t.name for t in lib.achievers("Clear")] == ["clear_away", "look"]
    assert [t.name for t in lib.templates.values() if t.senses] == ["look"]
    assert {t.name for t in lib.achievers("HandEmpty")} >= {"place", "put_down", "release"}


def test_a_small_library() -> None:
    lib = library(PUT)
    assert lib.is_a("cup", "thing") and not lib.is_a("spot", "thing")
    assert lib.parameters("put") == ("target", "spot") and lib.parameters("Empty") == ()
    assert [t.name for t in lib.achievers("Held")] == ["take"]
    assert lib.conditions["On"].goal and not lib.conditions["Held"].goal
    assert list(check_library(lib)) == []


@pytest.mark.parametrize(
    ("code", "line", "hint", "text"),
    [
        ("E033", 16, "did you mean Held?", template('<Heldd target="{t}"/>')),
        ("E033", 17, "declare it", template(post="<Zzzzzz/>")),
        ("E034", 16, "", template('<Held thing="{t}"/>')),
        ("E034", 16, "", template("<On target='{t}'/>")),
        ("E034", 16, "", template('<Empty target="{t}"/>')),
        (
            "E034",
            18,
            "under <post>",
            template().replace("</post>\n", "</post>\n<delete><Inverter><Empty/></Inverter></delete>"),
        ),
        ("E035", 16, "declare <param", template('<Held target="{target_7}"/>')),
        ("E035", 16, "did you mean {t}?", template('<Held target="{tt}"/>')),
        ("E035", 16, "write {t}?", template('<Held target="t"/>')),
        ("E035", 16, "", template('<Held target="*"/>')),
        ("E035", 16, "", template(more='<unequal first="t" second="u"/>\n')),
        ("E032", 14, "did you mean thing?", '<template name="x"><param name="t" type="thingg"/><post/></template>'),
        ("E031", 20, "", PUT + '<template name="put"><post><Empty/></post></template>'),
        ("E031", 14, "", '<template name="Held"><post><Empty/></post></template>'),
        ("E006", 14, "", '<template name="x"/>'),
        ("E006", 14, "", '<template name="x y"><post/></template>'),
    ],
)
def test_faults_of_templates(code: str, line: int, hint: str, text: str) -> None:
    found = faults(text)
    assert [(d.code, d.span and d.span.line) for d in found] == [(code, line)]
    assert hint in found[0].help


@pytest.mark.parametrize(
    ("code", "line", "old", "new"),
    [
        ("E031", 6, '<condition name="Empty"/>', '<condition name="Empty"/><condition name="Held"/>'),
        ("E032", 2, '<type name="cup" parent="thing"/>', '<type name="cup" parent="thin"/>'),
        ("E038", 2, '<type name="thing"/>', '<type name="thing" parent="cup"/>'),
        ("E032", 8, 'type="spot"/></constants>', 'type="spots"/></constants>'),
        ("E035", 11, 'spot="{spot}"/></variable>', 'spot="*"/></variable>'),
        ("E033", 10, "<Empty/><Held", "<Emty/><Held"),
    ],
)
def test_faults_of_declarations(code: str, line: int, old: str, new: str) -> None:
    found = faults(PUT, HEAD.replace(old, new, 1))
    assert (found[0].code, found[0].span and found[0].span.line) == (code, line)


def test_all_faults_are_told_at_once() -> None:
    assert [d.code for d in faults(template("<Nope/><Held/>", "<Gone/>"))] == ["E033", "E033", "E034"]


def test_a_post_that_nothing_needs_and_no_goal_may_name() -> None:
    (found,) = check_library(library(PUT.replace("<start><Empty/></start>", "")))
    assert (found.code, found.severity, found.span and found.span.line) == ("W036", Severity.WARNING, 16)
    assert "Empty" in found.title and 'goal="true"' in found.help


@pytest.mark.parametrize(
    ("hold", "why"),
    [
        ('<Empty/><Held target="{t}"/>', "hand"),
        ('<Held target="{t}"/><Inverter><Held target="{t}"/></Inverter>', "Held and not Held"),
        ('<On target="{t}" spot="{s}"/><On target="{u}" spot="{s}"/>', "seat"),
    ],
)
def test_a_template_that_can_never_apply(hold: str, why: str) -> None:
    text = template(hold, more='<param name="u" type="cup"/>')
    found = [d for d in check_library(library(PUT + text)) if d.code == "W037"]
    assert [(d.severity, d.span and d.span.line) for d in found] == [(Severity.WARNING, 20)]
    assert why in found[0].title and "`x`" in found[0].title


def test_two_things_on_a_place_that_may_hold_many_are_no_contradiction() -> None:
    lib = load_library("cargo_sorting")
    text = Path("atl/llmbt_atl/data/cargo_sorting.xml")
    data = (Path(__file__).parents[2] / text).read_text()
    tidy = """<template name="tidy"><param name="a" type="object"/><param name="b" type="object"/>
      <param name="place" type="region"/>
      <start><HandEmpty/><On target="{a}" place="{place}"/><On target="{b}" place="{place}"/></start>
      <post><Holding target="{a}"/></post></template></templates>"""
    assert list(check_library(parse_library(data.replace("</templates>", tidy).encode(), "c.xml"))) == []
    slot = tidy.replace('type="region"', 'type="slot"')
    assert [d.code for d in check_library(parse_library(data.replace("</templates>", slot).encode(), "c.xml"))] == [
        "W037"
    ]
    assert lib.is_a("slot", "spot")


def test_a_library_by_name_or_path(tmp_path: Path) -> None:
    path = tmp_path / "own.xml"
    path.write_text(f"{HEAD}{PUT}</templates></library>")
    assert load_library(str(path)).name == "l"
    assert load_library("own.xml", beside=tmp_path).name == "l"
    for wanted, code in (("cargo_sortin", "E030"), ("nowhere.xml", "E001")):
        with pytest.raises(LlmbtError) as caught:
            load_library(wanted)
        assert caught.value.diagnostics[0].code == code
    with pytest.raises(LlmbtError) as caught:
        load_library("cargo_sortin")
    assert caught.value.diagnostics[0].candidates == ("cargo_sorting",)


@pytest.mark.parametrize(
    ("code", "data"),
    [
        ("E003", b""),
        ("E004", b"<a>" * 100_000),
        ("E005", b'<!DOCTYPE l [<!ENTITY e "x">]><library name="l"/>'),
        ("E006", b"<root/>"),
    ],
)
def test_hostile_libraries_are_refused(code: str, data: bytes) -> None:
    with pytest.raises(LlmbtError) as caught:
        parse_library(data, "l.xml")
    assert caught.value.diagnostics[0].code == code
