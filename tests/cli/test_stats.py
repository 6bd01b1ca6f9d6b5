"""`wakeful stats` says what registration made of a source."""

from __future__ import annotations

import json
from pathlib import Path

from tests.cli.conftest import Wakeful, written
from tests.journal.builder import Book
from wakeful.facts.lines import Finished


def test_observations_per_event_and_incidents_beside_chance(wakeful: Wakeful, journal: Path) -> None:
    told = wakeful("stats", "--journal", journal).stdout
    assert "500 observations became 7 events." in told
    assert "One event stands for 71.4 observations." in told
    assert "protective_stop" in told
    assert "by chance" in told


def test_json_has_kinds_and_incidents(wakeful: Wakeful, journal: Path) -> None:
    told = json.loads(wakeful("stats", "--journal", journal, "--within", 20, "--json").stdout)
    assert told["within_s"] == 20
    assert {row["kind"] for row in told["kinds"]} == {"joint_current", "grip_lost", "temperature"}
    assert told["incidents"][0]["incidents"] == 1


def test_a_silent_recording_says_that_no_event_came_of_it(wakeful: Wakeful, tmp_path: Path) -> None:
    book = Book()
    book.write(Finished(source="arm.xlsx", observations=4093))
    told = wakeful("stats", "--journal", written(list(book.lines()), tmp_path / "silent.db")).stdout
    assert told == "No event came of 4,093 observations.\n"


def test_good_ends_are_no_incidents(wakeful: Wakeful, tmp_path: Path) -> None:
    book = Book(domain="vda5050")
    book.wait(5)
    book.admit()
    for label in ("cleared", "stopped", "cleared"):
        book.wait(5)
        book.witness(label)
    path = written(list(book.lines()), tmp_path / "vehicle.db")
    told = json.loads(wakeful("stats", "--journal", path, "--json").stdout)
    assert [(row["label"], row["incidents"]) for row in told["incidents"]] == [("any", 1), ("stopped", 1)]
    assert told["duration_s"] == 15
