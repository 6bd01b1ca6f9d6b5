"""A model version in memory: F_θ with its calibration and its novelty, and what is done to it between trainings."""

from __future__ import annotations

import msgspec
import numpy as np

from wakeful.facts.inputs import TrainingJob
from wakeful.learning.calibration import temperature
from wakeful.learning.material import Floats, Material
from wakeful.learning.network import Shape, logits, softmax, views
from wakeful.learning.novelty import Novelty


class Model(msgspec.Struct, frozen=True, kw_only=True):
    """A model version in memory. ``mean`` and ``scale`` (d,) standardise features: (f − mean) / scale."""

    treatments: tuple[str, ...]
    labels: tuple[str, ...]
    shape: Shape
    theta: Floats
    mean: Floats
    scale: Floats
    temperatures: tuple[float, float]
    novelty: Novelty

    def standardise(self, features: Floats) -> Floats:
        """Rows (n, d) or one row (d,) as the network and novelty see them."""
        return np.asarray((features - self.mean) / self.scale)


def probabilities(model: Model, rows: Material) -> tuple[Floats, Floats]:
    """Calibrated probabilities over treatments (n, k) and labels (n, l)."""
    z, w = logits(model.theta, model.shape, model.standardise(rows.x))
    return softmax(z / model.temperatures[0]), softmax(w / model.temperatures[1])


def calibrated(model: Model, rows: Material) -> Model:
    """The model with temperatures fitted to these rows."""
    z, w = logits(model.theta, model.shape, model.standardise(rows.x))
    fitted = (temperature(z, rows.treatment, rows.weight), temperature(w, rows.result, rows.weight))
    return msgspec.structs.replace(model, temperatures=fitted)


def restandardised(model: Model, mean: Floats, scale: Floats) -> Floats:
    """Parameters of the same function for features that are standardised by another mean and scale."""
    theta = model.theta.copy()
    parts = views(theta, model.shape)
    np.add(parts.first_bias, ((mean - model.mean) / model.scale) @ parts.first, out=parts.first_bias)
    np.multiply(parts.first, (scale / model.scale)[:, None], out=parts.first)
    return theta


def continued(base: Model, job: TrainingJob, hidden: int) -> Model | None:
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
