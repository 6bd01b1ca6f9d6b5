"""`wakeful revisit` and `rollback`: refuted knowledge, what rests on it, and the way back to an earlier model version."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner

from tests.cli.conftest import Wakeful
from wakeful.cli.main import main
from wakeful.facts.lines import Decided, Published, Reopened
from wakeful.journal.audit import audit
from wakeful.journal.revisit import OPEN_TO_CORRECTION, revisit
from wakeful.journal.sqlite import open_journal
from wakeful.journal.views import History, history

WHO = ("--who", "ana", "--why", "the scale was wrong")


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A service robot's journal with experiences, several model versions, and decisions whose outcome is still to come."""
    path = tmp_path_factory.mktemp("learned") / "robot.db"
    done = CliRunner().invoke(main, ["run", "service_robot", "--events", "260", "--journal", str(path)])
    assert done.exit_code == 0, done.output
    return path


@pytest.fixture
def path(learned: Path, tmp_path: Path) -> Path:
    copy = tmp_path / "robot.db"
    shutil.copy(learned, copy)
    return copy


def read(path: Path) -> History:
    with open_journal(path, read_only=True) as opened:
        assert audit(opened).ok
        return history(opened)


def with_open_decisions(past: History) -> int:
    """The number of an experience on which a decision rests that is still open to correction."""
    found = (
        number
        for number in past.gained
        if any(row.stands == OPEN_TO_CORRECTION for row in revisit(past, [number], "uneventful").affected)
    )
    return next(found)


def test_what_rests_on_an_experience_is_listed_once_each_and_what_is_open_before_what_is_settled(path: Path) -> None:
    past = read(path)
    found = revisit(past, [with_open_decisions(past)], "uneventful")
    assert all(row.on for row in found.affected)
    assert len({row.process for row in found.affected}) == len(found.affected)
    standing = [row.stands == OPEN_TO_CORRECTION for row in found.affected if not row.irreversible]
    assert standing == sorted(standing, reverse=True)
    for row in found.affected:
        decision = past.processes[row.process].decision
        assert decision is not None
        assert set(row.on) <= set(decision.rests_on)


def test_reopening_makes_a_deliberated_process_of_each_open_decision_and_only_of_these(path: Path, wakeful: Wakeful) -> None:
    number = with_open_decisions(read(path))
    asked = json.loads(wakeful("revisit", number, "--journal", path, "--json").stdout)
    done = wakeful("revisit", number, "--journal", path, "--reopen", *WHO, "--json")
    assert done.exit_code == 0, done.output
    still_open = {row["process"] for row in asked["affected"] if row["stands"] == OPEN_TO_CORRECTION}
    assert {each["process"] for each in json.loads(done.stdout)["reopened"]} == still_open
    with open_journal(path, read_only=True) as opened:
        lines = [line.record for line in opened.lines()]
    reopened = {record.process: record for record in lines if isinstance(record, Reopened)}
    assert {record.reopens for record in reopened.values()} >= still_open
    decided = [record for record in lines if isinstance(record, Decided) and record.process in reopened]
    assert {record.decision.mode for record in decided} <= {"delib", "fallback"}
    again = json.loads(wakeful("revisit", number, "--journal", path, "--json").stdout)
    assert not [row for row in again["affected"] if row["stands"] == OPEN_TO_CORRECTION]


def test_what_was_reopened_at_rest_is_thought_about_in_the_next_run(path: Path, wakeful: Wakeful) -> None:
    number = with_open_decisions(read(path))
    done = json.loads(wakeful("revisit", number, "--journal", path, "--reopen", *WHO, "--json").stdout)
    assert wakeful("run", "service_robot", "--events", 20, "--journal", path).exit_code == 0
    past = read(path)
    new = [
        record.process for record in past.reopened.values() if record.reopens in {each["process"] for each in done["reopened"]}
    ]
    assert new
    assert all(past.processes[process].first_treated_ns is not None for process in new)


def test_reopening_without_who_and_why_changes_nothing(path: Path, wakeful: Wakeful) -> None:
    before = read(path).last
    refused = wakeful("revisit", 1, "--journal", path, "--reopen")
    assert refused.exit_code == 2
    assert "--who" in refused.output
    assert read(path).last == before


def test_what_is_neither_an_event_nor_an_experience_is_named(path: Path, wakeful: Wakeful) -> None:
    refused = wakeful("revisit", "zzz", "--journal", path)
    assert refused.exit_code == 1
    assert "neither an event's id nor the number" in refused.output


def test_after_a_rollback_the_next_run_decides_with_that_version_and_learns_on_from_it(path: Path, wakeful: Wakeful) -> None:
    accepted = [record.card.version for _, record in read(path).published if record.card.accepted]
    assert len(accepted) >= 2, "the run must have published two versions for this test to say anything"
    done = wakeful("rollback", accepted[0], *WHO, "--journal", path)
    assert done.exit_code == 0, done.output
    last = read(path).last
    assert wakeful("run", "service_robot", "--events", 120, "--journal", path).exit_code == 0
    read(path)
    with open_journal(path, read_only=True) as opened:
        new = [line.record for line in opened.lines(after=last)]
    decided = next(record for record in new if isinstance(record, Decided) and record.decision.model)
    assert decided.decision.model == accepted[0]
    cards = [record.card for record in new if isinstance(record, Published)]
    assert [card.base for card in cards][:1] == [accepted[0]]


def test_a_version_that_was_never_accepted_is_refused_with_those_that_were(path: Path, wakeful: Wakeful) -> None:
    refused = wakeful("rollback", 999, *WHO, "--journal", path)
    assert refused.exit_code == 1
    assert "accepted are: 1" in refused.output
