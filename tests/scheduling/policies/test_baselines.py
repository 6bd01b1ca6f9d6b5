"""The paper's policies: what each is defined by (Sec. IV-A)."""

from __future__ import annotations

import pytest

from tests.scheduling.policies.views import seen
from wakeful.contracts.policy import Pick
from wakeful.facts.time import NS_PER_S
from wakeful.scheduling.policies.reactive_priority import ReactivePriority
from wakeful.scheduling.policies.sequential import Sequential
from wakeful.scheduling.policies.suspend_resume import SuspendResume
from wakeful.scheduling.policies.task_bounded import TaskBounded


@pytest.mark.parametrize("make", [Sequential, TaskBounded])
def test_sequential_policies_serve_the_first_that_came_and_wait_with_it(make: type[Sequential]) -> None:
    policy = make()
    policy.runnable(seen(1, at_s=0), 0)
    policy.runnable(seen(2, at_s=1, critical=True, priority=5), 0)
    assert policy.pick((), 1, 0) == Pick((1,))
    policy.waiting(seen(1, at_s=0, due_s=9), NS_PER_S)
    assert policy.pick((), 1, NS_PER_S) == Pick(())
    policy.runnable(seen(1, at_s=0), 2 * NS_PER_S)
    assert policy.pick((), 1, 2 * NS_PER_S) == Pick((1,))
    policy.gone(1, 3 * NS_PER_S)
    assert policy.pick((), 1, 3 * NS_PER_S) == Pick((2,))


def test_task_bounded_never_serves_what_is_outside_the_task() -> None:
    policy = TaskBounded()
    policy.runnable(seen(1, critical=True, relevant=False), 0)
    assert policy.pick((), 1, 0) == Pick(())
    policy.runnable(seen(2, at_s=1), NS_PER_S)
    assert policy.pick((), 1, NS_PER_S) == Pick((2,))
    policy.waiting(seen(1, critical=True, relevant=False, due_s=5), NS_PER_S)
    policy.gone(1, NS_PER_S)
    assert policy.pick((2,), 1, NS_PER_S) == Pick((2,))


def test_reactive_priority_drops_what_a_strictly_higher_priority_interrupts() -> None:
    policy = ReactivePriority()
    policy.runnable(seen(1, priority=2), 0)
    assert policy.pick((), 1, 0) == Pick((1,))
    policy.runnable(seen(2, at_s=1, priority=2), NS_PER_S)
    assert policy.pick((1,), 1, NS_PER_S) == Pick((1,))
    policy.runnable(seen(3, at_s=1, priority=3), NS_PER_S)
    assert policy.pick((1,), 1, NS_PER_S) == Pick((3,), abandon=(1,))
    policy.gone(1, NS_PER_S)
    assert policy.pick((), 1, NS_PER_S) == Pick((3,))


def test_reactive_priority_drops_what_waits_as_soon_as_anything_else_is_open() -> None:
    policy = ReactivePriority()
    policy.runnable(seen(1, priority=5), 0)
    assert policy.pick((), 1, 0) == Pick((1,))
    policy.waiting(seen(1, priority=5, due_s=9), NS_PER_S)
    assert policy.pick((), 1, NS_PER_S) == Pick(())
    policy.runnable(seen(2, at_s=1, priority=0), NS_PER_S)
    assert policy.pick((), 1, NS_PER_S) == Pick((2,), abandon=(1,))


def test_reactive_priority_goes_on_with_what_waited_if_nobody_came() -> None:
    policy = ReactivePriority()
    policy.runnable(seen(1), 0)
    policy.pick((), 1, 0)
    policy.waiting(seen(1, due_s=9), NS_PER_S)
    policy.runnable(seen(1), 2 * NS_PER_S)
    assert policy.pick((), 1, 2 * NS_PER_S) == Pick((1,))


def test_suspend_resume_takes_the_highest_priority_and_drops_nothing() -> None:
    policy = SuspendResume()
    policy.runnable(seen(1, priority=1), 0)
    policy.runnable(seen(2, at_s=1, priority=1), 0)
    policy.runnable(seen(3, at_s=2, critical=True, priority=2), 0)
    policy.runnable(seen(4, at_s=3, critical=True, priority=5), 0)
    assert policy.pick((1,), 3, 0) == Pick((4, 3, 1))
    policy.waiting(seen(4, at_s=3, critical=True, priority=5, due_s=9), NS_PER_S)
    assert policy.pick((4,), 1, NS_PER_S) == Pick((3,))
    policy.runnable(seen(4, at_s=3, critical=True, priority=5), 2 * NS_PER_S)
    assert policy.pick((3,), 1, 2 * NS_PER_S) == Pick((4,))
    policy.gone(4, 3 * NS_PER_S)
    policy.gone(3, 3 * NS_PER_S)
    assert policy.pick((), 2, 3 * NS_PER_S) == Pick((1, 2))


def test_suspend_resume_does_not_pick_twice_what_was_woken_often() -> None:
    policy = SuspendResume()
    policy.runnable(seen(2, at_s=1), 0)
    for second in range(5):
        policy.runnable(seen(1), second * NS_PER_S)
        policy.waiting(seen(1, due_s=99), second * NS_PER_S)
    policy.runnable(seen(1), 9 * NS_PER_S)
    assert policy.pick((), 2, 9 * NS_PER_S) == Pick((1, 2))
