"""The learner of Eq. 8: a shared encoder of 64-64 units, a treatment head and a result head, champion against challenger."""

from __future__ import annotations

import math
from hashlib import blake2b

import msgspec
import numpy as np

from wakeful.contracts.learner import Estimate, Vector
from wakeful.facts.experience import ModelCard
from wakeful.facts.inputs import TrainingJob
from wakeful.learning.calibration import choose_thresholds, mark, temperature
from wakeful.learning.network import (
    Fit,
    Floats,
    Material,
    Shape,
    logits,
    result_losses,
    softmax,
    start,
    train,
    treatment_losses,
    views,
)
from wakeful.learning.novelty import Novelty, learn_novelty
from wakeful.learning.weights import Model, from_bytes, to_bytes

_DIGITS = 9


class TwoHeadsSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The network and its training. The defaults are the paper's (Section IV-A) where it states them.

    ``treatment_loss`` and ``result_loss`` are λ_m and λ_r of Eq. 8. ``tolerance`` is by how much the challenger's held-back loss
    may exceed the champion's, in nats; ``target_error`` what share of automatic decisions may be wrong on held-back rows;
    ``scale_floor`` the least standard deviation a feature is divided by, so that one never seen before doesn't explode;
    ``epochs_again`` the least epochs of a training whose base can't be continued.
    """

    hidden: int = 64
    dropout: float = 0.1
    learning_rate: float = 1e-3
    weight_decay: float = 1e-4
    batch: int = 32
    treatment_loss: float = 1.0
    result_loss: float = 1.0
    tolerance: float = 0.02
    target_error: float = 0.10
    exemplars: int = 256
    scale_floor: float = 0.25
    epochs_again: int = 140


class Score(msgspec.Struct, frozen=True):
    """How a model does on held-back rows: its loss, and how often treatment, result, and both were right."""

    loss: float
    treatment_accuracy: float | None
    result_accuracy: float | None
    accuracy: float


class TwoHeads:
    """Trains and loads two-headed networks. Without state: the same job gives the same bytes."""

    name = "two_heads"

    def __init__(self, settings: TwoHeadsSettings | None = None) -> None:
        self.settings = settings or TwoHeadsSettings()

    def train(self, job: TrainingJob) -> tuple[ModelCard, bytes]:
        """Train a challenger and compare it with the champion that it came from.

        Both are calibrated on the held-back rows (a temperature a head) before they are compared there. Without held-back rows
        nothing is calibrated, no threshold is chosen, and the challenger is accepted. A base of other features, or one that
        knows a treatment or label that the job doesn't, is not continued: the training starts from scratch and says so.

        Raises:
            ValueError: the job's arrays don't fit together, hold NaN, or leave nothing to learn from; or the base is no model.
        """
        rows, held_back = _material(job)
        learned, kept = rows.rows(~held_back), rows.rows(held_back)
        if not len(learned.x):
            raise ValueError(f"training {job.training} has nothing to learn from: all {len(rows.x)} rows are held back")
        champion = from_bytes(job.base_weights) if job.base_weights else None
        base = None if champion is None else _continued(champion, job, self.settings.hidden)
        mean, scale, shape, theta = self._begin(job, learned, base)
        x = np.asarray((learned.x - mean) / scale)
        fit = self._fit(job, again=champion is not None and base is None)
        theta = train(theta, shape, msgspec.structs.replace(learned, x=x), fit)
        novelty = learn_novelty(x, np.asarray((kept.x - mean) / scale), self.settings.exemplars)
        challenger = calibrated(
            Model(
                treatments=job.treatments,
                labels=job.labels,
                shape=shape,
                theta=theta,
                mean=mean,
                scale=scale,
                temperatures=(1.0, 1.0),
                novelty=novelty,
            ),
            kept,
        )
        weights = to_bytes(challenger)
        rival = None if base is None else calibrated(base, kept)
        return self._card(job, fit, challenger, rival, learned, kept, weights), weights

    def load(self, weights: bytes) -> TwoHeadsPredictor:
        """The predictor of stored weights. Raises ValueError on bytes that are not a model."""
        return TwoHeadsPredictor(from_bytes(weights))

    def _begin(self, job: TrainingJob, learned: Material, base: Model | None) -> tuple[Floats, Floats, Shape, Floats]:
        if base is not None:
            return base.mean, base.scale, base.shape, base.theta
        shape = Shape(learned.x.shape[1], self.settings.hidden, len(job.treatments), len(job.labels))
        mean = np.round(learned.x.mean(axis=0), _DIGITS)
        scale = np.round(np.maximum(learned.x.std(axis=0), self.settings.scale_floor), _DIGITS)
        return mean, scale, shape, start(shape, job.seed)

    def _fit(self, job: TrainingJob, again: bool) -> Fit:
        own = self.settings
        return Fit(
            epochs=max(job.epochs, own.epochs_again) if again else job.epochs,
            seed=job.seed,
            treatment_loss=own.treatment_loss,
            result_loss=own.result_loss,
            dropout=own.dropout,
            learning_rate=own.learning_rate,
            weight_decay=own.weight_decay,
            batch=own.batch,
        )

    def _card(
        self,
        job: TrainingJob,
        fit: Fit,
        challenger: Model,
        champion: Model | None,
        learned: Material,
        kept: Material,
        weights: bytes,
    ) -> ModelCard:
        own = score(challenger, kept, self.settings)
        other = None if champion is None else score(champion, kept, self.settings)
        accepted, why = True, "the first version: there is nothing to compare it with"
        if own is None:
            why = "nothing was held back to compare on"
        elif job.base_weights and champion is None:
            why = "started from scratch: its base was made for other features, treatments or labels"
        elif other is not None:
            accepted = own.loss <= round(other.loss + self.settings.tolerance, _DIGITS)
            why = (
                f"held-back loss {own.loss:.3f} against {other.loss:.3f} of version {job.base_version} "
                f"on {len(kept.x)} experiences: "
                + ("not worse" if accepted else f"worse by more than {self.settings.tolerance:g}")
            )
        seen = np.concatenate([learned.treatment, kept.treatment])
        p, q = probabilities(challenger, kept)
        return ModelCard(
            version=job.training,
            base=0 if champion is None else job.base_version,
            watermark=job.watermark,
            seed=job.seed,
            epochs=fit.epochs,
            blob=blake2b(weights, digest_size=16).hexdigest(),
            accepted=accepted,
            champion_loss=None if other is None else other.loss,
            challenger_loss=None if own is None else own.loss,
            champion_accuracy=None if other is None else other.accuracy,
            challenger_accuracy=None if own is None else own.accuracy,
            held_back=len(kept.x),
            treatment_accuracy=None if own is None else own.treatment_accuracy,
            result_accuracy=None if own is None else own.result_accuracy,
            thresholds=choose_thresholds(mark(p, q, kept), job.treatments, self.settings.target_error) if len(kept.x) else {},
            support={name: int((seen == index).sum()) for index, name in enumerate(job.treatments) if (seen == index).any()},
            why=why,
        )


class TwoHeadsPredictor:
    """One loaded model version. Each row takes the same path alone and in company: equal to the last bit."""

    def __init__(self, model: Model) -> None:
        self.treatments, self.labels = model.treatments, model.labels
        self.typical: Vector = model.mean
        self._mean, self._rate = model.mean, 1.0 / model.scale
        self._novelty: Novelty = model.novelty
        self._parts = views(model.theta, model.shape)
        k = model.shape.treatments
        self._cut = k
        cooling = np.repeat(1.0 / np.array(model.temperatures), (k, model.shape.labels))
        self._heads, self._heads_bias = self._parts.heads * cooling, self._parts.heads_bias * cooling

    def estimate(self, features: Vector) -> Estimate:
        """F_θ for one event's features, shape (d,); probabilities and novelty are rounded to 9 digits.

        Raises:
            ValueError: the features have another shape than the model's.
        """
        if features.shape != self._mean.shape:
            raise ValueError(f"features of shape {features.shape}; this model was fitted on {self._mean.shape}")
        x = (features - self._mean) * self._rate
        parts = self._parts
        hidden = np.maximum(x @ parts.first + parts.first_bias, 0.0)
        hidden = np.maximum(hidden @ parts.second + parts.second_bias, 0.0)
        out = (hidden @ self._heads + self._heads_bias).tolist()
        return Estimate(
            treatments=_shares(out[: self._cut]),
            labels=_shares(out[self._cut :]),
            novelty=round(self._novelty.of(x), _DIGITS),
        )

    def estimate_many(self, features: Vector) -> list[Estimate]:
        """The same for rows (n, d), one after the other: a product over many rows adds up in another order."""
        return [self.estimate(row) for row in features]


def _shares(logits_of_one: list[float]) -> Vector:
    """Softmax of a handful of numbers, rounded: several times faster than numpy's calls."""
    highest = max(logits_of_one)
    parts = [math.exp(number - highest) for number in logits_of_one]
    total = sum(parts)
    return np.array([round(part / total, _DIGITS) for part in parts])


