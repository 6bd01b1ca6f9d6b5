"""Every system that is always installed comes to W's final states, and what it measures of itself is there."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.peers.__main__ import chosen, main
from benchmarks.peers.child import main as run
from benchmarks.peers.crashes import killed
from benchmarks.peers.kept import lean_of, messages_of
from benchmarks.peers.of_floor import Floor
from benchmarks.peers.running import Load, Run
from benchmarks.peers.systems import SYSTEMS, code_lines
from benchmarks.peers.treating import checksum
from benchmarks.peers.workload import make, save

EVENTS = 60
HERE = [("wakeful", "stream"), ("wakeful", "live"), ("floor", ""), ("asyncio", "")]
ASKED = ("system", "durable", "events_per_second", "cpu_us_per_event", "p50_ms", "p99_ms", "bytes_per_event", "peak_mb", "lost")
ASKED += ("repeated", "user_lines")


@pytest.fixture(scope="module")
def workload(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("workload")
    save(make(2, EVENTS), folder)
    return folder


@pytest.mark.parametrize(("system", "variant"), HERE)
def test_it_comes_to_the_final_states_that_were_worked_out_without_it(
    system: str, variant: str, workload: Path, tmp_path: Path
) -> None:
    row = run(system, variant, workload, tmp_path / "store", Load(window=16))
    assert row["finals"] == EVENTS
    assert row["right"] is True
    assert row["admit"] is not None
    assert row["resume"] is not None
    assert (row["bytes_per_event"] > 0) is SYSTEMS[system].durable  # type: ignore[operator]


def test_at_a_rate_the_floor_comes_to_the_same_and_says_what_it_is_made_of(workload: Path, tmp_path: Path) -> None:
    row = run("floor", "", workload, tmp_path / "store", Load(rate=20_000.0))
    assert row["right"] is True
    assert set(row["stages_us"]) == {"decode", "features", "forward", "append", "raw file", "steps"}  # type: ignore[call-overload]
    fastest = [min(kinds.values()) for stage, kinds in row["stages_us"].items() if stage != "raw file"]  # type: ignore[attr-defined]
    assert row["floor_us"] == pytest.approx(sum(fastest))


def test_a_system_that_loses_one_event_is_seen(workload: Path, tmp_path: Path) -> None:
    messages = [text for text in messages_of(workload) if b"device-00000" not in text]
    (tmp_path / "store").mkdir()
    floor = Floor(Run(messages, lean_of(workload), workload, tmp_path / "store", Load()), "")
    floor.run()
    whole = run("floor", "", workload, tmp_path / "other", Load())
    assert whole["checksum"] != checksum(floor.finals())


def test_the_command_prints_the_rows_that_others_read(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--systems", "asyncio,floor", "--events", str(EVENTS), "--rounds", "1", "--kills", "0", "--json"]
    assert main(words) == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["system"] for row in rows] == ["asyncio", "floor"]
    assert all(name in row for row in rows for name in ASKED)
    assert [row["durable"] for row in rows] == [False, True]
    assert all(row["right"] for row in rows)


def test_a_system_that_is_not_there_is_named() -> None:
    with pytest.raises(SystemExit, match="no system 'nobody'"):
        chosen("nobody")


def test_killed_and_started_again_wakeful_loses_nothing_and_a_plain_loop_does(workload: Path, tmp_path: Path) -> None:
    own = killed("wakeful", "stream", workload, tmp_path / "wakeful", EVENTS, kills=1)
    plain = killed("asyncio", "", workload, tmp_path / "asyncio", EVENTS, kills=1)
    assert (own["lost"], own["repeated"], own["acknowledged"]) == (0, 0, EVENTS)
    assert plain["kills"] == own["kills"] == 1
    assert plain["lost"] > 0


def test_lines_of_code_are_neither_blank_comment_nor_docstring() -> None:
    assert code_lines('"""One\n\nmore."""\n\nx = 1\n# why\ndef f():\n    """It does."""\n    return x\n') == 3
    assert SYSTEMS["wakeful"].lines_of("live") > SYSTEMS["wakeful"].lines_of("stream") > 100
