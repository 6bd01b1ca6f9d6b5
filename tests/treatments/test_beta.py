from math import comb

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wakeful.treatments.beta import Belief, distribution, quantile

counts = st.floats(0.05, 200.0)


@given(st.integers(1, 12), st.integers(1, 12), st.floats(0.01, 0.99))
def test_the_distribution_is_the_binomial_tail_where_both_counts_are_whole(a: int, b: int, x: float) -> None:
    n = a + b - 1
    tail = sum(comb(n, k) * x**k * (1 - x) ** (n - k) for k in range(a, n + 1))
    assert distribution(x, a, b) == pytest.approx(tail, abs=1e-10)


@given(st.floats(0.01, 0.99), counts, counts)
def test_the_quantile_undoes_the_distribution(p: float, a: float, b: float) -> None:
    x = quantile(p, a, b)
    assert 0.0 <= x <= 1.0
    if 1e-6 < x < 1 - 1e-6:
        assert distribution(x, a, b) == pytest.approx(p, abs=1e-5)


@given(st.floats(-1.0, 2.0), counts, counts)
def test_the_distribution_stays_between_nought_and_one(x: float, a: float, b: float) -> None:
    assert 0.0 <= distribution(x, a, b) <= 1.0


@given(st.floats(0.0, 1.0), st.floats(0.5, 20.0), st.floats(0.0, 50.0), st.floats(0.0, 50.0))
def test_the_mean_lies_in_its_interval_unless_almost_everything_is_at_one_end(
    probability: float, strength: float, hits: float, misses: float
) -> None:
    belief = Belief.of(probability, strength).after(hits, misses)
    low, high = belief.interval(0.98)
    assert 0.0 <= low <= high <= 1.0
    if min(belief.hits, belief.misses) > 1.0:
        assert low < belief.mean < high


def test_the_promised_number_of_cases_about_halves_the_interval() -> None:
    belief = Belief.of(0.3, 4.0).after(3.0, 5.0)
    low, high = belief.interval()
    more = belief.cases_to_halve()
    narrow_low, narrow_high = belief.after(belief.mean * more, (1.0 - belief.mean) * more).interval()
    assert (narrow_high - narrow_low) / (high - low) == pytest.approx(0.5, abs=0.05)