def probabilities(model: Model, rows: Material) -> tuple[Floats, Floats]:
    """Calibrated probabilities over treatments (n, k) and labels (n, l)."""
    z, w = logits(model.theta, model.shape, model.standardise(rows.x))
    return softmax(z / model.temperatures[0]), softmax(w / model.temperatures[1])


def calibrated(model: Model, rows: Material) -> Model:
    """The model with temperatures fitted to these rows."""
    z, w = logits(model.theta, model.shape, model.standardise(rows.x))
    fitted = (temperature(z, rows.treatment, rows.weight), temperature(w, rows.result, rows.weight))
    return msgspec.structs.replace(model, temperatures=fitted)


def score(model: Model, rows: Material, settings: TwoHeadsSettings) -> Score | None:
    """How the model does on these rows; None where nothing is known of any of them."""
    p, q = probabilities(model, rows)
    marks = mark(p, q, rows) if len(rows.x) else None
    if marks is None or not marks.judged.any():
        return None
    loss = 0.0
    for share, (each, weight) in (
        (settings.treatment_loss, treatment_losses(p, rows)),
        (settings.result_loss, result_losses(q, rows)),
    ):
        total = float(weight.sum())
        loss += share * float((each * weight).sum()) / total if total > 0.0 else 0.0
    told, decided = (rows.treatment >= 0) | (rows.refuted >= 0), rows.result >= 0
    return Score(
        loss=round(loss, _DIGITS),
        treatment_accuracy=_share(~marks.treatment_wrong[told]),
        result_accuracy=_share(~marks.result_wrong[decided]),
        accuracy=_share(~marks.wrong[marks.judged]) or 0.0,
    )


