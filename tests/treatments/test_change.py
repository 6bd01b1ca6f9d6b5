import pytest
from hypothesis import given
from hypothesis import strategies as st

from wakeful.treatments.change import change_point, cliffs_delta, robust_z, spread

numbers = st.lists(st.floats(-1e6, 1e6), max_size=40)


@given(st.floats(-1e6, 1e6), numbers, st.floats(-1e3, 1e3))
def test_a_robust_z_does_not_depend_on_where_zero_is(value: float, others: list[float], shift: float) -> None:
    here = robust_z(value, others)
    if here is not None and spread(others) > 1e-3:
        there = robust_z(value + shift, [other + shift for other in others])
        assert there == pytest.approx(here, rel=1e-3, abs=1e-3)


@given(numbers, numbers)
def test_cliffs_delta_is_antisymmetric_and_bounded(a: list[float], b: list[float]) -> None:
    delta = cliffs_delta(a, b)
    if delta is None:
        assert not a or not b
        return
    assert -1.0 <= delta <= 1.0
    assert cliffs_delta(b, a) == pytest.approx(-delta)


@given(numbers)
def test_a_change_point_always_lies_inside_the_sequence(values: list[float]) -> None:
    shift = change_point(values)
    if shift is not None:
        assert 0 < shift.at < len(values)


def test_one_wild_value_moves_the_robust_z_of_others_little() -> None:
    calm = [1.0, 1.1, 0.9, 1.05, 0.95]
    alone, beside = robust_z(2.0, calm), robust_z(2.0, [*calm, 1000.0])
    assert alone is not None
    assert beside is not None
    assert 0.5 * alone < beside < alone


def test_a_step_is_found_where_it_is_and_noise_has_no_change_point() -> None:
    noise = [0.1, -0.2, 0.15, -0.05, 0.2, -0.1, 0.05, -0.15, 0.0, 0.1]
    assert change_point(noise) is None
    shift = change_point([*noise, *(value + 3.0 for value in noise)])
    assert shift is not None
    assert shift.at == 10
    assert (shift.before, shift.after) == (pytest.approx(0.01), pytest.approx(3.01))


def test_constant_values_have_neither_spread_nor_change() -> None:
    assert robust_z(2.0, [2.0] * 5) == 0.0
    assert robust_z(3.0, [2.0] * 5) is None
    assert change_point([2.0] * 20) is None
