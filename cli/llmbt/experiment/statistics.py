"""The few statistics that the tables need: exact where that is possible, on counts alone, repeatable from a seed.

Wilson 1927; McNemar 1947 with the exact binomial; Holm 1979; Kaplan and Meier 1958. scipy is their oracle in the tests.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from statistics import NormalDist

__all__ = ["bootstrap_by_group", "holm", "mcnemar", "median_time", "survival", "wilson"]

Interval = tuple[float, float]


def wilson(good: int, n: int, confidence: float = 0.95) -> Interval:
    """The score interval of a rate; (0, 1) where nothing was tried."""
    if n == 0:
        return 0.0, 1.0
    z = NormalDist().inv_cdf(0.5 + confidence / 2)
    rate, z2 = good / n, z * z
    centre = (rate + z2 / (2 * n)) / (1 + z2 / n)
    half = z * math.sqrt(rate * (1 - rate) / n + z2 / (4 * n * n)) / (1 + z2 / n)
    low = 0.0 if good == 0 else max(0.0, centre - half)
    high = 1.0 if good == n else min(1.0, centre + half)
    return low, high


def bootstrap_by_group(
    groups: Mapping[str, Sequence[bool]], *, seed: int, draws: int = 10_000, confidence: float = 0.95
) -> Interval:
    """The percentile interval of a rate when whole groups are drawn again with replacement: trials of one case are no
    independent ones. With a handful of groups it is rough."""
    rng = random.Random(f"{seed}/bootstrap")
    counts = [(sum(g), len(g)) for g in groups.values() if g]
    if not counts:
        return 0.0, 1.0
    rates = []
    for _ in range(draws):
        drawn = [counts[rng.randrange(len(counts))] for _ in counts]
        rates.append(sum(k for k, _ in drawn) / sum(n for _, n in drawn))
    rates.sort()
    tail = (1 - confidence) / 2
    return rates[int(tail * (draws - 1))], rates[math.ceil((1 - tail) * (draws - 1))]


def mcnemar(only_first: int, only_second: int) -> float:
    """The exact two-sided p that two methods succeed equally often, from the pairs in which just one did."""
    n, k = only_first + only_second, min(only_first, only_second)
    if n == 0:
        return 1.0
    tail: float = sum(math.comb(n, i) for i in range(k + 1)) / 2**n
    return min(1.0, 2 * tail)


def holm(p_values: Sequence[float]) -> tuple[float, ...]:
    """The p-values adjusted for how many there are, in the order given."""
    order = sorted(range(len(p_values)), key=lambda i: p_values[i])
    adjusted, largest = [0.0] * len(p_values), 0.0
    for rank, i in enumerate(order):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[i]))
        adjusted[i] = largest
    return tuple(adjusted)


def survival(ended: Sequence[float], censored: Sequence[float]) -> tuple[tuple[float, float], ...]:
    """Kaplan and Meier: after each time at which something ended, the share that had not ended by then. `censored` is
    how long the others were watched."""
    alive, found = 1.0, []
    for t in sorted(set(ended)):
        risk = sum(e >= t for e in ended) + sum(c >= t for c in censored)
        alive *= 1 - sum(e == t for e in ended) / risk
        found.append((t, alive))
    return tuple(found)


def median_time(ended: Sequence[float], censored: Sequence[float]) -> float | None:
    """The Kaplan-Meier median; None where half of them did not end while watched."""
    return next((t for t, alive in survival(ended, censored) if alive <= 0.5 + 1e-12), None)
