"""What a learned forecast is measured against: always the most frequent outcome, and logistic regression on the same features."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


class Baseline(Protocol):
    """Fitted to all experience so far, asked for the next event's outcome."""

    def fit(self, features: Floats, outcome: Ints) -> None:
        """Fit from scratch to rows (n, d) and their outcomes (n,)."""

    def predict(self, features: Floats) -> int:
        """The likeliest outcome of one row (d,)."""


class BaseRate:
    """Always the outcome that was most frequent so far; of the ``last`` so many where that is given."""

    def __init__(self, labels: int, last: int | None = None) -> None:
        self._labels, self._last, self._said = labels, last, 0

    def fit(self, features: Floats, outcome: Ints) -> None:  # noqa: ARG002
        """Count outcomes."""
        seen = outcome if self._last is None else outcome[-self._last :]
        self._said = int(np.bincount(seen, minlength=self._labels).argmax())

    def predict(self, features: Floats) -> int:  # noqa: ARG002
        """The most frequent outcome, whatever the event."""
        return self._said


class LogisticRegression:
    """Multinomial, on standardised features, with an L2 penalty of ‖W‖² / (2 C) on the summed loss (C = 1 as is usual).

    Fitted by accelerated gradient descent (FISTA) with the loss's own Lipschitz constant: convex, so there is nothing to tune.
    """

    def __init__(self, labels: int, c: float = 1.0, steps: int = 600) -> None:
        self._labels, self._c, self._steps = labels, c, steps
        self._mean: Floats = np.zeros(0)
        self._scale: Floats = np.ones(0)
        self._weights: Floats | None = None

    def fit(self, features: Floats, outcome: Ints) -> None:
        """Minimise the penalised cross-entropy; the intercept (last row) is not penalised."""
        self._mean = features.mean(axis=0)
        spread = features.std(axis=0)
        self._scale = np.where(spread > 0.0, spread, 1.0)
        x = np.hstack([(features - self._mean) / self._scale, np.ones((len(features), 1))])
        wanted = np.eye(self._labels)[outcome]
        penalty = np.full((x.shape[1], 1), 1.0 / self._c)
        penalty[-1] = 0.0
        lipschitz = 0.5 * float(np.linalg.eigvalsh(x.T @ x)[-1]) + 1.0 / self._c
        weights = ahead = np.zeros((x.shape[1], self._labels))
        pace = 1.0
        for _ in range(self._steps):
            before = weights
            weights = ahead - (x.T @ (softmax(x @ ahead) - wanted) + penalty * ahead) / lipschitz
            faster = (1.0 + np.sqrt(1.0 + 4.0 * pace * pace)) / 2.0
            ahead = weights + (pace - 1.0) / faster * (weights - before)
            pace = faster
        self._weights = weights

    def predict(self, features: Floats) -> int:
        """The likeliest outcome; the first before anything was fitted."""
        return int(self.shares(features).argmax())

    def shares(self, features: Floats) -> Floats:
        """The outcomes' probabilities, shape (labels,); even before anything was fitted."""
        if self._weights is None:
            return np.full(self._labels, 1.0 / self._labels)
        row = np.append((features - self._mean) / self._scale, 1.0)
        return softmax((row @ self._weights)[None, :])[0]


def softmax(z: Floats) -> Floats:
    """Probabilities along the last axis."""
    shifted = np.exp(z - z.max(axis=1, keepdims=True))
    return np.asarray(shifted / shifted.sum(axis=1, keepdims=True))
