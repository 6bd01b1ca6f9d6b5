"""How the treatment selector was chosen: cross-validation within training and calibration events, on seeds used for nothing else.

Run: `python -m benchmarks.selector_choice`. For each of the tuning seeds and each variant of Experiment 1's world, a third of
the calibration events is left out in turn (both members of a pair together), everything is fitted on the training events with
the other calibration events held back, and the candidates are compared on what was left out. No test event is looked at.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import click
import msgspec
import numpy as np

from wakeful.contracts.learner import Predictor
from wakeful.experiments.exp1_events import events, labels_of, spec
from wakeful.experiments.worlds.service_events import TREATMENTS, VARIANTS, Split, Variant, World, world
from wakeful.facts.inputs import TrainingJob
from wakeful.learning.experts import logs_of, pooled, weigh
from wakeful.learning.forest import ForestReader, ForestSettings, fit_forest
from wakeful.learning.material import Flags, Floats, Ints, Material
from wakeful.learning.model import Model, probabilities
from wakeful.learning.network import softmax
from wakeful.learning.panel import PanelReader, fit_panels
from wakeful.learning.pooled import Pooled
from wakeful.learning.predictor import TwoHeadsPredictor
from wakeful.learning.rule_lists import RuleReader, fit_rules
from wakeful.learning.rule_search import SearchSettings
from wakeful.learning.two_heads import TwoHeads
from wakeful.selection.features import Encoder

SEEDS = tuple(range(5000, 5004))
FOLDS = 3
PRIORS = {
    "even": (1 / 3, 1 / 3, 1 / 3),
    "rules, trees": (0.0, 0.5, 0.5),
    "a little network": (0.1, 0.5, 0.5),
    "sharper": (0.1, 0.7, 0.7),
    "more rules": (0.1, 0.7, 0.4),
}
RIDGES = (3.0, 10.0, 30.0)


def features(of: World, split: Split, identity: bool) -> Floats:
    """A split's events as the product encodes them."""
    encoder = Encoder(spec(identity), TREATMENTS)
    return np.stack([encoder.encode(event) for event in events(of, split, identity)])


def material(x: Floats, y: Ints) -> Material:
    """Labelled rows without outcomes."""
    none, ones = np.full(len(x), -1), np.ones(len(x))
    return Material(x=x, treatment=y, result=none, refuted=none, weight=ones, result_weight=ones)


def job_of(rows: Material, held_back: Flags, seed: int) -> TrainingJob:
    """The rows as a training from scratch."""
    n = len(rows.x)
    return TrainingJob(
        training=1, base_version=0, base_weights=b"", watermark=n, seed=seed, epochs=140, treatments=TREATMENTS,
        labels=("none", "intervention"), features=rows.x, treatment=rows.treatment, result=rows.result, refuted=rows.refuted,
        weight=rows.weight, held_back=held_back,
    )  # fmt: skip


def network(rows: Material, held_back: Flags, seed: int) -> Model:
    """The product's two-headed network."""
    job = job_of(rows, held_back, seed)
    return TwoHeads().fitted(job, rows.rows(~held_back), rows.rows(held_back), None)[0]


def pairwise(rows: Material, x: Floats) -> Floats:
    """Multinomial logistic regression on all products of two columns, with a ridge: probabilities of other rows."""
    varying = np.flatnonzero(rows.x.std(axis=0) > 0)
    upper = np.triu_indices(len(varying))
    mean, scale = rows.x[:, varying].mean(axis=0), rows.x[:, varying].std(axis=0)

    def products(of: Floats) -> Floats:
        z = (of[:, varying] - mean) / scale
        return np.hstack([np.ones((len(z), 1)), z, (z[:, upper[0]] * z[:, upper[1]])])

    inputs, told = products(rows.x), np.eye(len(TREATMENTS))[rows.treatment]
    kernel, dual = inputs @ inputs.T, np.zeros((len(inputs), len(TREATMENTS)))
    rate = 1.0 / (0.5 * float(np.linalg.norm(kernel, 2)) + 0.3)
    for _ in range(400):
        slope = softmax(kernel @ dual) - told + 0.3 * dual
        dual -= rate * slope
    return softmax(products(x) @ (inputs.T @ dual))


