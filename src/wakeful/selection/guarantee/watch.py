"""The watch over a certified rule: revokes it when its errors come too fast, and how many may come before it does.

A running likelihood ratio between "wrong and automatic with probability ``to``" and "with probability α", which never falls
below where it began (Page's CUSUM): the largest of the e-processes begun at each event, an e-detector of Shin, Ramdas and
Rinaldo (2023). While the risk is at most α, on average at least ``patience`` events pass before a false alarm.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from wakeful.selection.guarantee.bets import Flags, Floats
from wakeful.selection.guarantee.bounds import most

_RISKS = 24
#: The heights of the watch that are told apart.
_STEPS = 4000


def step(log_ratio: Floats, error: Flags, probability: float, alpha: float, to: float) -> Floats:
    """The watch after one more event, in logs; it begins at 0.

    Args:
        log_ratio: the watch so far, any shape.
        error: whether the event was drawn, automatic and wrong, of the same shape.
        probability: with which it was drawn: a wrong one shows itself only as often as that.
        alpha: the risk that was promised.
        to: the risk after a change of the declared size.
    """
    none = math.log1p(-probability * to) - math.log1p(-probability * alpha)
    return np.maximum(0.0, log_ratio + np.where(error, math.log(to / alpha), none))


@lru_cache(maxsize=1024)
def events_to_alarm(risk: float, alpha: float, to: float, audit_rate: float, patience: float, delta: float) -> int:
    """So many events after a change to ``risk`` the watch has given alarm, with probability 1 − ``delta``.

    Computed, not simulated: the distribution of the watch after n events, from 0 on, on a grid onto which every gain is rounded
    down and every loss up, so that the alarm on the grid comes no earlier than the real one. A watch that stood higher at the
    change, or a greater risk, gives alarm no later.

    Raises:
        ValueError: ``risk`` is less than ``to``: a change smaller than declared need not be found.
    """
    if risk < to:
        raise ValueError(f"a change to a risk of {risk:g} is smaller than the declared one, to {to:g}")
    height = math.log(patience) / _STEPS
    gain = math.floor(math.log(to / alpha) / height)
    loss = math.ceil((math.log1p(-audit_rate * alpha) - math.log1p(-audit_rate * to)) / height)
    shown = audit_rate * risk
    watch = np.zeros(_STEPS)
    watch[0] = 1.0
    events = 0
    while watch.sum() > delta:
        after = np.zeros(_STEPS)
        after[0] = watch[: loss + 1].sum() * (1.0 - shown)
        after[1 : _STEPS - loss] = watch[loss + 1 :] * (1.0 - shown)
        after[gain:] += watch[: _STEPS - gain] * shown
        watch = after
        events += 1
    return events


@lru_cache(maxsize=1024)
def excess_bound(
    alpha: float, to: float, audit_rate: float, delay_events: int, patience: float, delta: float, spared: bool = False
) -> int:
    """B: at most so many automatic errors come after a change before revocation, with probability 1 − ``delta``.

    The change takes P(wrong and automatic) from at most α to ``to`` or anything above. With probability 1 − δ/2 the watch gives
    alarm by the N-th event (``events_to_alarm``), whose outcome is known ``delay_events`` later at most; and with probability
    1 − δ/2 no more than B of these N + D events are wrong and automatic. The largest B over all risks from ``to`` to 1 is
    returned. It counts all automatic errors since the change, so that those in excess of what α allows are at most as many.

    Args:
        alpha: the risk that was promised.
        to: the declared size of a change: the risk it leads to.
        audit_rate: q, with which automatic events are drawn.
        delay_events: D, how many events of the treatment come before an outcome is known.
        patience: see the module.
        delta: with which probability more may come.
        spared: whether drawn events are deliberated, so that their errors are no automatic ones.
    """
    worst = 0
    for risk in np.linspace(to, 1.0, _RISKS).tolist():
        events = events_to_alarm(risk, alpha, to, audit_rate, patience, delta / 2.0) + delay_events
        worst = max(worst, most(events, risk * (1.0 - audit_rate if spared else 1.0), delta / 2.0))
    return worst
