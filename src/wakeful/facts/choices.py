"""An automatic decision as the numbers that it was made by; the decision itself, with its words, follows from them.

The hot path records these numbers. Whoever reads the journal gets the Decision that they stand for (DESIGN section 4).
"""

from __future__ import annotations

from collections.abc import Mapping

from wakeful.facts.decisions import Audit, Candidate, Decision, Gate
from wakeful.facts.values import Fact

#: To how many digits probabilities, novelty and trust are rounded before they are compared, and recorded.
DIGITS = 6


class Basis(Fact, frozen=True):
    """What all automatic decisions for one treatment by one model version have in common.

    ``treatments`` and ``labels`` are what a choice's shares and prior are over, in this order. ``threshold`` is what the
    confidence must reach, ``result_threshold`` what the forecast must; ``support`` counts the treatment's validated experiences.
    """

    treatment: str
    model: int
    watermark: int
    treatments: tuple[str, ...]
    labels: tuple[str, ...]
    threshold: float
    result_threshold: float
    novelty_limit: float
    trust_limit: float
    support: int


class Choice(Fact, frozen=True):
    """One automatic decision: ``basis.treatment`` is the likeliest of ``shares``. ``rests_on`` as in Decision.

    ``cell`` is where the event lies in the model's experience; -1 where the model has no cells.
    """

    basis: Basis
    shares: tuple[float, ...]
    prior: tuple[float, ...]
    novelty: float
    trust: float
    rests_on: tuple[int, ...] = ()
    cell: int = -1

    @property
    def confidence(self) -> float:
        """The share of the treatment that was chosen."""
        return self.shares[self.basis.treatments.index(self.basis.treatment)]

    def decision(self) -> Decision:
        """The decision that these numbers stand for, in words."""
        basis = self.basis
        order = sorted(range(len(self.shares)), key=lambda place: (-self.shares[place], place))
        ranked = tuple(Candidate(treatment=basis.treatments[place], probability=self.shares[place]) for place in order)
        prior = dict(zip(basis.labels, self.prior, strict=True))
        gate = Gate(
            confidence=ranked[0].probability,
            threshold=basis.threshold,
            novelty=self.novelty,
            novelty_limit=basis.novelty_limit,
            trust=self.trust,
            trust_limit=basis.trust_limit,
        )
        return Decision(
            treatment=basis.treatment,
            mode="auto",
            confidence=gate.confidence,
            candidates=ranked,
            reasons=(
                said(ranked, basis.model, basis.watermark),
                automatic(gate, prior, basis.result_threshold, basis.support),
            ),
            gate=gate,
            prior=prior,
            model=basis.model,
            watermark=basis.watermark,
            rests_on=self.rests_on,
        )


def likeliest(prior: Mapping[str, float]) -> tuple[str, float]:
    """The likeliest label and its probability; of equal ones the first."""
    label = max(prior, key=lambda name: round(prior[name], DIGITS), default="")
    return label, round(prior.get(label, 0.0), DIGITS)


def said(ranked: tuple[Candidate, ...], model: int, watermark: int) -> str:
    """What the model said, in words.

    >>> said((Candidate(treatment="memory", probability=0.91), Candidate(treatment="planning", probability=0.05)), 3, 120)
    'Model version 3, learned from 120 experiences, gives memory 0.910, before planning with 0.050.'
    """
    best = ranked[0]
    after = f", before {ranked[1].treatment} with {ranked[1].probability:.3f}" if len(ranked) > 1 else ""
    return f"Model version {model}, learned from {watermark} experiences, gives {best.treatment} {best.probability:.3f}{after}."


def automatic(gate: Gate, prior: Mapping[str, float], needed: float, support: int) -> str:
    """Why the treatment may be executed automatically, in words: every number that was compared, beside its limit."""
    label, confidence = likeliest(prior)
    return (
        f"Automatic: confidence {gate.confidence:.3f} (at least {gate.threshold:.2f}), "
        f"forecast {label!r} with {confidence:.3f} (at least {needed:.2f}), "
        f"novelty {gate.novelty:.3f} (at most {gate.novelty_limit:g}), "
        f"trust {gate.trust:.2f} (at least {gate.trust_limit:g}), {support} validated experiences."
    )


def guaranteed(audit: Audit, deliberated: bool = False) -> str:
    """What the guarantee gate said, in words.

    >>> guaranteed(
    ...     Audit(treatment="memory", predicted="none", score=0.93, level=0.9, probability=0.2, drawn=False, alpha=0.05)
    ... )
    'Automatic under the guarantee: the score 0.930 reaches 0.90, from which memory is certified at a risk of 5 %.'
    """
    treatment = audit.treatment
    if audit.level > 1.0:
        return f"Not automatic: {treatment} is not certified yet at a risk of {100 * audit.alpha:g} %; the outcome will count."
    certified = f"{audit.level:.2f}, from which {treatment} is certified at a risk of {100 * audit.alpha:g} %"
    if not audit.automatic:
        return f"Not automatic: the score {audit.score:.3f} does not reach {certified}."
    if not audit.drawn:
        return f"Automatic under the guarantee: the score {audit.score:.3f} reaches {certified}."
    what = "deliberated to be compared" if deliberated else "its outcome counts as evidence"
    return (
        f"The score {audit.score:.3f} reaches {certified}; drawn for an audit (one in {1 / audit.probability:.3g}): {what}."
        if audit.probability < 1.0
        else f"Automatic under the guarantee: the score {audit.score:.3f} reaches {certified}; its outcome counts as evidence."
    )
