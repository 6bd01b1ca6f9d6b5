"""The faulty disk: what it says it does to a plain SQLite file is what happens to it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import apsw
import pytest

from wakeful.testing.faulty_disk import FaultyDisk, Survival


@pytest.fixture
def disk() -> Iterator[FaultyDisk]:
    with FaultyDisk(seed=1) as faulty:
        yield faulty


def opened(path: Path, disk: FaultyDisk, synchronous: str = "FULL") -> apsw.Connection:
    db = apsw.Connection(str(path), vfs=disk.name)
    db.execute("PRAGMA journal_mode=WAL")
    db.execute(f"PRAGMA synchronous={synchronous}")
    db.execute("CREATE TABLE IF NOT EXISTS t(x)")
    return db


def rows(path: Path) -> int:
    db = apsw.Connection(str(path))
    found = int(next(db.execute("SELECT count(*) FROM t"))[0])
    assert next(db.execute("PRAGMA integrity_check"))[0] == "ok"
    db.close()
    return found


def fill(db: apsw.Connection, count: int) -> None:
    for _ in range(count):
        db.execute("INSERT INTO t VALUES (randomblob(900))")


def power_loss(db: apsw.Connection, disk: FaultyDisk, survival: Survival) -> None:
    disk.cut_power()
    with pytest.raises(apsw.Error):
        db.execute("INSERT INTO t VALUES (1)")
    with suppress(apsw.Error):
        db.close()
    disk.restore_power(survival)


@pytest.mark.parametrize("survival", ["all", "none", "some"])
def test_what_was_synced_survives_a_loss_of_power(tmp_path: Path, disk: FaultyDisk, survival: Survival) -> None:
    db = opened(tmp_path / "a.db", disk)
    fill(db, 20)
    power_loss(db, disk, survival)
    assert rows(tmp_path / "a.db") == 20


def test_what_was_not_synced_is_lost_with_the_power(tmp_path: Path, disk: FaultyDisk) -> None:
    db = opened(tmp_path / "a.db", disk, synchronous="NORMAL")
    db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    fill(db, 20)
    power_loss(db, disk, "none")
    assert rows(tmp_path / "a.db") == 0


def test_some_sectors_survive_by_the_seed_and_the_database_is_whole(tmp_path: Path) -> None:
    found = []
    for seed in (3, 3, 4, 5, 6, 7, 8):
        with FaultyDisk(seed) as disk:
            path = tmp_path / f"{len(found)}.db"
            db = opened(path, disk, synchronous="NORMAL")
            db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            fill(db, 20)
            power_loss(db, disk, "some")
            found.append(rows(path))
    assert found[0] == found[1]
    assert max(found) < 20


@pytest.mark.parametrize(
    ("fault", "error"), [("full", apsw.FullError), ("read-only", apsw.ReadOnlyError), ("broken", apsw.IOError)]
)
def test_each_fault_is_refused_with_its_own_error_and_ends_when_it_is_mended(
    tmp_path: Path, disk: FaultyDisk, fault: str, error: type[apsw.Error]
) -> None:
    db = opened(tmp_path / "a.db", disk)
    disk.fail(fault, after_writes=4)  # type: ignore[arg-type]
    with pytest.raises(error):
        fill(db, 20)
    disk.mend()
    kept = next(db.execute("SELECT count(*) FROM t"))[0]
    fill(db, 1)
    assert next(db.execute("SELECT count(*) FROM t"))[0] == kept + 1
    db.close()


def test_a_slow_disk_waits_at_each_sync(tmp_path: Path) -> None:
    waited: list[float] = []
    with FaultyDisk(sleep=waited.append) as disk:
        db = opened(tmp_path / "a.db", disk)
        disk.slow(0.5)
        fill(db, 3)
        assert waited == [0.5] * 3
        disk.slow(0.0)
        db.close()


def test_rot_flips_as_many_bits_as_it_says(tmp_path: Path, disk: FaultyDisk) -> None:
    path = tmp_path / "file"
    path.write_bytes(bytes(1000))
    places = disk.rot(path, bits=3, after_byte=500)
    content = path.read_bytes()
    assert all(place >= 500 and content[place] for place in places)
    assert sum(byte.bit_count() for byte in content) in (1, 3)


def test_a_torn_file_has_lost_its_end(tmp_path: Path, disk: FaultyDisk) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"ab" * 500)
    disk.tear(path, lost_bytes=100)
    assert path.read_bytes() == b"ab" * 450
