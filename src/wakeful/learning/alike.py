"""Which exemplars an event is sufficiently similar to: those of the same categories that the model thinks of in the same way."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterator
from typing import Final

import numpy as np
import numpy.typing as npt

from wakeful.contracts.learner import Predictor, RowPredictor, Vector
from wakeful.learning.exemplar import Exemplar

LIKE_ENOUGH: Final = 0.6
"""How alike two events must be that agree in every category: 1 less the total variation of the model's shares of treatments."""
CLOSE: Final = 1e-3
"""Numbers that differ by no more are the same, model or not."""

_PER_PATTERN = 16
_DIGITS = 6


class Alike:
    """Exemplars by their categories: columns in which nothing but 0 and 1 was seen.

    Args:
        treatments: all registered treatments, in the order that exemplars count them in.
        labels: the domain's outcome labels, likewise.
    """

    def __init__(self, treatments: tuple[str, ...], labels: tuple[str, ...]) -> None:
        self._treatments, self._labels = treatments, labels
        self._exemplars: OrderedDict[int, Exemplar] = OrderedDict()
        self._like: dict[bytes, list[int]] = {}
        self._numeric: npt.NDArray[np.bool_] = np.zeros(0, dtype=np.bool_)

    def __len__(self) -> int:
        return len(self._exemplars)

    def get(self, identity: int) -> Exemplar | None:
        """The exemplar of that id; None where it was forgotten."""
        return self._exemplars.get(identity)

    def add(self, exemplar: Exemplar, limit: int) -> bytes | None:
        """Keep it, and at most ``limit`` of them; the pattern that none is left of, where one had to go."""
        self._exemplars[exemplar.id] = exemplar
        self._like.setdefault(self.pattern(exemplar.features), []).append(exemplar.id)
        return self._forget(next(iter(self._exemplars))) if len(self._exemplars) > limit else None

    def validated(self, exemplar: Exemplar) -> None:
        """It was validated last: of all it is the last to be forgotten."""
        self._exemplars.move_to_end(exemplar.id)

    def see(self, features: Vector) -> bool:
        """Columns with other numbers than 0 and 1 are no categories, from now on; whether that changed any pattern."""
        numeric = (features != 0.0) & (features != 1.0)
        if not len(self._numeric):
            self._numeric = numeric
            return False
        if not (numeric & ~self._numeric).any():
            return False
        self._numeric = self._numeric | numeric
        self._like = {}
        for exemplar in self._exemplars.values():
            self._like.setdefault(self.pattern(exemplar.features), []).append(exemplar.id)
        return True

    def pattern(self, features: Vector) -> bytes:
        """The event's categories."""
        return np.packbits((features == 1.0) & ~self._numeric).tobytes()

    def same(self, features: Vector) -> Exemplar | None:
        """The exemplar of these very numbers."""
        alike = self.to(features, None)
        return alike[0][1] if alike else None

    def to(self, features: Vector, predictor: Predictor | None) -> list[tuple[float, Exemplar]]:
        """The exemplars that are like enough with how like they are, the likest first, of equally like ones the last founded."""
        found: list[tuple[float, Exemplar]] = []
        own: Vector | None = None
        for identity in reversed(self._like.get(self.pattern(features), ())[-_PER_PATTERN:]):
            exemplar = self._exemplars[identity]
            if float(np.abs(exemplar.features - features).max()) <= CLOSE:
                # The very same event: what others like it were is beside the point.
                return [(1.0, exemplar)]
            if predictor is not None:
                own = _heads(predictor, features) if own is None else own
                cut = len(predictor.treatments)
                likeness = round(1.0 - 0.5 * float(np.abs(own - _foreseen(exemplar, predictor))[:cut].sum()), _DIGITS)
                if likeness >= LIKE_ENOUGH:
                    found.append((likeness, exemplar))
        return sorted(found, key=lambda pair: (-pair[0], -pair[1].id))

    def disputed(self, predictor: Predictor | None) -> set[bytes]:
        """The patterns of which memory may hold otherwise than that model version; all where finding out is not cheap."""
        if not isinstance(predictor, RowPredictor) or not self._exemplars:
            return set(self._like)
        rows = predictor.estimate_rows(np.stack([each.features for each in self._exemplars.values()]))
        for each, heads in zip(self._exemplars.values(), np.hstack([rows.treatments, rows.labels]), strict=True):
            each.estimate = (predictor, heads)
        return {pattern for pattern in self._like if self.is_disputed(pattern, predictor)}

    def is_disputed(self, pattern: bytes, predictor: Predictor) -> bool:
        """Whether the last word on some event of these categories was another than the model's, or than that on another one."""
        alike = list(self._of(pattern))
        return len({each.newest for each in alike}) > 1 or any(self._differs(each, predictor) for each in alike)

    def _of(self, pattern: bytes) -> Iterator[Exemplar]:
        return (self._exemplars[each] for each in self._like.get(pattern, ()))

    def _differs(self, exemplar: Exemplar, predictor: Predictor) -> bool:
        """Whether the model says otherwise of the exemplar itself than what was told last of it."""
        heads, cut = _foreseen(exemplar, predictor), len(predictor.treatments)
        treatment, label = exemplar.newest
        return (treatment >= 0 and predictor.treatments[int(heads[:cut].argmax())] != self._treatments[treatment]) or (
            label >= 0 and predictor.labels[int(heads[cut:].argmax())] != self._labels[label]
        )

    def _forget(self, identity: int) -> bytes | None:
        gone = self._exemplars.pop(identity)
        pattern = self.pattern(gone.features)
        left = [each for each in self._like.get(pattern, ()) if each != identity]
        if left:
            self._like[pattern] = left
            return None
        self._like.pop(pattern, None)
        return pattern


def _foreseen(exemplar: Exemplar, predictor: Predictor) -> Vector:
    if exemplar.estimate is None or exemplar.estimate[0] is not predictor:
        exemplar.estimate = (predictor, _heads(predictor, exemplar.features))
    return exemplar.estimate[1]


def _heads(predictor: Predictor, features: Vector) -> Vector:
    estimate = predictor.estimate(features)
    return np.concatenate([estimate.treatments, estimate.labels])
