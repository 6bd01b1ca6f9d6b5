"""A treatment's code changes, or is removed, while processes wait: each goes on, or begins again and is named; none is silent."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from wakeful.facts.named import MISMATCH, REMOVED
from wakeful.journal import open_journal
from wakeful.journal.audit import audit
from wakeful.journal.debt import debt
from wakeful.journal.named import named
from wakeful.journal.views import History, ProcessPast, history

CHILD = [sys.executable, str(Path(__file__).with_name("upgraded.py"))]


@pytest.fixture(scope="module")
def upgraded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a journal that version 1 began, was killed over, and version 2 went on with."""
    folder = tmp_path_factory.mktemp("upgrade")
    arguments = [str(folder / "mind.db"), str(folder / "called")]
    first = subprocess.run([*CHILD, "1", *arguments], capture_output=True, text=True, timeout=60, check=False)
    assert first.returncode == -signal.SIGKILL, first.stderr
    second = subprocess.run([*CHILD, "2", *arguments], capture_output=True, text=True, timeout=60, check=False)
    assert second.returncode == 0, second.stderr
    return folder


@pytest.fixture(scope="module")
def past(upgraded: Path) -> History:
    with open_journal(upgraded / "mind.db", read_only=True) as journal:
        report = audit(journal)
        assert report.ok, report
        return history(journal)


def root(past: History, name: str) -> ProcessPast:
    found = [process for event, process in past.roots() if event.event.entity == name]
    assert len(found) == 1
    return found[0]


def says(process: ProcessPast) -> str:
    assert process.concluded is not None
    return str(json.loads(bytes(process.concluded.result))["says"])


def notes(process: ProcessPast) -> list[str]:
    return [note.what for note in process.notes if note.what in (MISMATCH, REMOVED)]


def test_nobody_is_left_behind(past: History) -> None:
    assert {str(process.end) for _, process in past.roots()} == {"resolved"}
    assert [process.id for process in past.processes.values() if process.open] == []


@pytest.mark.parametrize("name", ["steady", "reworded"])
def test_one_whose_code_still_asks_the_same_goes_on(past: History, name: str) -> None:
    process = root(past, name)
    assert notes(process) == []
    assert "by version 2" in says(process)


@pytest.mark.parametrize("name", ["reordered", "caller", "effector", "asker", "unresult"])
def test_one_whose_code_asks_something_else_begins_again_and_is_named(past: History, name: str) -> None:
    process = root(past, name)
    assert notes(process) == [MISMATCH]
    assert "by version 2" in says(process)
    assert process.decision is not None
    assert process.decision.mode == "delib"


def test_what_was_answered_outside_is_not_called_again_after_the_restart(upgraded: Path) -> None:
    assert sorted((upgraded / "called").read_text().splitlines()) == ["caller 1", "effector 1"]


def test_a_childs_result_that_cannot_be_read_any_more_restarts_its_parent(past: History) -> None:
    process = root(past, "unresult")
    assert says(process) == "unresult over new by version 2"
    assert "cannot be read" in next(note.detail for note in process.notes if note.what == MISMATCH)


def test_a_removed_treatments_process_goes_on_in_fallback_and_is_debt(past: History) -> None:
    process = root(past, "leaver")
    assert notes(process) == [REMOVED]
    assert process.decision is not None
    assert (process.decision.treatment, process.decision.mode) == ("description", "fallback")
    assert "leaver" in [row.entity for row in debt(past)]


def test_a_child_whose_treatment_was_removed_fails_and_its_parent_hears_so(past: History) -> None:
    process = root(past, "parent")
    assert str(process.end) == "resolved"
    assert "No treatment could be completed" in says(process)
    child = next(each for each in past.processes.values() if each.parent == process.id)
    assert notes(child) == [REMOVED]
    assert str(child.end) == "unresolved"


def test_status_names_each_of_them_and_the_domains_change(upgraded: Path, past: History) -> None:
    command = [sys.executable, "-m", "wakeful", "status", "--journal", str(upgraded / "mind.db")]
    text = " ".join(subprocess.run(command, capture_output=True, text=True, check=True).stdout.split())
    restarted = [f"P{root(past, name).id}" for name in ("reordered", "caller", "effector", "asker", "unresult")]
    assert f"5 began again from their events: their code no longer matches what was recorded: {', '.join(restarted)}" in text
    assert "go on in fallback mode: their treatment is not registered any more; in debt" in text
    assert f"P{root(past, 'leaver').id}" in text
    assert "domain jsonl changed under this journal, version 1 to 2" in text
    told = json.loads(subprocess.run([*command, "--json"], capture_output=True, text=True, check=True).stdout)
    assert [each["what"] for each in told["named"]] == [MISMATCH, REMOVED, "domain changed"]
    assert [each.what for each in named(past)] == [MISMATCH, REMOVED, "domain changed"]