def fold(variant: Variant, seed: int, left_out: int, took: dict[str, float]) -> tuple[dict[str, Floats], Flags]:
    """Every candidate's probabilities on one third of the calibration events."""
    of = world(variant, seed)
    third = (np.arange(len(of.calibration)) // 2) % FOLDS == left_out
    y = np.concatenate([labels_of(of.training), labels_of(of.calibration)[~third]])
    held_back = np.arange(len(y)) >= len(of.training)
    found: dict[str, Floats] = {}

    def timed(name: str, run: Callable[..., Floats], *given: object) -> None:
        began = time.process_time()
        found[name] = run(*given)
        took[name] = took.get(name, 0.0) + time.process_time() - began

    for identity in (False, True):
        told = "" if identity else ", no identity"
        train, kept = features(of, "training", identity), features(of, "calibration", identity)
        x, new = np.vstack([train, kept[~third]]), kept[third]
        rows = material(x, y)
        timed("pairwise logistic" + told, pairwise, rows, new)
        timed("trees" + told, _trees, rows, new, seed)
        if not identity:
            timed("rules" + told, _rules, rows, held_back, new, seed)
    began = time.process_time()
    fitted = network(rows, held_back, seed)
    networked = time.process_time() - began
    found["network"] = probabilities(fitted, material(new, labels_of(of.calibration)[third]))[0]
    tested, whole = fit_panels(rows, held_back, len(TREATMENTS), seed, SearchSettings(), ForestSettings())
    spent = time.process_time() - began
    reader, blind = PanelReader(whole), PanelReader(tested)
    by_rules, by_trees = (softmax(each) for each in reader.logs_many(new))
    found["rules"], found["trees on what rules ask"] = by_rules, by_trees
    kept_rows = rows.rows(held_back)
    kept_logs = np.concatenate([logs_of(probabilities(fitted, kept_rows)[0])[None], blind.logs_many(kept_rows.x)])
    new_logs = np.concatenate([logs_of(found["network"])[None], reader.logs_many(new)])
    without = np.concatenate([logs_of(found["network"])[None], blind.logs_many(new)])
    for prior, weights in PRIORS.items():
        for ridge in RIDGES:
            chosen = weigh(kept_logs, kept_rows.treatment, kept_rows.weight, np.array(weights), ridge)
            found[f"pool, {prior}, ridge {ridge:g}"] = pooled(new_logs, chosen)
            if ridge == RIDGES[1]:
                found[f"pool, {prior}, no refit"] = pooled(without, chosen)
    for name in found:
        if name.startswith("pool"):
            took[name] = took.get(name, 0.0) + spent
    took["network"] = took.get("network", 0.0) + networked
    return found, third


def peers(variant: Variant, seed: int, left_out: int, took: dict[str, float]) -> tuple[dict[str, Floats], Flags]:
    """Boosted trees of the packages that people use, on the same thirds, where they are installed."""
    of = world(variant, seed)
    third = (np.arange(len(of.calibration)) // 2) % FOLDS == left_out
    y = np.concatenate([labels_of(of.training), labels_of(of.calibration)[~third]])
    found: dict[str, Floats] = {}
    for identity in (False, True):
        train, kept = features(of, "training", identity), features(of, "calibration", identity)
        x, new, told = np.vstack([train, kept[~third]]), kept[third], "" if identity else ", no identity"
        for name, model in packages(seed).items():
            began = time.process_time()
            found[name + told] = model.fit(x, y).predict_proba(new)
            took[name + told] = took.get(name + told, 0.0) + time.process_time() - began
    return found, third


def packages(seed: int) -> dict[str, Any]:
    """LightGBM's and scikit-learn's boosted trees, set as the forest is; these packages are no dependency of wakeful."""
    from lightgbm import LGBMClassifier  # noqa: PLC0415
    from sklearn.ensemble import HistGradientBoostingClassifier  # noqa: PLC0415

    return {
        "LightGBM": LGBMClassifier(
            n_estimators=150, max_depth=4, learning_rate=0.1, subsample=0.7, subsample_freq=1, colsample_bytree=0.5,
            min_child_samples=2, num_leaves=15, random_state=seed, n_jobs=1, verbose=-1,
        ),
        "scikit-learn": HistGradientBoostingClassifier(
            max_iter=150, max_depth=4, learning_rate=0.1, max_features=0.5, min_samples_leaf=2, early_stopping=False,
            random_state=seed,
        ),
    }  # fmt: skip


def _trees(rows: Material, new: Floats, seed: int) -> Floats:
    reader = ForestReader(fit_forest(rows, len(TREATMENTS), seed, ForestSettings()))
    return softmax(reader.logits_many(new))


def _rules(rows: Material, held_back: Flags, new: Floats, seed: int) -> Floats:
    return RuleReader(fit_rules(rows, held_back, len(TREATMENTS), seed, SearchSettings())[1]).shares_many(new)


class Tally(msgspec.Struct):
    """How one candidate did on one variant."""

    right: list[bool] = []
    structured: list[bool] = []
    loss: list[float] = []


def print_cost() -> None:
    """Print what training and one estimate cost, the network alone beside the pool: medians of single calls, taken in turn."""
    of = world(VARIANTS[0], SEEDS[0])
    x = np.vstack([features(of, "training", True), features(of, "calibration", True)])
    y = np.concatenate([labels_of(of.training), labels_of(of.calibration)])
    held_back = np.arange(len(y)) >= len(of.training)
    rows, new = material(x, y), features(of, "test", True)
    readers: list[tuple[str, Predictor]] = []
    for learner in (TwoHeads(), Pooled()):
        began = time.process_time()
        _, weights = learner.train(job_of(rows, held_back, SEEDS[0]))
        print(f"{learner.name:12} trained in {time.process_time() - began:.2f} s of processor time, {len(weights):,} bytes")
        readers.append((learner.name, learner.load(weights)))
    spent: dict[str, list[float]] = {}
    for turn in range(2000):
        row = new[turn % len(new)]
        for name, reader in readers:
            began = time.perf_counter()
            reader.estimate(row)
            spent.setdefault(f"{name}, one event", []).append(time.perf_counter() - began)
        if turn % 20 == 0:
            for name, reader in readers:
                assert isinstance(reader, TwoHeadsPredictor)
                began = time.perf_counter()
                reader.estimate_rows(new[:64])
                spent.setdefault(f"{name}, one of 64", []).append((time.perf_counter() - began) / 64)
    for name, seconds in spent.items():
        low, middle, high = np.percentile(np.array(seconds) * 1e6, [10, 50, 90])
        print(f"{name:24}{middle:8.1f} µs{low:10.1f} .. {high:.1f}")


@click.command()
@click.option("--seeds", default=len(SEEDS), help="How many of the tuning seeds.")
@click.option("--cost", is_flag=True, help="Print what the choice costs instead.")
@click.option("--peers", "packaged", is_flag=True, help="Compare LightGBM's and scikit-learn's trees instead.")
def main(seeds: int, cost: bool, packaged: bool) -> None:
    """Print each candidate's accuracy and log loss on what was left out, by variant."""
    if cost:
        print_cost()
        return
    tallies: dict[tuple[str, str], Tally] = {}
    took: dict[str, float] = {}
    for variant in VARIANTS:
        for seed in SEEDS[:seeds]:
            of = world(variant, seed)
            labels = labels_of(of.calibration)
            for left_out in range(FOLDS):
                found, third = (peers if packaged else fold)(variant, seed, left_out, took)
                for name, shares in found.items():
                    tally = tallies.setdefault((name, variant.name), Tally())
                    own = labels[third]
                    tally.right += (shares.argmax(axis=1) == own).tolist()
                    tally.structured += [case.structured for case, out in zip(of.calibration, third, strict=True) if out]
                    tally.loss += (-np.log(np.maximum(shares[np.arange(len(own)), own], 1e-4))).tolist()
    fits = len(VARIANTS) * seeds * FOLDS
    print(f"{seeds} seeds from {SEEDS[0]}, {FOLDS} folds of the calibration events; accuracy % (structured / random), log loss")
    print(f"{'candidate':38}" + "".join(f"{variant.name:>31}" for variant in VARIANTS) + f"{'mean loss':>11}{'s a fit':>9}")
    for name in dict.fromkeys(name for name, _ in tallies):
        cells, losses = [], []
        for variant in VARIANTS:
            tally = tallies[name, variant.name]
            right, structured = np.array(tally.right), np.array(tally.structured)
            whole, some, rest = 100 * right.mean(), 100 * right[structured].mean(), 100 * right[~structured].mean()
            losses.append(float(np.mean(tally.loss)))
            cells.append(f"{whole:6.2f} ({some:6.2f} /{rest:6.2f}) {losses[-1]:.3f}")
        spent = f"{took[name] / fits:9.2f}" if name in took else " " * 9
        print(f"{name:38}" + "".join(f"{cell:>31}" for cell in cells) + f"{np.mean(losses):11.4f}{spent}")


if __name__ == "__main__":
    main()
