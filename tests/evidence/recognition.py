"""Recognition over random scenes, judged; written into docs/recognition.md.

What is judged on was drawn apart from what recognition was developed on (tests/recognition/random_scenes.py): the
colours are the centroids of ISCC-NBS, and seeds, sizes, places of cameras, fields of view and the shares of touching,
lying and undeclared things are others.
"""

from __future__ import annotations

import argparse
import math
import statistics
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from llmbt_compiler.recognition.candidates import candidates
from llmbt_compiler.recognition.colour import term_of
from llmbt_compiler.recognition.recognise import STAGES, detections, recognise
from llmbt_ir.capture import Capture, PointCloud
from llmbt_ir.scene import Body
from llmbt_runtime.bullet.camera import DepthCameras
from llmbt_runtime.perception.rgbd import cloud_of, noisy
from tests.evidence.page import told_by, write_section
from tests.recognition.random_scenes import DEVELOPMENT, HARDER, Kit, Staged, stage

PAGE = Path(__file__).resolve().parents[2] / "docs" / "recognition.md"

KELLY = {
    "red": ("be0032", "bc3f4a", "841b2d", "ab4e52", "722f37"),
    "pink": ("ffb5ba", "ea9399", "e4717a", "f9ccca", "dea5a4"),
    "orange": ("f38400", "fd943f", "ed872d", "be6516", "fab57f", "d99058"),
    "brown": ("80461b", "593319", "a67b5b", "6f4e37", "422518"),
    "yellow": ("f3c300", "fada5e", "d4af37", "af8d13", "f8de7e", "c9ae5d"),
    "green": ("008856", "3eb489", "007959", "00543d", "8ed1b2", "3b7861", "1b4d3e"),
    "blue": ("00a1c2", "4997d0", "0067a5", "00416a", "70a3cc", "436b95", "00304e"),
    "purple": ("9a4eae", "d399e6", "875692", "602f6b", "b695c0", "86608e", "563c5c"),
    "white": ("f2f3f4",),
    "grey": ("b9b8b5", "848482", "555555"),
    "black": ("222222",),
}
"""The centroids that ISCC-NBS calls vivid, brilliant, strong, deep, light, moderate or dark red, pink, ..."""
HELD_OUT = Kit(
    palette=KELLY,
    width_m=(0.030, 0.070),
    height_m=(0.030, 0.120),
    cameras=((50, 120), (145, 220), (240, 310)),
    radius_m=(1.05, 1.55),
    eye_height_m=(0.95, 1.45),
    fov_deg=(41, 54),
    touching=0.3,
    lying=0.2,
    undeclared=0.2,
    on_shelf=0.5,
)
FIRST_SEED = 290_000
NOISE_M = 0.0015
NEAR_M = 0.02
"""A thing of the map this near to a real one is that one."""


@dataclass
class Tally:
    """What has been counted so far."""

    real: int = 0
    mapped: int = 0
    found: int = 0
    on_shelf: list[int] = field(default_factory=lambda: [0, 0])
    touching: list[int] = field(default_factory=lambda: [0, 0])
    undeclared: list[int] = field(default_factory=lambda: [0, 0])
    colours: int = 0
    words: int = 0
    shapes: int = 0
    named: list[int] = field(default_factory=lambda: [0, 0])
    places: int = 0
    off_mm: list[float] = field(default_factory=list)
    size_off_mm: list[float] = field(default_factory=list)
    stage_ms: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    misses: list[str] = field(default_factory=list)


def look(staged: Staged, seed: int) -> Capture:
    """The cameras' clouds, with noise."""
    cameras = DepthCameras(staged.truth, staged.paint)
    rng = np.random.default_rng([seed, 1])
    try:
        images = [noisy(cameras.look(staged.snapshot, c), NOISE_M, rng) for c in staged.truth.cameras]
        return Capture(PointCloud.join([cloud_of(i) for i in images]), cameras.robot(staged.snapshot))
    finally:
        cameras.close()


def away_m(body: Body, xyz: tuple[float, float, float]) -> float:
    """From the middle of a body."""
    assert body.pose is not None
    return math.dist(body.pose.xyz_m, xyz)


def pairs(real: tuple[Body, ...], seen: list[tuple[float, float, float]]) -> Iterator[tuple[Body, int]]:
    """Each real thing with the nearest thing seen that is near enough, the nearest pairs first, each once."""
    every = sorted((away_m(b, xyz), b.id, k) for b in real for k, xyz in enumerate(seen))
    by_id = {b.id: b for b in real}
    taken: set[int] = set()
    for off, id_, k in every:
        if off <= NEAR_M and id_ in by_id and k not in taken:
            taken.add(k)
            yield by_id.pop(id_), k


