"""``python -m tests.published FOLDER``: ALFRED's human sentences, from a local copy, scored by what they mean.

FOLDER holds ``traj_data.json`` files at any depth (https://github.com/askforalfred/alfred, MIT; "lite" is 35 MB).
"""

from __future__ import annotations

import argparse
from collections import Counter
from pathlib import Path
from random import Random

from llmbt_compiler.keywords.tagger import load_tagger
from llmbt_compiler.parsing.evaluate import wilson
from tests.published.alfred import VERBS, Standing, read_sentences, standing


def main() -> None:
    """Print the table."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("folder", type=Path)
    options.add_argument("-n", type=int, default=0, help="a sample of so many sentences, drawn by the seed; 0: all")
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--tagger", default="default")
    options.add_argument("--errors", type=int, default=0, help="show so many missed ones; not for a blind folder")
    asked = options.parse_args()
    sentences = list(dict.fromkeys(read_sentences(asked.folder)))
    if asked.n:
        sentences = Random(asked.seed).sample(sentences, min(asked.n, len(sentences)))
    tagged = load_tagger(asked.tagger).tag([s.text for s in sentences])
    outcomes = [(s, t, standing(s, t)) for s, t in zip(sentences, tagged, strict=True)]
    counted: Counter[tuple[str, Standing]] = Counter((s.action, o) for s, _, o in outcomes)
    print(f"{len(sentences)} sentences, {len({s.text for s in sentences})} different ones")
    for action in (*VERBS, "all"):
        of = {o: sum(n for (a, k), n in counted.items() if k is o and action in (a, "all")) for o in Standing}
        scored = of[Standing.FOUND] + of[Standing.MISSED]
        low, high = wilson(of[Standing.FOUND], scored)
        rate = f"{of[Standing.FOUND] / scored:.3f} ({low:.3f}-{high:.3f})" if scored else "-"
        apart = ", ".join(f"{of[o]} {o.value}" for o in list(Standing)[2:] if of[o])
        print(f"{action:<14}{of[Standing.FOUND]:>6} of {scored:<6}{rate:<24}apart: {apart}")
    shown = [(s, t) for s, t, o in outcomes if o is Standing.MISSED][: asked.errors]
    for sentence, step in shown:
        print(f"{sentence.action}({sentence.target}, {sentence.place}): {sentence.text}")
        print("   " + "; ".join(f"{k.label.value} {k.text}" for k in step.spans))


if __name__ == "__main__":
    main()
