"""The guarantee from one calibration set of fixed size, looked at once: what an experiment without deployment can promise."""

from __future__ import annotations

from wakeful.selection.guarantee.bets import LEVELS, Flags, Floats, place_of
from wakeful.selection.guarantee.bounds import clopper_pearson
from wakeful.selection.guarantee.standing import NOTHING


def level_for(scores: Floats, wrong: Flags, alpha: float, delta: float) -> float:
    """The loosest score from which one treatment may be automatic at a risk under ``alpha``, with probability 1 − ``delta``.

    Learn then test with a fixed sequence of levels (Angelopoulos et al. 2022): from the strictest on, up to the first whose
    Clopper–Pearson bound on P(wrong and automatic) exceeds α.

    Args:
        scores: of the treatment's events in the calibration set, (n,).
        wrong: whether the answer was wrong, (n,).

    Returns:
        One of ``LEVELS``; above 1 where the set is too small or too wrong for any.

    >>> import numpy as np
    >>> level_for(np.full(59, 0.95), np.zeros(59, dtype=bool), 0.05, 0.05)
    0.0
    >>> level_for(np.full(42, 0.95), np.zeros(42, dtype=bool), 0.05, 0.05)
    1.01
    """
    level = NOTHING
    places = place_of(scores)
    for place, loosest in enumerate(LEVELS):
        errors = int((wrong & (places <= place)).sum())
        if clopper_pearson(errors, len(scores), delta) > alpha:
            break
        level = loosest
    return level
