"""F_θ of Eq. 8: one encoder, a treatment head and a result head, and its training by AdamW, in numpy alone.

Every matrix product is over at most 32 rows. So small a product is done in one thread by every BLAS that we know (OpenBLAS
begins to share work above 2^18 multiplications), and each row's sums are added in one order: equal jobs give equal bytes
whatever the number of threads.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import msgspec
import numpy as np

from wakeful.learning.material import Floats, Material

ROWS: Final = 32
_TINY = 1e-6


class Shape(msgspec.Struct, frozen=True):
    """The network's sizes: inputs d, hidden units h (two layers of them), treatments k, outcome labels l."""

    inputs: int
    hidden: int
    treatments: int
    labels: int

    @property
    def size(self) -> int:
        """How many parameters there are."""
        h, out = self.hidden, self.treatments + self.labels
        return self.inputs * h + h + h * h + h + h * out + out


class Views(msgspec.Struct, frozen=True):
    """The layers as views into one vector θ; ``heads`` holds the treatment head's columns, then the result head's."""

    first: Floats
    first_bias: Floats
    second: Floats
    second_bias: Floats
    heads: Floats
    heads_bias: Floats
    treatments: int


class Fit(msgspec.Struct, frozen=True, kw_only=True):
    """How to train: λ_m and λ_r of Eq. 8, dropout, and AdamW's own settings (decoupled weight decay, as in PyTorch)."""

    epochs: int
    seed: int
    treatment_loss: float = 1.0
    result_loss: float = 1.0
    dropout: float = 0.1
    learning_rate: float = 1e-3
    weight_decay: float = 1e-4
    batch: int = ROWS


def views(theta: Floats, shape: Shape) -> Views:
    """θ, shape (size,), as layers that share its memory."""
    d, h, out = shape.inputs, shape.hidden, shape.treatments + shape.labels
    cuts = np.cumsum([d * h, h, h * h, h, h * out])
    a, b, c, e, f, g = np.split(theta, cuts)
    return Views(a.reshape(d, h), b, c.reshape(h, h), e, f.reshape(h, out), g, shape.treatments)


def start(shape: Shape, seed: int) -> Floats:
    """Initial parameters, uniform in ±1/√(inputs of the layer), as PyTorch's linear layers begin."""
    random = np.random.default_rng((seed, 1))
    theta = np.empty(shape.size)
    parts = views(theta, shape)
    for weights, bias in ((parts.first, parts.first_bias), (parts.second, parts.second_bias), (parts.heads, parts.heads_bias)):
        bound = 1.0 / np.sqrt(max(1, weights.shape[0]))
        weights[...] = random.uniform(-bound, bound, weights.shape)
        bias[...] = random.uniform(-bound, bound, bias.shape)
    return theta


def logits(theta: Floats, shape: Shape, x: Floats) -> tuple[Floats, Floats]:
    """Both heads' logits, (n, k) and (n, l), without dropout."""
    parts = views(theta, shape)
    out = np.empty((len(x), shape.treatments + shape.labels))
    for begin in range(0, len(x), ROWS):
        rows = x[begin : begin + ROWS]
        hidden = np.maximum(rows @ parts.first + parts.first_bias, 0.0)
        hidden = np.maximum(hidden @ parts.second + parts.second_bias, 0.0)
        out[begin : begin + ROWS] = hidden @ parts.heads + parts.heads_bias
    return out[:, : shape.treatments], out[:, shape.treatments :]


def softmax(z: Floats) -> Floats:
    """Probabilities along the last axis."""
    shifted = np.exp(z - z.max(axis=-1, keepdims=True))
    return np.asarray(shifted / shifted.sum(axis=-1, keepdims=True))


def treatment_losses(p: Floats, material: Material) -> tuple[Floats, Floats]:
    """Each row's loss of the treatment head and its weight: cross-entropy where the right treatment is known, else
    −ln(1 − p) of a treatment known to be wrong; weight 0 where neither is. ``p`` is (n, k)."""
    rows = np.arange(len(p))
    labelled = material.treatment >= 0
    negative = ~labelled & (material.refuted >= 0)
    own = p[rows, np.where(labelled, material.treatment, np.maximum(material.refuted, 0))]
    loss = np.where(labelled, -np.log(np.maximum(own, 1e-300)), -np.log(np.maximum(1.0 - own, _TINY)))
    return loss, np.where(labelled | negative, material.weight, 0.0)


def result_losses(p: Floats, material: Material) -> tuple[Floats, Floats]:
    """Each row's cross-entropy of the result head and its weight, 0 where the outcome is undecided. ``p`` is (n, l)."""
    rows = np.arange(len(p))
    decided = material.result >= 0
    loss = -np.log(np.maximum(p[rows, np.maximum(material.result, 0)], 1e-300))
    return loss, np.where(decided, material.result_weight, 0.0)


