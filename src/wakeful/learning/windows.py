"""The newest experiences as rows, and what the likest of them say of an event: forecasters that need no training.

Each looks at a window of its own, so that one of them is short enough for whatever is changing now. All of them are one look at
the distances: k nearest neighbours by inverse distance, newer ones weighing more, as in windowed and weighted nearest-neighbour
learners for drifting streams (Losing, Hammer and Wersing 2016).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt

from wakeful.contracts.learner import Vector
from wakeful.facts.events import Event

EncodeMany = Callable[[Sequence[Event]], Iterable[Vector]]


class Window(msgspec.Struct, frozen=True):
    """The last ``rows`` experiences, of which the ``nearest`` speak; ``half_life`` rows later one weighs half."""

    rows: int
    nearest: int
    half_life: float


#: Chosen on the first 3,000 events of Elec2 (docs/drift_streams.md). The last asks for no likeness: what came lately comes again.
WINDOWS: Final = (Window(50, 3, 1e9), Window(100, 5, 50.0), Window(300, 8, 100.0), Window(1000, 20, 200.0), Window(50, 50, 3.0))

LONGEST: Final = max(window.rows for window in WINDOWS)
"""So many rows are kept."""
RESCALED: Final = 64
"""Columns are scaled anew after so many rows."""
_LATEST: Final = len(WINDOWS) - 1
_NEAR: Final = 0.01
_COUNT: Final = 6.0
"""What all labels together count beside the votes, evenly: of an event that is far from all its neighbours little is said."""
_LEAST_SCALE: Final = 1e-3
_LEAST_CATEGORY: Final = 0.25
"""A category that was seldom met must not stand for more than several numbers together."""


class Windows:
    """Keeps twice ``LONGEST`` rows at most and says what the likest among those before a given one had come to.

    What it says depends on the rows alone, never on when it was asked.

    Args:
        encode_many: the selector's encoder.
        labels: how many outcome labels there are.
    """

    def __init__(self, encode_many: EncodeMany, labels: int) -> None:
        self._encode_many = encode_many
        self._labels = labels
        self._rows: npt.NDArray[np.float64] = np.zeros((0, 0))
        self._label: npt.NDArray[np.int64] = np.zeros(3 * LONGEST, dtype=np.int64)
        self._waiting: list[Event] = []
        self._first = 0
        self._rates: tuple[tuple[int, int], Vector] = ((-1, -1), np.zeros(0))
        self.count = 0
        """How many rows were ever kept; the next one's number."""

    def add(self, event: Event, label: int) -> None:
        """One more experience; its features are made when they are asked for, many at once."""
        if self.count - self._first == 3 * LONGEST:
            self._drop()
        self._label[self.count - self._first] = label
        self._waiting.append(event)
        self.count += 1

    def shares(self, features: Vector, before: int) -> npt.NDArray[np.float64] | None:
        """What each window says of features, shape (d,): (windows, labels). None where nothing that it would need is kept.

        Args:
            features: of the event.
            before: only rows with smaller numbers count: those that were there when the event was decided on.
        """
        first = max(self._first, before - LONGEST)
        if before - first < 1:
            return None
        self._write()
        here = slice(first - self._first, before - self._first)
        apart = self._rows[here] - features
        apart *= self._rate(before)
        distances = np.einsum("ij,ij->i", apart, apart)
        label = self._label[here]
        age = np.arange(len(label) - 1, -1, -1, dtype=np.float64)
        found = np.full((len(WINDOWS), self._labels), _COUNT / self._labels)
        for place, window in enumerate(WINDOWS):
            cut = max(0, len(label) - window.rows)
            likest = np.arange(cut, len(label))
            if len(likest) > window.nearest:
                likest = cut + np.argpartition(distances[cut:], window.nearest)[: window.nearest]
            weight = np.exp2(-age[likest] / window.half_life)
            if place != _LATEST:
                weight /= distances[likest] + _NEAR
            found[place] += np.bincount(label[likest], weight, self._labels)
        return np.asarray(found / found.sum(axis=1, keepdims=True))

    def _drop(self) -> None:
        """Let go of the oldest third, so that who was decided on within the last two can still be compared; what was never asked
        for of it is never encoded."""
        if len(self._waiting) < 2 * LONGEST:
            self._write()
            self._rows[: 2 * LONGEST] = self._rows[LONGEST:]
        else:
            del self._waiting[: -2 * LONGEST]
        self._first += LONGEST
        self._label[: 2 * LONGEST] = self._label[LONGEST:]

    def _write(self) -> None:
        waiting, self._waiting = self._waiting, []
        if not waiting:
            return
        made = np.asarray(list(self._encode_many(waiting)))
        if not self._rows.size:
            self._rows = np.zeros((3 * LONGEST, made.shape[1]))
        end = self.count - self._first
        self._rows[end - len(waiting) : end] = made

    def _rate(self, before: int) -> Vector:
        """What differences are multiplied by, from the rows up to the last multiple of ``RESCALED`` (or up to ``before``)."""
        until = before - before % RESCALED if before - before % RESCALED > self._first else before
        if self._rates[0] != (until, self._first):
            rows = self._rows[max(0, until - LONGEST - self._first) : until - self._first]
            category = ((rows == 0.0) | (rows == 1.0)).all(axis=0)
            scale = np.maximum(rows.std(axis=0), np.where(category, _LEAST_CATEGORY, _LEAST_SCALE))
            self._rates = ((until, self._first), 1.0 / scale)
        return self._rates[1]
