"""`llmbt solve`: the update loop on any STRIPS problem, in the symbolic world."""

from __future__ import annotations

from pathlib import Path

import click

from llmbt.options import force, json_flag, out_folder, quiet

__all__ = ["solve"]


@click.command()
@click.argument("domain", type=click.Path(path_type=Path), metavar="DOMAIN.pddl")
@click.argument("problem", type=click.Path(path_type=Path), metavar="PROBLEM.pddl")
@out_folder
@click.option("--seed", type=int, default=0, show_default=True, envvar="LLMBT_SEED", help="Of all chance.")
@click.option("--budget", type=click.IntRange(0), default=200_000, show_default=True, help="State expansions.")
@click.option(
    "--failure-rate", type=click.FloatRange(0, 1), default=0.0, show_default=True, help="How often an action fails."
)
@click.option(
    "--planner",
    type=click.Choice(["own", "fast-downward", "auto"]),
    default="own",
    show_default=True,
    envvar="LLMBT_PLANNER",
    help="Who plans where the local rule does not do; auto: our own search first, then Fast Downward if installed.",
)
@force
@quiet
@json_flag
def solve(
    domain: Path,
    problem: Path,
    folder: Path,
    seed: int,
    budget: int,
    failure_rate: float,
    planner: str,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> int:
    """Run the update loop on PROBLEM.pddl in the symbolic world.

    DIR gets `library.xml`, every tree version, `result.json` with the executed actions, and `plan.txt` with those that
    succeeded, as other planners write them.
    """
    from llmbt.commands.execute import summary
    from llmbt.folders import fresh_folder
    from llmbt.progress import Progress
    from llmbt.solving import read_problem, solve_problem
    from llmbt_ir.xml import read_bytes

    texts = [read_bytes(p, "PDDL file").decode("utf-8", "replace") for p in (domain, problem)]
    progress = Progress(quiet=quiet or as_json)
    stated = read_problem((texts[0], texts[1]), (str(domain), str(problem)))
    fresh_folder(folder, force=force)
    document = solve_problem(
        stated, folder, progress, seed=seed, budget=budget, failure_rate=failure_rate, planner=planner
    )
    return summary(document, folder, as_json=as_json)
