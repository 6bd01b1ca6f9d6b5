"""The clairvoyant bound against every schedule of small worlds, and against every policy."""

from __future__ import annotations

from functools import cache
from itertools import combinations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wakeful.experiments.bounds import clairvoyant, most_completions, most_deadlines
from wakeful.experiments.exp2_processing import METHODS, one
from wakeful.experiments.worlds.service_load import FIRST, Arrival, Load, arrivals

HORIZON = 9


def event(step: int, work: int, deadline: int | None = None, evidence: int | None = None) -> Arrival:
    return Arrival(
        step=step,
        kind="k",
        critical=deadline is not None,
        task_relevant=True,
        work=work,
        priority=0,
        deadline_steps=deadline,
        evidence_steps=evidence,
    )


EVENTS = st.builds(
    event,
    step=st.integers(0, 5),
    work=st.integers(2, 3),
    deadline=st.none() | st.integers(2, 5),
    evidence=st.none() | st.integers(2, 4),
)


def ends(world: tuple[Arrival, ...]) -> set[tuple[int | None, ...]]:
    """Every outcome that any schedule has: the step in which each event was completed, or None."""

    @cache
    def after(step: int, done: tuple[tuple[int, int], ...]) -> frozenset[tuple[int | None, ...]]:
        # done: (units, first step) of each event
        if step == HORIZON:
            return frozenset({tuple(None for _ in world)})
        found = set(after(step + 1, done))
        for place, arrival in enumerate(world):
            units, first = done[place]
            if arrival.step > step or units == arrival.work:
                continue
            last = units == arrival.work - 1
            if last and arrival.evidence_steps is not None and step < first + arrival.evidence_steps:
                continue
            begun = step if units == 0 else first
            for rest in after(step + 1, (*done[:place], (units + 1, begun), *done[place + 1 :])):
                found.add((*rest[:place], step, *rest[place + 1 :]) if last else rest)
        return frozenset(found)

    return set(after(0, tuple((0, 0) for _ in world)))


def in_time(world: tuple[Arrival, ...], ended: tuple[int | None, ...]) -> int:
    return sum(
        end is not None and each.deadline_steps is not None and end <= each.step + each.deadline_steps
        for each, end in zip(world, ended, strict=True)
    )


@settings(max_examples=60, deadline=None)
@given(st.lists(EVENTS, min_size=1, max_size=3).map(tuple))
def test_the_bound_on_deadlines_is_what_the_best_of_all_schedules_meets(world: tuple[Arrival, ...]) -> None:
    assert most_deadlines(world, HORIZON) == max(in_time(world, ended) for ended in ends(world))


@settings(max_examples=60, deadline=None)
@given(st.lists(EVENTS, min_size=1, max_size=3).map(tuple))
def test_no_schedule_without_a_miss_completes_more_than_the_bound(world: tuple[Arrival, ...]) -> None:
    critical = [place for place, each in enumerate(world) if each.critical]
    unmissed = [ended for ended in ends(world) if all(ended[place] is not None for place in critical)]
    if unmissed:
        assert most_completions(world, HORIZON) >= max(sum(end is not None for end in ended) for ended in unmissed)


@given(st.lists(st.builds(event, step=st.integers(0, 8), work=st.integers(2, 6)), min_size=1, max_size=7).map(tuple))
def test_without_deadlines_and_evidence_the_bound_on_completions_is_the_largest_set_that_fits(world: tuple[Arrival, ...]) -> None:
    def fits(chosen: tuple[Arrival, ...]) -> bool:
        return all(sum(each.work for each in chosen if each.step >= step) <= 12 - step for step in {each.step for each in chosen})

    best = max(size for size in range(len(world) + 1) for chosen in combinations(world, size) if fits(chosen))
    assert most_completions(world, 12) == best


def test_a_deadline_before_the_evidence_can_be_met_by_nobody() -> None:
    assert most_deadlines([event(0, 3, deadline=7, evidence=8)], 20) == 0
    assert most_deadlines([event(0, 3, deadline=8, evidence=8)], 20) == 1


def test_starting_two_that_wait_before_working_on_either_meets_both_deadlines() -> None:
    assert most_deadlines([event(0, 3, deadline=9, evidence=8), event(0, 3, deadline=9, evidence=8)], 20) == 2
    assert most_deadlines([event(0, 3, deadline=8, evidence=8), event(0, 3, deadline=8, evidence=8)], 20) == 1


@pytest.mark.parametrize("load", FIRST.loads[2:], ids=lambda load: load.name)
def test_no_policy_meets_more_deadlines_and_none_without_a_miss_completes_more(load: Load) -> None:
    for seed in (1000, 1001):
        bound = clairvoyant(arrivals(load, FIRST, seed))
        for method in METHODS:
            measured = one(method, load, FIRST, seed)
            assert measured.critical_deadline is not None
            assert measured.completion is not None
            assert measured.critical_deadline <= 100.0 * bound.deadlines / bound.critical + 1e-9
            if measured.critical_miss == 0.0:
                assert measured.completion <= 100.0 * bound.completions / bound.events + 1e-9


def test_criticals_that_no_schedule_can_complete_are_counted_as_missed() -> None:
    crowd = [
        Arrival(step=18, kind="k", work=4, critical=True, deadline_steps=9, task_relevant=False, priority=3) for _ in range(3)
    ]
    assert clairvoyant(crowd, horizon=22).criticals == 1
    assert clairvoyant(crowd, horizon=60).criticals == 3
