"""The bounds for a sample of fixed size, against what is known of the binomial distribution."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wakeful.selection.guarantee.bounds import at_most, clopper_pearson, error_free_needed, most


@given(st.integers(0, 60), st.integers(1, 60), st.floats(0.01, 0.99))
def test_the_tail_is_the_sum_of_the_binomial_probabilities(errors: int, cases: int, risk: float) -> None:
    exact = sum(math.comb(cases, k) * risk**k * (1 - risk) ** (cases - k) for k in range(min(errors, cases) + 1))
    assert at_most(errors, cases, risk) == pytest.approx(exact, abs=1e-9)


@given(st.integers(0, 40), st.integers(1, 40), st.floats(0.01, 0.5))
def test_the_upper_bound_is_where_so_few_errors_become_as_improbable_as_delta(errors: int, cases: int, delta: float) -> None:
    bound = clopper_pearson(errors, cases, delta)
    if errors >= cases:
        assert bound == 1.0
    else:
        assert at_most(errors, cases, bound) == pytest.approx(delta, abs=1e-6)
        assert bound > errors / cases


def test_59_cases_without_an_error_are_needed_for_five_percent_and_42_are_too_few() -> None:
    assert error_free_needed(0.05, 0.05) == 59
    assert clopper_pearson(0, 58, 0.05) > 0.05 > clopper_pearson(0, 59, 0.05)
    assert clopper_pearson(0, 42, 0.05) == pytest.approx(0.0688, abs=1e-4)
    assert clopper_pearson(0, 0, 0.05) == 1.0


@given(st.integers(1, 200), st.floats(0.01, 0.9), st.floats(0.01, 0.5))
def test_the_most_that_may_come_is_the_least_number_exceeded_with_probability_delta(
    cases: int, risk: float, delta: float
) -> None:
    number = most(cases, risk, delta)
    assert at_most(number, cases, risk) >= 1 - delta
    assert number == 0 or at_most(number - 1, cases, risk) < 1 - delta
