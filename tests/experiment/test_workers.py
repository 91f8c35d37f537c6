"""One worker, two, a cluster, and workers that die: the same trials, each once, and the same table."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from llmbt.experiment.ledger import TRIALS, read_trials

N = 12
LLMBT = [sys.executable, "-c", "import sys; from llmbt.main import main; sys.exit(main())"]


def begin(folder: Path, *options: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [
            *LLMBT,
            "experiment",
            "cargo_sorting",
            "--world",
            "symbolic",
            "-q",
            "--trials",
            str(N),
            "-o",
            str(folder),
            *options,
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def finished(process: subprocess.Popen[str]) -> None:
    _, err = process.communicate(timeout=300)
    assert process.returncode == 0, err


def table(folder: Path) -> bytes:
    keys = [line["key"] for line in read_trials(folder)]
    assert len(keys) == len(set(keys)) == N
    return (folder / "table.json").read_bytes()


def children(pid: int) -> Iterator[int]:
    """The worker processes that a command has started."""
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parent = int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1])
                words = (entry / "cmdline").read_bytes()
            except (OSError, ValueError, IndexError):
                continue
            if parent == pid and b"loky" in words and b"resource_tracker" not in words:
                yield int(entry.name)


def wait_for_lines(folder: Path, n: int) -> None:
    until = time.monotonic() + 120
    while time.monotonic() < until:
        if (folder / TRIALS).exists() and (folder / TRIALS).read_bytes().count(b"\n") >= n:
            return
        time.sleep(0.02)
    raise AssertionError(f"no {n} lines in time")


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    folder = tmp_path_factory.mktemp("alone") / "e"
    finished(begin(folder))
    return table(folder)


@pytest.mark.slow
class TestProcesses:
    def test_two_workers_give_the_same_table(self, tmp_path, alone):
        finished(begin(tmp_path / "e", "--workers", "2"))
        assert table(tmp_path / "e") == alone

    def test_a_killed_worker_loses_no_trial_and_counts_none_twice(self, tmp_path, alone):
        process = begin(tmp_path / "e", "--workers", "2")
        wait_for_lines(tmp_path / "e", 2)
        victims = list(children(process.pid))
        assert victims, "no worker was found to kill"
        os.kill(victims[0], signal.SIGKILL)
        finished(process)
        assert table(tmp_path / "e") == alone

    def test_a_killed_command_goes_on_with_resume(self, tmp_path, alone):
        process = begin(tmp_path / "e")
        wait_for_lines(tmp_path / "e", 3)
        process.kill()
        process.communicate()
        before = (tmp_path / "e" / TRIALS).read_bytes()
        kept = before[: before.rfind(b"\n") + 1]
        assert 3 <= kept.count(b"\n") < N
        finished(begin(tmp_path / "e", "--resume"))
        assert table(tmp_path / "e") == alone
        assert (tmp_path / "e" / TRIALS).read_bytes().startswith(kept)

    def test_resume_with_another_seed_is_refused(self, tmp_path):
        folder = tmp_path / "e"
        folder.mkdir()
        (folder / "plan.json").write_text(json.dumps({"kind": "paper", "seed": 9}))
        process = begin(folder, "--resume")
        _, err = process.communicate(timeout=60)
        assert process.returncode == 2
        assert "E404" in err


@pytest.mark.extras
def test_a_dask_cluster_gives_the_same_table_also_when_a_worker_dies(tmp_path, alone):
    """A real scheduler and two workers, processes of their own on the loopback; one is killed under way."""
    pytest.importorskip("distributed")
    scheduler_file = tmp_path / "scheduler.json"
    started: list[subprocess.Popen[bytes]] = []

    def start(module: str, *options: str) -> subprocess.Popen[bytes]:
        with (tmp_path / f"{module}{len(started)}.log").open("wb") as log:
            command = [sys.executable, "-m", f"distributed.cli.dask_{module}", *options]
            started.append(subprocess.Popen(command, stdout=log, stderr=log))
        return started[-1]

    try:
        start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
              "--scheduler-file", str(scheduler_file))  # fmt: skip
        until = time.monotonic() + 60
        while not scheduler_file.exists() and time.monotonic() < until:
            time.sleep(0.1)
        address = json.loads(scheduler_file.read_text())["address"]
        options = (address, "--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1",
                   "--local-directory", str(tmp_path))  # fmt: skip
        victim = start("worker", *options)
        start("worker", *options)
        _wait_for_workers(address, 2)
        process = begin(tmp_path / "e", "--backend", "dask", "--scheduler", address)
        wait_for_lines(tmp_path / "e", 2)
        victim.kill()
        finished(process)
    finally:
        for one in reversed(started):
            one.kill()
            one.wait()
    assert table(tmp_path / "e") == alone


def _wait_for_workers(address: str, n: int) -> None:
    from distributed import Client

    with Client(address, set_as_default=False) as client:
        client.wait_for_workers(n, timeout=60)
