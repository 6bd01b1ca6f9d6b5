"""How the treatment selector was chosen, on seeds that are used for nothing else; no test event is looked at.

    python -m benchmarks.selector_choice [--seeds 6] [--peers | --gate | --cost]

For each tuning seed and each variant of Experiment 1's world a candidate learns from the 268 training events, the 42 calibration
events are held back for it as in the experiment, and it is compared on the calibration events of twenty other tuning seeds (840
events, whose objects it has not met). What it learned from differs from fit to fit, so the spread is that over fits.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import click
import msgspec
import numpy as np

from benchmarks.selector_cost import print_cost
from wakeful.contracts.learner import Predictor, RowPredictor
from wakeful.experiments.exp1_asking import Asking
from wakeful.experiments.exp1_events import events, labels_of, spec
from wakeful.experiments.worlds.service_events import TREATMENTS, VARIANTS, Split, Variant, World, world
from wakeful.facts.inputs import TrainingJob
from wakeful.learning.experts import logs_of, pooled, weigh
from wakeful.learning.forest import ForestReader, ForestSettings, fit_forest
from wakeful.learning.material import Flags, Floats, Ints, Material
from wakeful.learning.model import probabilities
from wakeful.learning.network import softmax
from wakeful.learning.panel import PanelReader
from wakeful.learning.pooled import Pooled, PooledSettings
from wakeful.learning.pooled_predictor import PooledPredictor
from wakeful.learning.rule_lists import RuleReader, fit_rules
from wakeful.learning.rule_search import SearchSettings
from wakeful.learning.two_heads import TwoHeads
from wakeful.selection.features import Encoder

SEEDS = range(5100, 5140)
OTHERS = range(6000, 6020)
SHORT = SearchSettings(chains=4, steps=600, steps_again=200)
"""The search as it was before it was made longer."""
POOLS = {"prior .1 .5 .5, ridge 10": ((0.1, 0.5, 0.5), 10.0), "prior .1 .7 .4, ridge 10": ((0.1, 0.7, 0.4), 10.0)}
BELOW = (0.0, 0.5, 1.0)
"""By how many standard deviations the gate stays below what it expects of the reasoner."""


class Given(msgspec.Struct):
    """One seed's material in one variant, and what candidates are compared on, with and without identities."""

    rows: Material
    held_back: Flags
    advised: Ints
    new: Floats
    truth: Ints
    structured: Flags
    advice: Ints
    seed: int


def features(of: World, split: Split, identity: bool) -> Floats:
    """A split's events as the product encodes them."""
    encoder = Encoder(spec(identity), TREATMENTS)
    return np.stack([encoder.encode(event) for event in events(of, split, identity)])


@cache
def others(variant: Variant, identity: bool) -> tuple[Floats, Ints, Flags]:
    """The calibration events of the other tuning seeds: features, right treatments, and which are structured."""
    worlds = [world(variant, seed) for seed in OTHERS]
    return (
        np.vstack([features(of, "calibration", identity) for of in worlds]),
        np.concatenate([labels_of(of.calibration) for of in worlds]),
        np.array([case.structured for of in worlds for case in of.calibration]),
    )


@cache
def advised(variant: Variant, seeds: tuple[int, ...]) -> Ints:
    """What the stand-in for a language model says of the calibration events of these seeds."""
    with Asking("stand-in") as asking:
        found = []
        for seed in seeds:
            of = world(variant, seed)
            asked = events(of, "calibration")
            said = asking.answers(of, asked)
            found += [TREATMENTS.index(said[event.id]) for event in asked]
    return np.array(found)


def given(variant: Variant, seed: int, identity: bool) -> Given:
    """What one fit has to learn from."""
    of = world(variant, seed)
    x = np.vstack([features(of, "training", identity), features(of, "calibration", identity)])
    y = np.concatenate([labels_of(of.training), labels_of(of.calibration)])
    none, ones = np.full(len(x), -1), np.ones(len(x))
    new, truth, structured = others(variant, identity)
    return Given(
        rows=Material(x=x, treatment=y, result=none, refuted=none, weight=ones, result_weight=ones),
        held_back=np.arange(len(y)) >= len(of.training),
        advised=advised(variant, (seed,)),
        new=new,
        truth=truth,
        structured=structured,
        advice=advised(variant, tuple(OTHERS)),
        seed=seed,
    )


def job_of(of: Given) -> TrainingJob:
    """The rows as a training from scratch."""
    rows = of.rows
    return TrainingJob(
        training=1, base_version=0, base_weights=b"", watermark=len(rows.x), seed=of.seed, epochs=140, treatments=TREATMENTS,
        labels=("none", "intervention"), features=rows.x, treatment=rows.treatment, result=rows.result, refuted=rows.refuted,
        weight=rows.weight, held_back=of.held_back,
    )  # fmt: skip


# --- candidates: each gives probabilities of the new events ---


def by_learner(learner: TwoHeads, of: Given) -> Floats:
    """A learner as it ships."""
    return _said(learner.load(learner.train(job_of(of))[1]), of.new)


