"""Deadline-aware: deadlines that can be met, late criticals, then as many as possible, and nobody starves."""

from __future__ import annotations

from random import Random

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.scheduling.policies.views import seen
from wakeful.facts.processes import ProcessView
from wakeful.facts.time import NS_PER_S, to_ns
from wakeful.scheduling.policies.deadline_aware import DeadlineAware, DeadlineAwareSettings
from wakeful.testing import check_policy


def taught(settings: DeadlineAwareSettings | None = None, step_s: float = 1.0) -> DeadlineAware:
    """A policy that has seen one process take four steps of a second, without a wait."""
    policy = DeadlineAware(settings)
    view = msgspec.structs.replace(seen(9999, left=0, done=4), spent_ns=to_ns(4 * step_s), steps_needed=None)
    policy.runnable(view, 0)
    policy.completed(view, 0)
    policy.gone(9999, 0)
    return policy


def told(policy: DeadlineAware, *views: ProcessView, now_s: float = 1.0) -> DeadlineAware:
    for view in views:
        policy.runnable(view, to_ns(now_s))
    return policy


def order(policy: DeadlineAware, now_s: float = 1.0, many: int = 10) -> tuple[int, ...]:
    return policy.pick((), many, to_ns(now_s)).run


def first(policy: DeadlineAware, now_s: float = 1.0) -> int:
    return policy.pick((), 1, to_ns(now_s)).run[0]


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("slots", [1, 2, 3])
def test_it_keeps_the_contract(seed: int, slots: int) -> None:
    assert check_policy(DeadlineAware, seed=seed, slots=slots) == 40


def test_a_critical_process_goes_before_every_other() -> None:
    policy = told(taught(), seen(1, left=1), seen(2, left=6, critical=True), seen(3, left=2, criticality=2))
    assert first(policy) == 2


def test_deadlines_that_can_be_met_go_before_late_ones_whoever_came_first() -> None:
    late = seen(1, left=5, critical=True, deadline_s=4)
    possible = seen(2, at_s=1, left=3, critical=True, deadline_s=9)
    assert order(told(taught(), late, possible), many=1) == (2,)


def test_the_earliest_deadline_goes_first_among_those_that_fit() -> None:
    policy = told(taught(), seen(1, left=3, critical=True, deadline_s=20), seen(2, left=3, critical=True, deadline_s=7))
    assert first(policy) == 2


def test_of_those_that_do_not_fit_together_the_longest_gives_way() -> None:
    # By second 7 six steps fit: 4 + 2 do, 4 + 2 + 3 don't, and without the longest 2 + 3 do.
    policy = told(
        taught(),
        seen(1, left=4, critical=True, deadline_s=6),
        seen(2, left=2, critical=True, deadline_s=7),
        seen(3, left=3, critical=True, deadline_s=7),
    )
    assert first(policy) == 2
    policy.gone(3, NS_PER_S)
    assert first(policy) == 1


def test_one_that_will_wait_begins_at_once_while_the_others_can_spare_a_step() -> None:
    waits = seen(2, left=3, critical=True, deadline_s=13, waits=True)
    spare = told(taught(), seen(1, left=3, critical=True, deadline_s=5), waits)
    assert first(spare) == 2
    tight = told(taught(), seen(1, left=4, critical=True, deadline_s=5), waits)
    assert first(tight) == 1


def test_one_that_has_begun_and_waits_for_what_may_come_too_late_gives_way_to_what_is_sure() -> None:
    sure = seen(1, left=4, critical=True, deadline_s=8)
    doubtful = seen(2, left=4, done=1, critical=True, deadline_s=6, waits=True, started_s=0)
    assert first(told(taught(), sure, doubtful)) == 1


def test_late_criticals_go_first_come_first_served_before_everything_else() -> None:
    policy = told(
        taught(),
        seen(3, at_s=0.5, left=1, critical=True, deadline_s=1.2),
        seen(1, at_s=0.2, left=6, critical=True, deadline_s=2),
        seen(2, left=1),
    )
    assert order(policy) == (1, 3, 2)


def test_the_rest_goes_by_least_work_left_and_keeps_its_order_of_arrival_otherwise() -> None:
    policy = told(taught(), seen(1, left=5), seen(2, left=2), seen(4, left=3), seen(3, left=3))
    assert order(policy) == (2, 3, 4, 1)


def test_what_has_been_done_counts_for_a_preempted_process() -> None:
    policy = told(taught(), seen(1, left=2, done=4), seen(2, left=3))
    assert first(policy) == 1


