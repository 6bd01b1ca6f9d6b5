"""The network of Eq. 8 and its optimiser."""

from __future__ import annotations

import importlib.util

import msgspec
import numpy as np
import pytest

from wakeful.learning.material import Floats, Material
from wakeful.learning.network import (
    AdamW,
    Fit,
    Shape,
    gradient,
    logits,
    result_losses,
    softmax,
    start,
    train,
    treatment_losses,
    views,
)

SHAPE = Shape(inputs=7, hidden=5, treatments=3, labels=2)


def slope_of(theta: Floats, rows: Material, fit: Fit) -> Floats:
    slope = np.empty(SHAPE.size)
    gradient(views(theta, SHAPE), rows, fit, None, views(slope, SHAPE))
    return slope


def trained(theta: Floats, rows: Material, fit: Fit) -> Floats:
    *_, last = train(theta, SHAPE, rows, fit)
    return last


def material(rows: int = 24, seed: int = 0) -> Material:
    """Every kind of row: labelled, refuted, neither; decided and undecided; of several weights."""
    random = np.random.default_rng(seed)
    treatment = random.integers(-1, 3, rows)
    return Material(
        x=random.normal(size=(rows, SHAPE.inputs)),
        treatment=treatment,
        result=random.integers(-1, 2, rows),
        refuted=np.where(treatment < 0, random.integers(-1, 3, rows), -1),
        weight=random.choice([0.5, 1.0, 2.3], rows),
        result_weight=random.choice([0.1, 1.0], rows),
    )


def loss(theta: Floats, rows: Material, fit: Fit) -> float:
    z, w = logits(theta, SHAPE, rows.x)
    total = 0.0
    for share, (each, weight) in (
        (fit.treatment_loss, treatment_losses(softmax(z), rows)),
        (fit.result_loss, result_losses(softmax(w), rows)),
    ):
        total += share * float((each * weight).sum() / weight.sum())
    return total


def test_the_gradient_is_that_of_the_loss() -> None:
    rows, fit = material(), Fit(epochs=1, seed=0, treatment_loss=0.7, result_loss=1.3)
    theta = start(SHAPE, 3)
    slope = slope_of(theta, rows, fit)
    for at in np.random.default_rng(1).choice(SHAPE.size, 40, replace=False):
        step = np.zeros_like(theta)
        step[at] = 1e-6
        measured = (loss(theta + step, rows, fit) - loss(theta - step, rows, fit)) / 2e-6
        assert slope[at] == pytest.approx(measured, abs=1e-6)


def test_rows_of_which_nothing_is_known_teach_nothing() -> None:
    rows = material()
    blank = Material(
        x=rows.x,
        treatment=np.full(24, -1),
        result=np.full(24, -1),
        refuted=np.full(24, -1),
        weight=rows.weight,
        result_weight=rows.weight,
    )
    assert not slope_of(start(SHAPE, 0), blank, Fit(epochs=1, seed=0)).any()


def test_a_refuted_treatment_becomes_less_probable_and_the_others_keep_their_order() -> None:
    random = np.random.default_rng(0)
    x = random.normal(size=(32, SHAPE.inputs))
    none = np.full(32, -1)
    rows = Material(x=x, treatment=none, result=none, refuted=np.full(32, 1), weight=np.ones(32), result_weight=np.ones(32))
    theta = start(SHAPE, 0)
    before = softmax(logits(theta, SHAPE, x)[0])[:, 1].mean()
    after = softmax(logits(trained(theta, rows, Fit(epochs=300, seed=0)), SHAPE, x)[0])[:, 1].mean()
    assert after < 0.1 < before


def test_training_is_repeatable_and_leaves_its_start_alone() -> None:
    theta = start(SHAPE, 5)
    kept = theta.copy()
    one = trained(theta, material(), Fit(epochs=7, seed=11))
    assert (one == trained(theta, material(), Fit(epochs=7, seed=11))).all()
    assert (one != trained(theta, material(), Fit(epochs=7, seed=12))).any()
    assert (theta == kept).all()


