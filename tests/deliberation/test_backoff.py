"""Backoff and Retry-After."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wakeful.deliberation.backoff import Backoff, retry_after_s


def test_waits_double_within_their_jitter_up_to_the_limit() -> None:
    backoff = Backoff(1.0, 8.0, seed=1)
    for failures, full_s in [(0, 1.0), (1, 2.0), (2, 4.0), (3, 8.0), (4, 8.0), (5000, 8.0)]:
        assert full_s / 2 <= backoff.wait_s(failures) <= full_s


def test_the_same_seed_waits_alike_and_another_does_not() -> None:
    waits = [[Backoff(1.0, 8.0, seed).wait_s(n) for n in range(5)] for seed in (1, 1, 2)]
    assert waits[0] == waits[1] != waits[2]


def test_the_endpoint_may_ask_for_more_and_never_for_less() -> None:
    backoff = Backoff(1.0, 8.0, seed=1)
    assert backoff.wait_s(0, retry_after_s=60.0) == 60.0
    assert backoff.wait_s(3, retry_after_s=0.001) >= 4.0


@pytest.mark.parametrize(
    ("headers", "seconds"),
    [
        ({}, 0.0),
        ({"retry-after": "3"}, 3.0),
        ({"retry-after": "0.5"}, 0.5),
        ({"retry-after": "-3"}, 0.0),
        ({"retry-after": "nan"}, 0.0),
        ({"retry-after": "inf"}, 0.0),
        ({"retry-after": "soon"}, 0.0),
        ({"retry-after": "Fri, 31 Dec 1999 23:59:59 GMT", "date": "Fri, 31 Dec 1999 23:59:29 GMT"}, 30.0),
        ({"retry-after": "Fri, 31 Dec 1999 23:59:59 GMT", "date": "Fri, 31 Dec 1999 23:59:59 GMT"}, 0.0),
        ({"retry-after": "Fri, 31 Dec 1999 23:59:59 GMT"}, 0.0),
    ],
)
def test_retry_after_is_read_as_seconds_or_as_a_date(headers: dict[str, str], seconds: float) -> None:
    assert retry_after_s(headers) == seconds


@given(st.text(), st.text())
def test_no_header_makes_it_raise_or_wait_backwards(asked: str, date: str) -> None:
    assert retry_after_s({"retry-after": asked, "date": date}) >= 0.0
