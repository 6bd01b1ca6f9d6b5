"""What repeated validations say of a thing that may change and is told with noise: a filter over both possibilities at once.

A repetition that ends otherwise is either told wrongly or the world has changed. Which of the two it was shows later: what was
told wrongly reverts, what has changed stays. So noise and change are estimated together, on a grid, from how well each pair has
foretold what came: a hidden Markov model with unknown parameters, the forward filter (Rabiner 1989, Section III-A) for each pair.
"""

from __future__ import annotations

from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

NOISE: Final = (0.002, 0.01, 0.03, 0.08, 0.15, 0.25, 0.40)
"""The share of validations that tell something else than what is so."""
CHANGE: Final = (0.0003, 0.001, 0.003, 0.01, 0.03, 0.1)
"""The chance that a thing is redrawn from one experience of the mind to the next, whatever that is an experience of."""
_NOISE = np.repeat(np.array(NOISE), len(CHANGE))
_CHANGE = np.tile(np.array(CHANGE), len(NOISE))
MEMORY: Final = 60.0
"""Validations over which the estimate forgets."""
_LEAST = 1e-12
_KEEP = 1.0 - 1.0 / MEMORY

#: So many foretold validations are counted in at a time.
TOGETHER: Final = 64


class Expected(msgspec.Struct, frozen=True):
    """How much noise and change are expected before anything has shown: exponential priors with these means.

    Chosen on seeds 1000 to 1019 of Experiment 3 by ``python -m wakeful.experiments.exp3_choice``.
    """

    noise: float = 0.15
    change: float = 0.03


class Repeatability:
    """How noise and change have shown so far, over all things together: a weight for each pair of the grid."""

    def __init__(self, expected: Expected | None = None) -> None:
        first = expected or Expected()
        self._prior: Floats = -_NOISE / first.noise - _CHANGE / first.change
        self._logs: Floats = np.zeros(len(_NOISE))
        self._waiting: list[tuple[float, int, int]] = []

    @property
    def logs(self) -> Floats:
        """The pairs' log weights, prior included, not normalised."""
        return self._prior + self._with_waiting()

    def learn(self, chances: Floats) -> None:
        """One validation: the chance that each pair had given to what came, (pairs,)."""
        if self._waiting:
            self._logs, self._waiting = self._with_waiting(), []
        self._logs = self._logs * _KEEP + np.log(np.maximum(chances, _LEAST))
        self._logs -= self._logs.max()

    def foretold(self, share: float, values: int, age: int) -> None:
        """One validation of a value among so many that had been foretold with probability ``share``, ``age`` experiences ago.

        Nearly all validations are of this kind: they are counted in by so many at once, at places that don't depend on who asks.
        """
        self._waiting.append((share, values, max(0, age)))
        if len(self._waiting) == TOGETHER:
            self._logs, self._waiting = self._with_waiting(), []

    def _with_waiting(self) -> Floats:
        """The log weights with what is not counted in yet."""
        if not self._waiting:
            return self._logs
        share, values, age = (column[:, None] for column in np.array(self._waiting, dtype=np.float64).T)
        even = 1.0 / values
        now = even + (share - even) * np.power(1.0 - _CHANGE, age)
        chances = now * (1.0 - _NOISE) + (1.0 - now) * _NOISE / np.maximum(1.0, values - 1.0)
        weights = _KEEP ** np.arange(len(values) - 1, -1, -1)
        logs = self._logs * _KEEP ** len(values) + weights @ np.log(np.maximum(chances, _LEAST))
        return np.asarray(logs - logs.max())

    @property
    def noise(self) -> float:
        """The expected share of wrong validations."""
        return float(_shares(self.logs) @ _NOISE)

    @property
    def change(self) -> float:
        """The expected chance of a change from one experience to the next."""
        return float(_shares(self.logs) @ _CHANGE)


class Belief:
    """What is held of one thing with k possible values, for each pair of the grid.

    Args:
        first: what is thought of it before anything was told, (k,).
        at: the number of the experience before which that holds.
    """

    def __init__(self, first: Floats, at: int) -> None:
        self._p: Floats = np.tile(first, (len(_NOISE), 1))
        self._own: Floats = np.zeros(len(_NOISE))
        self._at = at
        self.told = 0

    def learn(self, value: int, at: int, common: Repeatability) -> None:
        """It was told as ``value`` by experience ``at``; ``common`` learns from how well that had been foretold."""
        p, k = self._aged(at), self._p.shape[1]
        likely = np.full((len(_NOISE), k), (_NOISE / max(1, k - 1))[:, None])
        likely[:, value] = 1.0 - _NOISE
        joint = p * likely
        chances = joint.sum(axis=1)
        common.learn(chances)
        self._p = joint / chances[:, None]
        self._own += np.log(chances)
        self._at = at
        self.told += 1

    def shares(self, at: int, common: Repeatability) -> Floats:
        """The probability of each value before experience ``at``, (k,)."""
        return np.round(_shares(common.logs + self._own) @ self._aged(at), 9)

    def noise(self, common: Repeatability) -> float:
        """The expected share of wrong validations of this very thing."""
        return float(_shares(common.logs + self._own) @ _NOISE)

    def _aged(self, at: int) -> Floats:
        """What it may have been redrawn to since."""
        even = 1.0 / self._p.shape[1]
        kept = np.power(1.0 - _CHANGE, max(0, at - self._at))[:, None]
        return np.asarray(even + (self._p - even) * kept)


def _shares(logs: Floats) -> Floats:
    weights = np.exp(logs - logs.max())
    return np.asarray(weights / weights.sum())
