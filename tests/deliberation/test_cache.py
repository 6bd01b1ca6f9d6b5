"""The reply cache: whole files or none, private, and never trusted."""

from __future__ import annotations

import json
import logging
import stat
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from wakeful.deliberation.cache import ReplyCache, default_folder, digest
from wakeful.facts.asking import Reply

REPLY = Reply(choice="planning", confidence=0.8, because=("so",), cost_usd=0.5, calls=3, reasoner="openai")


def test_a_kept_reply_comes_back_as_if_it_had_cost_nothing(tmp_path: Path) -> None:
    ReplyCache(tmp_path).put(digest("a"), REPLY)
    kept = ReplyCache(tmp_path).get(digest("a"))
    assert kept is not None
    assert (kept.choice, kept.because, kept.cost_usd, kept.calls) == ("planning", ("so",), 0.0, 0)


def test_what_was_never_kept_is_absent(tmp_path: Path) -> None:
    assert ReplyCache(tmp_path / "nowhere").get(digest("a")) is None


@pytest.mark.parametrize(
    "content", [b"", b"{", b"[]", b'{"choice": 1}', b"\xff", b"x" * 2_000_000, b'{"choice":"a","confidence":1,"run":"rm"}']
)
def test_a_file_that_cannot_be_read_counts_as_absent_and_is_replaced(
    tmp_path: Path, content: bytes, caplog: pytest.LogCaptureFixture
) -> None:
    cache = ReplyCache(tmp_path)
    cache.put(digest("a"), REPLY)
    (path,) = tmp_path.rglob("*.json")
    path.write_bytes(content)
    with caplog.at_level(logging.WARNING):
        assert cache.get(digest("a")) is None
    assert str(path) in caplog.text
    cache.put(digest("a"), REPLY)
    assert cache.get(digest("a")) is not None


def test_files_and_folders_are_for_their_owner_only(tmp_path: Path) -> None:
    ReplyCache(tmp_path / "replies").put(digest("a"), REPLY)
    (path,) = tmp_path.rglob("*.json")
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700


def test_a_folder_that_cannot_be_written_is_logged_and_costs_no_answer(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    with caplog.at_level(logging.WARNING):
        ReplyCache(blocked).put(digest("a"), REPLY)
        assert ReplyCache(blocked).get(digest("a")) is None
    assert "could not keep" in caplog.text


def test_many_writers_of_one_reply_leave_one_whole_file(tmp_path: Path) -> None:
    def write(number: int) -> None:
        ReplyCache(tmp_path).put(digest("a"), Reply(choice="planning", confidence=number / 100, because=("x" * 10_000,)))

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(write, range(100)))
    (path,) = [one for one in tmp_path.rglob("*") if one.is_file()]
    assert json.loads(path.read_bytes())["choice"] == "planning"


def test_a_digest_tells_where_one_part_ends() -> None:
    assert len({digest("a", "b"), digest("ab"), digest("", "ab"), digest("ab", "")}) == 4


def test_the_default_folder_follows_the_xdg_rule() -> None:
    assert default_folder({"XDG_CACHE_HOME": "/somewhere"}) == Path("/somewhere/wakeful/replies")
    assert default_folder({"XDG_CACHE_HOME": "relative"}) == default_folder({})
    assert default_folder({}).parts[-3:] == (".cache", "wakeful", "replies")
