"""How confident a selector is and how right: reliability, expected calibration error, and risk against coverage."""

from __future__ import annotations

from collections.abc import Sequence

from wakeful.facts.values import Fact

BINS = 10


class Cell(Fact, frozen=True):
    """One test event: the learned part's confidence, whether its choice was right, and whether what was done was."""

    confidence: float
    right: bool
    gained: bool


class Bin(Fact, frozen=True):
    """Events of like confidence: how many, how confident in the mean, and which share was right."""

    events: int
    confidence: float
    right: float


def reliability(cells: Sequence[Cell], bins: int = BINS) -> list[Bin]:
    """The events in bins of equal width of confidence, without empty ones.

    >>> reliability([Cell(confidence=0.9, right=True, gained=True), Cell(confidence=1.0, right=False, gained=True)])
    [Bin(events=2, confidence=0.95, right=0.5)]
    """
    found: list[list[Cell]] = [[] for _ in range(bins)]
    for cell in cells:
        found[min(bins - 1, int(round(cell.confidence * bins, 9)))].append(cell)
    return [
        Bin(
            events=len(each),
            confidence=sum(cell.confidence for cell in each) / len(each),
            right=sum(cell.right for cell in each) / len(each),
        )
        for each in found
        if each
    ]


def calibration_error(bins: Sequence[Bin]) -> float:
    """The expected calibration error: the mean distance of confidence from accuracy, by events."""
    events = sum(each.events for each in bins)
    return sum(each.events * abs(each.confidence - each.right) for each in bins) / events if events else 0.0


def deferral_curve(cells: Sequence[Cell]) -> list[tuple[float, float]]:
    """(coverage, share wrong among what is covered) as ever less confident events are handled automatically."""
    ordered = sorted(cells, key=lambda cell: -cell.confidence)
    wrong, curve = 0, []
    for place, cell in enumerate(ordered, 1):
        wrong += not cell.right
        if place == len(ordered) or ordered[place].confidence < cell.confidence:
            curve.append((place / len(ordered), wrong / place))
    return curve


def oracle_curve(cells: Sequence[Cell]) -> list[tuple[float, float]]:
    """The same for an oracle that knows what is wrong and covers it last."""
    right, events = sum(cell.right for cell in cells), len(cells)
    return [(place / events, max(0, place - right) / place) for place in range(1, events + 1)]
