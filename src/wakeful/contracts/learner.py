"""The contract of a learner: trains F_θ (Eq. 8) off the kernel's thread, and loads it for selection."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import msgspec
import numpy as np
from numpy.typing import NDArray

from wakeful.facts.experience import ModelCard
from wakeful.facts.inputs import TrainingJob

Vector = NDArray[np.float64]


class MissingLearner(Exception):
    """A learner wants a package that is not installed. The message names the extra that brings it."""


class Estimate(msgspec.Struct, frozen=True):
    """F_θ(e): calibrated probabilities over treatments (k,) and outcome labels (l,), and novelty in [0, 1].

    Novelty is distance from experience as a quantile of held-back distances: 0.95 is farther than 95 % of what is familiar.
    """

    treatments: Vector
    labels: Vector
    novelty: float
    cell: int = -1
    """The cell of experience that the event lies in, where the model divides experience into cells; -1 where it does not."""


class Estimates(msgspec.Struct, frozen=True):
    """The same of n events: probabilities (n, k) and (n, l), novelty (n,), cells (n,)."""

    treatments: Vector
    labels: Vector
    novelty: Vector
    cells: NDArray[np.int64]


class Predictor(Protocol):
    """One loaded model version."""

    @property
    def treatments(self) -> tuple[str, ...]:
        """What ``Estimate.treatments`` is over, in its order; it may lack a treatment that was registered later."""

    @property
    def labels(self) -> tuple[str, ...]:
        """What ``Estimate.labels`` is over, in its order."""

    @property
    def typical(self) -> Vector:
        """The mean of the features that it was fitted on, shape (d,): what ``why`` compares an event with."""

    def estimate(self, features: Vector) -> Estimate:
        """F_θ for one event's features, shape (d,). Values are rounded to 9 digits, so that batching changes nothing."""

    def estimate_many(self, features: Vector) -> list[Estimate]:
        """The same for rows (n, d)."""


@runtime_checkable
class RowPredictor(Predictor, Protocol):
    """A model version that estimates many events at once for much less than one by one."""

    def estimate_rows(self, features: Vector) -> Estimates:
        """For rows (n, d) what ``estimate`` says of each, in the digits that are kept."""


class Learner(Protocol):
    """Trains and loads. Same job, same bytes, on the same build."""

    name: str

    def train(self, job: TrainingJob) -> tuple[ModelCard, bytes]:
        """Train a challenger from ``job.base_weights`` (empty: from scratch), compare it with the champion on the held-back
        rows, and say whether it is accepted. Pure: no clock, no disk."""

    def load(self, weights: bytes) -> Predictor:
        """The predictor of stored weights. Raises ValueError on bytes that are not a model."""
