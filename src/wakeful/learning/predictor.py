"""A model version as selection uses it: one event at a time, in microseconds."""

from __future__ import annotations

import math

import numpy as np

from wakeful.contracts.learner import Estimate, Estimates, Vector
from wakeful.learning.model import Model
from wakeful.learning.network import views
from wakeful.learning.novelty import Novelty
from wakeful.learning.rows import RowEstimator

_DIGITS = 9


class TwoHeadsPredictor:
    """One loaded model version. Each row takes the same path alone and in company: equal to the last bit."""

    def __init__(self, model: Model) -> None:
        self.treatments, self.labels = model.treatments, model.labels
        self.typical: Vector = model.mean
        self._mean, self._rate = model.mean, 1.0 / model.scale
        self._novelty: Novelty = model.novelty
        self._parts = views(model.theta, model.shape)
        k = model.shape.treatments
        self._cut = k
        cooling = np.repeat(1.0 / np.array(model.temperatures), (k, model.shape.labels))
        self._rows = RowEstimator(model)
        self._heads, self._heads_bias = self._parts.heads * cooling, self._parts.heads_bias * cooling

    def estimate(self, features: Vector) -> Estimate:
        """F_θ for one event's features, shape (d,); probabilities and novelty are rounded to 9 digits.

        Raises:
            ValueError: the features have another shape than the model's.
        """
        if features.shape != self._mean.shape:
            raise ValueError(f"features of shape {features.shape}; this model was fitted on {self._mean.shape}")
        x = (features - self._mean) * self._rate
        parts = self._parts
        hidden = np.maximum(x @ parts.first + parts.first_bias, 0.0)
        hidden = np.maximum(hidden @ parts.second + parts.second_bias, 0.0)
        out = (hidden @ self._heads + self._heads_bias).tolist()
        distance, cell = self._novelty.nearest(x) if len(self._novelty.exemplars) else (0.0, -1)
        return Estimate(
            treatments=shares(out[: self._cut]),
            labels=shares(out[self._cut :]),
            novelty=1.0 if cell < 0 else round(self._novelty.quantile(distance), _DIGITS),
            cell=cell,
        )

    def estimate_many(self, features: Vector) -> list[Estimate]:
        """The same for rows (n, d), one after the other: a product over many rows adds up in another order."""
        return [self.estimate(row) for row in features]

    def estimate_rows(self, features: Vector) -> Estimates:
        """The same for rows (n, d), all at once: equal in the digits that are kept, and many times faster.

        Raises:
            ValueError: the features have another shape than the model's.
        """
        if features.shape[1:] != self._mean.shape:
            raise ValueError(f"features of shape {features.shape[1:]}; this model was fitted on {self._mean.shape}")
        return self._rows.estimate(features)


def shares(logits_of_one: list[float]) -> Vector:
    """Softmax of a handful of numbers, rounded: several times faster than numpy's calls."""
    highest = max(logits_of_one)
    parts = [math.exp(number - highest) for number in logits_of_one]
    total = sum(parts)
    return np.array([round(part / total, _DIGITS) for part in parts])
