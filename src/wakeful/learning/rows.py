"""F_θ and novelty for many events at once: one matrix product gives the first layer and all distances to exemplars."""

from __future__ import annotations

import numpy as np

from wakeful.contracts.learner import Estimates, Vector
from wakeful.learning.material import Floats
from wakeful.learning.model import Model
from wakeful.learning.network import views
from wakeful.learning.novelty import TIE, quantiles

_DIGITS = 9


class RowEstimator:
    """One model version, with standardisation and temperatures folded into its matrices.

    The sums add up in another order than one by one, which changes the last of sixteen digits; nine are kept.

    Args:
        model: with exemplars (m, d), hidden units h, inputs d.
    """

    def __init__(self, model: Model) -> None:
        parts, novelty = views(model.theta, model.shape), model.novelty
        rate = 1.0 / model.scale
        shift = model.mean * rate
        self._hidden = model.shape.hidden
        self._cut = model.shape.treatments
        exemplars: Floats = novelty.exemplars.reshape(-1, len(rate))
        self._joint = np.hstack([rate[:, None] * parts.first, -2.0 * rate[:, None] * exemplars.T, -2.0 * (shift * rate)[:, None]])
        self._bias = np.concatenate(
            [
                parts.first_bias - shift @ parts.first,
                novelty.norms + 2.0 * (exemplars @ shift) + TIE * np.arange(len(exemplars)),
                [float(shift @ shift)],
            ]
        )
        self._squares = rate * rate
        self._second, self._second_bias = parts.second, parts.second_bias
        cooling = np.repeat(1.0 / np.array(model.temperatures), (self._cut, model.shape.labels))
        self._heads, self._heads_bias = parts.heads * cooling, parts.heads_bias * cooling
        self._novelty = novelty

    def estimate(self, features: Vector) -> Estimates:
        """The estimates of rows (n, d)."""
        # Most columns are 0 in every event of a batch (kinds, buckets and phases that none of them has).
        used = np.flatnonzero(features.any(axis=0))
        x = features[:, used]
        out = x @ self._joint[used]
        out += self._bias
        h = self._hidden
        hidden = np.maximum(out[:, :h], 0.0)
        hidden = np.maximum(hidden @ self._second + self._second_bias, 0.0)
        logits = hidden @ self._heads + self._heads_bias
        n = len(features)
        if out.shape[1] > h + 1:
            apart = out[:, h:-1]
            cells = apart.argmin(axis=1)
            least = apart[np.arange(n), cells] - TIE * cells + out[:, -1] + (x * x) @ self._squares[used]
            novelty = quantiles(self._novelty.reference, np.round(np.sqrt(np.maximum(least, 0.0)), 6))
        else:
            cells, novelty = np.full(n, -1), np.ones(n)
        return Estimates(
            treatments=_shares(logits[:, : self._cut]),
            labels=_shares(logits[:, self._cut :]),
            novelty=np.round(novelty, _DIGITS),
            cells=cells,
        )


def _shares(logits: Floats) -> Floats:
    parts = np.exp(logits - logits.max(axis=1, keepdims=True))
    parts /= parts.sum(axis=1, keepdims=True)
    return np.asarray(np.round(parts, _DIGITS))
