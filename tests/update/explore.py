"""`python -m tests.update.explore -n 20000`: the property tests of `test_claims.py` over so many random episodes, new
ones for each seed. A violation is shown as hypothesis shows it: the smallest episode that has it."""

from __future__ import annotations

import argparse
import sys
import time
import traceback
from collections import Counter
from typing import Any
from unittest.mock import patch

import hypothesis
from hypothesis import HealthCheck, settings


def main() -> int:
    """Run them, count what was run by how it ended; 1 where a claim does not hold."""
    parser = argparse.ArgumentParser(prog="python -m tests.update.explore", description=__doc__)
    parser.add_argument("-n", type=int, default=20_000, help="episodes, a third for each property")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    settings.register_profile(
        "explore",
        max_examples=-(-options.n // 3),
        deadline=None,
        derandomize=False,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    settings.load_profile("explore")
    from tests.update import test_claims

    began, failed, total = time.process_time(), 0, 0
    for name in ("over_propositions", "over_things_with_types_variables_and_containment",
                 "the_verdict_is_that_of_an_independent_search"):  # fmt: skip
        ended: Counter[str] = Counter()

        def noted(inner: Any, ended: Counter[str] = ended, name: str = name) -> Any:
            def call(*args: Any, **kwargs: Any) -> Any:
                found = inner(*args, **kwargs)
                ended[found.outcome.value] += 1
                if ended.total() % 1_000 == 0:
                    print(f"{name}: {ended.total()}", file=sys.stderr)
                return found

            return call

        with (
            patch.object(test_claims, "measure", noted(test_claims.measure)),
            patch.object(test_claims, "execute", noted(test_claims.execute)),
        ):
            try:
                hypothesis.seed(options.seed)(getattr(test_claims, f"test_{name}"))()
                verdict = "holds"
            except Exception:
                traceback.print_exc()
                verdict, failed = "DOES NOT HOLD", failed + 1
        total += ended.total()
        print(f"{name}: {verdict} over {ended.total()} episodes: {dict(ended.most_common())}", flush=True)
    print(f"{total} episodes, seed {options.seed}, {time.process_time() - began:.0f} s of one core")
    return int(failed > 0)


if __name__ == "__main__":
    raise SystemExit(main())
