"""What a training learns from, as numbers that were checked."""

from __future__ import annotations

import msgspec
import numpy as np
import numpy.typing as npt

from wakeful.facts.inputs import TrainingJob

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Flags = npt.NDArray[np.bool_]


class Material(msgspec.Struct, frozen=True, kw_only=True):
    """Rows to learn from: x (n, d), treatment (n,), result (n,) and refuted (n,) as indices or -1, and what each row weighs
    for the two heads, weight (n,) and result_weight (n,)."""

    x: Floats
    treatment: Ints
    result: Ints
    refuted: Ints
    weight: Floats
    result_weight: Floats

    def rows(self, chosen: npt.NDArray[np.intp] | npt.NDArray[np.bool_]) -> Material:
        """The chosen rows, in that order."""
        return Material(
            x=self.x[chosen],
            treatment=self.treatment[chosen],
            result=self.result[chosen],
            refuted=self.refuted[chosen],
            weight=self.weight[chosen],
            result_weight=self.result_weight[chosen],
        )

    def part(self, begin: int, end: int) -> Material:
        """The rows from ``begin`` up to ``end``, sharing memory."""
        return Material(
            x=self.x[begin:end],
            treatment=self.treatment[begin:end],
            result=self.result[begin:end],
            refuted=self.refuted[begin:end],
            weight=self.weight[begin:end],
            result_weight=self.result_weight[begin:end],
        )


def material_of(job: TrainingJob, half_life: float | None) -> tuple[Material, Flags]:
    """A job's rows, checked, and which of them are held back.

    Args:
        job: its rows stand in the order in which they were gained.
        half_life: how many rows later an outcome weighs half; None: all weigh the same.

    Raises:
        ValueError: the arrays don't fit together, hold NaN, or name what isn't there.
    """
    x = np.ascontiguousarray(np.asarray(job.features, dtype=np.float64))
    treatment, result, refuted = (np.asarray(part, dtype=np.int64) for part in (job.treatment, job.result, job.refuted))
    weight, held_back = np.asarray(job.weight, dtype=np.float64), np.asarray(job.held_back, dtype=np.bool_)
    if x.ndim != 2 or any(part.shape != x.shape[:1] for part in (treatment, result, refuted, weight, held_back)):
        raise ValueError(f"training {job.training}: features of shape {x.shape} and the other arrays don't fit together")
    if not np.isfinite(x).all() or not np.isfinite(weight).all() or (weight < 0.0).any():
        raise ValueError(f"training {job.training}: features and weights must be finite, weights not negative")
    for what, part, count in (
        ("treatment", treatment, len(job.treatments)),
        ("refuted", refuted, len(job.treatments)),
        ("result", result, len(job.labels)),
    ):
        if part.size and (int(part.min()) < -1 or int(part.max()) >= count):
            raise ValueError(f"training {job.training}: {what} must hold -1 or an index below {count}")
    age = np.arange(len(x) - 1, -1, -1, dtype=np.float64)
    recent = weight if half_life is None else weight * np.exp2(-age / half_life)
    rows = Material(x=x, treatment=treatment, result=result, refuted=refuted, weight=weight, result_weight=recent)
    return rows, held_back
