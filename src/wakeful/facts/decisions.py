"""What treatment, and how: the choice made for one event (Eq. 4)."""

from __future__ import annotations

from typing import Literal

from wakeful.facts.values import Fact

Mode = Literal["auto", "delib", "fallback"]
"""How a treatment is executed, z of Eq. 4. Analogy is a treatment; fallback is a mode."""


class Candidate(Fact, frozen=True):
    """One treatment that was considered, with its calibrated probability."""

    treatment: str
    probability: float


class Gate(Fact, frozen=True):
    """Why automation was or was not allowed: the numbers that were compared, rounded before comparison."""

    confidence: float
    threshold: float
    novelty: float
    novelty_limit: float
    trust: float
    trust_limit: float


class Audit(Fact, frozen=True):
    """What the guarantee gate did with one event that could be automatic.

    ``treatment`` and ``predicted``, the likeliest label of its forecast, are the model's answer, whatever was made of it after;
    ``score`` is the probability with which it holds both to be right. ``level`` is what that had to reach for automation, above
    1 where nothing was certified. ``probability`` is that with which the event was drawn for its outcome to count as evidence,
    ``drawn`` whether it was. ``alpha`` is the risk that was promised.
    """

    treatment: str
    predicted: str
    score: float
    level: float
    probability: float
    drawn: bool
    alpha: float

    @property
    def automatic(self) -> bool:
        """Whether the score allowed automation."""
        return self.score >= self.level


class Decision(Fact, frozen=True):
    """(treatment, mode, confidence, candidates, reasons, model version) made for one event."""

    treatment: str
    mode: Mode
    confidence: float
    candidates: tuple[Candidate, ...]
    reasons: tuple[str, ...]
    gate: Gate
    prior: dict[str, float] = {}
    """The result head's probabilities over outcome labels; what auto mode starts from."""
    model: int = 0
    watermark: int = 0
    """How many experiences the model version had learned from."""
    rests_on: tuple[int, ...] = ()
    """Ids of the nearest experiences."""
    audit: Audit | None = None
    """What the guarantee gate did; None under the other gates, and for what novelty, trust or lack of experience held back."""
    recalled: int = 0
    """The id of the exemplar that the decision rests on; 0 where nothing sufficiently similar was remembered."""
    foretold: dict[str, float] = {}
    """What the model alone forecast, where ``prior`` is memory's, or joined by recent experience; else empty."""
