"""Whether a value is unusual among others, how large a shift is, and when it began.

Sources: robust z by median and median absolute deviation (Iglewicz and Hoaglin 1993); Cliff's delta (Cliff 1993); change point
by the largest excursion of the cumulative sum (Page 1954; Taylor 2000), over robustly standardised values.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from itertools import accumulate, pairwise
from statistics import fmean, median

import msgspec

#: 1 / Φ⁻¹(3/4): makes the median absolute deviation estimate a normal standard deviation.
_MAD_TO_SD = 1.4826

#: 1 / mean absolute deviation of a unit normal: where over half the values are equal and the former is zero.
_MEAN_TO_SD = 1.2533

#: A CUSUM excursion beyond this many standard deviations times sqrt(n) is a change: the 99 % point of the Brownian bridge's
#: largest absolute value (Kolmogorov's distribution).
_EXCURSION = 1.628


class Shift(msgspec.Struct, frozen=True):
    """A change point: the index of the first value after it, the means on either side, and the excursion's size."""

    at: int
    before: float
    after: float
    excursion: float


def spread(values: Sequence[float]) -> float:
    """A robust standard deviation; 0.0 where all values are equal or there are none."""
    if not values:
        return 0.0
    middle = median(values)
    away = [abs(value - middle) for value in values]
    return _MAD_TO_SD * median(away) or _MEAN_TO_SD * fmean(away)


def robust_z(value: float, others: Sequence[float]) -> float | None:
    """How many robust standard deviations the value is from the others' median; None of fewer than three, or without spread
    where the value differs (any number would do).

    >>> round(robust_z(5.0, [1.0, 2.0, 3.0]), 3)
    2.023
    """
    if len(others) < 3:
        return None
    width = spread(others)
    off = value - median(others)
    return off / width if width > 0.0 else 0.0 if off == 0.0 else None


def cliffs_delta(a: Sequence[float], b: Sequence[float]) -> float | None:
    """P(a > b) - P(a < b), in [-1, 1]; None where either is empty.

    >>> round(cliffs_delta([3.0, 4.0], [1.0, 2.0, 3.0]), 3)
    0.833
    """
    if not a or not b:
        return None
    ordered = sorted(b)
    more = sum(bisect_left(ordered, value) for value in a)
    less = sum(len(ordered) - bisect_right(ordered, value) for value in a)
    return (more - less) / (len(a) * len(b))


def change_point(values: Sequence[float]) -> Shift | None:
    """The one most likely change of level in a sequence, oldest first; None where there is none or fewer than six values.

    The values are standardised by the spread of their successive differences, which a single step hardly widens.

    >>> change_point([1.0, 1.2, 0.9, 1.1, 5.0, 5.1, 4.9, 5.2]).at
    4
    """
    if len(values) < 6:
        return None
    width = spread([b - a for a, b in pairwise(values)]) / 2**0.5
    if width <= 0.0:
        width = spread(values)
    if width <= 0.0:
        return None
    mean = fmean(values)
    sums = list(accumulate((value - mean) / width for value in values))[:-1]
    at = max(range(len(sums)), key=lambda index: abs(sums[index]))
    excursion = abs(sums[at]) / len(values) ** 0.5
    if excursion < _EXCURSION:
        return None
    return Shift(at + 1, fmean(values[: at + 1]), fmean(values[at + 1 :]), excursion)
