"""Episodes stay what they are, the referee is fair to good clients and hard on bad ones, and judges by the truth."""

from __future__ import annotations

import hashlib
import json
import sys
from pathlib import Path

import pytest

from llmbt.experiment.episode_set import committed, read_key, sealed_seed, set_of
from llmbt.experiment.referee import Executor, play
from llmbt.experiment.score import in_process, judge, played_by, score_table
from llmbt.main import main
from llmbt_ir.diagnostics import LlmbtError
from llmbt_runtime.episodes import episode
from llmbt_runtime.episodes.written import read_episodes, write_episode

CLIENT = Path(__file__).parents[2] / "docs" / "examples" / "benchmark_client.py"
KINDS = ("strips", "coins", "cycles", "rooms")


def written(*episodes) -> bytes:
    return "".join(write_episode(e) + "\n" for e in episodes).encode()


@pytest.mark.parametrize("kind", ["strips", "cargo", "obstacles", "rooms", "threats", "negation", "alternatives"])
@pytest.mark.parametrize("rough", [False, True])
def test_an_episode_reads_back_as_it_was_and_runs_as_it_did(kind, rough):
    before = episode(kind, 4, events=3, rough=rough)
    (after,) = read_episodes(written(before), "x")
    assert write_episode(after) == write_episode(before)
    assert (after.facts, after.goals, after.events) == (before.facts, before.goals, before.events)
    games = [next(in_process("loop", [e]))[1] for e in (before, after)]
    assert games[0] == games[1]


def test_the_open_set_is_the_committed_one():
    """By the first episode of each cell; `llmbt experiment episodes` holds the whole set against its hash."""
    told = committed()["open"]
    lines = [write_episode(e) for e in set_of(1, None)]
    assert len(lines) * committed()["per_cell"] == told["episodes"]
    assert hashlib.sha256("".join(f"{x}\n" for x in lines).encode()).hexdigest() == told["first_sha256"]


def test_the_sealed_set_opens_with_its_key_alone(tmp_path):
    (tmp_path / "key").write_text("guess\n")
    with pytest.raises(LlmbtError, match="E411"):
        read_key(tmp_path / "key")
    seeds = {sealed_seed(b"k", cell, n) for cell in "ab" for n in range(3)}
    assert len(seeds) == 6
    assert sealed_seed(b"k", "a", 0) == sealed_seed(b"k", "a", 0) != sealed_seed(b"l", "a", 0)


def test_a_damaged_file_is_told_with_its_line():
    good = written(episode("coins", 0))
    for bad in (b"rubbish\n", good.replace(b'"format":1', b'"format":2'), good.replace(b"Coin(", b"(", 1)):
        with pytest.raises(LlmbtError, match="E410") as caught:
            read_episodes(good + bad, "f")
        assert caught.value.diagnostics[0].span.line == 2


class TestReferee:
    def test_the_example_client_solves_what_can_be_solved_and_says_what_cannot(self):
        episodes = [
            episode(k, s, events=e, rough=r) for k in KINDS for s in (0, 4) for e in (0, 3) for r in (False, True)
        ]
        scored = [judge(*game) for game in played_by(f"{sys.executable} {CLIENT}", episodes, 20)]
        assert [s.id for s in scored if not s.right] == []
        assert {s.verdict for s in scored} == {"SUCCESS", "UNSOLVABLE"}
        assert score_table(scored, "client").title == "client: score 100.0"

    @pytest.mark.parametrize(
        ("code", "says"),
        [
            ("import time; input(); time.sleep(30)", "no answer within"),
            ("input(); print('hello')", "no JSON"),
            ("input()", "ended"),
            ('input(); print(\'{"do": "fly"}\')', "unknown: do fly"),
            ('input(); print(\'{"do": "start", "action": "fly(home)"}\')', "no such action: fly(home)"),
            ('input(); print(\'{"do": "end", "verdict": "MAYBE"}\')', "no verdict"),
            ("input(); print('x' * 5_000_000)", "megabytes"),
        ],
    )
    def test_a_bad_client_loses_the_episode_and_no_more(self, code, says, tmp_path):
        path = tmp_path / "client.py"
        path.write_text(code + "\nimport sys; sys.stdout.flush()\n")
        two = [episode("strips", 0), episode("strips", 1)]
        scored = [judge(*game) for game in played_by(f"{sys.executable} {path}", two, 1.0)]
        assert len(scored) == 2
        assert all(says in s.fault and not s.right for s in scored)

    def test_no_such_command(self):
        with pytest.raises(LlmbtError, match="E412"), Executor("/nowhere/at/all", 1.0) as executor:
            play(episode("strips", 0), executor, 10)

    def test_a_verdict_is_judged_and_not_believed(self, tmp_path):
        path = tmp_path / "boaster.py"
        path.write_text(
            "import sys\nfor line in sys.stdin:\n  if '\"result\"' not in line:\n"
            '    print(\'{"do": "end", "verdict": "VERDICT"}\', flush=True)\n'
        )
        for verdict in ("SUCCESS", "UNSOLVABLE"):
            path.write_text(path.read_text().replace("VERDICT", verdict))
            (scored,) = (judge(*g) for g in played_by(f"{sys.executable} {path}", [episode("strips", 0)], 5))
            assert scored.wrong
            assert not scored.right
            path.write_text(path.read_text().replace(verdict, "VERDICT"))

    def test_an_endless_client_is_stopped_by_the_ticks(self, tmp_path):
        path = tmp_path / "waiter.py"
        path.write_text('import sys\nfor line in sys.stdin:\n  print(\'{"do": "wait"}\', flush=True)\n')
        with Executor(f"{sys.executable} {path}", 5) as executor:
            played = play(episode("strips", 0), executor, 25)
        assert (played.ticks, played.verdict, played.fault) == (25, "", "")


def test_commands(tmp_path, capsys):
    file = tmp_path / "e.jsonl"
    file.write_bytes(written(*(episode(k, 0, events=1) for k in KINDS)))
    assert main(["experiment", "score", str(file), "loop", "--json", "-o", str(tmp_path / "s.json")]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [e["right"] for e in told["episodes"]] == [True] * 4
    assert json.loads((tmp_path / "s.json").read_text())["table"] == told["table"]
    assert main(["experiment", "score", str(tmp_path / "no.jsonl"), "loop"]) == 1
