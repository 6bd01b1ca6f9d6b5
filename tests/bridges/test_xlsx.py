"""Spreadsheets and CSV files."""

from __future__ import annotations

import tracemalloc
from itertools import pairwise
from pathlib import Path

import pytest

from tests.bridges.recordings import csv, sheet
from wakeful.bridges.xlsx import XlsxBridge
from wakeful.contracts.bridge import SourceError
from wakeful.facts.events import Observation, Undecodable


def test_a_sheet_is_read_with_its_columns_times_and_blanks(tmp_path: Path) -> None:
    rows = [item for item in XlsxBridge().read(sheet(tmp_path / "a.xlsx")) if isinstance(item, Observation)]
    assert len(rows) == 20
    assert rows[4].values["Current_J0"] is None
    assert [row.position for row in rows if row.values["stopped"]] == [7]
    assert rows[0].values["cycle"] == 1.0
    assert {later.at_ns - earlier.at_ns for earlier, later in pairwise(rows)} == {1_000_000_000}


def test_a_sheets_length_and_duration_are_known_beforehand(tmp_path: Path) -> None:
    peek = XlsxBridge().peek(sheet(tmp_path / "a.xlsx", rows=30))
    assert peek.items == 30
    assert peek.duration_s == pytest.approx(30, rel=0.1)
    assert "row/cycle" in peek.channels


def test_a_csv_with_semicolons_tabs_or_another_code_page_is_read(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes("\ufeffname;value\nZürich;1\n".encode())
    (tmp_path / "b.csv").write_bytes(b"name\tvalue\nZ\xfcrich\t1\n")
    for name in ("a.csv", "b.csv"):
        (row,) = XlsxBridge().read(tmp_path / name)
        assert isinstance(row, Observation)
        assert row.values == {"name": "Zürich", "value": 1}


def test_a_csv_without_its_last_line_end_loses_nothing(tmp_path: Path) -> None:
    path = csv(tmp_path / "a.csv")
    path.write_bytes(path.read_bytes().rstrip(b"\n"))
    assert len(list(XlsxBridge().read(path))) == 20


def test_a_truncated_csv_loses_only_its_tail(tmp_path: Path) -> None:
    path = csv(tmp_path / "a.csv")
    path.write_bytes(path.read_bytes()[:-24])
    items = list(XlsxBridge().read(path))
    assert len(items) == 20
    assert [type(item) for item in items[-2:]] == [Observation, Undecodable]


def test_a_line_of_ten_megabytes_is_refused_within_bounded_memory(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"a,b\n1,2\n{'x' * 10_000_000},3\n4,5\n")
    tracemalloc.start()
    items = list(XlsxBridge().read(path))
    _, peak_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert [type(item) for item in items] == [Observation, Undecodable, Observation]
    assert isinstance(items[1], Undecodable)
    assert "10,000,003 bytes" in items[1].reason
    assert peak_bytes < 6_000_000


def test_a_field_beyond_the_readers_limit_is_refused_and_the_next_row_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"a,b\n{'x' * 200_000},3\n4,5\n")
    assert [type(item) for item in XlsxBridge().read(path)] == [Undecodable, Observation]


def test_binary_data_called_csv_is_one_error(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(bytes(range(256)))
    with pytest.raises(SourceError, match=r"a\.csv holds binary data"):
        list(XlsxBridge().read(tmp_path / "a.csv"))


def test_a_truncated_workbook_is_one_error(tmp_path: Path) -> None:
    path = sheet(tmp_path / "a.xlsx")
    path.write_bytes(path.read_bytes()[:700])
    with pytest.raises(SourceError, match=r"a\.xlsx is not a spreadsheet that can be read"):
        list(XlsxBridge().read(path))


def test_the_recorded_arm_is_read_row_by_row(shared_data: Path) -> None:
    rows = [item for item in XlsxBridge().read(shared_data / "ur3_cobotops" / "dataset.xlsx") if isinstance(item, Observation)]
    assert len(rows) == 7409
    assert sum(row.values["Robot_ProtectiveStop"] is True for row in rows) == 278
    assert sum(row.values["grip_lost"] is True for row in rows) == 243
    assert sum(row.values["Robot_ProtectiveStop"] is None for row in rows) == 54
    assert all(row.clock == "source" for row in rows)
    assert all(later.at_ns > earlier.at_ns for earlier, later in pairwise(rows))