def judge(tally: Tally, staged: Staged, seed: int) -> None:
    """Recognise one scene and count."""
    capture = look(staged, seed)
    found = recognise(capture, staged.told, observe=lambda s, t: tally.stage_ms[s].append(t * 1e3))
    seen = detections(capture, staged.told, candidates(staged.told, None))
    declared = {b.id for b in staged.told.objects}
    alike: dict[tuple[object, ...], int] = defaultdict(int)
    for b in staged.told.objects:
        alike[b.colour, b.shape, b.size_m] += 1
    real = staged.truth.objects
    tally.real, tally.mapped = tally.real + len(real), tally.mapped + len(found.objects)
    by_id = {b.id: found.objects[k] for b, k in pairs(real, [o.pose.xyz_m for o in found.objects])}
    for b in real:
        thing = by_id.get(b.id)
        assert b.pose is not None
        for row, holds in (
            (tally.on_shelf, b.pose.xyz_m[2] - b.size_m[2] / 2 > 0.45),
            (tally.touching, b.id in staged.touching),
            (tally.undeclared, b.id not in declared),
        ):
            row[1] += holds
            row[0] += holds and thing is not None
        if thing is None:
            tally.misses.append(f"seed {seed}: {b.id}, a {staged.terms[b.id]} {b.shape}, is missed")
            continue
        tally.found += 1
        tally.off_mm.append(1e3 * away_m(b, thing.pose.xyz_m))
        if b.id not in declared:
            off = np.abs(np.sort(thing.size_m) - np.sort(b.size_m)).max()
            tally.size_off_mm.append(1e3 * float(off))
        elif alike[b.colour, b.shape, b.size_m] == 1:
            tally.named[1] += 1
            tally.named[0] += thing.id == b.id
        tally.places += thing.place == place_of(staged, b)
    for b, k in pairs(real, [d.best.xyz_m for d in seen]):
        shape = "box" if b.shape in ("box", "cube") else b.shape
        tally.shapes += seen[k].measured.geometry.kind == shape
        own = term_of(np.array(staged.paint[b.id]))
        tally.colours += seen[k].term == own
        tally.words += seen[k].term == staged.terms[b.id]
        if seen[k].term != own:
            tally.misses.append(f"seed {seed}: {b.id} is painted {own} and called {seen[k].term}")
    wrong = len(found.objects) - len(by_id)
    if wrong:
        tally.misses.append(f"seed {seed}: {wrong} in the map that are not there")


def place_of(staged: Staged, body: Body) -> str | None:
    """Where a body really stands."""
    assert body.pose is not None
    x, y, z = body.pose.xyz_m
    lies = body.shape == "cylinder" and abs(body.pose.quat_xyzw[3]) < 0.75 and abs(body.pose.quat_xyzw[1]) > 1e-9
    return staged.truth.most_specific(x, y, z - (body.size_m[0] if lies else body.size_m[2]) / 2)


def share(part: int, whole: int) -> str:
    return f"{part}/{whole} ({part / whole:.3f})" if whole else "-"


def spread(values: list[float], digits: int = 0) -> str:
    """The median and the largest."""
    return f"{statistics.median(values):.{digits}f}, {max(values):.{digits}f}" if values else "-"


def table(tally: Tally, scenes: int) -> list[str]:
    off = sorted(tally.off_mm)
    total = [sum(row) for row in zip(*tally.stage_ms.values(), strict=True)]
    rows = [
        ("scenes, things", f"{scenes}, {tally.real}"),
        ("recall", share(tally.found, tally.real)),
        ("precision", share(tally.found, tally.mapped)),
        ("recall on shelf levels", share(*tally.on_shelf)),
        ("recall of touching pairs of one colour", share(*tally.touching)),
        ("recall of undeclared things", share(*tally.undeclared)),
        ("colour: the term for its own paint", share(tally.colours, tally.found)),
        ("colour: the word that ISCC-NBS has for its paint", share(tally.words, tally.found)),
        ("shape (box, cylinder, sphere)", share(tally.shapes, tally.found)),
        ("id, of things unlike all others", share(*tally.named)),
        ("place", share(tally.places, tally.found)),
        (
            "position: median, 95 %, worst",
            f"{statistics.median(off):.2f}, {off[int(0.95 * len(off))]:.2f}, {off[-1]:.2f} mm",
        ),
        ("size of undeclared things: median, worst", f"{spread(tally.size_off_mm, 1)} mm"),
    ]
    rows += [(f"time of `{stage}`: median, worst", f"{spread(tally.stage_ms[stage])} ms") for stage in STAGES]
    rows.append(("time of all: median, worst", f"{spread(total)} ms"))
    return ["| | |", "|---|---|", *(f"| {a} | {b} |" for a, b in rows)]


def judged(kit: Kit, first: int, scenes: int) -> list[str]:
    """The table of so many scenes, and what went wrong in them."""
    tally = Tally()
    for seed in range(first, first + scenes):
        judge(tally, stage(kit, seed), seed)
        print(f"{seed - first + 1}/{scenes}: {tally.found}/{tally.real} found", flush=True)
    misses = ["", "What went wrong:", "", *(f"- {m}" for m in tally.misses)] if tally.misses else []
    return [*table(tally, scenes), *misses]


def written() -> None:
    """Judge the scenes held out and write the table into the page."""
    lines = judged(HELD_OUT, FIRST_SEED, 50)
    print("\n".join(lines))
    told = (
        f"{told_by('python -m tests.evidence --only recognition')} One thread of a shared machine. Rendered scenes, "
        f"three cameras of 640 x 480, {1e3 * NOISE_M:g} mm of independent depth noise."
    )
    write_section(PAGE, "evidence", [told, "", *lines])


def main() -> None:
    """Judge scenes of a development kit, or fewer of those held out; nothing is written."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--scenes", type=int, default=50)
    options.add_argument("--development", choices=["easy", "harder"])
    chosen = options.parse_args()
    kits = {"easy": (DEVELOPMENT, 0), "harder": (HARDER, 5_000), None: (HELD_OUT, FIRST_SEED)}
    print("\n".join(judged(*kits[chosen.development], chosen.scenes)))


if __name__ == "__main__":
    main()
