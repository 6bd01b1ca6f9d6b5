"""How the guarantee gate opens as validated events accumulate, in Experiment 1's world, for `proposed` and `wakeful`.

    ./run python -m benchmarks.guarantee_growth [--fits 4]

Both selectors learn once, as in the experiment (268 training and 42 calibration events). Then n events that neither has learned
from are validated, and each treatment is certified by one look at its own among them (`selection/guarantee/fixed.py`). What that
allows is measured on other events again. Events come from calibration splits of seeds that are used for nothing else.
"""

from __future__ import annotations

import os
from collections.abc import Sequence

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import click
import numpy as np

from wakeful.experiments.exp1_asking import Asking
from wakeful.experiments.exp1_events import events, labels_of, spec
from wakeful.experiments.exp1_guaranteed import ALPHA, DELTA
from wakeful.experiments.exp1_methods import Trial, paper_network
from wakeful.experiments.exp1_wakeful import GATE, job_of
from wakeful.experiments.worlds.service_events import TREATMENTS, VARIANTS, Case, Variant, world
from wakeful.learning.material import Flags, Floats, Ints
from wakeful.learning.pooled import Pooled
from wakeful.learning.pooled_predictor import PooledPredictor
from wakeful.selection.guarantee.fixed import level_for
from wakeful.selection.selector import Selector

FITTED = 5300
POOL = range(7000, 7200)
VALIDATED = 60
"""So many of them give the validated events, the others those on which what these allow is measured."""
SIZES = (42, 100, 200, 400, 800, 1600, 2500)
DRAWS = 20


def shares_of(variant: Variant, seed: int, cases: Sequence[Case], features: Floats) -> dict[str, Floats]:
    """What both selectors say of the events, (n, 6) each."""
    of = world(variant, seed)
    calibration = events(of, "calibration")
    with Asking("stand-in") as asking:
        given = Trial(world=of, calibration=calibration, test=(), advice=asking.answers(of, calibration), guidelines={})
    learner = Pooled()
    predictor = learner.load(learner.train(job_of(given, Selector(spec(), TREATMENTS, learner, GATE)))[1])
    assert isinstance(predictor, PooledPredictor)
    return {"proposed": paper_network(of)(tuple(cases)), "wakeful": predictor.estimate_rows(features).treatments}


def allowed(shares: Floats, truth: Ints, validated: Ints, measured: Flags) -> tuple[float, float, float]:
    """What share is automatic, how often these are wrong, and of which share of treatments P(wrong and automatic) exceeds α."""
    chosen, scores = shares.argmax(axis=1), np.round(shares.max(axis=1), 6)
    wrong = chosen != truth
    automatic = np.zeros(len(chosen), dtype=np.bool_)
    risks = []
    for place in range(len(TREATMENTS)):
        own = validated[chosen[validated] == place]
        passing = (chosen == place) & (scores >= level_for(scores[own], wrong[own], ALPHA, DELTA))
        automatic |= passing
        here = measured & (chosen == place)
        risks.append(float((passing & wrong & here).sum()) / max(1, int(here.sum())))
    passed = automatic & measured
    return (
        float(passed.sum() / measured.sum()),
        float((passed & wrong).sum() / max(1, int(passed.sum()))),
        float(np.mean(np.array(risks) > ALPHA)),
    )


@click.command()
@click.option("--fits", default=3, show_default=True, help="How many seeds are learned from, in each variant.")
def main(fits: int) -> None:
    """Print what the guarantee gate allows after n validated events."""
    print(f"risk {ALPHA:.0%} per treatment, held with {1 - DELTA:.0%}; {fits} fits, {DRAWS} draws of n events each (10 … 90 %)")
    print(f"{'variant, method':20}{'validated':>10}{'automatic':>28}{'wrong if automatic':>20}{'risk > 5 %':>14}")
    for variant in VARIANTS:
        worlds = [world(variant, seed) for seed in POOL]
        cases = [case for of in worlds for case in of.calibration]
        encoder = Selector(spec(), TREATMENTS, Pooled(), GATE).encoder
        features = np.array([encoder.encode(event) for of in worlds for event in events(of, "calibration")])
        truth = labels_of(tuple(cases))
        measured = np.arange(len(cases)) >= VALIDATED * len(worlds[0].calibration)
        said = [shares_of(variant, FITTED + fit, cases, features) for fit in range(fits)]
        for method in ("proposed", "wakeful"):
            for size in SIZES:
                random = np.random.default_rng((size, 5))
                draws = [random.choice(np.flatnonzero(~measured), size, replace=False) for _ in range(DRAWS)]
                found = np.array([allowed(shares[method], truth, drawn, measured) for shares in said for drawn in draws])
                low, high = np.percentile(100 * found[:, 0], [10, 90])
                print(
                    f"{variant.name + ', ' + method:20}{size:10,}{100 * found[:, 0].mean():12.1f} % ({low:5.1f} … {high:5.1f})"
                    f"{100 * found[:, 1].mean():17.2f} %{100 * found[:, 2].mean():12.1f} %",
                    flush=True,
                )


if __name__ == "__main__":
    main()
