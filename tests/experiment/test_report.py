"""Pages stand on their own, links lead somewhere, and tables say the same in every form."""

from __future__ import annotations

import csv
import io
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from llmbt.experiment.cases import load_experiment
from llmbt.experiment.figures import figures_of
from llmbt.experiment.ledger import read_trials
from llmbt.experiment.paper_study import PaperOrder, run_paper
from llmbt.experiment.plan import Setting
from llmbt.experiment.results import write_results
from llmbt.experiment.run_page import run_page
from llmbt.experiment.tables import Table, rate
from llmbt.experiment.timeline import timeline
from llmbt.experiment.workers import Pool
from llmbt.main import main
from llmbt_ir.diagnostics import LlmbtError

RUNS = Path(__file__).parents[1] / "tree" / "runs"
HOSTILE = "<script>alert(1)</script> & \"quoted\" 'text' </pre>"


class Page(HTMLParser):
    """What a browser would load, and the text."""

    def __init__(self, data: bytes) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.tags: list[str] = []
        self.text = ""
        self.feed(data.decode())

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.loads += [v for k, v in attrs if k in ("src", "href", "srcset", "data", "action") and v]

    def handle_data(self, data):
        self.text += data


@pytest.mark.parametrize("run", sorted(p.name for p in RUNS.iterdir()))
def test_a_run_s_page_needs_nothing_else_and_tells_the_run(run):
    page = Page(run_page(RUNS / run))
    assert all(x.startswith("data:") for x in page.loads)
    assert not {"script", "link", "iframe"} & set(page.tags)
    for word in ("v001", "it will work", "SUCCESS", "pick(object_1, sorting_area)", "yes"):
        assert word in page.text
    assert page.tags.count("svg") == 1
    assert "disturbance" in page.text


def test_words_of_users_are_words(tmp_path):
    line = {
        "key": "k",
        "verdict": "refused",
        "kind": "unclear",
        "register": "terse",
        "codes": ["E301"],
        "says": HOSTILE,
    }
    page = Page(run_page(tmp_path, line=line, text=HOSTILE))
    assert "script" not in page.tags
    assert page.text.count(HOSTILE) == 2
    assert Page(Table("n", HOSTILE, (HOSTILE,), ((HOSTILE,),), (HOSTILE,)).html().encode()).text.count(HOSTILE) == 4


def test_no_run_is_told(tmp_path):
    with pytest.raises(LlmbtError, match="E080"):
        run_page(tmp_path)
    assert main(["report", str(tmp_path), "--json"]) == 1


def test_a_timeline_has_a_bar_for_each_action_and_a_line_for_each_mark():
    done = [{"name": "pick", "args": ["a"], "result": "SUCCESS", "started_s": k, "ended_s": k + 1.0} for k in range(3)]
    drawn = timeline(done, [(1.0, "disturbance", "drop of a"), (2.0, "update", "v002")], 4.0)
    assert drawn.count("<rect") == 3
    assert drawn.count("stroke-dasharray") == 2


TABLE = Table(
    "some_table", "A & B", ("what", "share_1"), (("50 % | half", rate(1, 2)), ("ä→b", "–")), ("A note, 100 %.",)
)


class TestTable:
    def test_markdown(self):
        lines = ["## A & B", "", "| what | share_1 |", "|---|---|", "| 50 % \\| half | 1/2 = 50.0 % (9–91 %) |"]
        assert TABLE.markdown().splitlines() == [*lines, "| ä→b | – |", "", "A note, 100 %."]

    def test_csv_reads_back(self):
        rows = list(csv.reader(io.StringIO(TABLE.csv())))
        assert rows == [list(TABLE.head), *map(list, TABLE.rows)]

    def test_latex_escapes_what_latex_reads(self):
        text = TABLE.latex()
        assert "A \\& B" in text
        assert "share\\_1" in text
        assert "50 \\% | half & 1/2 = 50.0 \\% (9--91 \\%) \\\\" in text
        assert not re.search(r"(?<!\\)[%#_](?!caption)", re.sub(r"\\label\{[^}]*\}", "", text))


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study") / "e"
    order = PaperOrder(trials=7, settings=(Setting("symbolic"),))
    run_paper(load_experiment("cargo_sorting"), order, folder, Pool(), quiet=True)
    return folder


@pytest.mark.slow
class TestStudy:
    def test_every_trial_has_a_page_and_every_link_leads_to_one(self, study):
        page = Page((study / "index.html").read_bytes())
        links = [x for x in page.loads if not x.startswith("data:")]
        assert len(links) == 7
        assert all((study / link).is_file() for link in links)
        assert "authored" in page.text

    def test_writing_the_results_again_changes_nothing(self, study):
        before = {p.name: p.read_bytes() for p in study.rglob("*") if p.is_file()}
        write_results(study)
        assert {p.name: p.read_bytes() for p in study.rglob("*") if p.is_file()} == before

    def test_titles_say_authored_and_the_reasoning_column_too(self, study):
        text = (study / "tables/cargo_sorting_as_the_paper.md").read_text()
        assert text.startswith("## Cargo sorting, as the paper counts, given authored replies")
        rows = [line.split(" | ") for line in text.splitlines() if line.startswith("| ")][1:]
        assert {r[2] for r in rows} == {"authored"}
        assert rows[-1][8:] == ["87/100", "90/100", "88/90", "87/88 |"]
        assert "two (cases 2 and 5)" in text

    def test_no_time_and_no_path_in_the_table(self, study):
        text = (study / "table.json").read_text()
        assert "wall" not in text
        assert str(study) not in text

    def test_results_as_one_document(self, study, tmp_path):
        out = tmp_path / "results.md"
        assert main(["report", str(study), "--results", str(out), "--json"]) == 0
        text = out.read_text()
        for word in ("# Results", "- machine:", "- date: 20", "llmbt experiment cargo_sorting --repeat 1", "7 trials"):
            assert word in text
        assert str(study) not in text

    def test_a_report_of_an_experiment_that_is_not_over_says_so(self, study, tmp_path):
        part = tmp_path / "part"
        part.mkdir()
        (part / "plan.json").write_bytes((study / "plan.json").read_bytes())
        lines = (study / "trials.jsonl").read_bytes().splitlines(keepends=True)
        (part / "trials.jsonl").write_bytes(b"".join(lines[:3]) + lines[3][:10])
        assert main(["report", str(part), "--results", str(tmp_path / "r.md")]) == 0
        assert "3 of the 7 trials planned" in (tmp_path / "r.md").read_text()


@pytest.mark.extras
def test_figures_are_drawn_and_repeat(study):
    pytest.importorskip("matplotlib")
    lines = list(read_trials(study))
    one, two = figures_of(lines, "paper"), figures_of(lines, "paper")
    assert [f.name for f in one] == ["success", "growth", "recovery"]
    assert [f.svg for f in one] == [f.svg for f in two]
    assert all(f.png.startswith(b"\x89PNG") for f in one)
    assert len(Page((study / "index.html").read_bytes()).tags) > 20
