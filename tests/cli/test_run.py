"""`wakeful run` does the main job, goes on where it stopped, and ends with a summary."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec
import pytest

from tests.cli.conftest import Wakeful
from wakeful.cli.progress import Progress, Stop, stoppable
from wakeful.cli.sources import Source, find_source
from wakeful.contracts.bridge import Item

PROMISED = {
    "source",
    "domain",
    "received",
    "admitted",
    "duplicate",
    "refused",
    "coverage",
    "completion",
    "treatments",
    "modes",
    "waiting",
    "suspended",
    "outcomes_matched",
    "verdicts",
    "reasoner_calls",
    "events_per_second",
}


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A seeded stream of a vehicle as a file."""
    path = tmp_path_factory.mktemp("recording") / "agv.jsonl"
    program = [sys.executable, "-m", "wakeful", "simulate", "vda5050", "--messages", "400", "--seed", "5"]
    path.write_bytes(subprocess.run(program, check=True, capture_output=True).stdout)
    return path


def test_a_simulated_robot_runs_into_a_journal_that_passes_its_audit(wakeful: Wakeful, tmp_path: Path) -> None:
    journal = tmp_path / "robot.db"
    result = wakeful("run", "service_robot", "--events", 60, "--journal", journal)
    assert result.exit_code == 0, result.output
    assert result.stdout.index("The strangest episodes") < result.stdout.index("Summary of service_robot")
    assert "60 = 60 admitted + 0 duplicate + 0 refused" in result.stdout
    assert wakeful("audit", "--journal", journal).exit_code == 0


def test_json_is_one_object_with_all_that_is_promised(wakeful: Wakeful, tmp_path: Path) -> None:
    result = wakeful("run", "service_robot", "--events", 30, "--journal", tmp_path / "robot.db", "--json")
    told = json.loads(result.stdout)
    assert set(told) >= PROMISED
    assert (told["source"], told["domain"], told["admitted"]) == ("service_robot", "service_robot", 30)
    assert told["coverage"] == 1.0
    assert sum(told["treatments"].values()) == sum(told["modes"].values()) == 30
    assert told["this_run"]["interrupted"] is False


def test_the_same_command_goes_on_where_it_stopped(wakeful: Wakeful, tmp_path: Path) -> None:
    once, twice = tmp_path / "once.db", tmp_path / "twice.db"
    wakeful("run", "service_robot", "--events", 40, "--journal", once)
    for _ in range(2):
        wakeful("run", "service_robot", "--events", 20, "--journal", twice)
    exports = [wakeful("export", "--journal", path, "--stable").stdout for path in (once, twice)]
    assert exports[0] == exports[1]


def test_a_source_that_was_read_to_its_end_gives_only_duplicates_again(wakeful: Wakeful, recording: Path, tmp_path: Path) -> None:
    journal = tmp_path / "agv.db"
    first = json.loads(wakeful("run", recording, "--journal", journal, "--json").stdout)
    again = json.loads(wakeful("run", recording, "--journal", journal, "--json").stdout)
    assert first["admitted"] > 0
    assert (again["this_run"]["admitted"], again["this_run"]["duplicate"]) == (0, first["admitted"])
    assert again["treatments"] == first["treatments"]
    assert wakeful("audit", "--journal", journal).exit_code == 0


def test_the_domain_is_recognised_and_the_journal_has_a_place_of_its_own(
    wakeful: Wakeful, recording: Path, tmp_path: Path
) -> None:
    told = json.loads(wakeful("run", recording, "--json").stdout)
    assert told["domain"] == "vda5050"
    assert Path(told["journal"]).parent == tmp_path / "state" / "wakeful"
    assert f"journal: {told['journal']}" in wakeful("status").stderr


def test_standard_input_is_a_source(wakeful: Wakeful, recording: Path, tmp_path: Path) -> None:
    told = json.loads(
        wakeful(
            "run", "-", "--domain", "vda5050", "--journal", tmp_path / "piped.db", "--json", input=recording.read_bytes()
        ).stdout
    )
    assert told["admitted"] > 0


def test_a_robot_that_the_source_does_not_name_is_named_by_its_option(wakeful: Wakeful, tmp_path: Path) -> None:
    journal = tmp_path / "robot.db"
    events = tmp_path / "events.jsonl"
    events.write_text('{"event": {"kind": "slip", "entity": "left wheel", "at": 1, "says": "the wheel slips"}}\n')
    result = wakeful("run", events, "--domain", "jsonl", "--robot", "R2", "--journal", journal)
    assert result.exit_code == 0, result.output
    assert json.loads(wakeful("why", "--sample", 1, "--journal", journal, "--json").stdout)[0]["event"]["robot"] == "R2"


def test_a_source_of_which_no_event_comes_says_so(wakeful: Wakeful, tmp_path: Path) -> None:
    silent = tmp_path / "silent.jsonl"
    silent.write_text('{"evidence": {"topic": "clearance", "key": "aisle 4", "value": 0.35}}\n')
    result = wakeful("run", silent, "--domain", "jsonl", "--journal", tmp_path / "silent.db")
    assert result.exit_code == 0
    assert "no event came of 1 item" in result.stdout


