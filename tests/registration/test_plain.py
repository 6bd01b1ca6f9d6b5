"""Values nobody vouches for."""

from __future__ import annotations

import msgspec
from hypothesis import given
from hypothesis import strategies as st

from wakeful.facts.values import Value
from wakeful.registration.plain import elapsed_s, field, number, scalar

anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=3), inner, max_size=4),
    max_leaves=8,
)


@given(anything)
def test_whatever_a_value_is_a_field_can_be_written_down_and_read_back(value: Value) -> None:
    kept = field(value)
    assert msgspec.json.decode(msgspec.json.encode(kept)) == (list(kept) if isinstance(kept, tuple) else kept)
    assert scalar(value) is None or isinstance(scalar(value), bool | int | float | str)
    assert number(value) is None or isinstance(number(value), float)


def test_a_long_or_broken_text_is_cut_and_mended() -> None:
    kept = field("x\ud800" + "y" * 10_000_000)
    assert isinstance(kept, str)
    assert kept.startswith("x?y")
    assert len(kept) == 200


def test_a_clock_a_little_out_of_order_has_not_moved_and_one_set_back_begins_anew() -> None:
    assert elapsed_s(0, 1_000_000_000) == 0.0
    assert elapsed_s(0, 61_000_000_000) == float("inf")
