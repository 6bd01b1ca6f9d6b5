"""A user's mistake is one line with a way out, never a traceback."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

import apsw
import pytest

from tests.cli.conftest import Wakeful

READERS = ("status", "events", "processes", "audit", "stats", "trust", "learning", "export")


def _one_line(result: object, code: int, *words: str) -> None:
    assert result.exit_code == code, result.output  # type: ignore[attr-defined]
    assert len(result.stderr.splitlines()) == 1, result.stderr  # type: ignore[attr-defined]
    assert result.stdout == ""  # type: ignore[attr-defined]
    for word in words:
        assert word in result.stderr  # type: ignore[attr-defined]


@pytest.mark.parametrize("command", READERS)
def test_a_journal_that_is_not_there(wakeful: Wakeful, tmp_path: Path, command: str) -> None:
    _one_line(wakeful(command, "--journal", tmp_path / "absent.db"), 1, "there is no journal at", "wakeful run")


@pytest.mark.parametrize("command", READERS)
def test_no_journal_at_all(wakeful: Wakeful, command: str) -> None:
    _one_line(wakeful(command), 1, "there is no journal in", "--journal")


def test_a_file_that_is_no_journal(wakeful: Wakeful, tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("not a database " * 100)
    _one_line(wakeful("audit", "--journal", path), 1, "cannot be opened as a journal")


def test_a_database_that_is_no_journal(wakeful: Wakeful, tmp_path: Path) -> None:
    path = tmp_path / "other.db"
    apsw.Connection(str(path)).execute("CREATE TABLE a(b)")
    _one_line(wakeful("status", "--journal", path), 1, "not a wakeful journal")


def test_a_journal_of_a_newer_wakeful(wakeful: Wakeful, journal: Path) -> None:
    apsw.Connection(str(journal)).execute("PRAGMA user_version=99")
    _one_line(wakeful("audit", "--journal", journal), 1, "schema 99", "install the newer wakeful")


def test_a_source_that_is_not_there(wakeful: Wakeful) -> None:
    _one_line(wakeful("run", "no/such/file.xlsx"), 1, "no file", "simulators are")


def test_a_domain_that_is_not_there(wakeful: Wakeful, tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    path.write_text('{"a": 1}\n')
    _one_line(wakeful("run", path, "--domain", "submarine"), 1, "submarine")


@pytest.mark.parametrize(
    "arguments",
    [
        ("fly",),
        ("why",),
        ("run", "x", "--speed", "0"),
        ("events", "--mode", "quick"),
        ("export", "--format", "parquet"),
        ("run", "--x"),
    ],
)
def test_a_wrong_usage_ends_with_two(wakeful: Wakeful, arguments: tuple[str, ...]) -> None:
    _one_line(wakeful(*arguments), 2, "--help")


def test_standard_input_needs_a_named_domain(wakeful: Wakeful) -> None:
    _one_line(wakeful("run", "-", input="{}\n"), 1, "--domain")


def test_a_directory_in_the_way_of_an_export(wakeful: Wakeful, journal: Path, tmp_path: Path) -> None:
    _one_line(wakeful("export", "--journal", journal, "--out", tmp_path / "no" / "such" / "x.jsonl"), 1, "--out")


def test_a_missing_extra_names_itself(wakeful: Wakeful, journal: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    result = wakeful("export", "--journal", journal, "--format", "parquet", "--out", tmp_path / "x.parquet")
    _one_line(result, 1, "pip install 'wakeful[parquet]'")


@pytest.mark.parametrize("arguments", [("status",), ("events", "--json"), ("audit",), ("export",), ("trust",)])
@pytest.mark.parametrize(("redirection", "says"), [(">&-", "closed"), (">/dev/full", "No space left")])
def test_an_output_that_takes_nothing_is_one_line(journal: Path, arguments: tuple[str, ...], redirection: str, says: str) -> None:
    program = shlex.join([sys.executable, "-m", "wakeful", *arguments, "--journal", str(journal)])
    result = subprocess.run(["sh", "-c", f"exec {program} {redirection}"], stderr=subprocess.PIPE, text=True, check=False)
    assert result.returncode == 1
    assert len(result.stderr.splitlines()) == 1, result.stderr
    assert says in result.stderr


def test_a_wrong_domain_is_said_before_anything_about_the_source(wakeful: Wakeful) -> None:
    _one_line(wakeful("run", "--domain", "nope", "x.jsonl"), 1, "no domain 'nope'")


def test_no_directory_is_made_for_a_journal_that_was_named(wakeful: Wakeful, tmp_path: Path) -> None:
    place = tmp_path / "no" / "such" / "mind.db"
    _one_line(wakeful("run", "service_robot", "--events", 1, "--journal", place), 1, "there is no directory", "--journal")
    assert not (tmp_path / "no").exists()
