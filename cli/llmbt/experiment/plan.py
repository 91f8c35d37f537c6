"""The trials of an experiment, drawn up before any of them is run: which, with which seed, under which conditions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any
from zlib import crc32

from llmbt.experiment.cases import Experiment
from llmbt_runtime.chance import chance

__all__ = ["Setting", "Trial", "factorial", "plan", "sample", "setting_of", "trial_seed", "under"]


@dataclass(frozen=True, slots=True)
class Setting:
    """The conditions of a trial: `world` is bullet or symbolic, `scenes` nominal or varied (poses, sizes, masses,
    friction), `perception` truth or camera: in physics what conditions and skills go by, in a world of facts where the
    first facts come from."""

    world: str = "bullet"
    perception: str = "truth"
    scenes: str = "nominal"

    def __str__(self) -> str:
        return f"{self.world}, {self.perception}, {self.scenes}"


@dataclass(frozen=True, slots=True)
class Trial:
    """One request of one case, the `repeat`-th time (from 0). The seed is that of all chance in it; the disturbance,
    too, is drawn from it."""

    experiment: str
    case: str
    request: str
    repeat: int
    seed: int
    setting: Setting = Setting()

    @property
    def key(self) -> str:
        """Its name within the plan, and that of its folder."""
        where = self.setting
        plain = where == Setting(where.world)
        suffix = "" if plain else f".{where.perception}.{where.scenes}"
        return f"{self.case}.{self.request}.{self.repeat}.{where.world}{suffix}"

    def as_json(self) -> dict[str, Any]:
        """For the ledger."""
        found = asdict(self)
        return {"key": self.key, **found.pop("setting"), **found}


def trial_seed(seed: int, *names: str | int) -> int:
    """The seed of a trial: from the experiment's and what the trial is about, the same on every machine."""
    return crc32("/".join(map(str, (seed, *names))).encode()) % 2**31


def plan(experiment: Experiment, *, seed: int, repeat: int) -> tuple[Trial, ...]:
    """Every request of every case, each clear one `repeat` times with another seed; an unclear one once, since what
    becomes of it is settled before there is any chance."""
    return tuple(
        Trial(experiment.name, case.name, r.id, k, trial_seed(seed, experiment.name, case.name, r.id, k))
        for k in range(repeat)
        for case in experiment.cases
        for r in case.requests
        if r.clear or k == 0
    )


def under(trials: Iterable[Trial], settings: Iterable[Setting]) -> tuple[Trial, ...]:
    """The same trials, with the same seeds, under each of the settings."""
    trials = tuple(trials)
    return tuple(replace(t, setting=setting) for setting in settings for t in trials)


def sample(trials: tuple[Trial, ...], n: int, seed: int) -> tuple[Trial, ...]:
    """`n` of the trials, drawn by the seed, in their order; all where there are no more."""
    rng = chance(seed, "sample")
    left = list(range(len(trials)))
    chosen = sorted(left.pop(rng.integers(len(left))) for _ in range(min(n, len(trials))))
    return tuple(trials[i] for i in chosen)


def factorial() -> Iterator[Setting]:
    """Truth or camera x symbolic or physics x nominal or varied."""
    for world in ("symbolic", "bullet"):
        for perception in ("truth", "camera"):
            for scenes in ("nominal", "varied"):
                yield Setting(world, perception, scenes)


def setting_of(record: Mapping[str, Any]) -> Setting:
    """The setting of a line of the ledger."""
    return Setting(str(record["world"]), str(record["perception"]), str(record["scenes"]))
