"""A flag rises or falls, a category changes."""

from __future__ import annotations

import pytest

from tests.registration.watching import detector, founds
from wakeful.contracts.domain import DomainError
from wakeful.facts.events import Phase
from wakeful.facts.values import Value


def test_a_flag_rises_and_falls_and_a_blank_is_neither() -> None:
    values: list[Value] = [False, True, None, True, False, "", True]
    assert [index for index, _ in founds(detector("edge", on="rising"), values)] == [1, 6]
    assert [index for index, _ in founds(detector("edge", on="falling"), values)] == [4]
    assert [index for index, _ in founds(detector("edge", on="change"), values)] == [1, 4, 6]


def test_a_lasting_flag_is_raised_and_cleared() -> None:
    found = founds(detector("edge", on="rising", lasting=True), [False, True, True, False])
    assert [item.phase for _, item in found] == [Phase.RAISED, Phase.CLEARED]
    assert founds(detector("edge", on="rising", lasting=True, first=True), [True])[0][1].phase is Phase.RAISED


def test_a_lasting_category_changes_its_condition() -> None:
    found = founds(detector("edge", lasting=True), ["", "STOPPED", "STOPPED", "ESTOP"])
    assert [(item.fields["value"], item.phase) for _, item in found] == [("ESTOP", Phase.CHANGED)]


def test_a_category_says_what_it_was_and_for_how_long() -> None:
    ((_, found),) = founds(detector("edge"), ["AUTO", "AUTO", "AUTO", "MANUAL"])
    assert found.fields == {"channel": "t/x", "value": "MANUAL", "was": "AUTO", "lasted_s": 3.0}


def test_only_the_values_that_were_asked_for() -> None:
    assert [item.fields["value"] for _, item in founds(detector("edge", only=["FAULT"]), ["A", "FAULT", "B", "FAULT"])] == [
        "FAULT"
    ] * 2


def test_an_edge_of_no_known_kind_is_refused() -> None:
    with pytest.raises(DomainError, match=r"Invalid enum value 'up' - at `\$\.on`; it knows on, first"):
        detector("edge", on="up")


def test_a_long_time_is_written_out() -> None:
    ((_, found),) = founds(detector("edge"), ["AUTO"] * 18_812 + ["MANUAL"])
    assert "after 18800 s" in found.says
