"""How long trials take with one worker and with two: `python -m tests.experiment.speed --trials 40`. Wall time of whole
commands, so processes and worlds are built anew in each; on a machine that does nothing else."""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

LLMBT = [sys.executable, "-c", "import sys; from llmbt.main import main; sys.exit(main())"]


def run(experiment: str, trials: int, workers: int, folder: Path) -> tuple[float, bytes]:
    """Seconds that a sample of an experiment takes, and its table."""
    command = [*LLMBT, "experiment", experiment, "--trials", str(trials), "--workers", str(workers), "-q"]
    began = time.monotonic()
    subprocess.run([*command, "-o", str(folder)], check=True, stdout=subprocess.DEVNULL)
    return time.monotonic() - began, (folder / "table.json").read_bytes()


def measure(experiment: str, trials: int) -> None:
    """Print both times, what they come to for 200 trials, and whether the tables are the same."""
    with tempfile.TemporaryDirectory() as made:
        (one, table), (two, other) = (run(experiment, trials, n, Path(made) / str(n)) for n in (1, 2))
    print(f"{experiment}, {trials} trials, wall time")
    for workers, seconds in ((1, one), (2, two)):
        each = seconds / trials
        print(f"{workers} worker(s): {seconds:.1f} s, {each:.2f} s a trial, 200 trials in {200 * each / 60:.1f} min")
    print(f"two workers are {one / two:.2f} times as fast as one; the same table: {'yes' if table == other else 'NO'}")


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--experiment", default="cargo_sorting")
    options.add_argument("--trials", type=int, default=40)
    given = options.parse_args()
    measure(given.experiment, given.trials)
