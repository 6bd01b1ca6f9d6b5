"""`wakeful export` writes a journal's lines."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.conftest import Wakeful
from tests.journal.builder import Book


def test_json_lines_on_standard_output(wakeful: Wakeful, book: Book, journal: Path) -> None:
    rows = [json.loads(line) for line in wakeful("export", "--journal", journal).stdout.splitlines()]
    assert [row["position"] for row in rows] == list(range(1, len(book.written) + 1))
    assert rows[0]["record"]["is"] == "opened"
    assert set(rows[0]) == {"position", "at_ns", "record"}


def test_a_stable_export_leaves_out_the_wall_clock(wakeful: Wakeful, journal: Path, tmp_path: Path) -> None:
    out = tmp_path / "stable.jsonl"
    assert wakeful("export", "--journal", journal, "--stable", "--out", out).exit_code == 0
    text = out.read_text()
    assert "received_ns" not in text
    assert "monotonic_ns" not in text
    assert '"boot"' not in text


def test_parquet_to_a_file(wakeful: Wakeful, book: Book, journal: Path, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    out = tmp_path / "journal.parquet"
    assert wakeful("export", "--journal", journal, "--format", "parquet", "--out", out).exit_code == 0
    assert parquet.read_table(out).num_rows == len(book.written)
