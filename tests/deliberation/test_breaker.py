"""The circuit breaker, with a clock that the test moves."""

from __future__ import annotations

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from wakeful.deliberation.breaker import Breaker, Circuit, CircuitOpen


class Clock:
    now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def breaker(clock: Clock) -> Breaker:
    return Breaker(failures=3, pause_s=10.0, clock=clock)


def test_failures_in_a_row_open_it_and_a_success_between_starts_anew(breaker: Breaker) -> None:
    for report in (breaker.failed, breaker.failed, breaker.succeeded, breaker.failed, breaker.failed):
        report(breaker.admit())
    assert breaker.circuit is Circuit.CLOSED
    breaker.failed(breaker.admit())
    assert breaker.circuit is Circuit.OPEN
    with pytest.raises(CircuitOpen):
        breaker.admit()


def test_half_open_lets_one_trial_through(breaker: Breaker, clock: Clock) -> None:
    open_it(breaker)
    clock.now_s = 10.0
    assert breaker.circuit is Circuit.HALF_OPEN
    trial = breaker.admit()
    with pytest.raises(CircuitOpen):
        breaker.admit()
    breaker.succeeded(trial)
    assert breaker.circuit is Circuit.CLOSED
    breaker.admit()


def test_a_failed_trial_opens_it_for_another_pause(breaker: Breaker, clock: Clock) -> None:
    open_it(breaker)
    clock.now_s = 10.0
    breaker.failed(breaker.admit())
    clock.now_s = 19.9
    assert breaker.circuit is Circuit.OPEN
    clock.now_s = 20.0
    assert breaker.circuit is Circuit.HALF_OPEN


def test_a_withdrawn_trial_makes_room_for_another(breaker: Breaker, clock: Clock) -> None:
    open_it(breaker)
    clock.now_s = 10.0
    breaker.withdrawn(breaker.admit())
    breaker.succeeded(breaker.admit())
    assert breaker.circuit is Circuit.CLOSED


def test_a_late_report_from_before_it_opened_says_nothing(breaker: Breaker, clock: Clock) -> None:
    late = breaker.admit()
    open_it(breaker)
    breaker.succeeded(late)
    assert breaker.circuit is Circuit.OPEN
    clock.now_s = 10.0
    breaker.failed(late)
    assert breaker.circuit is Circuit.HALF_OPEN


def test_checking_takes_nothing(breaker: Breaker, clock: Clock) -> None:
    open_it(breaker)
    clock.now_s = 10.0
    breaker.check()
    breaker.check()
    breaker.admit()
    with pytest.raises(CircuitOpen):
        breaker.check()


def open_it(breaker: Breaker) -> None:
    tickets = [breaker.admit() for _ in range(3)]
    for ticket in tickets:
        breaker.failed(ticket)
    assert breaker.circuit is Circuit.OPEN


class AnyOrder(RuleBasedStateMachine):
    """Whatever the order of calls and reports, an open circuit lets nothing through and a half-open one at most one."""

    def __init__(self) -> None:
        super().__init__()
        self.clock = Clock()
        self.breaker = Breaker(2, 10.0, self.clock)
        self.under_way: list[tuple[int, Circuit]] = []

    @rule()
    def call(self) -> None:
        circuit = self.breaker.circuit
        try:
            self.under_way.append((self.breaker.admit(), circuit))
        except CircuitOpen:
            assert circuit is not Circuit.CLOSED
        else:
            assert circuit is not Circuit.OPEN

    @precondition(lambda self: self.under_way)
    @rule(which=st.integers(0, 9), how=st.sampled_from(["succeeded", "failed", "withdrawn"]))
    def end(self, which: int, how: str) -> None:
        ticket, _ = self.under_way.pop(which % len(self.under_way))
        getattr(self.breaker, how)(ticket)

    @rule(seconds=st.floats(0, 15))
    def wait(self, seconds: float) -> None:
        self.clock.now_s += seconds

    @invariant()
    def one_trial_at_most(self) -> None:
        if self.breaker.circuit is Circuit.HALF_OPEN:
            newest = max((ticket for ticket, _ in self.under_way), default=-1)
            trials = [one for one in self.under_way if one == (newest, Circuit.HALF_OPEN)]
            assert len(trials) <= 1


TestAnyOrder = AnyOrder.TestCase