def _said(predictor: Predictor, new: Floats) -> Floats:
    assert isinstance(predictor, RowPredictor)
    return predictor.estimate_rows(new).treatments


def by_trees(of: Given) -> Floats:
    """Our own boosted trees on all columns."""
    return softmax(ForestReader(fit_forest(of.rows, len(TREATMENTS), of.seed, ForestSettings())).logits_many(of.new))


def by_rules(search: SearchSettings, of: Given) -> Floats:
    """Decision lists alone."""
    return RuleReader(fit_rules(of.rows, of.held_back, len(TREATMENTS), of.seed, search)[1]).shares_many(of.new)


def by_pairs(of: Given) -> Floats:
    """Multinomial logistic regression on all products of two columns, with a ridge."""
    varying = np.flatnonzero(of.rows.x.std(axis=0) > 0)
    upper = np.triu_indices(len(varying))
    mean, scale = of.rows.x[:, varying].mean(axis=0), of.rows.x[:, varying].std(axis=0)

    def products(x: Floats) -> Floats:
        z = (x[:, varying] - mean) / scale
        return np.hstack([np.ones((len(z), 1)), z, (z[:, upper[0]] * z[:, upper[1]])])

    inputs, told = products(of.rows.x), np.eye(len(TREATMENTS))[of.rows.treatment]
    kernel, dual = inputs @ inputs.T, np.zeros((len(inputs), len(TREATMENTS)))
    rate = 1.0 / (0.5 * float(np.linalg.norm(kernel, 2)) + 0.3)
    for _ in range(400):
        dual -= rate * (softmax(kernel @ dual) - told + 0.3 * dual)
    return softmax(products(of.new) @ (inputs.T @ dual))


def by_lightgbm(of: Given) -> Floats:
    """LightGBM alone, on all columns, with the prototype's settings."""
    from lightgbm import LGBMClassifier  # noqa: PLC0415

    model: Any = LGBMClassifier(
        n_estimators=150, max_depth=4, learning_rate=0.1, subsample=0.7, subsample_freq=1, colsample_bytree=0.5,
        min_child_samples=2, num_leaves=15, random_state=of.seed, n_jobs=1, verbose=-1,
    )  # fmt: skip
    return _of_package(model, of)


def by_scikit(of: Given) -> Floats:
    """scikit-learn's boosted trees alone, set likewise."""
    from sklearn.ensemble import HistGradientBoostingClassifier  # noqa: PLC0415

    return _of_package(
        HistGradientBoostingClassifier(
            max_iter=150, max_depth=4, learning_rate=0.1, max_features=0.5, min_samples_leaf=2, early_stopping=False,
            random_state=of.seed,
        ),
        of,
    )  # fmt: skip


def _of_package(model: Any, of: Given) -> Floats:
    found = np.zeros((len(of.new), len(TREATMENTS)))
    model.fit(of.rows.x, of.rows.treatment)
    found[:, model.classes_] = model.predict_proba(of.new)
    return found


Candidate = tuple[Callable[[Given], Floats], bool]

OURS: Mapping[str, Candidate] = {
    "network (two_heads)": (partial(by_learner, TwoHeads()), True),
    "pairwise logistic, no identity": (by_pairs, False),
    "trees, no identity": (by_trees, False),
    "trees": (by_trees, True),
    "lists, 4 chains of 600, no identity": (partial(by_rules, SHORT), False),
    "lists, 4 chains of 600": (partial(by_rules, SHORT), True),
    "lists, 6 chains of 1,200": (partial(by_rules, SearchSettings()), True),
    "pool, as it was": (partial(by_learner, Pooled(PooledSettings(rules=SHORT, prior=(0.1, 0.5, 0.5), ridge=10.0))), True),
    "pool (pooled), no identity": (partial(by_learner, Pooled()), False),
    "pool (pooled)": (partial(by_learner, Pooled()), True),
}


def peers() -> Mapping[str, Candidate]:
    """The packages that people use, alone, and LightGBM's trees within the pool; they have to be installed."""
    return {
        "trees, no identity": (by_trees, False),
        "LightGBM, no identity": (by_lightgbm, False),
        "LightGBM": (by_lightgbm, True),
        "scikit-learn, no identity": (by_scikit, False),
        "scikit-learn": (by_scikit, True),
        "pool (pooled)": (partial(by_learner, Pooled()), True),
        "pool, LightGBM's trees (boosted)": (partial(by_learner, Pooled(PooledSettings(trees="lightgbm"))), True),
    }


