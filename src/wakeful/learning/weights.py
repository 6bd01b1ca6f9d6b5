"""A model version as bytes: MessagePack of plain numbers and names, so that nothing is executed when it is loaded."""

from __future__ import annotations

import msgspec
import numpy as np

from wakeful.learning.model import Model
from wakeful.learning.network import Shape
from wakeful.learning.novelty import Novelty

FORMAT = 1


class Stored(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All that a model version is. Arrays are little-endian: θ, mean, scale and reference float64, exemplars float32."""

    format: int
    treatments: tuple[str, ...]
    labels: tuple[str, ...]
    inputs: int
    hidden: int
    theta: bytes
    mean: bytes
    scale: bytes
    temperatures: tuple[float, float]
    exemplars: bytes
    reference: bytes


def to_bytes(model: Model) -> bytes:
    """The model as bytes: equal models, equal bytes."""
    stored = Stored(
        format=FORMAT,
        treatments=model.treatments,
        labels=model.labels,
        inputs=model.shape.inputs,
        hidden=model.shape.hidden,
        theta=model.theta.astype("<f8").tobytes(),
        mean=model.mean.astype("<f8").tobytes(),
        scale=model.scale.astype("<f8").tobytes(),
        temperatures=model.temperatures,
        exemplars=model.novelty.exemplars.astype("<f4").tobytes(),
        reference=model.novelty.reference.astype("<f8").tobytes(),
    )
    return msgspec.msgpack.encode(stored)


def from_bytes(weights: bytes) -> Model:
    """The model that ``to_bytes`` gave out.

    Raises:
        ValueError: the bytes are not a model, are of another format, or their arrays don't fit together.
    """
    try:
        stored = msgspec.msgpack.decode(weights, type=Stored)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"these {len(weights)} bytes are not the weights of a two-headed model: {error}") from error
    if stored.format != FORMAT:
        raise ValueError(f"weights of format {stored.format}; this version of wakeful reads format {FORMAT}")
    shape = Shape(stored.inputs, stored.hidden, len(stored.treatments), len(stored.labels))
    d = shape.inputs
    sizes = (len(stored.theta), len(stored.mean), len(stored.scale))
    whole = d > 0 and shape.hidden > 0 and shape.treatments > 0 and shape.labels > 0
    if not whole or sizes != (8 * shape.size, 8 * d, 8 * d) or len(stored.exemplars) % (4 * d) or len(stored.reference) % 8:
        raise ValueError("the weights' arrays don't fit together: the bytes are damaged or of another program")
    theta, mean, scale = (np.frombuffer(part, "<f8").astype(np.float64) for part in (stored.theta, stored.mean, stored.scale))
    exemplars = np.frombuffer(stored.exemplars, "<f4").astype(np.float64).reshape(-1, d)
    reference = np.frombuffer(stored.reference, "<f8").astype(np.float64)
    finite = all(bool(np.isfinite(part).all()) for part in (theta, mean, scale, exemplars, reference))
    if not finite or not (scale > 0.0).all() or not all(0.0 < t < 1e6 for t in stored.temperatures):
        raise ValueError("the weights hold numbers that no training gives: the bytes are damaged")
    return Model(
        treatments=stored.treatments,
        labels=stored.labels,
        shape=shape,
        theta=theta,
        mean=mean,
        scale=scale,
        temperatures=stored.temperatures,
        novelty=Novelty(exemplars, reference),
    )
