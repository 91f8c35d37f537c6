"""`llmbt experiment`: trials in numbers, and the tables they come to."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from llmbt.options import force, json_flag, quiet

if TYPE_CHECKING:
    from llmbt.experiment.workers import Pool

__all__ = ["experiment"]


class Experiments(click.Group):
    """The subcommands, and beside them every experiment: a shipped one by its name, any other by the path of its
    file."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Shipped experiments first."""
        from llmbt.experiment.cases import experiment_names

        return [*experiment_names(), *super().list_commands(ctx)]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """A subcommand; for another word the command that runs the experiment of that name."""
        found = super().get_command(ctx, cmd_name)
        if found is not None or cmd_name.startswith("-"):
            return found
        return _of_cases(cmd_name)


@click.group(cls=Experiments, subcommand_metavar="NAME|FILE.xml [OPTIONS]")
def experiment() -> None:
    """Many trials: the paper's tables with ours beside them, other ways to execute, a benchmark for others."""


def pool_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """-o, --resume, --workers, --backend, --scheduler, --seed, --trials."""
    for option in (
        click.option("--trials", type=click.IntRange(1), default=None, help="A sample of so many trials."),
        click.option("--seed", type=int, default=0, show_default=True, envvar="LLMBT_SEED", help="Of all chance."),
        click.option("--scheduler", default="", metavar="HOST:PORT", help="With --backend dask: the scheduler."),
        click.option("--backend", type=click.Choice(["processes", "dask"]), default="processes", show_default=True),
        click.option("--workers", type=click.IntRange(1), default=1, show_default=True, help="Processes."),
        click.option("--resume", is_flag=True, help="Go on with what DIR holds."),
        click.option(
            "-o",
            "--out",
            "folder",
            required=True,
            type=click.Path(path_type=Path),
            metavar="DIR",
            help="An empty folder, or with --resume one that was begun.",
        ),
    ):
        command = option(command)
    return command


def pool_of(workers: int, backend: str, scheduler: str) -> Pool:
    """The pool that the options ask for. A usage fault where they do not go together."""
    from llmbt.experiment.workers import Pool

    if (backend == "dask") != bool(scheduler):
        raise click.UsageError("--backend dask and --scheduler HOST:PORT go together")
    return Pool(workers, scheduler)


def _of_cases(name: str) -> click.Command:
    @click.command(name, short_help="The paper's table of it: each request with one disturbance.")
    @click.option("--repeat", type=click.IntRange(1), default=1, show_default=True, help="Seeds of each clear request.")
    @click.option("--world", type=click.Choice(["bullet", "symbolic"]), default="bullet", show_default=True)
    @click.option("--factorial", is_flag=True, help="Under all eight settings: world, perception, scenes.")
    @click.option("--keep", is_flag=True, help="Keep every run's folder, not only the failed ones'.")
    @pool_options
    @force
    @quiet
    @json_flag
    def run(
        repeat: int,
        world: str,
        factorial: bool,
        keep: bool,
        folder: Path,
        resume: bool,
        workers: int,
        backend: str,
        scheduler: str,
        seed: int,
        trials: int | None,
        force: bool,
        quiet: bool,
        as_json: bool,
    ) -> int:
        """Compile and execute every request of every case with one random disturbance; the paper's table in DIR."""
        from llmbt.experiment.cases import load_experiment
        from llmbt.experiment.paper_study import PaperOrder, run_paper
        from llmbt.experiment.plan import Setting
        from llmbt.experiment.plan import factorial as all_settings
        from llmbt.render import print_json

        pool = pool_of(workers, backend, scheduler)
        settings = tuple(all_settings()) if factorial else (Setting(world),)
        order = PaperOrder(seed, repeat, trials, settings, keep)
        found = run_paper(
            load_experiment(name), order, folder, pool, resume=resume, force=force, quiet=quiet or as_json
        )
        if as_json:
            print_json(dict(found.document), 0)
        else:
            click.echo("\n".join(t.markdown() for t in found.tables))
            click.echo(f"{found.header['n']} trials; tables, figures and pages in {folder}")
        return 0

    return run