def print_choice(candidates: Mapping[str, Candidate], seeds: int) -> None:
    """Each candidate's accuracy and log loss by variant: mean over fits, ± the standard error of that mean."""
    print(f"{seeds} seeds from {SEEDS[0]}, each tried on {len(OTHERS)} others' calibration events")
    print("accuracy % ± standard error over fits (structured / random), log loss")
    print(f"{'candidate':36}" + "".join(f"{variant.name:>37}" for variant in VARIANTS) + f"{'s a fit':>9}")
    for name, (run, identity) in candidates.items():
        cells, spent = [], []
        for variant in VARIANTS:
            figures = []
            for seed in SEEDS[:seeds]:
                of = given(variant, seed, identity)
                began = time.process_time()
                shares = run(of)
                spent.append(time.process_time() - began)
                right = shares.argmax(axis=1) == of.truth
                loss = -np.log(np.maximum(shares[np.arange(len(right)), of.truth], 1e-4)).mean()
                figures.append((100 * right.mean(), 100 * right[of.structured].mean(), 100 * right[~of.structured].mean(), loss))
            whole, some, rest, loss = np.mean(figures, axis=0)
            error = np.std([each[0] for each in figures], ddof=1) / np.sqrt(seeds) if seeds > 1 else 0.0
            cells.append(f"{whole:6.2f} ± {error:.2f} ({some:6.2f} /{rest:6.2f}) {loss:.3f}")
        print(f"{name:36}" + "".join(f"{cell:>37}" for cell in cells) + f"{np.mean(spent):9.2f}", flush=True)


# --- weights and gate, on one fit of the pool each ---


def print_gate(seeds: int) -> None:
    """What other priors and ridges of the pool's weights do, and asking the stand-in, by how much the gate doubts it."""
    table: dict[str, dict[str, list[tuple[float, ...]]]] = {}
    for variant in VARIANTS:
        for seed in SEEDS[:seeds]:
            of = given(variant, seed, True)
            learner = Pooled()
            predictor = learner.load(learner.train(job_of(of))[1])
            assert isinstance(predictor, PooledPredictor)
            model, kept = predictor.model, of.rows.rows(of.held_back)
            blind, published = PanelReader(model.tested), PanelReader(model.whole)
            new = msgspec.structs.replace(kept, x=of.new)
            held = np.concatenate([logs_of(probabilities(model.network, kept)[0])[None], blind.logs_many(kept.x)])
            logs = np.concatenate([logs_of(probabilities(model.network, new)[0])[None], published.logs_many(of.new)])
            own = PooledSettings()
            for name, (prior, ridge) in {**POOLS, "as it ships: prior .1 .7 .4, ridge 30": (own.prior, own.ridge)}.items():
                weights = weigh(held, kept.treatment, kept.weight, np.array(prior), ridge)
                shares = pooled(logs, weights)
                loss = float(-np.log(np.maximum(shares[np.arange(len(of.truth)), of.truth], 1e-4)).mean())
                right = shares.argmax(axis=1) == of.truth
                table.setdefault(name, {}).setdefault(variant.name, []).append((100 * right.mean(), 0.0, loss))
            told = pooled(held, weights)
            for below in BELOW:
                needed = needs(told, kept.treatment, of.advised, below)
                asks = shares.max(axis=1) < needed[shares.argmax(axis=1)]
                right = np.where(asks, of.advice, shares.argmax(axis=1)) == of.truth
                row = (100 * right.mean(), 82 * asks.mean(), loss)
                table.setdefault(f"  … asking {below:g} sd below", {}).setdefault(variant.name, []).append(row)
    print(f"{seeds} seeds from {SEEDS[0]}: accuracy %, calls per 82 events, log loss of the model alone")
    for name, by_variant in table.items():
        cells = [np.mean(by_variant[variant.name], axis=0) for variant in VARIANTS]
        print(f"{name:40}" + "".join(f"{right:12.2f}{calls:6.2f}{loss:8.4f}" for right, calls, loss in cells))


def needs(told: Floats, truth: Ints, advice: Ints, below: float) -> Floats:
    """The confidence that each treatment needs not to be asked about, as ``calibration.expected_of_advice`` makes it."""
    doubt, chosen = np.maximum(0.02, 1.0 - told.max(axis=1)), told.argmax(axis=1)
    right = (advice == truth).astype(np.float64)

    def rate(own: Flags, prior: float) -> tuple[float, float]:
        cases = float(doubt[own].sum()) + 1.0
        return (float((doubt * right)[own].sum()) + prior) / cases, cases

    whole, _ = rate(np.ones(len(told), dtype=np.bool_), 0.5)
    rates = [rate(chosen == place, whole) for place in range(told.shape[1])]
    return np.array([mean - below * np.sqrt(mean * (1.0 - mean) / (cases + 1.0)) for mean, cases in rates])


@click.command()
@click.option("--seeds", default=6, show_default=True, help="How many of the tuning seeds.")
@click.option("--peers", "packaged", is_flag=True, help="LightGBM's and scikit-learn's trees instead.")
@click.option("--gate", is_flag=True, help="The pool's weights and the gate instead.")
@click.option("--cost", is_flag=True, help="What the choice costs instead.")
def main(seeds: int, packaged: bool, gate: bool, cost: bool) -> None:
    """Print each candidate's accuracy and log loss on tuning seeds."""
    if cost:
        of = given(VARIANTS[0], SEEDS[0], True)
        print_cost(job_of(of), of.new)
    elif gate:
        print_gate(seeds)
    else:
        print_choice(peers() if packaged else OURS, seeds)


if __name__ == "__main__":
    main()