def gradient(parts: Views, batch: Material, fit: Fit, keep: tuple[Floats, Floats] | None, into: Views) -> None:
    """Writes the gradient of λ_m L_m + λ_r L_r over one batch, as layers; each L is the weighted mean over its own rows.

    Args:
        parts: the parameters.
        batch: at most 32 rows.
        fit: λ_m and λ_r.
        keep: the dropout masks of the two hidden layers, (n, h) each, already divided by the share that is kept.
        into: what is written to.
    """
    n, k = len(batch.x), parts.treatments
    first = np.maximum(batch.x @ parts.first + parts.first_bias, 0.0)
    first_kept = first if keep is None else first * keep[0]
    second = np.maximum(first_kept @ parts.second + parts.second_bias, 0.0)
    second_kept = second if keep is None else second * keep[1]
    out = second_kept @ parts.heads + parts.heads_bias

    by_logit = np.empty_like(out)
    rows = np.arange(n)
    p = softmax(out[:, :k])
    labelled = batch.treatment >= 0
    negative = ~labelled & (batch.refuted >= 0)
    at = np.where(labelled, batch.treatment, np.maximum(batch.refuted, 0))
    own = p[rows, at]
    # Cross-entropy: p − 1[label]. Negative: p_j / (1 − p_j) · (1[j] − p).
    by_logit[:, :k] = p
    by_logit[rows, at] -= 1.0
    factor = np.where(labelled, 1.0, np.where(negative, -own / np.maximum(1.0 - own, _TINY), 0.0)) * batch.weight
    total = batch.weight[labelled | negative].sum()
    by_logit[:, :k] *= (fit.treatment_loss / total * factor if total > 0.0 else np.zeros(n))[:, None]

    decided = batch.result >= 0
    by_logit[:, k:] = softmax(out[:, k:])
    by_logit[rows, k + np.maximum(batch.result, 0)] -= 1.0
    total = batch.result_weight[decided].sum()
    share = fit.result_loss / total * np.where(decided, batch.result_weight, 0.0) if total > 0.0 else np.zeros(n)
    by_logit[:, k:] *= share[:, None]

    np.matmul(second_kept.T, by_logit, out=into.heads)
    by_logit.sum(axis=0, out=into.heads_bias)
    back = by_logit @ parts.heads.T
    if keep is not None:
        back *= keep[1]
    back *= second > 0.0
    np.matmul(first_kept.T, back, out=into.second)
    back.sum(axis=0, out=into.second_bias)
    back = back @ parts.second.T
    if keep is not None:
        back *= keep[0]
    back *= first > 0.0
    np.matmul(batch.x.T, back, out=into.first)
    back.sum(axis=0, out=into.first_bias)


class AdamW:
    """The optimiser's memory. Same arithmetic as ``torch.optim.AdamW`` (betas 0.9 and 0.999, eps 1e-8)."""

    def __init__(self, size: int, learning_rate: float, weight_decay: float) -> None:
        self._rate, self._decay = learning_rate, weight_decay
        self._mean, self._square, self._room = np.zeros(size), np.zeros(size), np.empty(size)
        self._steps = 0

    def step(self, theta: Floats, slope: Floats) -> None:
        """Move θ by one step, in place."""
        room = self._room
        self._steps += 1
        theta *= 1.0 - self._rate * self._decay
        self._mean += np.multiply(np.subtract(slope, self._mean, out=room), 0.1, out=room)
        self._square *= 0.999
        self._square += np.multiply(np.multiply(slope, slope, out=room), 0.001, out=room)
        np.sqrt(self._square, out=room)
        room /= math.sqrt(1.0 - 0.999**self._steps)
        room += 1e-8
        np.divide(self._mean, room, out=room)
        room *= self._rate / (1.0 - 0.9**self._steps)
        theta -= room


def train(theta: Floats, shape: Shape, material: Material, fit: Fit) -> Iterator[Floats]:
    """Yields θ after each of ``fit.epochs`` passes over the material in seeded order.

    It is one array that goes on changing: copy what is to be kept. The given θ is not changed.
    """
    theta, slope = theta.copy(), np.empty(shape.size)
    parts, into = views(theta, shape), views(slope, shape)
    optimiser = AdamW(shape.size, fit.learning_rate, fit.weight_decay)
    random = np.random.default_rng((fit.seed, 2))
    n, h, kept = len(material.x), shape.hidden, 1.0 - fit.dropout
    for _ in range(fit.epochs):
        shuffled = material.rows(random.permutation(n))
        masks = (random.random((n, 2 * h)) < kept) / kept if fit.dropout > 0.0 else None
        for begin in range(0, n, fit.batch):
            batch = shuffled.part(begin, begin + fit.batch)
            keep = None if masks is None else (masks[begin : begin + fit.batch, :h], masks[begin : begin + fit.batch, h:])
            gradient(parts, batch, fit, keep, into)
            optimiser.step(theta, slope)
        yield theta
