"""The two-headed 64-64 model without anything around it: what every system but wakeful selects with, and the floor.

The weights are those that wakeful's own learner gave; standardisation, temperatures and the columns that never change in W
are folded into the first layer, so that it is the same function of the eight fields at less cost.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from benchmarks.peers.messages import CATEGORIES, CONTEXTS, LABELS, LOCATIONS, ROUTES, STATES, TREATMENTS, Event

Floats = npt.NDArray[np.float64]

CHOICES = (CATEGORIES, LOCATIONS, STATES, ROUTES, CONTEXTS)
COLUMNS = sum(map(len, CHOICES)) + 3
_AT = [
    {name: start + index for index, name in enumerate(names)}
    for names, start in zip(CHOICES, np.cumsum([0, *map(len, CHOICES)]).tolist(), strict=False)
]
_CATEGORY, _LOCATION, _STATE, _ROUTE, _CONTEXT = _AT


def places(event: Event) -> tuple[int, int, int, int, int]:
    """The columns of an event's five categories."""
    return (
        _CATEGORY[event.category],
        _LOCATION[event.location],
        _STATE[event.state],
        _ROUTE[event.route],
        _CONTEXT[event.context],
    )


def features(events: list[Event]) -> Floats:
    """Rows (n, 20): five categories one by one, then load, x and y."""
    rows = np.zeros((len(events), COLUMNS))
    if not events:
        return rows
    at = np.array([places(event) for event in events])
    rows[np.arange(len(events))[:, None], at] = 1.0
    rows[:, -3:] = [(event.load, event.x, event.y) for event in events]
    return rows


class Lean:
    """The folded layers: (20, 64), (64,), (64, 64), (64,), (64, 8), (8,)."""

    def __init__(self, layers: list[Floats]) -> None:
        self.layers = layers

    def logits(self, rows: Floats) -> Floats:
        """Both heads' outputs, (n, 6 + 2)."""
        a, b, c, d, e, f = self.layers
        return np.maximum(np.maximum(rows @ a + b, 0.0) @ c + d, 0.0) @ e + f

    def choose(self, events: list[Event]) -> list[tuple[str, str]]:
        """Each event's treatment, and the outcome that is forecast."""
        out = self.logits(features(events))
        cut = len(TREATMENTS)
        treatments, labels = out[:, :cut].argmax(1).tolist(), out[:, cut:].argmax(1).tolist()
        return [(TREATMENTS[t], LABELS[y]) for t, y in zip(treatments, labels, strict=True)]

    def save(self, path: Path) -> None:
        """As one .npz file."""
        np.savez(path, *self.layers)


def load(path: Path) -> Lean:
    """What ``save`` wrote."""
    with np.load(path) as found:
        return Lean([found[name] for name in found.files])
