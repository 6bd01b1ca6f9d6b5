"""What a model version says of many events at once, and the automatic decisions that follow: the hot path of selection.

A batch only foresees what depends on event and model version alone. Each decision is made when its event is covered, by the
trust and the experience of that instant, so that decisions don't depend on how events were batched.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from wakeful.contracts.learner import Estimate, Estimates
from wakeful.facts.choices import DIGITS, Basis, Choice

Seen: TypeAlias = tuple[Basis, tuple[float, ...], tuple[float, ...], float, int, bool, Estimates, int]
"""What one model version says of one event: what an automatic decision would have in common with others, shares, prior, novelty,
cell, whether nothing in all this speaks against it; then the batch's estimates, and the event's place among them."""


class Foresight:
    """The gate of one model version, for many events at once.

    Args:
        bases: for each allowed treatment, in their order, what its automatic decisions have in common.
        places: for each of them its place in the model's estimates; None where the model does not know it.
        needed_support: validated experiences that a treatment needs.
    """

    def __init__(self, bases: Sequence[Basis], places: Sequence[int | None], needed_support: int) -> None:
        self._bases = tuple(bases)
        self._from = [place for place in places if place is not None]
        self._to = [at for at, place in enumerate(places) if place is not None]
        self._thresholds = np.array([basis.threshold for basis in bases])
        self._supported = np.array([basis.support >= needed_support for basis in bases])
        self._needed = round(bases[0].result_threshold, DIGITS)
        self._novelty_limit = bases[0].novelty_limit
        self._trust_limit = bases[0].trust_limit

    def see(self, found: Estimates) -> list[Seen]:
        """What follows from the model's estimates of n events."""
        n = len(found.cells)
        raw = np.zeros((n, len(self._bases)))
        raw[:, self._to] = found.treatments[:, self._from]
        total = raw.sum(axis=1)
        possible = total > 0.0
        shares = np.round(raw / np.where(possible, total, 1.0)[:, None], DIGITS)
        prior = np.round(found.labels, DIGITS)
        novelty = np.round(found.novelty, DIGITS)
        chosen = shares.argmax(axis=1)
        fit = (
            possible
            & (novelty <= self._novelty_limit)
            & self._supported[chosen]
            & (shares[np.arange(n), chosen] >= self._thresholds[chosen])
            & (prior.max(axis=1) >= self._needed)
        )
        bases = self._bases
        return list(
            zip(
                [bases[each] for each in chosen.tolist()],
                map(tuple, shares.tolist()),
                map(tuple, prior.tolist()),
                novelty.tolist(),
                found.cells.tolist(),
                fit.tolist(),
                [found] * n,
                range(n),
                strict=True,
            )
        )

    def choose(self, seen: Seen, trust: float, rests_on: tuple[int, ...]) -> Choice | None:
        """The automatic decision, if there is to be one.

        Args:
            seen: what the model says of the event.
            trust: in the treatment that it would choose, as of now.
            rests_on: the nearest experiences, as of now.
        """
        trust = round(trust, DIGITS)
        if not seen[5] or trust < self._trust_limit:
            return None
        return Choice(basis=seen[0], shares=seen[1], prior=seen[2], novelty=seen[3], trust=trust, rests_on=rests_on, cell=seen[4])


def alone(estimate: Estimate) -> Estimates:
    """The estimate of one event as a batch of one."""
    return Estimates(
        treatments=estimate.treatments[None, :],
        labels=estimate.labels[None, :],
        novelty=np.array([estimate.novelty]),
        cells=np.array([estimate.cell]),
    )


def of_one(seen: Seen) -> Estimate:
    """The model's estimate of that event."""
    found, place = seen[6], seen[7]
    return Estimate(
        treatments=found.treatments[place],
        labels=found.labels[place],
        novelty=float(found.novelty[place]),
        cell=int(found.cells[place]),
    )