def test_other_deadlines_that_can_be_met_go_before_the_rest() -> None:
    policy = told(taught(), seen(1, left=1), seen(2, left=4, criticality=2, deadline_s=8), seen(3, left=9, deadline_s=3))
    assert order(policy) == (2, 1, 3)


def test_a_level_of_criticality_is_worth_some_steps_of_work() -> None:
    policy = told(taught(), seen(1, left=3), seen(2, left=6, criticality=1), seen(3, left=8, criticality=1))
    assert order(policy) == (2, 1, 3)


def test_the_wait_of_a_routine_process_is_begun_early_only_while_little_is_ready() -> None:
    policy = taught()
    waiter = seen(50, left=4, waits=True)
    policy.runnable(waiter, 0)
    policy.waiting(seen(50, left=1, done=3, started_s=0, waits=True), 3 * NS_PER_S)
    policy.runnable(seen(50, left=1, done=3, started_s=0, waits=True), 10 * NS_PER_S)  # it waited ten seconds from its start
    policy.gone(50, 11 * NS_PER_S)
    told(policy, seen(1, at_s=12, left=2), seen(2, at_s=12, left=6, waits=True), now_s=12)
    assert first(policy, 12) == 2
    told(policy, *(seen(number, at_s=12, left=2) for number in range(3, 9)), now_s=12)
    assert first(policy, 12) == 1


def test_with_several_slots_it_takes_as_many_in_order_and_each_once() -> None:
    policy = told(
        taught(),
        seen(1, left=2, critical=True, deadline_s=9),
        seen(2, left=2, critical=True, deadline_s=5, waits=True),
        seen(3, left=1),
        seen(4, left=3, critical=True),
    )
    assert order(policy, many=3) == (2, 1, 4)


def test_what_waits_or_is_gone_is_not_picked_and_comes_back_when_it_is_woken() -> None:
    policy = told(taught(), seen(1, left=2), seen(2, left=1))
    policy.waiting(seen(2, left=1, due_s=50), NS_PER_S)
    assert order(policy) == (1,)
    policy.gone(1, NS_PER_S)
    assert order(policy) == ()
    policy.runnable(seen(2, left=1), 2 * NS_PER_S)
    assert order(policy, 2) == (2,)


def test_what_takes_long_is_learned_by_kind_from_those_that_were_completed() -> None:
    policy = DeadlineAware()
    for number, (kind, steps) in enumerate((("long", 6), ("short", 2), ("long", 6), ("short", 2))):
        view = seen(100 + number, done=steps, kind=kind, waits=None)
        policy.runnable(view, number * NS_PER_S)
        policy.completed(view, number * NS_PER_S)
        policy.gone(view.id, number * NS_PER_S)
    told(policy, seen(1, at_s=8, kind="long", waits=None), seen(2, at_s=9, kind="short", waits=None), now_s=9)
    assert order(policy, 9) == (2, 1)
    told(policy, seen(1, at_s=8, done=5, kind="long", waits=None), now_s=10)
    assert order(policy, 10) == (1, 2)


# --- nobody starves ---


def test_waiting_makes_up_for_work() -> None:
    policy = taught(DeadlineAwareSettings(wait_s_per_step=10))
    told(policy, seen(1, at_s=0, left=6), now_s=0)
    told(policy, seen(2, at_s=49, left=1), now_s=49)
    assert order(policy, 49) == (2, 1)
    told(policy, seen(3, at_s=51, left=1), now_s=51)
    assert order(policy, 51) == (2, 1, 3)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), rate=st.sampled_from([0.2, 0.5, 1.0]), slots=st.integers(1, 2))
def test_a_process_is_overtaken_only_by_criticals_and_by_those_that_came_within_its_bound(
    seed: int, rate: float, slots: int
) -> None:
    """Under overload without end: whoever runs while it is ready came before arrival + (work - 1) × wait_s_per_step."""
    random, wait_s = Random(seed), 5.0
    policy = taught(DeadlineAwareSettings(wait_s_per_step=wait_s))
    open_now: dict[int, ProcessView] = {}
    number = 0
    for second in range(1, 200):
        if random.random() < rate:
            number += 1
            open_now[number] = seen(number, second, left=random.randint(1, 6), critical=random.random() < 0.1)
            policy.runnable(open_now[number], to_ns(second))
        run = policy.pick((), slots, to_ns(second)).run
        for each in (open_now[process] for process in run):
            for other in open_now.values():
                if other.id in run or other.criticality >= 3 or each.criticality >= 3:
                    continue
                left = (other.steps_needed or 0) - other.steps_done
                assert each.arrived_ns <= other.arrived_ns + to_ns(wait_s * (left - 1))
        for process in run:
            view = open_now[process]
            view = msgspec.structs.replace(view, steps_done=view.steps_done + 1)
            if view.steps_done == view.steps_needed:
                del open_now[process]
                policy.gone(process, to_ns(second + 0.9))
            else:
                open_now[process] = view
                policy.runnable(view, to_ns(second + 0.9))


