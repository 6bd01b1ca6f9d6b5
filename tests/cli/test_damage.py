"""A damaged journal is said to be damaged, with the place and a way out, by every command: never a traceback."""

from __future__ import annotations

import json
import random
from pathlib import Path

import apsw
import pytest
from click.testing import CliRunner

from tests.cli.conftest import Wakeful
from wakeful.cli.main import main

READERS = ("status", "events", "processes", "debt", "stats", "trust", "learning", "export", "audit", "trace", "timeline")


def _sunk(path: Path) -> bytes:
    """The whole journal in its one file, as a copy of it would be."""
    db = apsw.Connection(str(path))
    db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    db.close()
    return path.read_bytes()


def _spoilt(journal: Path, position: int, record: bytes | str) -> None:
    db = apsw.Connection(str(journal))
    if isinstance(record, bytes):
        db.execute("UPDATE lines SET record = CAST(? AS TEXT) WHERE position = ?", (record, position))
    else:
        db.execute("UPDATE lines SET record = ? WHERE position = ?", (record, position))
    db.close()


@pytest.mark.parametrize("command", READERS)
@pytest.mark.parametrize("record", [b'{"is":"admitted","\xff\xfe', '{"is":"admitted"}', '{"is":"nothing known"}', "{"])
def test_a_line_that_cannot_be_read_is_named(
    wakeful: Wakeful, journal: Path, tmp_path: Path, command: str, record: bytes | str
) -> None:
    _spoilt(journal, 9, record)
    out = ("--out", tmp_path / "out.svg") if command in ("trace", "timeline") else ()
    result = wakeful(command, "--journal", journal, *out)
    assert result.exit_code == 1
    assert isinstance(result.exception, SystemExit)
    assert "line 9 cannot be read" in result.output
    assert "restore the file from a backup" in result.output


def test_the_audit_reports_it_as_an_offence_in_json(wakeful: Wakeful, journal: Path) -> None:
    _spoilt(journal, 9, b"\xff")
    result = wakeful("audit", "--journal", journal, "--json")
    assert result.exit_code == 1
    report = json.loads(result.stdout)
    assert report["ok"] is False
    assert report["checks"]["readable"]["ok"] is False
    assert report["checks"]["readable"]["first_offender"]["position"] == 9


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
    db = apsw.Connection(str(path))
    ((position,),) = db.execute(
        "SELECT min(position) FROM lines WHERE kind = 'answered' AND record LIKE '%deliberate%'"
    ).fetchall()
    db.execute("UPDATE lines SET record = replace(record, '\"choice\"', '\"chxice\"') WHERE position = ?", (position,))
    db.close()
    result = wakeful("run", "service_robot", "--events", 3, "--journal", path)
    assert result.exit_code == 1
    assert isinstance(result.exception, SystemExit)
    assert "damaged" in result.stderr
    assert len(result.stderr.splitlines()) == 1
