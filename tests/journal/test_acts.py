"""The folder through which operators hand acts to whoever writes a journal."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest

from wakeful.contracts.journal import JournalError
from wakeful.facts.inputs import Act
from wakeful.journal.acts import ActSpool


def act(process: int = 1, identity: str = "") -> Act:
    return Act(who="ana", act="hold", process=process, why="a test", id=identity)


@pytest.fixture
def spool(tmp_path: Path) -> ActSpool:
    return ActSpool(tmp_path / "mind.db")


def test_acts_come_out_in_the_order_of_being_handed_in_until_they_are_done(spool: ActSpool) -> None:
    for process in (3, 1, 2):
        spool.put(act(process))
    handed = spool.waiting()
    assert [each.act.process for each in handed] == [3, 1, 2]
    assert len({each.act.id for each in handed}) == 3
    spool.done(handed[:2])
    assert [each.act.process for each in spool.waiting()] == [2]
    spool.done(handed)
    assert spool.waiting() == []


def test_nobody_but_the_owner_may_look_or_write(spool: ActSpool) -> None:
    spool.put(act())
    assert stat.S_IMODE(spool.folder.stat().st_mode) == 0o700
    assert {stat.S_IMODE(file.stat().st_mode) for file in spool.folder.iterdir()} == {0o600}


def test_a_folder_that_others_may_write_is_neither_read_nor_written(spool: ActSpool) -> None:
    spool.put(act())
    spool.folder.chmod(0o777)
    assert spool.waiting() == []
    with pytest.raises(JournalError, match="others may write it"):
        spool.put(act())


@pytest.mark.parametrize(
    "content", [b"", b"{", b'{"who": "ana"}', b'{"who":"a","act":"hold","process":1,"why":"","more":1}', b"\xff"]
)
def test_what_is_no_act_is_set_aside_and_the_others_are_taken(spool: ActSpool, content: bytes) -> None:
    spool.put(act(1))
    (spool.folder / "0-bad.act").write_bytes(content)
    spool.put(act(2))
    assert [each.act.process for each in spool.waiting()] == [1, 2]
    assert (spool.folder / "0-bad.refused").read_bytes() == content


def test_a_link_to_somewhere_else_is_not_followed(spool: ActSpool, tmp_path: Path) -> None:
    spool.put(act(1))
    real = spool.waiting()[0].file
    elsewhere = real.rename(tmp_path / "elsewhere")
    (spool.folder / "1-link.act").symlink_to(elsewhere)
    assert spool.waiting() == []


def test_a_half_written_file_is_not_seen(spool: ActSpool) -> None:
    spool.put(act(1))
    (spool.folder / "0-slow.new").write_bytes(b'{"who":')
    assert len(spool.waiting()) == 1


def test_without_a_folder_nothing_waits(spool: ActSpool) -> None:
    assert spool.waiting() == []
