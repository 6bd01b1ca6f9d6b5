"""Experiment 1's baselines: the structural facts in every seed, and the paper's cells within one published deviation."""

from __future__ import annotations

from statistics import fmean

import pytest

from wakeful.experiments.exp1_asking import Asking
from wakeful.experiments.exp1_events import events
from wakeful.experiments.exp1_methods import (
    Choice,
    Trial,
    always_llm,
    fixed,
    networked,
    oracle_deferral,
    paper_threshold,
    task_only,
    trial,
)
from wakeful.experiments.exp1_treatment import METRICS, SEEDS, Measured, measure
from wakeful.experiments.rows import paper_cells
from wakeful.experiments.worlds.service_events import VARIANTS, A, Variant, world
from wakeful.learning.calibration import CANDIDATES


def bare(variant: Variant, seed: int) -> Trial:
    of = world(variant, seed)
    return Trial(world=of, calibration=events(of, "calibration"), test=events(of, "test"), advice={}, guidelines={})


@pytest.mark.parametrize("seed", [*SEEDS, *range(1000, 1010)])
@pytest.mark.parametrize("variant", VARIANTS, ids=lambda each: each.name)
def test_the_structural_facts_hold_in_every_seed(variant: Variant, seed: int) -> None:
    given = bare(variant, seed)
    by_object = measure(given.world.test, fixed(given))
    assert (by_object.structured, by_object.strict_pair) == (pytest.approx(100 * 12 / 34), 0.0)
    by_task = measure(given.world.test, task_only(given))
    assert (by_task.structured, by_task.strict_pair) == (pytest.approx(100 * 8 / 34), 0.0)


@pytest.fixture(scope="module")
def ten() -> dict[str, list[Measured]]:
    found: dict[str, list[Measured]] = {}
    with Asking("stand-in") as asking:
        for seed in SEEDS:
            given = trial(world(A, seed), asking)
            alone, *_ = networked(given)
            for name, choices in (
                ("task_only", task_only(given)),
                ("fixed", fixed(given)),
                ("always_llm", always_llm(given)),
                ("dl_only", alone),
            ):
                found.setdefault(name, []).append(measure(given.world.test, choices))
    return found


@pytest.mark.parametrize("metric", METRICS)
@pytest.mark.parametrize("method", ["task_only", "fixed", "dl_only", "always_llm"])
def test_a_baselines_mean_over_the_ten_seeds_is_within_one_published_deviation(
    ten: dict[str, list[Measured]], method: str, metric: str
) -> None:
    cell = paper_cells()[method, "A", metric]
    mean = fmean(getattr(each, metric) for each in ten[method])
    assert abs(mean - cell.paper_mean) <= (cell.paper_sd or 0.0) + 0.005


def test_the_threshold_is_the_least_of_those_with_the_most_right_on_calibration_events() -> None:
    given = bare(A, 5000)
    sure = [Choice(treatment=case.truth, learned=case.truth, automatic=True, confidence=0.95) for case in given.world.calibration]
    assert paper_threshold(given, sure) == CANDIDATES[0]
    # Wrong at 0.62, and the reasoner would have known: the least threshold above it.
    wrong = sure[0].treatment
    sure[0] = Choice(treatment="memory", learned="memory", automatic=True, confidence=0.62)
    told = Trial(
        world=given.world,
        calibration=given.calibration,
        test=given.test,
        advice={given.calibration[0].id: wrong},
        guidelines={},
    )
    assert paper_threshold(told, sure) == 0.65


def test_the_oracle_asks_exactly_where_asking_turns_wrong_into_right() -> None:
    given = bare(A, 5001)
    truth = given.world.test[0].truth
    told = Trial(
        world=given.world, calibration=(), test=given.test, advice={given.test[0].id: truth, given.test[1].id: "?"}, guidelines={}
    )
    learned = [Choice(treatment="?", learned="?", automatic=True) for _ in given.test]
    chosen = oracle_deferral(told, learned)
    assert [choice.asked for choice in chosen] == [True] + [False] * 81
    assert chosen[0].treatment == truth
