"""Experiment 2's world: sizes, shares and ranges as declared, the same for the same seed."""

from __future__ import annotations

from statistics import fmean

import pytest

from wakeful.experiments.exp2_processing import SEEDS
from wakeful.experiments.worlds.service_load import FIRST, NOMINAL_STEPS, SECOND, Arrival, Load, Parameters, arrivals

PAPER_EVENTS = {"low": 13.2, "medium": 43.7, "high": 84.8, "bursty_delayed": 54.0}
EACH = [pytest.param(parameters, load, id=parameters.named(load)) for parameters in (FIRST, SECOND) for load in parameters.loads]


def crowd(load: Load, parameters: Parameters, seeds: range) -> list[Arrival]:
    return [arrival for seed in seeds for arrival in arrivals(load, parameters, seed)]


@pytest.mark.parametrize(("parameters", "load"), EACH)
def test_the_ten_seeds_have_as_many_events_as_the_papers_within_3_percent(parameters: Parameters, load: Load) -> None:
    counted = fmean(len(arrivals(load, parameters, seed)) for seed in SEEDS)
    assert counted == pytest.approx(PAPER_EVENTS[load.name], rel=0.03)


@pytest.mark.parametrize(("parameters", "load"), EACH)
def test_the_ten_worlds_are_typical_in_what_they_contain(parameters: Parameters, load: Load) -> None:
    ten = [arrival for seed in SEEDS for arrival in arrivals(load, parameters, seed)]
    many = crowd(load, parameters, range(5000, 5200))
    rough = 0.2 if load.name == "low" else 0.06  # a low load's ten worlds hold 132 events in all
    for share in ("critical", "task_relevant"):
        ours, all_of_them = fmean(getattr(each, share) for each in ten), fmean(getattr(each, share) for each in many)
        assert ours == pytest.approx(all_of_them, rel=rough), share
    assert fmean(each.work for each in ten) == pytest.approx(fmean(each.work for each in many), rel=0.04)


@pytest.mark.parametrize(("parameters", "load"), EACH)
def test_what_events_are_like_follows_the_declared_parameters(parameters: Parameters, load: Load) -> None:
    events = crowd(load, parameters, range(300))
    assert {each.work for each in events} == set(range(parameters.work[0], parameters.work[1] + 1))
    assert all(0 <= each.step < NOMINAL_STEPS for each in events)
    assert fmean(each.critical for each in events) == pytest.approx(load.critical, abs=0.03)
    assert fmean(each.task_relevant for each in events) == pytest.approx(parameters.task_relevant, abs=0.03)
    for each in events:
        lowest, highest = parameters.critical_priority if each.critical else parameters.routine_priority
        assert lowest <= each.priority <= highest
        assert (each.deadline_steps is not None) is each.critical
    deadlines = {each.deadline_steps for each in events if each.deadline_steps is not None}
    assert (min(deadlines), max(deadlines)) == parameters.deadline_steps
    delays = [each.evidence_steps for each in events if each.evidence_steps is not None]
    assert min(delays) >= parameters.evidence_steps[0]
    assert max(delays) <= parameters.evidence_steps[1]
    plain = [each for each in events if not each.critical and not each.task_relevant]
    assert fmean(each.evidence_steps is not None for each in plain) == pytest.approx(load.delayed, abs=0.05)
    urgent = [each for each in events if each.critical and not each.task_relevant]
    expected = load.delayed * parameters.delayed_if_critical
    assert fmean(each.evidence_steps is not None for each in urgent) == pytest.approx(expected, abs=0.06)


@pytest.mark.parametrize("parameters", [FIRST, SECOND], ids=lambda each: each.name)
def test_a_kind_says_two_adjacent_efforts_and_whether_it_waits(parameters: Parameters) -> None:
    for each in crowd(parameters.loads[2], parameters, range(20)):
        waits, least, most = each.kind.split("_")
        assert int(least) <= each.work <= int(most) == int(least) + 1
        assert (waits == "awaited") is (each.evidence_steps is not None)
        assert parameters.work[0] <= int(least) < int(most) <= parameters.work[1]


def test_the_same_seed_gives_the_same_world_and_another_seed_another() -> None:
    load = FIRST.loads[2]
    assert arrivals(load, FIRST, 7) == arrivals(load, FIRST, 7)
    assert arrivals(load, FIRST, 7) != arrivals(load, FIRST, 8)


def test_both_parameter_sets_meet_as_many_events() -> None:
    for first, second in zip(FIRST.loads, SECOND.loads, strict=True):
        for seed in range(20):
            one, two = arrivals(first, FIRST, seed), arrivals(second, SECOND, seed)
            assert len(one) == len(two)
            if not first.bursts:
                assert [each.step for each in one] == [each.step for each in two]


def test_bursts_stay_in_their_segments_and_are_as_large_as_declared() -> None:
    load = FIRST.loads[3]
    bursts_only = Load(name=load.name, rate=0.0, critical=0.3, delayed=0.9, bursts=6)
    for seed in range(50):
        steps = [each.step for each in arrivals(bursts_only, FIRST, seed)]
        for segment in range(6):
            within = [step for step in steps if segment * NOMINAL_STEPS // 6 <= step < (segment + 1) * NOMINAL_STEPS // 6]
            assert 2 <= len(within) <= 6
            assert max(within) - min(within) < bursts_only.burst_steps
