"""The learned band: robust, forgetting, and said with no more digits than it knows."""

from __future__ import annotations

from random import Random

from hypothesis import given
from hypothesis import strategies as st

from wakeful.registration.learned_band import Band

numbers = st.floats(-1e150, 1e150, allow_nan=False)


def taught(values: list[float], warm_up: int = 60, memory: float = 1000.0) -> Band:
    band = Band()
    for value in values:
        band.learn(value, warm_up, memory)
    return band


def test_it_finds_the_quantiles_of_a_stationary_channel() -> None:
    random = Random(0)
    band = taught([random.gauss(5.0, 2.0) for _ in range(20_000)])
    assert abs(band.middle - 5.0) < 0.3
    assert abs(band.high - (5.0 + 1.645 * 2.0)) < 0.5
    assert abs(band.low - (5.0 - 1.645 * 2.0)) < 0.5
    assert 1.7 < band.score(9.0) < 2.3


def test_outliers_hardly_move_it_however_far_out_they_are() -> None:
    random = Random(0)
    usual = [random.gauss(0.0, 1.0) for _ in range(5000)]
    clean, dirty = taught(usual), taught([1e9 if index % 50 == 0 else value for index, value in enumerate(usual)], warm_up=40)
    assert abs(dirty.middle - clean.middle) < 0.5


def test_a_skewed_channel_is_judged_by_each_side_of_its_own() -> None:
    random = Random(1)
    band = taught([random.expovariate(1.0) for _ in range(5000)])
    assert band.score(-1.0) < -2.0
    assert 0.0 < band.score(2.0) < 2.0


def test_the_usual_has_no_more_digits_than_the_band_is_wide() -> None:
    band = taught([0.00002345 + 0.05 * (index % 3 - 1) for index in range(300)])
    assert band.usual == 0.0


@given(st.lists(numbers, max_size=80), numbers, st.integers(1, 20), st.floats(2.0, 1e6))
def test_whatever_it_is_taught_its_band_is_ordered_and_its_score_a_number(
    values: list[float], value: float, warm_up: int, memory: float
) -> None:
    band = taught(values, warm_up, memory)
    if band.learned:
        assert band.low <= band.middle <= band.high
        assert band.score(value) == band.score(value)
        assert (band.score(value) > 0) == (value > band.middle)
        assert abs(band.usual - band.middle) <= 0.01 * max(band.high - band.low, band.size) + 1e-9 * abs(band.middle)
