"""Several experts on one question, pooled by how well each foretold held-back experience."""

from __future__ import annotations

from typing import Final

import numpy as np

from wakeful.learning.material import Floats, Ints
from wakeful.learning.network import softmax

LEAST: Final = 1e-4
"""No expert is believed to be surer than this that something is not so."""
_STEPS = 200
_DIGITS = 6


def pooled(logs: Floats, weights: Floats) -> Floats:
    """The weighted geometric mean of the experts' probabilities, normalised.

    Args:
        logs: logarithms of probabilities, (experts, n, k) or (experts, k).
        weights: (experts,); below 1 together they cool, above 1 they sharpen.
    """
    return softmax(np.tensordot(weights, logs, axes=1))


def logs_of(shares: Floats) -> Floats:
    """Logarithms of probabilities, none below that of ``LEAST``."""
    return np.asarray(np.log(np.maximum(shares, LEAST)))


def weigh(logs: Floats, label: Ints, weight: Floats, prior: Floats, ridge: float) -> Floats:
    """The experts' weights: least cross-entropy on held-back rows, plus ridge · |w − prior|².

    So a few rows leave the prior almost as it is, and many overrule it. The loss is convex; projected gradient descent with
    backtracking keeps weights from falling below 0.

    Args:
        logs: (experts, n, k).
        label: (n,) indices, -1 where not known.
        weight: (n,), of which only the proportions count.
        prior: (experts,), the weights without any held-back row.
        ridge: in nats.
    """
    known = (label >= 0) & (weight > 0.0)
    if not known.any():
        return prior
    logs, label = logs[:, known], label[known]
    share = weight[known] / weight[known].mean()
    rows = np.arange(len(label))

    def loss(at: Floats) -> float:
        own = np.maximum(pooled(logs, at)[rows, label], 1e-300)
        return float(-(share * np.log(own)).sum() + ridge * ((at - prior) ** 2).sum())

    now, step = prior.copy(), 0.1
    least = loss(now)
    for _ in range(_STEPS):
        shares = pooled(logs, now)
        expected = (shares[None] * logs).sum(axis=2) - logs[:, rows, label]
        slope = (share * expected).sum(axis=1) + 2.0 * ridge * (now - prior)
        while step > 1e-9:
            new = np.maximum(now - step * slope, 0.0)
            found = loss(new)
            if found < least:
                now, least, step = new, found, step * 1.5
                break
            step /= 2.0
        else:
            break
    return np.round(now, _DIGITS)
