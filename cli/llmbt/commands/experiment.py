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
    @click.option("--factorial", is_flag=True, help="Under all settings that this version has, not in one world.")
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
        settings = tuple(s for s in all_settings() if s.available) if factorial else (Setting(world),)
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
