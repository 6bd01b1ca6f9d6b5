"""Learning material: verdicts, experiences, and what was learned from them."""

from __future__ import annotations

from enum import StrEnum

from wakeful.facts.values import Fact


class Verdict(StrEnum):
    """V(r, y) (Eq. 10)."""

    SUPPORTED = "supported"
    CONTRADICTED = "contradicted"
    UNDECIDED = "undecided"


class Experience(Fact, frozen=True):
    """(e, m, r, y) with its verdict (Eq. 7). ``id`` counts from 1 in the journal of the robot that made it.

    ``treatment`` is what was applied; ``treatment_label`` the right one where the world or a person said so, the
    applied one where the result was supported, empty where it is only known to be wrong (a negative).
    ``predicted`` is the RECORDED result's label, ``outcome`` what the world showed.
    """

    id: int
    event: str
    process: int
    treatment: str
    treatment_label: str
    predicted: str
    outcome: str
    verdict: Verdict
    mode: str
    robot: str = ""
    weight: float = 1.0
    acted_on: bool = False


class ModelCard(Fact, frozen=True):
    """A model version with its lineage: what it came from, what it learned, how it compared on held-back experience."""

    version: int
    base: int
    watermark: int
    seed: int
    epochs: int
    blob: str
    """Name of the weights in the journal's blob table: the hex digest of their bytes."""
    accepted: bool
    champion_loss: float | None = None
    challenger_loss: float | None = None
    champion_accuracy: float | None = None
    challenger_accuracy: float | None = None
    held_back: int = 0
    treatment_accuracy: float | None = None
    result_accuracy: float | None = None
    """Of the challenger on held-back rows, apart; ``challenger_accuracy`` counts a row only where both are right."""
    thresholds: dict[str, float] = {}
    support: dict[str, int] = {}
    """How many validated experiences each treatment has among what was learned."""
    why: str = ""
