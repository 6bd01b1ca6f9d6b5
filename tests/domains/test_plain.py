"""Only plain values get through."""

from __future__ import annotations

import math

from hypothesis import given

from tests.domains.watching import anything
from wakeful.domains.plain import flag, number, series, text, whole


@given(anything())
def test_whatever_a_value_is_the_answer_is_finite_or_none(value: object) -> None:
    values = {"x": value}
    found = number(values, "x")  # type: ignore[arg-type]
    assert found is None or math.isfinite(found)
    bits = whole(values, "x")  # type: ignore[arg-type]
    assert bits is None or -(2**63) <= bits < 2**63
    assert flag(values, "x") in (True, False, None)  # type: ignore[arg-type]
    assert text(values, "x").isprintable()  # type: ignore[arg-type]
    assert all(one is None or math.isfinite(one) for one in series(values, "x"))  # type: ignore[arg-type]


def test_a_bit_mask_keeps_every_bit() -> None:
    mask = 2**62 + 1
    assert whole({"x": mask}, "x") == mask


def test_a_number_in_words_is_no_number() -> None:
    assert number({"x": "12"}, "x") is None
