"""V(r, y): the recorded result compared with what the world showed (Eq. 10)."""

from __future__ import annotations

from wakeful.facts.experience import Verdict


def verdict(predicted: str, label: str, acted_on: bool = False, quiet: str = "none") -> Verdict:
    """Compare the label that a result forecast with the label of the outcome.

    The prediction is the RECORDED one; nothing is predicted again here. ``quiet`` is the label that says that nothing came (the
    first of the domain's labels). Where the result had been acted on and what it forecast did not come, that may have been
    prevented: undecided, not contradicted. A forecast that nothing will come prevents nothing: what came contradicts it.

    >>> verdict("intervention", "intervention"), verdict("intervention", "none"), verdict("intervention", "none", acted_on=True)
    (<Verdict.SUPPORTED: 'supported'>, <Verdict.CONTRADICTED: 'contradicted'>, <Verdict.UNDECIDED: 'undecided'>)
    >>> verdict("none", "intervention", acted_on=True)
    <Verdict.CONTRADICTED: 'contradicted'>
    """
    if predicted == label:
        return Verdict.SUPPORTED
    prevented = acted_on and predicted != quiet and label == quiet
    return Verdict.UNDECIDED if prevented else Verdict.CONTRADICTED
