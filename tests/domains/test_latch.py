"""A condition is raised when it held, and cleared when it stayed away."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from wakeful.domains.latch import Latch
from wakeful.facts.events import Phase


def test_a_short_spike_raises_nothing() -> None:
    latch = Latch()
    assert [latch.see(level, at, hold_ns=3) for at, level in enumerate([1, 1, 0, 1, 0, 1, 1])] == [None] * 7


def test_wavering_around_the_limit_stays_one_condition() -> None:
    latch = Latch()
    phases = [latch.see(at % 2, at, hold_ns=0, clear_ns=5) for at in range(1, 40)]
    assert [phase for phase in phases if phase] == [Phase.RAISED]


def test_getting_worse_is_a_change_and_getting_a_little_better_is_not() -> None:
    latch = Latch()
    assert latch.see(1, 0) is Phase.RAISED
    assert latch.see(3, 1) is Phase.CHANGED
    assert latch.see(1, 2) is None
    assert latch.see(0, 3) is Phase.CLEARED


def test_a_clock_that_steps_back_starts_the_wait_anew() -> None:
    latch = Latch()
    latch.see(1, 100, hold_ns=10)
    assert latch.see(1, 50, hold_ns=10) is None
    assert latch.see(1, 60, hold_ns=10) is Phase.RAISED


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 10**6)), max_size=60), st.integers(0, 50), st.integers(0, 50))
def test_raised_and_cleared_alternate_whatever_comes(looks: list[tuple[int, int]], hold_ns: int, clear_ns: int) -> None:
    latch, open_now = Latch(), False
    for level, at_ns in looks:
        phase = latch.see(level, at_ns, hold_ns, clear_ns)
        assert phase is not Phase.RAISED or not open_now
        assert phase not in (Phase.CHANGED, Phase.CLEARED) or open_now
        open_now = phase is not Phase.CLEARED and (open_now or phase is Phase.RAISED)
        assert open_now == (latch.level > 0)
