"""From the model's scores to labels: the best sequence that the grammar allows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from llmbt_compiler.keywords.labels import LABELS, Label, follows

__all__ = ["best_path", "log_softmax"]

_ALLOWED = np.array([[0.0 if follows(a, b) else -np.inf for b in LABELS] for a in LABELS])
_FIRST = np.array([0.0 if follows(None, b) else -np.inf for b in LABELS])


def log_softmax(logits: NDArray[np.float32]) -> NDArray[np.float64]:
    """Log probabilities of scores (n x labels)."""
    shifted = logits.astype(np.float64) - logits.max(axis=-1, keepdims=True)
    result: NDArray[np.float64] = shifted - np.log(np.exp(shifted).sum(axis=-1, keepdims=True))
    return result


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
