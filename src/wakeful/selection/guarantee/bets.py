"""Evidence that a risk lies under a level, as the capital of bets against the contrary: valid whenever one looks.

Whoever doubts the rule says that its risk E[X] is at least r. A bet that pays 1 + b (r − X) on each event is then unfavourable,
so the capital exceeds 1/δ at any time with probability at most δ (Ville's inequality). X is what an event contributes to the
risk: 1/p where the event was wrong, would be automatic and was drawn with probability p, else 0. With b = c / (1/p − r) an
error leaves 1 − c of the capital and every other event multiplies it by 1 + c r p / (1 − r p). Several shares c are bet side by
side (Waudby-Smith and Ramdas 2024, *Estimating means of bounded random variables by betting*).
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Counts = npt.NDArray[np.int64]
Flags = npt.NDArray[np.bool_]

LEVELS: Final = (0.99, 0.98, 0.97, 0.96, 0.94, 0.92, 0.90, 0.85, 0.80, 0.75, 0.70, 0.60, 0.50, 0.40, 0.20, 0.0)
"""The thresholds that may be certified for the score, the strictest first."""
SHARES: Final = (1.0, 0.9, 0.8, 0.65, 0.5, 0.35, 0.2, 0.1)
"""The shares c of the capital that are at stake with each event."""
WEIGHTS: Final = (0.3, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1)
"""How the first capital of 1 is split over the shares."""

_PLACES = np.arange(len(LEVELS))
_NEGATED = -np.array(LEVELS)
_SHARES = np.array(SHARES)
_LOG_WEIGHTS = np.log(np.array(WEIGHTS))
#: Log of what an error leaves. Nothing is left of a share of 1: a finite number, so that no error times it is no NaN.
_LOG_LEFT = np.where(_SHARES < 1.0, np.log1p(-np.minimum(_SHARES, 0.999)), -1e9)
_BISECTIONS = 40


def place_of(score: float | Floats) -> Counts:
    """The index of the strictest level that the score reaches; ``len(LEVELS)`` where it reaches none."""
    return np.searchsorted(_NEGATED, -np.asarray(score, dtype=np.float64), side="left")


class Tally:
    """What was seen of a rule at each level: events without an error by the probability of their draw, and errors.

    Args:
        shape: () for one treatment; (n,) counts n of them side by side.
    """

    def __init__(self, shape: tuple[int, ...] = ()) -> None:
        self.shape = (*shape, len(LEVELS))
        self.errors: Counts = np.zeros(self.shape, dtype=np.int64)
        self.quiet: dict[float, Counts] = {1.0: np.zeros(self.shape, dtype=np.int64)}

    def count(self, place: Counts, wrong: Flags, probability: float, where: Flags | None = None) -> None:
        """Count one event each.

        Args:
            place: the strictest level that its score reaches, ``shape``. At stricter levels it is not automatic: no error
                there, whatever its outcome.
            wrong: whether it was drawn and its answer was wrong, ``shape``.
            probability: with which its draw was made.
            where: count only there; everywhere without it.
        """
        automatic = np.asarray(place)[..., None] <= _PLACES
        counted = np.ones(self.shape, dtype=np.bool_) if where is None else np.broadcast_to(where[..., None], self.shape)
        missed = automatic & np.asarray(wrong)[..., None]
        if probability not in self.quiet:
            self.quiet[probability] = np.zeros(self.shape, dtype=np.int64)
        self.errors += counted & missed
        self.quiet[probability] += counted & automatic & ~missed
        self.quiet[1.0] += counted & ~automatic

    def clear(self, where: Flags) -> None:
        """Forget everything there."""
        self.errors[where] = 0
        for counts in self.quiet.values():
            counts[where] = 0

    def log_capital(self, risk: float | Floats, place: Counts | None = None) -> Floats:
        """Log of the capital against "the risk is at least ``risk``".

        Returns:
            At each level, ``(*shape, levels)``; or at one level each, ``place``, both of ``shape``.
        """
        level = np.asarray(risk, dtype=np.float64)[..., None]
        logs = _at(self.errors, place)[..., None] * _LOG_LEFT
        for probability, counts in self.quiet.items():
            gains = np.log1p(_SHARES * level * probability / (1.0 - level * probability))
            logs = logs + _at(counts, place)[..., None] * gains
        logs = logs + _LOG_WEIGHTS
        top = logs.max(axis=-1)
        return np.asarray(top + np.log(np.exp(logs - top[..., None]).sum(axis=-1)))

    def bound(self, delta: float) -> Floats:
        """The least risk that is refuted at each level: the risk lies under it, at every time at once, with probability 1 − δ."""
        low, high = np.zeros(self.shape), np.ones(self.shape)
        for _ in range(_BISECTIONS):
            middle = (low + high) / 2.0
            refuted = self.log_capital(middle) >= -math.log(delta)
            low, high = np.where(refuted, low, middle), np.where(refuted, middle, high)
        return high

    def more_needed(self, place: int, alpha: float, delta: float) -> int:
        """How many more events without an error, each drawn for sure, certify the level at ``place`` (one tally only)."""
        at, limit = np.asarray(place), -math.log(delta)
        ahead = Tally()
        ahead.errors, ahead.quiet = self.errors, dict(self.quiet)

        def certified(more: int) -> bool:
            ahead.quiet[1.0] = self.quiet[1.0] + more
            return float(ahead.log_capital(alpha, at)) >= limit

        if certified(0):
            return 0
        high = 1
        while not certified(high):
            high *= 2
        low = high // 2
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if certified(middle) else (middle, high)
        return high


def _at(counts: Counts, place: Counts | None) -> Counts:
    return counts if place is None else np.take_along_axis(counts, np.asarray(place)[..., None], axis=-1)[..., 0]