def test_the_layers_share_the_memory_of_theta() -> None:
    theta = np.zeros(SHAPE.size)
    views(theta, SHAPE).heads_bias[...] = 1.0
    assert theta.sum() == SHAPE.treatments + SHAPE.labels
    assert theta[-5:].all()


def test_adamw_decays_without_the_gradients_help() -> None:
    theta = np.ones(4)
    AdamW(4, learning_rate=0.1, weight_decay=0.5).step(theta, np.zeros(4))
    assert theta == pytest.approx(np.full(4, 0.95))


@pytest.mark.skipif(importlib.util.find_spec("torch") is None, reason="PyTorch is not installed; it is no dependency")
@pytest.mark.parametrize("dropout", [0.0, 0.1])
def test_the_trainer_agrees_with_pytorch(dropout: float) -> None:
    import torch  # noqa: PLC0415  (not a dependency: only where it happens to be installed)

    rows, fit = material(rows=70, seed=4), Fit(epochs=6, seed=9, dropout=dropout, weight_decay=1e-2, result_loss=0.6)
    theta = start(SHAPE, 2)
    parts = views(theta.copy(), SHAPE)
    names = ("first", "first_bias", "second", "second_bias", "heads", "heads_bias")
    p = {name: torch.tensor(getattr(parts, name), dtype=torch.float64, requires_grad=True) for name in names}
    optimiser = torch.optim.AdamW(p.values(), lr=fit.learning_rate, weight_decay=fit.weight_decay)
    random = np.random.default_rng((fit.seed, 2))
    k, n, h = SHAPE.treatments, len(rows.x), SHAPE.hidden
    for _ in range(fit.epochs):
        order = random.permutation(n)
        masks = (random.random((n, 2 * h)) < 1.0 - dropout) / (1.0 - dropout) if dropout else np.ones((n, 2 * h))
        for begin in range(0, n, fit.batch):
            batch, keep = rows.rows(order[begin : begin + fit.batch]), torch.tensor(masks[begin : begin + fit.batch])
            hidden = torch.relu(torch.tensor(batch.x) @ p["first"] + p["first_bias"]) * keep[:, :h]
            hidden = torch.relu(hidden @ p["second"] + p["second_bias"]) * keep[:, h:]
            out = hidden @ p["heads"] + p["heads_bias"]
            weight, recent = torch.tensor(batch.weight), torch.tensor(batch.result_weight)
            total = torch.tensor(0.0, dtype=torch.float64)
            logs = torch.log_softmax(out[:, :k], dim=1)
            known, wrong = batch.treatment >= 0, (batch.treatment < 0) & (batch.refuted >= 0)
            told = torch.nn.functional.nll_loss(logs[known], torch.tensor(batch.treatment[known]), reduction="none")
            bad = -torch.log1p(-torch.exp(logs[wrong, batch.refuted[wrong]]))
            parts_m = torch.cat([told * weight[known], bad * weight[wrong]])
            total = total + fit.treatment_loss * parts_m.sum() / weight[known | wrong].sum()
            done = batch.result >= 0
            each = torch.nn.functional.cross_entropy(out[done][:, k:], torch.tensor(batch.result[done]), reduction="none")
            total = total + fit.result_loss * (each * recent[done]).sum() / recent[done].sum()
            optimiser.zero_grad()
            total.backward()
            optimiser.step()
    ours = views(trained(theta, rows, fit), SHAPE)
    for name in names:
        np.testing.assert_allclose(getattr(ours, name), p[name].detach().numpy(), rtol=1e-8, atol=1e-10)


def test_a_shape_counts_its_parameters() -> None:
    assert msgspec.structs.replace(SHAPE, inputs=1, hidden=1).size == 1 + 1 + 1 + 1 + 5 + 5
