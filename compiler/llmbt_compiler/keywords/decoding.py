"""From the model's scores to labels: what the grammar allows, the likeliest first, each with its probability.

The model scores each word by itself. A sequence's probability is the product of its words', over all sequences that the
grammar allows; a word's is the sum over the sequences in which it has that label.
"""

from __future__ import annotations

from heapq import nlargest

import numpy as np
from numpy.typing import NDArray

from llmbt_compiler.keywords.labels import LABELS, Label, follows

__all__ = ["best_path", "best_paths", "certain_path", "log_softmax", "marginals"]

_ALLOWED = np.array([[0.0 if follows(a, b) else -np.inf for b in LABELS] for a in LABELS])
_FIRST = np.array([0.0 if follows(None, b) else -np.inf for b in LABELS])
_BEFORE = tuple(tuple(a for a in range(len(LABELS)) if _ALLOWED[a, b] == 0) for b in range(len(LABELS)))


def log_softmax(logits: NDArray[np.float32]) -> NDArray[np.float64]:
    """Log probabilities of scores (n x labels)."""
    shifted = logits.astype(np.float64) - logits.max(axis=-1, keepdims=True)
    result: NDArray[np.float64] = shifted - np.log(np.exp(shifted).sum(axis=-1, keepdims=True))
    return result


def certain_path(log_probabilities: NDArray[np.float64], least: float) -> tuple[Label, ...] | None:
    """The likeliest label of each word, if each has at least the probability `least` and together they are grammatical:
    then no search is needed. None otherwise."""
    likeliest = log_probabilities.argmax(axis=-1)
    if len(likeliest) == 0 or log_probabilities[np.arange(len(likeliest)), likeliest].min() < np.log(least):
        return None
    allowed = _FIRST[likeliest[0]] + _ALLOWED[likeliest[:-1], likeliest[1:]].sum()
    return tuple(LABELS[k] for k in likeliest) if allowed == 0 else None


def best_path(log_probabilities: NDArray[np.float64]) -> tuple[Label, ...]:
    """The most probable grammatical labels of n words (n x 8, columns as in LABELS); Viterbi."""
    n = len(log_probabilities)
    if n == 0:
        return ()
    score = _FIRST + log_probabilities[0]
    back = np.zeros((n, len(LABELS)), dtype=np.int64)
    for i in range(1, n):
        options = score[:, None] + _ALLOWED
        back[i] = options.argmax(axis=0)
        score = options.max(axis=0) + log_probabilities[i]
    path = [int(score.argmax())]
    for i in range(n - 1, 0, -1):
        path.append(int(back[i, path[-1]]))
    return tuple(LABELS[k] for k in reversed(path))


def _summed(options: NDArray[np.float64]) -> NDArray[np.float64]:
    """log(sum(exp(options))) over the last axis; every row has something finite."""
    top = options.max(axis=-1, keepdims=True)
    out: NDArray[np.float64] = top[..., 0] + np.log(np.exp(options - top).sum(axis=-1))
    return out


def _forward(log_probabilities: NDArray[np.float64]) -> NDArray[np.float64]:
    out = np.empty_like(log_probabilities)
    out[0] = _FIRST + log_probabilities[0]
    for i in range(1, len(out)):
        out[i] = _summed((out[i - 1][:, None] + _ALLOWED).T) + log_probabilities[i]
    return out


def marginals(log_probabilities: NDArray[np.float64]) -> NDArray[np.float64]:
    """The probability of each label at each word (n x 8), given that the whole is grammatical; forward-backward."""
    n = len(log_probabilities)
    if n == 0:
        return np.zeros((0, len(LABELS)))
    ahead = _forward(log_probabilities)
    behind = np.zeros_like(log_probabilities)
    for i in range(n - 2, -1, -1):
        behind[i] = _summed(_ALLOWED + (log_probabilities[i + 1] + behind[i + 1])[None, :])
    out: NDArray[np.float64] = np.exp(ahead + behind - _summed(ahead[-1]))
    return out


def best_paths(
    log_probabilities: NDArray[np.float64], k: int, floor: float = 1e-3
) -> tuple[tuple[tuple[Label, ...], float], ...]:
    """Up to `k` grammatical label sequences with their probabilities, likeliest first.

    Labels that a word has with less than `floor` are not looked at, but for its likeliest one.
    """
    n = len(log_probabilities)
    if n == 0:
        return (((), 1.0),)
    total = float(_summed(_forward(log_probabilities)[-1]))
    usable = marginals(log_probabilities) >= floor
    usable[np.arange(n), [LABELS.index(label) for label in best_path(log_probabilities)]] = True
    first = [float(v) for v in _FIRST + log_probabilities[0]]
    paths: dict[int, list[tuple[float, tuple[int, ...]]]] = {
        b: [(first[b], (b,))] for b in range(len(LABELS)) if usable[0, b] and np.isfinite(first[b])
    }
    for i in range(1, n):
        row = log_probabilities[i]
        grown: dict[int, list[tuple[float, tuple[int, ...]]]] = {}
        for b in np.flatnonzero(usable[i]).tolist():
            reached = (p for a in _BEFORE[b] for p in paths.get(a, ()))
            best = nlargest(k, reached, key=lambda p: p[0])
            if best:
                grown[b] = [(score + float(row[b]), (*labels, b)) for score, labels in best]
        paths = grown
    found = nlargest(k, (p for ps in paths.values() for p in ps), key=lambda p: p[0])
    return tuple((tuple(LABELS[b] for b in labels), float(np.exp(score - total))) for score, labels in found)
