"""Which events were admitted, up to a horizon."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from wakeful.admission.seen import Seen


@given(keep=st.integers(2, 40), count=st.integers(0, 200))
def test_the_newest_half_is_known_and_nothing_beyond_the_horizon(keep: int, count: int) -> None:
    seen = Seen(keep)
    for number in range(count):
        seen.add(str(number))
    known = [number for number in range(count) if str(number) in seen]
    assert known[-(keep // 2) :] == list(range(count))[-(keep // 2) :]
    assert len(known) <= keep
    assert str(count) not in seen