def _share(right: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> float | None:
    return round(float(right.mean()), _DIGITS) if right.size else None


def _continued(base: Model, job: TrainingJob, hidden: int) -> Model | None:
    """The base with the job's treatments and labels, in its order; None where it can't be continued.

    A treatment that is new begins with weights 0 and the smallest bias there is: it is not chosen before it is learned.
    """
    d = np.asarray(job.features).shape[1]
    lost = not set(base.treatments) <= set(job.treatments) or not set(base.labels) <= set(job.labels)
    if base.shape.inputs != d or base.shape.hidden != hidden or lost:
        return None
    if base.treatments == job.treatments and base.labels == job.labels:
        return base
    shape = Shape(d, hidden, len(job.treatments), len(job.labels))
    theta = np.zeros(shape.size)
    old, new = views(base.theta, base.shape), views(theta, shape)
    for name in ("first", "first_bias", "second", "second_bias"):
        getattr(new, name)[...] = getattr(old, name)
    new.heads_bias[...] = old.heads_bias.min()
    for names, known, before, after in (
        (job.treatments, base.treatments, 0, 0),
        (job.labels, base.labels, len(base.treatments), len(job.treatments)),
    ):
        for place, name in enumerate(known):
            new.heads[:, after + names.index(name)] = old.heads[:, before + place]
            new.heads_bias[after + names.index(name)] = old.heads_bias[before + place]
    return msgspec.structs.replace(base, treatments=job.treatments, labels=job.labels, shape=shape, theta=theta)


def _material(job: TrainingJob) -> tuple[Material, np.ndarray[tuple[int, ...], np.dtype[np.bool_]]]:
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
    return Material(x, treatment, result, refuted, weight), held_back
