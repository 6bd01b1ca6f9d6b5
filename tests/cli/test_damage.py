"""A damaged journal is said to be damaged, with the place and a way out, by every command: never a traceback."""

from __future__ import annotations

import json
import random
from pathlib import Path

import apsw
import pytest
from click.testing import CliRunner

from tests.cli.conftest import Wakeful
from tests.journal.forging import spoil
from wakeful.cli.main import main

READERS = ("status", "events", "processes", "debt", "stats", "trust", "learning", "export", "audit", "trace", "timeline")


def _sunk(path: Path) -> bytes:
    """The whole journal in its one file, as a copy of it would be."""
    db = apsw.Connection(str(path))
    db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    db.close()
    return path.read_bytes()


#: What no journal writes, under its right digest, and something under a wrong one.
SPOILT = [(b"\xc1", True), (b"\x92\xc4\x01\x01\x93\xc4\x02\xff\xff\x00\x90", True), (b"\x91\xa1x", False)]


@pytest.mark.parametrize("command", READERS)
@pytest.mark.parametrize(("body", "sealed"), SPOILT)
def test_a_row_that_cannot_be_read_is_named(
    wakeful: Wakeful, journal: Path, tmp_path: Path, command: str, body: bytes, sealed: bool
) -> None:
    first, last = spoil(journal, 9, body, sealed=sealed)
    out = ("--out", tmp_path / "out.svg") if command in ("trace", "timeline") else ()
    result = wakeful(command, "--journal", journal, *out)
    assert result.exit_code == 1
    assert isinstance(result.exception, SystemExit)
    assert f"the row of lines {first} to {last} cannot be read" in result.output
    assert "restore the file from a backup" in result.output


def test_the_audit_reports_it_as_an_offence_in_json(wakeful: Wakeful, journal: Path) -> None:
    first, _ = spoil(journal, 9, b"\xff", sealed=False)
    result = wakeful("audit", "--journal", journal, "--json")
    assert result.exit_code == 1
    report = json.loads(result.stdout)
    assert report["ok"] is False
    assert report["checks"]["readable"]["ok"] is False
    assert report["checks"]["readable"]["first_offender"]["position"] == first


@pytest.mark.parametrize("seed", range(12))
def test_two_hundred_flipped_bytes_never_give_a_traceback(journal: Path, tmp_path: Path, seed: int) -> None:
    whole = bytearray(_sunk(journal))
    draw = random.Random(seed)
    start = 100 if seed % 3 else 0  # the first hundred bytes are the file's header
    for _ in range(200):
        whole[draw.randrange(start, len(whole))] ^= 1 << draw.randrange(8)
    damaged = tmp_path / "damaged.db"
    damaged.write_bytes(whole)
    for command in ("status", "events", "audit", "stats", "trust", "export"):
        result = CliRunner().invoke(main, [command, "--journal", str(damaged)])
        assert result.exception is None or isinstance(result.exception, SystemExit), (command, result.exception)
        assert result.exit_code in (0, 1)
    assert CliRunner().invoke(main, ["audit", "--journal", str(damaged)]).exit_code == 1


def test_going_on_with_a_damaged_journal_is_refused_in_one_line(wakeful: Wakeful, tmp_path: Path) -> None:
    path = tmp_path / "mind.db"
    assert wakeful("run", "service_robot", "--events", 3, "--journal", path).exit_code == 0
    spoil(path, 9, b"\xc1", sealed=True)
    result = wakeful("run", "service_robot", "--events", 3, "--journal", path)
    assert result.exit_code == 1
    assert isinstance(result.exception, SystemExit)
    assert "damaged" in result.stderr
    assert len(result.stderr.splitlines()) == 1
