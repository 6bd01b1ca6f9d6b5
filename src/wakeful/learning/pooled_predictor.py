"""A pooled model version as selection uses it."""

from __future__ import annotations

import math

import msgspec
import numpy as np

from wakeful.contracts.grounds import Grounds, Part
from wakeful.contracts.learner import Estimate, Estimates, Vector
from wakeful.learning.experts import LEAST, logs_of, pooled
from wakeful.learning.panel import EXPERTS, PanelReader
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
        network, rules, trees = self._each
        logits = [network * n + rules * r + trees * t for n, r, t in self._said(features, found.treatments)]
        return Estimate(treatments=shares(logits), labels=found.labels, novelty=found.novelty, cell=found.cell)

    def grounds(self, features: Vector, treatment: str) -> Grounds | None:
        """Which rules spoke for the treatment, and how far network, rules and trees moved it against the likeliest other one.

        Nothing is sampled or fitted for it: these are the terms of which ``estimate`` made its probabilities.
        """
        if treatment not in self.treatments or len(self.treatments) < 2:
            return None
        own = self.treatments.index(treatment)
        ranked = self.estimate(features).treatments.tolist()
        other = max((place for place in range(len(ranked)) if place != own), key=lambda place: ranked[place])
        said = self._said(features, super().estimate(features).treatments)
        parts = [
            Part(name, round(weight * (mine - theirs), _DIGITS))
            for name, weight, mine, theirs in zip(EXPERTS, self._each, said[own], said[other], strict=True)
        ]
        return Grounds(
            treatment=treatment,
            against=self.treatments[other],
            parts=tuple(part for part, weight in zip(parts, self._each, strict=True) if weight > 0.0),
            rules=self._panel.heard(features, own) if self._each[1] > 0.0 else (),
        )

    def _said(self, features: Vector, by_network: Vector) -> list[tuple[float, float, float]]:
        """For each treatment what network, rules and trees say: logarithms of probabilities, up to a constant each."""
        by_rules, by_trees = self._panel.alone(features)
        return [
            (math.log(max(n, LEAST)), math.log(max(r, LEAST)), t)
            for n, r, t in zip(by_network.tolist(), by_rules, by_trees, strict=True)
        ]

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
