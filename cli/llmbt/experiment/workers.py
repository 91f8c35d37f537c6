"""Trials on many processes, of this machine (joblib's loky) or of a cluster (joblib's Dask backend).

Trials depend on nothing but themselves, so the order in which they end means nothing, and a trial whose process died is
simply run again.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from llmbt_ir.diagnostics import Diagnostic, ExitCode, LlmbtError

__all__ = ["Pool", "run_all"]

MAX_DEATHS = 3
"""So often in a row, without a trial ending in between, a pool may break before it is given up."""


class _Task(Protocol):
    @property
    def key(self) -> str: ...


class _Done(Protocol):
    @property
    def key(self) -> str: ...


T = TypeVar("T", bound=_Task)
D = TypeVar("D", bound=_Done)


@dataclass(frozen=True, slots=True)
class Pool:
    """Where trials run: `workers` processes of this machine, or with `scheduler` (host:port) all workers of a Dask
    cluster."""

    workers: int = 1
    scheduler: str = ""


def run_all(tasks: Sequence[T], work: Callable[[T], D], pool: Pool) -> Iterator[D]:
    """The results as they come; each task's exactly once, also where a worker dies under it.

    `work` runs in the workers, so it and what it takes and gives are to be picklable. Errors: E407 the workers die
    again and again; E408 the cluster cannot be used.
    """
    if pool.workers <= 1 and not pool.scheduler:
        yield from map(work, tasks)
        return
    left = {task.key: task for task in tasks}
    deaths = 0
    while left:
        try:
            for done in _parallel(list(left.values()), work, pool):
                if left.pop(done.key, None) is not None:
                    deaths = 0
                    yield done
        except _broken() as fault:
            deaths += 1
            if deaths >= MAX_DEATHS:
                raise LlmbtError(
                    Diagnostic(
                        "E407",
                        f"the workers died {deaths} times in a row: {str(fault).splitlines()[0]}",
                        help="look for what they die of (memory?), then go on with --resume, with fewer --workers",
                    )
                ) from None


def _broken() -> tuple[type[BaseException], ...]:
    from concurrent.futures import BrokenExecutor

    found: list[type[BaseException]] = [BrokenExecutor]
    try:
        from distributed import KilledWorker
    except ImportError:
        return tuple(found)
    return (*found, KilledWorker)


def _parallel(tasks: list[T], work: Callable[[T], D], pool: Pool) -> Iterator[D]:
    from joblib import Parallel, delayed

    with _configured(pool), warnings.catch_warnings():
        # loky takes a worker that has grown for a leaking one and puts another in its place; ours keep a world a scene
        warnings.filterwarnings("ignore", message="A worker stopped while some jobs were given")
        run = Parallel(
            batch_size=1, pre_dispatch="all" if pool.scheduler else "2*n_jobs", return_as="generator_unordered"
        )
        results: Iterator[D] = run(delayed(work)(task) for task in tasks)
        yield from results


def _configured(pool: Pool) -> AbstractContextManager[Any]:
    from joblib import parallel_config

    found: AbstractContextManager[Any]
    if not pool.scheduler:
        found = parallel_config(backend="loky", n_jobs=pool.workers, inner_max_num_threads=1)
        return found
    _check_cluster(pool.scheduler)
    found = parallel_config(backend="dask", n_jobs=-1, scheduler_host=pool.scheduler)
    return found


def _check_cluster(address: str) -> None:
    """Workers are there, each with one thread: a trial has its process to itself."""
    try:
        import distributed
    except ImportError:
        raise _unusable("the packages for it are missing", "pip install 'llm-bt[cluster]'") from None
    try:
        with distributed.Client(address, timeout="10s", set_as_default=False) as client:
            threads = client.nthreads()
    except (OSError, ValueError) as fault:
        raise _unusable(f"no scheduler answers at {address}: {fault}", "start one: dask scheduler") from None
    if not threads:
        raise _unusable("it has no workers", "start some: dask worker ADDRESS --nthreads 1")
    if any(n > 1 for n in threads.values()):
        raise _unusable("a worker has several threads", "start each with: dask worker ADDRESS --nthreads 1")


def _unusable(why: str, hint: str) -> LlmbtError:
    return LlmbtError(Diagnostic("E408", f"the cluster cannot be used: {why}", help=hint), exit_code=ExitCode.USAGE)
