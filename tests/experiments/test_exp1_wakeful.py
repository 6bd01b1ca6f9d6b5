"""Experiment 1's ``wakeful``: the product's own learner and gate, and nothing of the test events' truth."""

from __future__ import annotations

import msgspec
import pytest

from wakeful.experiments.exp1_asking import Asking
from wakeful.experiments.exp1_events import events, paper_inputs, spec
from wakeful.experiments.exp1_methods import Trial, trial
from wakeful.experiments.exp1_treatment import METHODS, METRICS, measure, rows, run_all
from wakeful.experiments.exp1_wakeful import GATE, job_of, wakeful
from wakeful.experiments.worlds.service_events import TREATMENTS, A, B, C, world
from wakeful.learning.pooled import Pooled
from wakeful.selection.explain import contributions
from wakeful.selection.selector import Selector


@pytest.fixture(scope="module")
def given() -> Trial:
    with Asking("stand-in") as asking:
        return trial(world(C, 5003), asking)


def test_a_test_events_truth_changes_nothing_that_is_decided(given: Trial) -> None:
    shuffled = [msgspec.structs.replace(case, truth="memory") for case in given.world.test]
    blind = msgspec.structs.replace(given, world=msgspec.structs.replace(given.world, test=tuple(shuffled)))
    assert wakeful(blind) == wakeful(given)


def test_it_is_mostly_right_and_mostly_automatic_on_objects_that_it_never_met(given: Trial) -> None:
    found = measure(given.world.test, wakeful(given))
    assert found.overall > 90.0
    assert found.automatic > 90.0


def test_a_reasoner_that_errs_where_the_model_doubts_is_not_asked_more_than_one_that_does_not(given: Trial) -> None:
    truths = {
        event.id: case.truth
        for split, asked in (("calibration", given.calibration), ("test", given.test))
        for event, case in zip(asked, getattr(given.world, split), strict=True)
    }
    wise = msgspec.structs.replace(given, advice=truths)
    foolish = msgspec.structs.replace(given, advice=dict.fromkeys(truths, "comparison"))
    calls = [sum(choice.asked for choice in wakeful(each)) for each in (wise, foolish)]
    assert calls[1] <= calls[0]
    assert calls[1] <= 2


def test_the_calibration_events_are_the_held_back_rows(given: Trial) -> None:
    job = job_of(given, Selector(spec(), TREATMENTS, Pooled(), GATE))
    assert list(job.held_back) == [False] * 268 + [True] * 42  # type: ignore[call-overload]
    assert set(job.advised[:268]) == {-1}  # type: ignore[index]
    assert (job.advised[268:] >= 0).all()  # type: ignore[index]


def test_why_gives_exact_effects_of_the_fields_with_the_pooled_model(given: Trial) -> None:
    selector = Selector(spec(), TREATMENTS, Pooled(), GATE)
    card, weights = Pooled().train(job_of(given, selector))
    selector.use(card, weights)
    predictor = selector.predictor
    assert predictor is not None
    event = given.test[1]  # unstable at an edge, with people near
    chosen = selector.decide(event, {}, (), card.watermark).treatment
    found = {each.field: each.treatment for each in contributions(selector.encoder, predictor, event, chosen)}
    assert chosen == "risk_prediction"
    assert max(found["state"], found["location"]) > 0.1
    x = selector.encode(event).copy()
    at = list(selector.encoder.groups["state"])
    x[at] = predictor.typical[at]
    place = predictor.treatments.index(chosen)
    effect = selector.encode(event)
    assert found["state"] == pytest.approx(
        float(predictor.estimate(effect).treatments[place] - predictor.estimate(x).treatments[place]), abs=1e-6
    )


def test_without_identities_the_encoder_sees_none() -> None:
    assert "identity" not in spec(identity=False).fields
    assert all("identity" not in event.fields for event in events(world(A, 1), "test", identity=False))
    assert paper_inputs(world(A, 1).test).shape == (82, 29)


def test_a_run_has_every_method_variant_and_metric() -> None:
    done: list[tuple[int, int]] = []
    with Asking("stand-in") as asking:
        runs = run_all([5004], lambda *each: done.append(each), asking, [B])
    assert done == [(1, 82)]
    found = rows(runs)
    assert [(each.method, each.metric) for each in found] == [(method, metric) for method in METHODS for metric in METRICS]
    assert {each.workload for each in found} == {"B"}
    assert all(each.paper_mean is None for each in found)
