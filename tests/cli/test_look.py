"""`status`, `events` and `processes` say where things stand."""

from __future__ import annotations

import json
from pathlib import Path

from tests.cli.conftest import Wakeful, written
from tests.journal.builder import Book
from wakeful.facts.processes import Trigger


def test_status_says_what_was_received_and_what_is_open(wakeful: Wakeful, journal: Path) -> None:
    result = wakeful("status", "--journal", journal)
    assert result.exit_code == 0
    assert "9 = 7 admitted + 1 duplicate + 1 refused" in result.stdout
    assert "1 waiting, 0 suspended" in result.stdout
    assert json.loads(wakeful("status", "--journal", journal, "--json").stdout)["summary"]["admitted"] == 7


def test_events_lists_each_event_with_its_treatment_and_how_it_ended(wakeful: Wakeful, journal: Path) -> None:
    rows = [line.split("\t") for line in wakeful("events", "--journal", journal).stdout.splitlines()]
    assert rows[0][:5] == ["event", "when", "kind", "entity", "treatment"]
    assert len(rows) == 8
    assert rows[1][4:7] == ["diagnosis", "delib", "contradicted"]


def test_events_can_be_filtered_and_limited(wakeful: Wakeful, journal: Path) -> None:
    automatic = json.loads(wakeful("events", "--journal", journal, "--mode", "auto", "--json").stdout)
    assert [row["mode"] for row in automatic] == ["auto"] * 3
    result = wakeful("events", "--journal", journal, "--limit", 2)
    assert len(result.stdout.splitlines()) == 3
    assert "the last 2 of 7 events" in result.stderr
    assert (
        json.loads(wakeful("events", "--journal", journal, "--kind", "temperature", "--verdict", "supported", "--json").stdout)
        == []
    )


def test_processes_lists_what_is_open_and_what_each_waits_for(wakeful: Wakeful, journal: Path) -> None:
    rows = json.loads(wakeful("processes", "--journal", journal, "--json").stdout)
    assert [(row["treatment"], row["state"]) for row in rows] == [("risk_prediction", "waiting"), ("comparison", "created")]
    assert rows[0]["stands"] == "waits for evidence camera|joint_3, at most 60.0 s more"


def test_processes_can_show_the_completed_too(wakeful: Wakeful, journal: Path) -> None:
    rows = json.loads(wakeful("processes", "--journal", journal, "--all", "--json").stdout)
    assert len(rows) == 9
    assert [row["reopens"] for row in rows if row["reopens"]] == [1]


def test_a_preempted_process_names_who_preempted_it(wakeful: Wakeful, tmp_path: Path) -> None:
    book = Book()
    slow = book.admit()
    book.move(slow, Trigger.DISPATCH)
    urgent = book.admit("grip_lost", "gripper", criticality=3)
    book.move(slow, Trigger.PREEMPT, by=f"P{urgent}")
    path = written(list(book.lines()), tmp_path / "preempted.db")
    rows = json.loads(wakeful("processes", "--journal", path, "--state", "suspended", "--json").stdout)
    assert [row["stands"] for row in rows] == [f"ready; preempted by process {urgent} (grip_lost of gripper)"]
