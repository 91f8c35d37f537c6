"""`python -m tests.requests.ambik FILE.csv`: the pairs of AmbiK, a published set of ambiguous kitchen tasks, decided by
their texts and their lists of objects alone; no model is asked, and nothing is planned.

AmbiK (Ivanova and others, ACL 2025; github.com/IvAnastasia/AmbiK-dataset) states no licence, so that its file is not
here. A request is asked about where one of its singular noun phrases fits several objects of its scene, unless it
points back ("the ceramic bowl ... the bowl") or measures ("a cup of milk"); both rules were written after a look at the
set. What needs knowledge of the world (which oil one fries with) is no such thing: the set calls it common sense.
"""

from __future__ import annotations

import argparse
import csv
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from llmbt_atl.library import Library, load_library
from llmbt_compiler.parsing.names import Found, Talk
from llmbt_compiler.parsing.objects import resolve_objects
from llmbt_compiler.parsing.scene import Scene
from llmbt_compiler.parsing.words import Token, tokens
from llmbt_ir.geometry import Pose
from llmbt_ir.semantic_map import MapObject, MapPlace, SemanticMap

__all__ = ["Pair", "asked_about", "counted", "map_of", "read"]

_LONGEST = 4


@dataclass(frozen=True, slots=True)
class Pair:
    """A task in ambiguous and in clear words, what kind of ambiguity it is, and what it is between."""

    kind: str
    objects: tuple[str, ...]
    unclear: str
    clear: str
    between: frozenset[str]


def read(path: Path) -> tuple[Pair, ...]:
    """The pairs of a file of AmbiK."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return tuple(
        Pair(
            row["ambiguity_type"],
            _names(row["environment_short"]),
            row["ambiguous_task"],
            row["singelablel_clear"],
            frozenset(map(_id, _names(row["amb_shortlist"] or ""))),
        )
        for row in rows
    )


def _names(text: str) -> tuple[str, ...]:
    return tuple(dict.fromkeys(n.strip() for n in text.split(",") if n.strip()))


def _id(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")


def map_of(names: Sequence[str]) -> SemanticMap:
    """A map in which everything stands on one table."""
    objects = {_id(n): MapObject(_id(n), n, "", "", (0.05,) * 3, Pose((0.0, 0.0, 0.0)), "kitchen_table") for n in names}
    places = (MapPlace("kitchen_table", "kitchen table", "location"),)
    return SemanticMap("kitchen", "household", tuple(objects.values()), places)


def asked_about(request: str, semantic_map: SemanticMap, library: Library) -> frozenset[str] | None:
    """The objects that the first ambiguous phrase of a request fits; None where it has none."""
    scene = Scene(semantic_map, library)
    words = tokens(request)
    before: set[str] = set()
    i = 0
    while i < len(words):
        for length in range(min(_LONGEST, len(words) - i), 0, -1):
            parts = words[i : i + length]
            hit = _fitting(parts, scene)
            if hit is None:
                continue
            measures = i + length < len(words) and words[i + length].text == "of"
            if len(hit) > 1 and not scene.word(parts[-1], True).plural and not measures and not hit & before:
                return hit
            before |= hit if len(hit) == 1 else set()
            i += length - 1
            break
        i += 1
    return None


def _fitting(parts: Sequence[Token], scene: Scene) -> frozenset[str] | None:
    """What a run of words fits, if every one of them is of a name in the scene."""
    own = scene.vocabulary(True)
    if not all(t.word and t.number is None and scene.word(t, True).text in own for t in parts):
        return None
    exact = resolve_objects(parts, scene, Talk())
    if isinstance(exact, Found) and len(exact.ids) == 1 and not exact.corrected and not exact.chosen:
        return frozenset(exact.ids)
    every = (Token("all", parts[0].start, parts[0].start), *parts)
    found = resolve_objects(every, scene, Talk())
    return frozenset(found.ids) if isinstance(found, Found) and not found.corrected else None


def main() -> int:
    """Decide both members of each pair, and print how often."""
    parser = argparse.ArgumentParser(prog="python -m tests.requests.ambik", description=__doc__)
    parser.add_argument("file", type=Path, help="ambik-dataset/ambik_test.csv of AmbiK")
    parser.add_argument("--verbose", action="store_true")
    options = parser.parse_args()
    print(counted(read(options.file), verbose=options.verbose))
    return 0


def counted(pairs: Sequence[Pair], *, verbose: bool = False) -> str:
    """Markdown: a row for each kind of ambiguity."""
    library = load_library("household")
    lines = [
        "| kind | pairs | unclear: asked | with an object of the shortlist | clear: not asked |",
        "|---|---|---|---|---|",
    ]
    for kind in sorted({p.kind for p in pairs}):
        of_kind = [p for p in pairs if p.kind == kind]
        unclear = [asked_about(p.unclear, map_of(p.objects), library) for p in of_kind]
        clear = [asked_about(p.clear, map_of(p.objects), library) for p in of_kind]
        if verbose:
            for p, u, c in zip(of_kind, unclear, clear, strict=True):
                print(kind, "|", p.unclear, "|", u, "|", sorted(p.between), "|", p.clear, "|", c, file=sys.stderr)
        asked = sum(u is not None for u in unclear)
        hits = sum(u is not None and bool(u & p.between) for u, p in zip(unclear, of_kind, strict=True))
        quiet = sum(c is None for c in clear)
        n = len(of_kind)
        lines.append(f"| {kind} | {n} | {_share(asked, n)} | {_share(hits, n)} | {_share(quiet, n)} |")
    return "\n".join(lines)


def _share(part: int, whole: int) -> str:
    return f"{part} ({100 * part / whole:.0f} %)"


if __name__ == "__main__":
    raise SystemExit(main())