@pytest.mark.parametrize("seed", range(4))
def test_below_capacity_every_process_is_done_within_the_work_that_was_open_and_came_meanwhile(seed: int) -> None:
    """The slot is never left empty while anybody is ready: a busy period ends, and everybody in it is done by then."""
    random, policy = Random(seed), taught()
    left: dict[int, int] = {}
    since: dict[int, int] = {}
    busy_since = 0
    for second in range(1, 600):
        if not left:
            busy_since = second
        if random.random() < 0.25:
            number = second
            left[number], since[number] = random.randint(1, 5), second
            policy.runnable(seen(number, second, left=left[number], critical=random.random() < 0.3), to_ns(second))
        run = policy.pick((), 1, to_ns(second)).run
        assert len(run) == min(1, len(left))
        for process in run:
            left[process] -= 1
            if not left[process]:
                del left[process]
                policy.gone(process, to_ns(second + 0.9))
        assert all(arrived >= busy_since for process, arrived in since.items() if process in left)


# --- its answer depends on what it was told and on the time alone ---


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), untold=st.booleans())
def test_one_that_was_never_asked_before_answers_like_one_that_was_asked_at_every_step(seed: int, untold: bool) -> None:
    random = Random(seed)
    asked, fresh = DeadlineAware(), DeadlineAware()
    open_now: dict[int, ProcessView] = {}
    total: dict[int, int] = {}
    number = 0
    for second in range(1, 80):
        now_ns = to_ns(second)
        if random.random() < 0.4:
            number += 1
            critical = random.random() < 0.4
            total[number] = random.randint(1, 6)
            view = seen(
                number,
                second,
                left=None if untold else total[number],
                critical=critical,
                deadline_s=second + random.randint(3, 14) if critical else None,
                waits=None if untold else random.random() < 0.4,
                kind=str(random.randrange(3)),
            )
            open_now[number] = view
            for policy in (asked, fresh):
                policy.runnable(view, now_ns)
        run = asked.pick((), 1, now_ns).run
        for process in run:
            view = open_now[process]
            view = msgspec.structs.replace(
                view,
                steps_done=view.steps_done + 1,
                started_ns=view.started_ns if view.started_ns is not None else now_ns,
                spent_ns=view.spent_ns + NS_PER_S,
            )
            open_now[process] = view
            for policy in (asked, fresh):
                policy.runnable(view, now_ns + NS_PER_S // 2)
                if view.steps_done == total[process]:
                    policy.completed(view, now_ns + NS_PER_S // 2)
                    policy.gone(process, now_ns + NS_PER_S // 2)
            if view.steps_done == total[process]:
                del open_now[process]
    end_ns = to_ns(80)
    assert asked.pick((), 10, end_ns) == fresh.pick((), 10, end_ns)


def test_a_burst_of_hopeless_deadlines_hides_none_that_can_be_met() -> None:
    hopeless = [seen(n, left=20, critical=True, deadline_s=10) for n in range(1, 41)]
    possible = seen(50, left=5, critical=True, deadline_s=12)
    assert first(told(taught(), *hopeless, possible)) == 50


def test_what_it_gives_away_of_a_waiting_process_brings_it_back_as_it_was() -> None:
    calm, parking = taught(), taught()
    for policy in (calm, parking):
        begun = msgspec.structs.replace(seen(1, left=0, done=2), steps_needed=None)
        policy.runnable(begun, 0)
        policy.waiting(begun, 1)
        if policy is parking:
            known = policy.park(1)
            assert not policy._waiting
            assert not policy._before_wait
            policy.bring_back(1, known)
        ended = msgspec.structs.replace(begun, steps_done=5)
        policy.runnable(begun, 5)
        policy.completed(ended, 9)
        policy.gone(1, 9)
        fresh = msgspec.structs.replace(seen(2, left=0), steps_needed=None)
        told(policy, fresh, seen(3, left=3), now_s=10.0)
    assert calm._history.of(fresh).left_after_wait(2) == parking._history.of(fresh).left_after_wait(2)
    assert calm._history.of(fresh).likely_waits() == parking._history.of(fresh).likely_waits()
    assert order(calm, now_s=11.0) == order(parking, now_s=11.0)
