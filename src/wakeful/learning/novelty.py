"""Novelty: how far an event is from experience, as a quantile of how far familiar events are from each other."""

from __future__ import annotations

import math
from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

NEAR: Final = 0.5
"""Distances below this (in standardised units) are never told apart: a world of a few repeated events would otherwise call
every small difference unfamiliar."""
_TAIL = 4.0
_ENOUGH_HELD_BACK = 20


class Novelty(msgspec.Struct, frozen=True):
    """What is familiar: exemplars (m, d), standardised, and the sorted distances of familiar events to them."""

    exemplars: Floats
    reference: Floats

    def of(self, x: Floats) -> float:
        """The novelty in [0, 1] of one standardised row, shape (d,).

        Within the reference it is the share of familiar distances that are smaller. Beyond the farthest it goes on to 1 as
        1 − (farthest / distance)^4 / (n + 1), so that a short reference doesn't call everything a little farther
        unheard of.
        """
        if not len(self.exemplars):
            return 1.0
        return self.quantile(nearest(self.exemplars, x))

    def quantile(self, distance: float) -> float:
        """The novelty of something at this distance from the nearest exemplar."""
        n = len(self.reference)
        if n == 0:
            return 1.0
        distance, farthest = max(distance, NEAR), max(float(self.reference[-1]), NEAR)
        if distance > farthest:
            return 1.0 - math.pow(farthest / distance, _TAIL) / (n + 1)
        if distance <= NEAR:
            return 0.0
        return float(np.searchsorted(self.reference, distance, side="left")) / (n + 1)


def nearest(exemplars: Floats, x: Floats) -> float:
    """The distance of x to its nearest exemplar. No BLAS: the sum over a row is the same in any company."""
    apart = exemplars - x
    squares: Floats = np.einsum("ij,ij->i", apart, apart)
    return math.sqrt(squares.min())


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
    kept = cover(learned, limit)
    exemplars = learned[kept].astype(np.float32).astype(np.float64)
    if len(held_back) >= _ENOUGH_HELD_BACK:
        reference = [nearest(exemplars, row) for row in held_back]
    else:
        reference = [nearest(np.delete(learned, i, axis=0), row) for i, row in enumerate(learned)] if len(learned) > 1 else []
        reference += [nearest(exemplars, row) for row in held_back]
    return Novelty(exemplars, np.sort(np.round(np.array(reference, dtype=np.float64), 9)))


def cover(rows: Floats, limit: int) -> list[int]:
    """Indices of at most ``limit`` rows that cover all (greedy k-centre): the newest first, then each time the farthest."""
    if len(rows) <= limit:
        return list(range(len(rows)))
    chosen = [len(rows) - 1]
    apart = rows - rows[-1]
    least = np.einsum("ij,ij->i", apart, apart)
    while len(chosen) < limit:
        at = int(np.argmax(np.round(least, 9)))
        chosen.append(at)
        apart = rows - rows[at]
        least = np.minimum(least, np.einsum("ij,ij->i", apart, apart))
    return sorted(chosen)
