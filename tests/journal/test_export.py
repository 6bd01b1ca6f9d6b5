"""Exports hold every line, and stable ones nothing that differs from run to run."""

from __future__ import annotations

import io
from pathlib import Path

import msgspec
import pytest
from msgspec.structs import replace

from tests.journal.builder import full_book
from tests.journal.test_audit import Pages, inserted
from wakeful.facts.lines import Admitted, AnyRecord, Line, Noted, Opened
from wakeful.journal.export import exported, write_jsonl, write_parquet


def test_every_line_comes_back_from_json() -> None:
    book = full_book()
    out = io.BytesIO()
    assert write_jsonl(book, out) == len(book.written)
    decoder = msgspec.json.Decoder(Line)
    read = [decoder.decode(line) for line in out.getvalue().splitlines()]
    assert [(line.position, line.at_ns, type(line.record)) for line in read] == [
        (line.position, line.at_ns, type(line.record)) for line in book.written
    ]
    assert msgspec.json.encode(read) == msgspec.json.encode(book.written)


def _stable(lines: list[Line]) -> bytes:
    out = io.BytesIO()
    write_jsonl(Pages(lines), out, stable=True)
    return out.getvalue()


def _interrupted(lines: list[Line]) -> list[Line]:
    """The same run, interrupted once, on another machine at another time."""
    resumed = Opened(source="arm.xlsx", digest="d1", domain="arm", domain_version=1, offset_ns=0, seed=0, resumed_at=3)
    broken = inserted(inserted(lines, 20, resumed), 21, Noted(what="resumption", detail="went on after position 3"))
    return [Line(line.position, line.at_ns, _elsewhere(line.record)) for line in broken]


def _elsewhere(record: AnyRecord) -> AnyRecord:
    if not isinstance(record, Admitted):
        return record
    stamp = replace(record.event.stamp, received_ns=99)
    return Admitted(event=replace(record.event, stamp=stamp))


def test_a_stable_export_of_an_interrupted_run_equals_that_of_an_undisturbed_one() -> None:
    lines = list(full_book().lines())
    assert _stable(_interrupted(lines)) == _stable(lines)
    whole = io.BytesIO()
    write_jsonl(Pages(_interrupted(lines)), whole)
    assert whole.getvalue() != _stable(lines)


def test_a_stable_export_still_shows_another_decision() -> None:
    lines = list(full_book().lines())
    assert _stable(lines[:-1]) != _stable(lines)


def test_positions_of_a_stable_export_have_no_gap() -> None:
    lines = _interrupted(list(full_book().lines()))
    assert [line.position for line in exported(Pages(lines), stable=True)] == list(range(1, len(lines) - 1))


def test_parquet_holds_every_line_with_its_kind_event_and_process(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    book = full_book()
    out = tmp_path / "journal.parquet"
    assert write_parquet(book, out) == len(book.written)
    table = parquet.read_table(out).to_pylist()
    assert [row["position"] for row in table] == [line.position for line in book.written]
    first = next(row for row in table if row["kind"] == "created")
    assert (first["event"], first["process"]) == (book.event_of(1), 1)
