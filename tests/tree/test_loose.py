"""What is no XML, and BehaviorTree.CPP reads it all the same: scripts with `&&` and `<` in them."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from llmbt.main import main
from llmbt_ir.btcpp.check import check_document
from llmbt_ir.btcpp.document import parse_document
from llmbt_ir.btcpp.loose import escaped
from llmbt_ir.diagnostics import LlmbtError
from tests.tree.corpus import GUARD, SEQ, tree

LOOSE = """<root BTCPP_format="4" main_tree_to_execute="Main">
<!-- a < b && c: nothing to mend, "here" -->
<BehaviorTree ID="Main"><Sequence>
  <Script code="a:=1; b:=2; c:=3 &amp; 1"/>
  <ScriptCondition code='a<b && c < 4'/>
  <AlwaysSuccess _skipIf="a < b && b < a" name="x > y"/>
</Sequence></BehaviorTree></root>
"""
STRICT = LOOSE.replace("'a<b && c < 4'", '"a&lt;b &amp;&amp; c &lt; 4"').replace(
    "a < b && b < a", "a &lt; b &amp;&amp; b &lt; a"
)


def test_it_is_read_as_it_is_meant() -> None:
    document = parse_document(LOOSE.encode())
    assert document == parse_document(STRICT.encode())
    assert (document.loose, parse_document(STRICT.encode()).loose) == ((5, 6), ())
    assert escaped(LOOSE.encode()) == (
        STRICT.replace('"a&lt;b &amp;&amp; c &lt; 4"', "'a&lt;b &amp;&amp; c &lt; 4'").encode(),
        (5, 6),
    )
    assert parse_document(document.write()) == document


def test_the_real_engine_reads_it_too(tmp_path: Path) -> None:
    """And runs it to success: the conditions mean what they say."""
    (tmp_path / "loose.xml").write_text(LOOSE)
    code = (
        "import sys, behaviortreepy as bt\n"
        "factory = bt.BehaviorTreeFactory()\n"
        "tree = factory.create_tree_from_text(open(sys.argv[1]).read())\n"
        "print(tree.tick_exactly_once().name)\n"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "loose.xml")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert done.stdout.split() == ["SUCCESS"], done.stderr


def test_it_is_a_warning_with_its_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "loose.xml"
    path.write_text(LOOSE)
    assert main(["tree", "check", str(path)]) == 0
    said = capsys.readouterr().out
    assert said.count("warning[T216]") == 2 and "line 5" in said and "0 errors" in said
    assert main(["tree", "show", str(path)]) == 0
    assert "a<b && c < 4" in capsys.readouterr().out
    (tmp_path / "strict.xml").write_text(STRICT)
    assert main(["tree", "diff", str(path), str(tmp_path / "strict.xml")]) == 0


@pytest.mark.parametrize("text", ['<a b="<>', "<a b='&&' c='", "<a>&&", "<a><b c='&'></a>", "<!DOCTYPE a><a b='&&'/>"])
def test_what_nobody_reads_stays_refused(text: str) -> None:
    with pytest.raises(LlmbtError) as fault:
        parse_document(text.encode())
    assert fault.value.diagnostics[0].code in ("E003", "E005")


@given(st.text(alphabet="<>&;\"'a =!-[]?/\n", max_size=80))
def test_nothing_is_changed_where_nothing_is_loose(text: str) -> None:
    data = text.encode()
    strict, lines = escaped(data)
    assert (strict == data) == (not lines)
    assert escaped(strict) == (strict, ())
    assert strict.replace(b"&amp;", b"&").replace(b"&lt;", b"<") == data.replace(b"&amp;", b"&").replace(b"&lt;", b"<")


@pytest.mark.parametrize("piece", ['<a "', "<a '", '<a b="', "<!--", "&", '<a b="&&"', "<![CDATA[", "<?"])
def test_hostile_texts_take_no_time(piece: str) -> None:
    start = time.process_time()
    escaped((piece * 20_000).encode())
    assert time.process_time() - start < 3


def test_a_type_that_a_program_may_register_is_no_error() -> None:
    """A file without TreeNodesModel leaves that open, but for names that are almost a built-in one's."""

    def codes(body: str) -> list[str]:
        return [d.code for d in check_document(parse_document(tree(body, rest="").encode()))]

    assert codes(f"<LoopPoses>{GUARD}</LoopPoses>")[0] == "T209"
    assert "T109" not in codes(f"<LoopPoses>{GUARD}</LoopPoses>")
    assert "T109" in codes(SEQ.format(GUARD).replace("ReactiveSequence", "ReactiveSequenc"))