@experiment.command()
@click.argument("name", default="cargo_sorting", metavar="[NAME|FILE.xml]")
@click.option("--world", type=click.Choice(["symbolic", "bullet", "both"]), default="symbolic", show_default=True)
@click.option(
    "--attacks", type=click.IntRange(0), default=0, show_default=True, help="Search for what breaks a method."
)
@click.option("--method", "methods", multiple=True, metavar="METHOD", help="One of the methods; all without it.")
@pool_options
@force
@quiet
@json_flag
def baselines(
    name: str,
    world: str,
    attacks: int,
    methods: tuple[str, ...],
    folder: Path,
    resume: bool,
    workers: int,
    backend: str,
    scheduler: str,
    seed: int,
    trials: int | None,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> int:
    """Other ways to execute the same goals, against the same disturbances, paired by seed.

    --trials: scenarios a kind of disturbance (50) in the world of facts, in all (100) in physics.
    """
    from llmbt.experiment.baselines_study import BaselineOrder, run_baselines
    from llmbt.experiment.cases import load_experiment
    from llmbt.render import print_json
    from llmbt_runtime.baselines import EXECUTORS

    unknown = [m for m in methods if m not in EXECUTORS]
    if unknown:
        raise click.UsageError(f"unknown method {unknown[0]}; known: {', '.join(EXECUTORS)}")
    worlds = ("symbolic", "bullet") if world == "both" else (world,)
    wanted = trials or (100 if worlds == ("bullet",) else 50)
    order = BaselineOrder(worlds, wanted, attacks, seed, methods or tuple(EXECUTORS))
    pool = pool_of(workers, backend, scheduler)
    found = run_baselines(
        load_experiment(name), order, folder, pool, resume=resume, force=force, quiet=quiet or as_json
    )
    if as_json:
        print_json(dict(found.document), 0)
    else:
        click.echo("\n".join(t.markdown() for t in (*found.tables, *found.times)))
        click.echo(f"{found.header['n']} trials; tables, figures and pages in {folder}")
    return 0


@experiment.command()
@click.option(
    "--per-cell", type=click.IntRange(1), default=None, help="Episodes of each kind, number of events, manner."
)
@click.option(
    "--sealed", "key", type=click.Path(path_type=Path), default=None, help="The sealed set, by its key's file."
)
@click.option("-o", "--out", type=click.Path(path_type=Path), required=True, metavar="FILE.jsonl")
@json_flag
def episodes(per_cell: int | None, key: Path | None, out: Path, as_json: bool) -> int:
    """Write the benchmark's episodes, one a line (docs/benchmark.md)."""
    import hashlib

    from llmbt.experiment.episode_set import committed, read_key, set_of
    from llmbt.render import print_json
    from llmbt_ir.versions import write_atomic
    from llmbt_runtime.episodes.written import write_episode

    secret = read_key(key) if key is not None else None
    lines = [write_episode(e) + "\n" for e in set_of(per_cell or committed()["per_cell"], secret)]
    data = "".join(lines).encode()
    write_atomic(out, data)
    told = {"episodes": len(lines), "sha256": hashlib.sha256(data).hexdigest(), "file": str(out)}
    if as_json:
        print_json(told, 0)
    else:
        click.echo(f"{told['episodes']} episodes, sha256 {told['sha256']}: {out}")
        if secret is None and per_cell is None:
            same = told["sha256"] == committed()["open"]["sha256"]
            click.echo("the open set as it was committed" if same else "NOT the open set as it was committed")
    return 0


@experiment.command()
@click.argument("file", type=click.Path(path_type=Path), metavar="EPISODES.jsonl")
@click.argument("executor", metavar="COMMAND|METHOD")
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), default=None, metavar="FILE.json", help="Every episode, too."
)
@click.option("--patience", type=click.FloatRange(0.1), default=20.0, show_default=True, help="Seconds for an answer.")
@click.option("--trials", type=click.IntRange(1), default=None, help="The first so many episodes.")
@json_flag
def score(file: Path, executor: str, out: Path | None, patience: float, trials: int | None, as_json: bool) -> int:
    """Measure an executor on EPISODES: a command that speaks the protocol of docs/benchmark.md, or one of our methods
    by its name."""
    import json

    from llmbt.experiment.score import as_document, in_process, judge, played_by, score_table
    from llmbt.render import print_json
    from llmbt_ir.versions import write_atomic
    from llmbt_ir.xml import read_bytes
    from llmbt_runtime.baselines import EXECUTORS
    from llmbt_runtime.episodes.written import read_episodes

    found = read_episodes(read_bytes(file, "episodes"), str(file))[:trials]
    games = in_process(executor, found) if executor in EXECUTORS else played_by(executor, found, patience)
    scored = [judge(*game) for game in games]
    table = score_table(scored, executor)
    document = dict(as_document(scored, table))
    if out is not None:
        write_atomic(out, (json.dumps(document, indent=1, ensure_ascii=False) + "\n").encode())
    if as_json:
        print_json(document, 0)
    else:
        click.echo(table.markdown())
    return 0
