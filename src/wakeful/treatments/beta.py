"""The Beta distribution, as far as a probability learned from counts needs it: distribution, quantile, credible interval.

Source: the continued fraction of the incomplete beta function, Abramowitz and Stegun 26.5.8, evaluated by Lentz's method.
"""

from __future__ import annotations

from math import ceil, exp, lgamma, log

import msgspec

from wakeful.treatments.measures import significant

_TINY = 1e-300
_TERMS = 300
_CLOSE = 1e-13
#: Enough for nine digits, three more than results carry.
_HALVINGS = 30


class Belief(msgspec.Struct, frozen=True):
    """A probability as a Beta(hits, misses) distribution; both counts may be fractions and are above zero."""

    hits: float
    misses: float

    @classmethod
    def of(cls, probability: float, strength: float) -> Belief:
        """A prior of mean ``probability`` that weighs as much as ``strength`` cases. Extremes are kept off 0 and 1."""
        mean = min(max(probability, 0.005), 0.995)
        return cls(mean * strength, (1.0 - mean) * strength)

    def after(self, hits: float, misses: float) -> Belief:
        """The belief after so many more cases."""
        return Belief(self.hits + hits, self.misses + misses)

    @property
    def mean(self) -> float:
        """The expected probability."""
        return self.hits / (self.hits + self.misses)

    def interval(self, mass: float = 0.9) -> tuple[float, float]:
        """The equal-tailed credible interval that holds ``mass``."""
        tail = (1.0 - mass) / 2.0
        return significant(quantile(tail, self.hits, self.misses)), significant(quantile(1.0 - tail, self.hits, self.misses))

    def cases_to_halve(self) -> int:
        """About how many more cases, coming as expected, would halve the interval.

        The standard deviation is sqrt(mean (1 - mean) / (n + 1)), so n + 1 must become four times what it is.
        """
        return ceil(3.0 * (self.hits + self.misses + 1.0))


def distribution(x: float, a: float, b: float) -> float:
    """The regularised incomplete beta function I_x(a, b), for a and b above zero.

    >>> round(distribution(0.5, 2.0, 2.0), 12), round(distribution(0.2, 1.0, 3.0), 12)
    (0.5, 0.488)
    """
    if x <= 0.0:
        return 0.0
    if x >= 1.0:
        return 1.0
    front = exp(lgamma(a + b) - lgamma(a) - lgamma(b) + a * log(x) + b * log(1.0 - x))
    # the fraction converges fast only on the near side of the mean
    if x < (a + 1.0) / (a + b + 2.0):
        return min(front * _fraction(x, a, b) / a, 1.0)
    return max(1.0 - front * _fraction(1.0 - x, b, a) / b, 0.0)


def quantile(p: float, a: float, b: float) -> float:
    """The x at which I_x(a, b) is ``p``, by bisection.

    >>> round(quantile(0.5, 3.0, 3.0), 8)
    0.5
    """
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = (low + high) / 2.0
        if distribution(middle, a, b) < p:
            low = middle
        else:
            high = middle
    return (low + high) / 2.0


def _fraction(x: float, a: float, b: float) -> float:
    c, d = 1.0, _away(1.0 - (a + b) * x / (a + 1.0))
    d = 1.0 / d
    value = d
    for m in range(1, _TERMS + 1):
        even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m))
        odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))
        for term in (even, odd):
            d = 1.0 / _away(1.0 + term * d)
            c = _away(1.0 + term / c)
            value *= c * d
        if abs(c * d - 1.0) < _CLOSE:
            break
    return value


def _away(value: float) -> float:
    return _TINY if abs(value) < _TINY else value
