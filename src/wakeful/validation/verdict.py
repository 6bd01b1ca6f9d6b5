"""V(r, y): the recorded result compared with what the world showed (Eq. 10)."""

from __future__ import annotations

from wakeful.facts.experience import Verdict


def verdict(predicted: str, label: str, acted_on: bool = False) -> Verdict:
    """Compare the label that a result forecast with the label of the outcome.

    The prediction is the RECORDED one; nothing is predicted again here. Where the result had been acted on, a forecast that
    did not come true may have been prevented: undecided, not contradicted.

    >>> verdict("intervention", "intervention"), verdict("intervention", "none"), verdict("intervention", "none", acted_on=True)
    (<Verdict.SUPPORTED: 'supported'>, <Verdict.CONTRADICTED: 'contradicted'>, <Verdict.UNDECIDED: 'undecided'>)
    """
    if predicted == label:
        return Verdict.SUPPORTED
    return Verdict.UNDECIDED if acted_on else Verdict.CONTRADICTED
