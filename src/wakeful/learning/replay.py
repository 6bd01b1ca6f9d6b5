"""Which experiences a training learns from: a bounded replay, which rows are held back, and which treatments were wrong."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from hashlib import blake2b

import msgspec
import numpy as np
import numpy.typing as npt

from wakeful.contracts.learner import Vector
from wakeful.facts.events import Event

LIKE_EVENTS = 8
"""Among how many of the likest experiences a better treatment is looked for."""


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """One experience as numbers. ``label`` is the index of the right treatment or -1, ``applied`` of the one applied or -1,
    ``result`` of the outcome or -1."""

    id: int
    event: str
    process: int
    features: Vector
    label: int
    applied: int
    result: int
    contradicted: bool
    weight: float
    held_back: bool
    source: Event | None = None
    """Its event, while ``features`` are still to be made of it; they are empty then."""

    @property
    def right(self) -> bool:
        """Whether what was concluded at the time was right: the result, and the treatment where the right one is known."""
        return not self.contradicted and self.label in (-1, self.applied)

    @property
    def stratum(self) -> tuple[int, int]:
        """What the row is an instance of: the treatment it speaks of, and the outcome."""
        return (self.label if self.label >= 0 else self.applied, self.result)


class Sides:
    """Decides once and for all which experiences are held back for comparison and calibration.

    By a hash of the event's id, so that neither order nor batching matters, and an event that was reopened stays on its side.
    The first two of every (treatment, outcome) are always learned from: what is rare must not be held back altogether.
    """

    ALWAYS_LEARNED = 2

    def __init__(self, share: float) -> None:
        self._share = share
        self._learned: Counter[tuple[int, int]] = Counter()

    def held_back(self, event: str, stratum: tuple[int, int], before: bool | None) -> bool:
        """Whether the experience is held back; ``before`` is the answer for an earlier experience of the same event."""
        if before is None:
            before = self._learned[stratum] >= self.ALWAYS_LEARNED and fraction(event) < self._share
        if not before:
            self._learned[stratum] += 1
        return before


def fraction(event: str) -> float:
    """A number in [0, 1) that belongs to the event's id."""
    return int.from_bytes(blake2b(event.encode(), digest_size=6, person=b"held-back").digest(), "little") / 2**48


def replay(rows: Sequence[Row], limit: int) -> list[Row]:
    """At most ``limit`` rows in the order of their ids: half the newest, an eighth the newest contradictions among the rest,
    and then in turn one of every (treatment, outcome), newest first, so that what is rare stays."""
    if len(rows) <= limit:
        return list(rows)
    rest = sorted(rows, key=lambda row: -row.id)
    chosen, rest = rest[: limit // 2], rest[limit // 2 :]
    contradictions = [row for row in rest if row.contradicted][: limit // 8]
    chosen += contradictions
    taken = {row.id for row in contradictions}
    strata: dict[tuple[int, int], list[Row]] = {}
    for row in rest:
        if row.id not in taken:
            strata.setdefault(row.stratum, []).append(row)
    queues = [strata[key] for key in sorted(strata)]
    depth = 0
    while len(chosen) < limit:
        layer = [queue[depth] for queue in queues if depth < len(queue)]
        chosen += layer[: limit - len(chosen)]
        depth += 1
    return sorted(chosen, key=lambda row: row.id)


def refuted(rows: Sequence[Row]) -> npt.NDArray[np.int64]:
    """For each row the index of the treatment that it shows to be wrong, or -1.

    A contradicted result without a told treatment may only have been a wrong result: thought about in the right way, and the
    world was otherwise. The treatment itself counts as wrong where another one got right, on like events, what this one
    got wrong: among the eight likest experiences (each of features within the same distances for all) some have the
    same outcome and a right treatment, and the applied one is not among these.
    """
    found = np.full(len(rows), -1, dtype=np.int64)
    if not rows:
        return found
    features = np.stack([row.features for row in rows])
    label = np.array([row.label for row in rows])
    result = np.array([row.result for row in rows])
    for place in _doubtful(rows):
        apart = features - features[place]
        distance = np.round(np.einsum("ij,ij->i", apart, apart), 9)
        distance[place] = np.inf
        likest = np.argsort(distance, kind="stable")[:LIKE_EVENTS]
        right = {int(label[i]) for i in likest if result[i] == result[place] and label[i] >= 0}
        if right and rows[place].applied not in right:
            found[place] = rows[place].applied
    return found


def _doubtful(rows: Iterable[Row]) -> list[int]:
    return [place for place, row in enumerate(rows) if row.contradicted and row.label < 0 and row.applied >= 0]
