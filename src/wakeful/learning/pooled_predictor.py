"""A pooled model version as selection uses it."""

from __future__ import annotations

import math

import msgspec
import numpy as np

from wakeful.contracts.learner import Estimate, Estimates, Vector
from wakeful.learning.experts import LEAST, logs_of, pooled
from wakeful.learning.panel import PanelReader
from wakeful.learning.pooled_weights import PooledModel
from wakeful.learning.predictor import TwoHeadsPredictor, shares

_DIGITS = 9


class PooledPredictor(TwoHeadsPredictor):
    """One loaded model version: the network's estimate, its treatments joined by what lists and trees say."""

    def __init__(self, model: PooledModel) -> None:
        super().__init__(model.network)
        self.model = model
        self._panel = PanelReader(model.whole)
        self._weights = np.array(model.weights)
        self._each = model.weights

    def estimate(self, features: Vector) -> Estimate:
        """F_θ for one event's features, shape (d,); probabilities and novelty are rounded to 9 digits.

        Raises:
            ValueError: the features have another shape than the model's.
        """
        found = super().estimate(features)
        by_rules, by_trees = self._panel.alone(features)
        network, rules, trees = self._each
        logits = [
            network * math.log(max(n, LEAST)) + rules * math.log(max(r, LEAST)) + trees * t
            for n, r, t in zip(found.treatments.tolist(), by_rules, by_trees, strict=True)
        ]
        return Estimate(treatments=shares(logits), labels=found.labels, novelty=found.novelty, cell=found.cell)

    def estimate_rows(self, features: Vector) -> Estimates:
        """The same for rows (n, d), all at once.

        Raises:
            ValueError: the features have another shape than the model's.
        """
        found = super().estimate_rows(features)
        if not len(features):
            return found
        logs = np.concatenate([logs_of(found.treatments)[None], self._panel.logs_many(features)])
        return msgspec.structs.replace(found, treatments=np.round(pooled(logs, self._weights), _DIGITS))
