"""`wakeful audit` proves or refutes, and says so by its exit code."""

from __future__ import annotations

import json
from pathlib import Path

from tests.cli.conftest import Wakeful, written
from tests.journal.builder import Book
from tests.journal.test_audit import changed, first
from wakeful.facts.lines import Refused


def test_a_sound_journal_passes_with_one_line_per_check(wakeful: Wakeful, journal: Path) -> None:
    result = wakeful("audit", "--journal", journal)
    assert result.exit_code == 0
    lines = result.stdout.splitlines()
    assert [line.split()[1] for line in lines if line.startswith("ok")] == [
        "readable",
        "positions",
        "time",
        "conservation",
        "identities",
        "coverage",
        "abandoned",
        "transitions",
        "results",
        "wake-ups",
        "answers",
        "repeats",
        "gates",
        "verdicts",
        "trust",
        "lineage",
        "weights",
        "whole",
    ]
    assert [line for line in lines if line.startswith("skip")] == [
        "skip    offered               0 checked  it was not counted what was offered when this journal was written"
    ]
    assert "nothing was ignored" in lines[-1]


def test_a_broken_journal_ends_with_one_and_the_first_offending_line(wakeful: Wakeful, book: Book, tmp_path: Path) -> None:
    lines = list(book.lines())
    index = first(lines, Refused)
    path = written(changed(lines, index, reason=""), tmp_path / "broken.db", book.blobs)
    result = wakeful("audit", "--journal", path)
    assert result.exit_code == 1
    assert result.stdout.splitlines()[-1].startswith(f"first offending line: {index + 1} (refused)")


def test_json_has_ok_and_for_each_check_ok_count_and_first_offender(wakeful: Wakeful, book: Book, tmp_path: Path) -> None:
    lines = list(book.lines())
    path = written(changed(lines, first(lines, Refused), reason=""), tmp_path / "broken.db")
    report = json.loads(wakeful("audit", "--journal", path, "--json").stdout)
    assert report["ok"] is False
    conservation = report["checks"]["conservation"]
    assert (conservation["ok"], conservation["count"]) == (False, 1)
    assert conservation["first_offender"]["record"] == "refused"
    assert report["checks"]["time"] == {**report["checks"]["time"], "ok": True, "count": 0, "first_offender": None}
