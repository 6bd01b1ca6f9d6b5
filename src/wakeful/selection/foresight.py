"""What a model version says of many events at once, and the automatic decisions that follow: the hot path of selection.

A batch only foresees what depends on event and model version alone. Each decision is made when its event is covered, by the
trust and the experience of that instant, so that decisions don't depend on how events were batched.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import msgspec
import numpy as np

from wakeful.contracts.learner import Estimate, Estimates, Vector
from wakeful.facts.choices import DIGITS, Basis, Choice


class Seen(msgspec.Struct, frozen=True):
    """What one model version says of one event. ``fit``: nothing in it speaks against an automatic decision."""

    estimate: Callable[[], Estimate]
    basis: Basis | None
    shares: tuple[float, ...]
    prior: tuple[float, ...]
    novelty: float
    cell: int
    fit: bool


class Foresight:
    """One model version's gate, for many events at once.

    Args:
        bases: for each allowed treatment, in their order, what its automatic decisions rest on.
        places: for each allowed treatment its place in the model's estimates; None where the model does not know it.
    """

    def __init__(self, bases: Sequence[Basis], places: Sequence[int | None], needed_support: int) -> None:
        self._bases = tuple(bases)
        self._known = [place for place in places if place is not None]
        self._unknown = [at for at, place in enumerate(places) if place is None]
        self._at = [at for at, place in enumerate(places) if place is not None]
        self._whole = self._known == list(range(len(places)))
        self._thresholds = np.array([basis.threshold for basis in bases])
        self._supported = np.array([basis.support >= needed_support for basis in bases])
        self._needed = bases[0].result_threshold
        self._novelty_limit = bases[0].novelty_limit

    def see(self, found: Estimates) -> list[Seen]:
        """What follows from the model's estimates of n events."""
        n = len(found.cells)
        if self._whole and found.treatments.shape[1] == len(self._bases):
            raw = found.treatments
        else:
            raw = np.zeros((n, len(self._bases)))
            raw[:, self._at] = found.treatments[:, self._known]
        total = raw.sum(axis=1)
        possible = total > 0.0
        shares = np.round(np.round(raw / np.where(possible, total, 1.0)[:, None], 9), DIGITS)
        prior = np.round(found.labels, DIGITS)
        novelty = np.round(found.novelty, DIGITS)
        chosen = shares.argmax(axis=1)
        confidence = shares[np.arange(n), chosen]
        fit = (
            possible
            & (novelty <= self._novelty_limit)
            & self._supported[chosen]
            & (confidence >= self._thresholds[chosen])
            & (prior.max(axis=1) >= self._needed)
        )
        bases = self._bases
        return [
            Seen(_later(found, place), bases[which], tuple(own), tuple(labels), new, cell, fits)
            for place, (which, own, labels, new, cell, fits) in enumerate(
                zip(
                    chosen.tolist(),
                    shares.tolist(),
                    prior.tolist(),
                    novelty.tolist(),
                    found.cells.tolist(),
                    fit.tolist(),
                    strict=True,
                )
            )
        ]