def test_an_empty_file_is_one_error_and_leaves_no_journal(wakeful: Wakeful, tmp_path: Path) -> None:
    empty = tmp_path / "empty.jsonl"
    empty.touch()
    result = wakeful("run", empty, "--domain", "jsonl", "--journal", tmp_path / "empty.db")
    assert result.exit_code == 1
    assert "is empty" in result.stderr
    assert not (tmp_path / "empty.db").exists()


def test_options_come_from_the_environment(wakeful: Wakeful, tmp_path: Path) -> None:
    journal = tmp_path / "env.db"
    settings = {"WAKEFUL_JOURNAL": str(journal), "WAKEFUL_EVENTS": "5", "WAKEFUL_JSON": "1"}
    assert json.loads(wakeful("run", "service_robot", env=settings).stdout)["admitted"] == 5
    assert journal.is_file()


def test_a_journal_of_another_domain_is_refused(wakeful: Wakeful, recording: Path, tmp_path: Path) -> None:
    journal = tmp_path / "robot.db"
    wakeful("run", "service_robot", "--events", 5, "--journal", journal)
    result = wakeful("run", recording, "--journal", journal)
    assert result.exit_code == 1
    assert "was made with the domain service_robot" in result.stderr


def test_what_weighed_most_is_recomputed_with_the_recorded_model(wakeful: Wakeful, tmp_path: Path) -> None:
    journal = tmp_path / "robot.db"
    wakeful("run", "service_robot", "--events", 80, "--journal", journal)
    last = json.loads(wakeful("events", "--journal", journal, "--limit", 1, "--json").stdout)[0]["id"]
    assert "what weighed most for " in wakeful("why", last, "--journal", journal).stdout


def test_ctrl_c_stops_cleanly_and_the_same_command_goes_on(
    wakeful: Wakeful, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stopped, undisturbed = tmp_path / "stopped.db", tmp_path / "undisturbed.db"
    command = ("run", "service_robot", "--events", 30, "--journal")
    wakeful(*command, undisturbed)
    with monkeypatch.context() as patch:
        patch.setattr("wakeful.cli.run.find_source", _interrupting_after(40))
        result = wakeful(*command, stopped)
    assert result.exit_code == 130
    assert "the same command goes on from here" in result.stderr
    assert wakeful("audit", "--journal", stopped).exit_code == 0
    left = 30 - json.loads(wakeful("status", "--journal", stopped, "--json").stdout)["summary"]["received"]
    assert 0 < left < 30
    wakeful("run", "service_robot", "--events", left, "--journal", stopped)
    exports = [wakeful("export", "--journal", path, "--stable").stdout for path in (stopped, undisturbed)]
    assert exports[0] == exports[1]


def _interrupting_after(items: int) -> Callable[[str, str | None, int], Source]:
    """Finds the source as ever, and presses ctrl-C while its items are read."""

    def find(name: str, domain: str | None, seed: int) -> Source:
        found = find_source(name, domain, seed)

        def read(after: int) -> Iterator[Item]:
            for index, item in enumerate(found.items(after)):
                if index == items:
                    os.kill(os.getpid(), signal.SIGINT)
                yield item

        return msgspec.structs.replace(found, items=read)

    return find


def test_a_second_signal_interrupts_at_once() -> None:
    with stoppable() as stop:
        stop.take(signal.SIGINT, None)
        assert stop.asked
        with pytest.raises(KeyboardInterrupt):
            stop.take(signal.SIGINT, None)


def test_a_pause_ends_when_a_stop_is_asked_for() -> None:
    stop = Stop()
    stop.take(signal.SIGINT, None)
    stop.pause(3600)


def test_there_is_no_progress_bar_where_no_terminal_is(capsys: pytest.CaptureFixture[str]) -> None:
    progress = Progress(10)
    progress.show(5, 1)
    progress.clear()
    assert capsys.readouterr() == ("", "")


def test_speed_waits_for_the_sources_own_time(
    wakeful: Wakeful, recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pauses: list[float] = []
    monkeypatch.setattr(Stop, "pause", lambda _, seconds: pauses.append(seconds))
    told = json.loads(wakeful("run", recording, "--speed", 10, "--journal", tmp_path / "paced.db", "--json").stdout)
    # A long pause is taken in parts, so that operators are heard meanwhile.
    assert len(pauses) >= told["this_run"]["items"] - 1
    assert sum(pauses) * 10 > 60


def test_a_reader_that_goes_away_is_no_error(wakeful: Wakeful, tmp_path: Path) -> None:
    journal = tmp_path / "robot.db"
    wakeful("run", "service_robot", "--events", 60, "--journal", journal)
    program = [sys.executable, "-m", "wakeful", "export", "--journal", str(journal)]
    with subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as export:
        assert export.stdout is not None
        assert export.stderr is not None
        assert export.stdout.readline().startswith(b'{"position":1,')
        export.stdout.close()
        assert export.stderr.read() == b""
