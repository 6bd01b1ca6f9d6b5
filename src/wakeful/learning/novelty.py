"""Novelty: how far an event is from experience, as a quantile of how far familiar events are from each other."""

from __future__ import annotations

import math
from bisect import bisect_left
from typing import Final

import numpy as np

from wakeful.learning.material import Floats

NEAR: Final = 0.5
"""Distances below this (in standardised units) are never told apart: a world of a few repeated events would otherwise call
every small difference unfamiliar."""
TIE: Final = 1e-9
"""Each further exemplar is taken to be so much farther: of those equally near, up to rounding errors, the first counts."""
_TAIL = 4.0
_ENOUGH_HELD_BACK = 20
_DIGITS = 6


class Novelty:
    """What is familiar: exemplars (m, d), standardised, and the sorted distances of familiar events to them (n,)."""

    def __init__(self, exemplars: Floats, reference: Floats) -> None:
        self.exemplars, self.reference = exemplars, reference
        self.norms = squares(exemplars)
        self._ranked = self.norms + TIE * np.arange(len(exemplars))
        self._steps = reference.tolist()

    def of(self, x: Floats) -> float:
        """The novelty in [0, 1] of one standardised row, shape (d,).

        Within the reference it is the share of familiar distances that are smaller. Beyond the farthest it goes on to 1 as
        1 − (farthest / distance)^4 / (n + 1), so that a short reference doesn't call everything a little farther
        unheard of.
        """
        return self.quantile(self.distance(x)) if len(self.exemplars) else 1.0

    def distance(self, x: Floats) -> float:
        """The distance to the nearest exemplar, rounded to 6 digits: far more than it errs by."""
        return self.nearest(x)[0]

    def nearest(self, x: Floats) -> tuple[float, int]:
        """The same, and which exemplar that is: the cell of experience that the row lies in."""
        apart = self._ranked - 2.0 * (self.exemplars @ x)
        cell = int(apart.argmin())
        least = float(apart[cell]) - TIE * cell + float(x @ x)
        return round(math.sqrt(max(0.0, least)), _DIGITS), cell

    def quantile(self, distance: float) -> float:
        """The novelty of something at this distance from the nearest exemplar."""
        n = len(self._steps)
        if n == 0:
            return 1.0
        if distance <= NEAR:
            return 0.0
        farthest = max(self._steps[-1], NEAR)
        if distance > farthest:
            return 1.0 - math.pow(farthest / distance, _TAIL) / (n + 1)
        return bisect_left(self._steps, distance) / (n + 1)


def quantiles(reference: Floats, distances: Floats) -> Floats:
    """``Novelty.quantile`` of many distances, (n,), by a sorted reference."""
    n = len(reference)
    if n == 0:
        return np.ones(len(distances))
    farthest = max(float(reference[-1]), NEAR)
    inside = np.searchsorted(reference, distances, side="left") / (n + 1)
    beyond = 1.0 - np.power(farthest / np.maximum(distances, farthest), _TAIL) / (n + 1)
    return np.where(distances <= NEAR, 0.0, np.where(distances > farthest, beyond, inside))


def squares(rows: Floats) -> Floats:
    """The squared length of each row, (n,)."""
    return np.asarray(np.einsum("ij,ij->i", rows, rows))


def learn_novelty(learned: Floats, held_back: Floats, limit: int) -> Novelty:
    """The novelty reference of a model version.

    Args:
        learned: standardised rows that were learned from, (n, d).
        held_back: standardised rows that were not, (m, d).
        limit: how many exemplars are kept.

    Returns:
        Exemplars that cover what was learned (each next one the farthest from those before, so that what was seen once is
        kept), as float32 numbers; and the distances of the held-back rows, joined by those of each learned row from the
        others where the held-back ones are few.
    """
    known = Novelty(learned[cover(learned, limit)].astype(np.float32).astype(np.float64), np.zeros(0))
    reference = [known.distance(row) for row in held_back]
    if len(held_back) < _ENOUGH_HELD_BACK:
        others = [Novelty(np.delete(learned, i, axis=0), np.zeros(0)) for i in range(len(learned))] if len(learned) > 1 else []
        reference += [rest.distance(row) for rest, row in zip(others, learned, strict=False)]
    return Novelty(known.exemplars, np.sort(np.array(reference, dtype=np.float64)))


def cover(rows: Floats, limit: int) -> list[int]:
    """Indices of at most ``limit`` rows that cover all (greedy k-centre): the newest first, then each time the farthest."""
    if len(rows) <= limit:
        return list(range(len(rows)))
    chosen = [len(rows) - 1]
    least = squares(rows - rows[-1])
    while len(chosen) < limit:
        at = int(np.argmax(np.round(least, 9)))
        chosen.append(at)
        least = np.minimum(least, squares(rows - rows[at]))
    return sorted(chosen)
