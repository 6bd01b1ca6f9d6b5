"""Binomial bounds for a sample of fixed size: what a calibration set alone can promise."""

from __future__ import annotations

import math

_STEPS = 60


def error_free_needed(alpha: float, delta: float) -> int:
    """How many error-free cases hold a risk under ``alpha`` with probability 1 − ``delta``: the least n with (1 − α)^n ≤ δ.

    >>> error_free_needed(0.05, 0.05), error_free_needed(0.01, 0.05)
    (59, 299)
    """
    return math.ceil(math.log(delta) / math.log1p(-alpha))


def at_most(errors: int, cases: int, risk: float) -> float:
    """P(Binomial(cases, risk) ≤ errors).

    >>> round(at_most(0, 59, 0.05), 4), at_most(3, 3, 0.5)
    (0.0485, 1.0)
    """
    if errors >= cases or risk <= 0.0:
        return 1.0
    if errors < 0 or risk >= 1.0:
        return 0.0
    log_risk, log_rest = math.log(risk), math.log1p(-risk)
    top = math.lgamma(cases + 1)
    logs = (
        top - math.lgamma(k + 1) - math.lgamma(cases - k + 1) + k * log_risk + (cases - k) * log_rest for k in range(errors + 1)
    )
    return min(1.0, math.fsum(math.exp(value) for value in logs))


def clopper_pearson(errors: int, cases: int, delta: float) -> float:
    """The upper bound on a risk that holds with probability 1 − ``delta``, after ``errors`` in a sample of ``cases``.

    Exact and distribution-free for exchangeable cases looked at once (Clopper and Pearson 1934); 1 without any cases.

    >>> round(clopper_pearson(0, 42, 0.05), 4), round(clopper_pearson(0, 59, 0.05), 4)
    (0.0688, 0.0495)
    """
    if cases <= 0 or errors >= cases:
        return 1.0
    low, high = errors / cases, 1.0
    for _ in range(_STEPS):
        middle = (low + high) / 2.0
        if at_most(errors, cases, middle) > delta:
            low = middle
        else:
            high = middle
    return high


def most(cases: int, risk: float, delta: float) -> int:
    """The least k with P(Binomial(cases, risk) > k) ≤ delta.

    >>> most(100, 0.0, 0.05), most(10, 1.0, 0.05), most(100, 0.5, 0.05)
    (0, 10, 58)
    """
    low, high = -1, cases
    while high - low > 1:
        middle = (low + high) // 2
        if at_most(middle, cases, risk) >= 1.0 - delta:
            high = middle
        else:
            low = middle
    return high
