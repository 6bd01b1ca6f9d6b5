"""A band that a number usually stays in, learned as it goes: robust, forgetting, of fixed size."""

from __future__ import annotations

import math
from typing import Final

import msgspec

LOW, MIDDLE, HIGH = 0.05, 0.5, 0.95
"""The quantiles that are followed. Ten per cent outside do not move them, however far out they are."""

GAUSS: Final = 1.645
"""Standard deviations from the middle to the 95 % quantile of a normal distribution: makes `Band.score` read like one."""

STEP: Final = 2.0
FAR: Final = 8.0
"""A value counts as at most so many widths away: an enormous one moves the band no more than a large one."""


class Band(msgspec.Struct):
    """Three quantiles followed by stochastic approximation (Robbins and Monro 1951), started from the sorted first values.

    A step is bounded by the band's own width, so that outliers cannot stretch it, while a lasting change of level is taken up
    within about ``memory`` values. ``size`` follows the mean distance to the middle, each counted up to FAR widths, and keeps a
    constant channel from getting stuck at zero width.
    """

    count: int = 0
    first: list[float] = []
    low: float = 0.0
    middle: float = 0.0
    high: float = 0.0
    size: float = 0.0

    @property
    def learned(self) -> bool:
        """Whether there is a band yet."""
        return self.count > 0 and not self.first

    @property
    def usual(self) -> float:
        """The middle, to a hundredth of the band's width: more digits would be noise."""
        width = max(self.high - self.low, self.size)
        return round(self.middle, 2 - math.floor(math.log10(width))) + 0.0 if width > 1e-100 else self.middle

    def score(self, value: float, floor: float = 0.0) -> float:
        """How far out a value is: 0 at the middle, ±1 a (robust, one-sided) standard deviation, whatever the skew.

        Args:
            value: the number to judge.
            floor: the least standard deviation that counts, in the value's unit.
        """
        away = value - self.middle
        spread = (self.high - self.middle if away > 0 else self.middle - self.low) / GAUSS
        if spread > floor and spread > 0.05 * self.size:
            least = 1e-6 * abs(self.middle) + 1e-12
            return away / (spread if spread > least else least)
        return away / max(floor, spread, 0.05 * self.size, 1e-6 * abs(self.middle) + 1e-12)

    def learn(self, value: float, warm_up: int, memory: float) -> None:
        """Take up a value. The band is there after ``warm_up`` values and forgets over about ``memory`` of them."""
        self.count += 1
        if self.first or self.count == 1:
            self.first.append(value)
            if len(self.first) >= warm_up:
                self._start()
            return
        low, middle, high = self.low, self.middle, self.high
        rate = 1.0 / (self.count if self.count < memory else memory)
        width = high - low
        away = abs(value - middle)
        most = FAR * (width if width > self.size else self.size)
        self.size += rate * ((away if away < most or most == 0.0 else most) - self.size)
        step = STEP * rate * (width if width > self.size else self.size)
        if value != low:
            low += step * (LOW if value > low else LOW - 1.0)
        if value != high:
            high += step * (HIGH if value > high else HIGH - 1.0)
        if value != middle:
            middle += step * (MIDDLE if value > middle else -MIDDLE)
        self.low, self.middle, self.high = (low if low < middle else middle), middle, (high if high > middle else middle)

    def _start(self) -> None:
        ordered = sorted(self.first)
        last = len(ordered) - 1
        self.low, self.middle, self.high = (ordered[round(share * last)] for share in (LOW, MIDDLE, HIGH))
        most = FAR * (self.high - self.low) or math.inf
        self.size = sum(min(abs(value - self.middle), most) for value in ordered) / len(ordered)
        self.first = []
