"""What an executor comes to on a set of episodes: judged by the truth, never by its word."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from llmbt.experiment.referee import Executor, Played, play
from llmbt.experiment.tables import Table, rate, share
from llmbt_ir.condition import satisfied
from llmbt_runtime.baselines import EXECUTORS, Limits, run
from llmbt_runtime.episodes import KINDS, Episode, reachable
from llmbt_runtime.episodes.written import episode_id
from llmbt_runtime.outcome import Outcome

__all__ = ["MAX_TICKS", "Scored", "in_process", "judge", "played_by", "score_table"]

MAX_TICKS = 600
"""Of an episode: a minute of simulated time."""
OURS = Limits(MAX_TICKS, 20_000, 100, 10_000, attempts=10, settle_s=0.0)
"""For our own methods in the same process."""


@dataclass(frozen=True, slots=True)
class Scored:
    """One episode. `right`: solved, or called UNSOLVABLE in a state where it is so; `wrong`: a verdict that is not
    true."""

    id: str
    kind: str
    solvable: bool | None
    verdict: str
    fault: str
    success: bool
    right: bool
    wrong: bool
    ticks: int
    actions: int
    answer_s: float

    def as_json(self) -> dict[str, Any]:
        """A line of the score."""
        return asdict(self)


def played_by(command: str, episodes: Iterable[Episode], patience_s: float) -> Iterator[tuple[Episode, Played]]:
    """Somebody's executor, as a process, through the protocol."""
    with Executor(command, patience_s) as executor:
        for episode in episodes:
            yield episode, play(episode, executor, MAX_TICKS)


def in_process(method: str, episodes: Iterable[Episode]) -> Iterator[tuple[Episode, Played]]:
    """One of our own methods, without a process between: the same world, the same limit."""
    assert method in EXECUTORS
    for episode in episodes:
        world = episode.world()
        found = run(method, world, episode.fresh(), episode.goals, OURS)
        world.halt()
        told = {Outcome.SUCCESS: "SUCCESS", Outcome.UNSOLVABLE: "UNSOLVABLE"}.get(found.outcome, "GIVE_UP")
        yield episode, Played(told, "", world.truth(), found.ticks, len(found.actions), 0.0)


def judge(episode: Episode, played: Played) -> Scored:
    """A game against what is true: of the episode, and of the state in which the verdict was given."""
    success = satisfied(episode.goals, played.facts)
    unsolvable, right = played.verdict == "UNSOLVABLE", success
    wrong = played.verdict == "SUCCESS" and not success
    if unsolvable:
        truth = reachable(episode.domain, played.facts, episode.goals)
        truth = episode.solvable if truth is None else truth
        right, wrong = truth is False, truth is True
    return Scored(
        episode_id(episode),
        episode.kind,
        episode.solvable,
        played.verdict,
        played.fault,
        success,
        right and not played.fault,
        wrong,
        played.ticks,
        played.actions,
        round(played.answer_s, 4),
    )


def score_table(scored: Sequence[Scored], name: str) -> Table:
    """A line for each kind; the score is the mean over the kinds of the share that is right."""
    rows, shares = [], []
    for kind in KINDS:
        mine = [s for s in scored if s.kind == kind]
        if not mine:
            continue
        rows.append((kind, *_row(mine)))
        shares.append(sum(s.right for s in mine) / len(mine))
    rows.append(("all", *_row(scored)))
    mean = sum(shares) / len(shares) if shares else 0.0
    return Table(
        "score",
        f"{name}: score {100 * mean:.1f}",
        (
            "kind", "right (Wilson 95 %)", "right of solvable", "of unsolvable", "of open", "wrong verdicts", "faults",
            "ticks (mean)", "actions (mean)",
        ),
        tuple(rows),
        (
            f"{len(scored)} episodes. The score is the mean over the kinds of the share that is right, times 100. "
            "Right: the goals hold at the end, or it is called UNSOLVABLE in a state from which they cannot be "
            "reached. Wrong: a verdict that is not true. Solvable, unsolvable: whatever happens when; open: it "
            "depends. Ticks and actions: of the episodes solved.",
        ),
    )  # fmt: skip


def _row(scored: Sequence[Scored]) -> tuple[str, ...]:
    able = [s for s in scored if s.solvable is True]
    unable = [s for s in scored if s.solvable is False]
    open_ = [s for s in scored if s.solvable is None]
    won = [s for s in scored if s.success]
    return (
        rate(sum(s.right for s in scored), len(scored)),
        share(sum(s.right for s in able), len(able)),
        share(sum(s.right for s in unable), len(unable)),
        share(sum(s.right for s in open_), len(open_)),
        str(sum(s.wrong for s in scored)),
        str(sum(bool(s.fault) for s in scored)),
        f"{sum(s.ticks for s in won) / len(won):.1f}" if won else "–",
        f"{sum(s.actions for s in won) / len(won):.1f}" if won else "–",
    )


def as_document(scored: Sequence[Scored], table: Table) -> Mapping[str, Any]:
    """What `--json` prints."""
    return {"table": table.as_json(), "episodes": [s.as_json() for s in scored]}
