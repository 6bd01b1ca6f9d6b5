"""Tables as observations."""

from __future__ import annotations

import pytest

from wakeful.bridges.rows import Cells, Unreadable, observations
from wakeful.contracts.bridge import SourceError
from wakeful.facts.events import Observation, Undecodable
from wakeful.facts.time import NS_PER_S


def read(*rows: Cells | Unreadable) -> list[Observation]:
    items = list(observations("table", rows))
    assert all(isinstance(item, Observation) for item in items)
    return [item for item in items if isinstance(item, Observation)]


def test_column_names_lose_their_blanks_and_are_made_unique() -> None:
    (row,) = read(("cycle ", "", "speed", "speed", "driver\npresent"), (1.0, 2, 3, 4, "x"))
    assert dict(row.values) == {"cycle": 1.0, "column_2": 2, "speed": 3, "speed.2": 4, "driver present": "x"}


def test_blank_cells_and_nan_are_none_and_the_row_is_kept() -> None:
    (row,) = read(("a", "b", "c", "d"), ("", "nan", float("inf"), None))
    assert list(row.values.values()) == [None] * 4


def test_more_rows_than_are_looked_ahead_are_all_delivered() -> None:
    assert [row.values["n"] for row in read(("n",), *((number,) for number in range(200)))] == list(range(200))


def test_times_are_taken_in_several_manners_from_one_column() -> None:
    rows = read(
        ("Timestamp", "x"), ("1970-01-01T00:00:01Z", 1), ('"1970-01-01T00:00:02.500Z"', 2), ("1970-01-01 00:00:04", 3), (5, 4)
    )
    assert [row.at_ns / NS_PER_S for row in rows] == [1, 2.5, 4, 5]
    assert {row.clock for row in rows} == {"source"}


def test_a_row_whose_time_cannot_be_read_is_a_second_after_the_one_before() -> None:
    rows = read(("time", "x"), ("1970-01-01T00:01:00Z", 1), ("soon", 2), ("1970-01-01T00:01:09Z", 3))
    assert [(row.at_ns // NS_PER_S, row.clock) for row in rows] == [(60, "source"), (61, "row"), (69, "source")]


def test_rows_without_a_time_column_are_a_second_apart() -> None:
    rows = read(("period", "class"), (0.1, 1), (0.2, 0))
    assert [(row.at_ns, row.clock) for row in rows] == [(0, "row"), (NS_PER_S, "row")]


def test_a_column_called_time_that_holds_no_instants_is_no_clock() -> None:
    assert read(("time", "x"), ("morning", 1))[0].clock == "row"


def test_a_row_of_the_wrong_width_is_refused_and_the_others_are_kept() -> None:
    items = list(observations("table", [("a", "b"), (1, 2), (1,), (1, 2, 3), (3, 4)]))
    assert [type(item) for item in items] == [Observation, Undecodable, Undecodable, Observation]
    assert isinstance(items[1], Undecodable)
    assert items[1].reason == "a row of 1 cells under a header of 2"
    assert items[1].position == 1


def test_a_cell_of_a_megabyte_is_refused_with_its_length() -> None:
    (item,) = observations("table", [("a",), ("x" * 10_000_000,)])
    assert isinstance(item, Undecodable)
    assert "10,000,000 characters" in item.reason


def test_a_table_without_header_is_one_error() -> None:
    with pytest.raises(SourceError, match="table is empty; the first row must name the columns"):
        list(observations("table", []))
