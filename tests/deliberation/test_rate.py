"""The rate limit: a sliding minute."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wakeful.deliberation.rate import RateLimit, TooOften


def test_the_limit_frees_a_minute_after_each_call() -> None:
    now_s = [0.0]
    limit = RateLimit(2, lambda: now_s[0])
    assert limit.reserve(0.0) == 0.0
    now_s[0] = 30.0
    assert limit.reserve(0.0) == 0.0
    with pytest.raises(TooOften, match=r"in 30\.0 s"):
        limit.reserve(29.0)
    assert limit.reserve(30.0) == 30.0
    now_s[0] = 90.0
    assert limit.reserve(0.0) == 0.0


def test_a_refused_reservation_takes_no_place() -> None:
    now_s = [0.0]
    limit = RateLimit(1, lambda: now_s[0])
    limit.reserve(0.0)
    for _ in range(5):
        with pytest.raises(TooOften):
            limit.reserve(1.0)
    now_s[0] = 60.0
    assert limit.reserve(0.0) == 0.0


def test_no_limit_never_waits() -> None:
    limit = RateLimit(None, lambda: 0.0)
    assert {limit.reserve(0.0) for _ in range(1000)} == {0.0}


def test_a_limit_of_nothing_is_a_mistake() -> None:
    with pytest.raises(ValueError, match="at least one"):
        RateLimit(0, lambda: 0.0)


@given(st.integers(1, 5), st.lists(st.tuples(st.floats(0, 40), st.floats(0, 100)), max_size=80))
def test_no_minute_holds_more_calls_than_allowed(per_minute: int, steps: list[tuple[float, float]]) -> None:
    now_s = [0.0]
    limit = RateLimit(per_minute, lambda: now_s[0])
    called: list[float] = []
    for forward_s, patience_s in steps:
        now_s[0] += forward_s
        try:
            called.append(now_s[0] + limit.reserve(patience_s))
        except TooOften:
            continue
    for start_s in called:
        assert sum(1 for at in called if start_s <= at < start_s + 60.0 - 1e-6) <= per_minute
