"""A process is killed at each crash point, by SIGKILL, started again, and ends as one that nobody disturbed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import NamedTuple

import msgspec
import pytest

import wakeful
from tests.chaos import small_mind
from tests.chaos.older import put_back_to_schema_1
from wakeful.drivers.assembly import assemble
from wakeful.drivers.blobs import JournalBlobs
from wakeful.facts.asking import Kind
from wakeful.facts.crash_points import CRASH_AT, CRASH_POINTS
from wakeful.facts.lines import Admitted, Answered, Asked, Created, Line, Moved, Published
from wakeful.facts.processes import State, Trigger
from wakeful.facts.settings import MindSettings
from wakeful.journal.audit import audit
from wakeful.journal.export import exported
from wakeful.journal.sqlite import open_journal


class Day(NamedTuple):
    """Where a small mind lives."""

    journal: Path
    calls: Path

    def live(self, crash_at: str = "", *more: str) -> subprocess.CompletedProcess[str]:
        """Have it live in a process of its own, until it is over or killed."""
        environment = {name: value for name, value in os.environ.items() if name != CRASH_AT}
        environment |= {"PYTHONPATH": str(Path(wakeful.__file__).parents[1]), "OPENBLAS_NUM_THREADS": "1"}
        if crash_at:
            environment[CRASH_AT] = crash_at
        command = [sys.executable, small_mind.__file__, str(self.journal), str(self.calls), *more]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=120)

    def lines(self) -> list[Line]:
        """What its journal holds; nothing where it was killed before there was one."""
        if not self.journal.is_file() or not self.journal.stat().st_size:
            return []
        with open_journal(self.journal) as journal:
            return list(journal.lines())

    def export(self) -> bytes:
        """Its journal, apart from what differs from run to run."""
        with open_journal(self.journal) as journal:
            return b"\n".join(msgspec.json.encode(line) for line in exported(journal, stable=True))

    def called(self) -> Counter[str]:
        """How often the callee was asked for what."""
        return Counter(self.calls.read_text().splitlines()) if self.calls.exists() else Counter()


class Undisturbed(NamedTuple):
    """A day without a crash."""

    export: bytes
    called: Counter[str]
    reached: dict[str, int]
    lines: list[Line]


def a_day(folder: Path) -> Day:
    return Day(folder / "mind.db", folder / "calls")


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Undisturbed:
    return without_a_crash(tmp_path_factory)


@pytest.fixture(scope="module")
def compacted(tmp_path_factory: pytest.TempPathFactory) -> Undisturbed:
    return without_a_crash(tmp_path_factory, "--compact")


def without_a_crash(folders: pytest.TempPathFactory, *how: str) -> Undisturbed:
    day = a_day(folders.mktemp("undisturbed"))
    run = day.live("", "--count", *how)
    assert run.returncode == 0, run.stderr
    return Undisturbed(day.export(), day.called(), json.loads(run.stdout), day.lines())


def answered_calls(lines: list[Line]) -> Counter[str]:
    """The calls outside whose answers are committed, as the callee names them."""
    event_of = {line.record.process: line.record.event for line in lines if isinstance(line.record, Created)}
    return Counter(
        f"{event_of[line.record.process]} {line.record.key}"
        for line in lines
        if isinstance(line.record, Answered) and line.record.kind is Kind.CALL and not line.record.error
    )


def ends(lines: list[Line]) -> dict[int, tuple[str, str, int]]:
    """Of each process that is still told line by line: its event, how it ended and after how many steps."""
    events = {line.record.process: line.record.event for line in lines if isinstance(line.record, Created)}
    return {
        line.record.process: (events[line.record.process], line.record.trigger.value, line.record.steps)
        for line in lines
        if isinstance(line.record, Moved) and line.record.after is State.COMPLETED and line.record.process in events
    }


def states(lines: list[Line]) -> dict[int, tuple[State, int]]:
    """State and steps of each open process."""
    found: dict[int, tuple[State, int]] = {}
    for line in lines:
        record = line.record
        if isinstance(record, Created):
            found[record.process] = (State.CREATED, 0)
        elif isinstance(record, Moved):
            found[record.process] = (record.after, record.steps)
    return {process: at for process, at in found.items() if at[0] is not State.COMPLETED}


def test_the_day_holds_what_a_crash_could_matter_to(undisturbed: Undisturbed) -> None:
    triggers = Counter(line.record.trigger for line in undisturbed.lines if isinstance(line.record, Moved))
    assert triggers[Trigger.PREEMPT] > 3
    assert triggers[Trigger.EXPIRE] > 0
    assert any(isinstance(line.record, Asked) and line.record.kind is Kind.EVIDENCE for line in undisturbed.lines)
    assert any(isinstance(line.record, Published) and line.record.card.accepted for line in undisturbed.lines)
    assert sum(undisturbed.called.values()) >= 10
    assert max(undisturbed.called.values()) == 1


@pytest.mark.parametrize("name", [name for name in CRASH_POINTS if not name.startswith("compaction")])
def test_a_process_that_is_killed_there_loses_and_repeats_nothing(name: str, undisturbed: Undisturbed, tmp_path: Path) -> None:
    day = a_day(tmp_path)
    at_death: list[Line] = []
    nth = (undisturbed.reached.get(name, 1) + 1) // 2
    if name.startswith("migration"):
        at_death = half_a_day_in_schema_1(day, undisturbed)
    killed = day.live(f"{name}@{nth}")
    assert killed.returncode == -signal.SIGKILL, f"{name!r} was not reached: {killed.stderr}"
    at_death, called_then = at_death or day.lines(), day.called()
    promised = answered_calls(at_death)
    if at_death and not name.startswith("migration"):
        its_processes_stand_where_they_stood(day, at_death)

    resumed = day.live()
    assert resumed.returncode == 0, resumed.stderr
    lines, called = day.lines(), day.called()
    with open_journal(day.journal) as journal:
        report = audit(journal)
    assert report.ok, report.first_offender
    assert lines[: len(at_death)] == at_death, "an acknowledged line is gone or changed"
    admitted = {line.record.event.id for line in at_death if isinstance(line.record, Admitted)}
    assert admitted <= {line.record.event.id for line in lines if isinstance(line.record, Admitted)}
    assert {call: called[call] for call in promised} == {call: called_then[call] for call in promised}, "a call was repeated"
    in_doubt = called - undisturbed.called
    assert sum(in_doubt.values()) <= 1, "more was done again outside than the one call whose answer was in hand"
    assert set(called) == set(undisturbed.called)
    assert not states(lines), "a process is stranded"
    assert day.export() == undisturbed.export


@pytest.mark.parametrize("name", [name for name in CRASH_POINTS if name.startswith("compaction")])
def test_a_process_that_is_killed_in_compaction_keeps_all_that_is_open_and_owed(
    name: str, compacted: Undisturbed, tmp_path: Path
) -> None:
    assert len(compacted.lines) < compacted.lines[-1].position, "something was given up"
    day = a_day(tmp_path)
    killed = day.live(f"{name}@{(compacted.reached[name] + 1) // 2}", "--compact")
    assert killed.returncode == -signal.SIGKILL, f"{name!r} was not reached: {killed.stderr}"
    at_death, called_then = day.lines(), day.called()
    promised = answered_calls([line for line in at_death if line.position > at_death[0].position])
    still_open = states(at_death)
    assert still_open, "somebody waits at noon"
    resumed = day.live("", "--compact")
    assert resumed.returncode == 0, resumed.stderr
    lines, called = day.lines(), day.called()
    with open_journal(day.journal) as journal:
        report = audit(journal)
    assert report.ok, report.first_offender
    assert {call: called[call] for call in promised} == {call: called_then[call] for call in promised}, "a call was repeated"
    assert called == compacted.called
    assert not states(lines), "a process is stranded"
    # Not the whole export: a mind goes on remembering what it met after its lines were given up; one that begins anew from the
    # journal does not, so what it recalls, and forecasts from that, may differ. How everything ended does not.
    assert ends(lines) == ends(compacted.lines)


def half_a_day_in_schema_1(day: Day, undisturbed: Undisturbed) -> list[Line]:
    """A mind that was killed at noon, its journal in an older schema; returns what that holds."""
    killed = day.live(f"commit: done@{undisturbed.reached['commit: done'] // 2}")
    assert killed.returncode == -signal.SIGKILL
    lines = day.lines()
    put_back_to_schema_1(day.journal)
    return lines


def its_processes_stand_where_they_stood(day: Day, lines: list[Line]) -> None:
    """Recovered in this process, from a copy: every open process has its state and its steps, none begins anew."""
    copy = day.journal.with_name("copy.db")
    copy.write_bytes(day.journal.read_bytes())
    wal = day.journal.with_name(day.journal.name + "-wal")
    if wal.exists():
        copy.with_name(copy.name + "-wal").write_bytes(wal.read_bytes())
    kernel, _ = assemble(small_mind.DOMAIN, MindSettings(step_s=0.4, seed=5), registry=small_mind.registry(day.calls))
    with open_journal(copy) as journal:
        mended = kernel.recover(journal.entries(), journal.state(), JournalBlobs(journal))
    restarted = [line for line in mended.lines if isinstance(line.record, Moved) and line.record.trigger is Trigger.RESTART]
    assert not restarted
    recorded = states([*lines, *mended.lines])
    assert {each.id: (each.state, each.steps) for each in kernel._scheduler.processes} == recorded
    before = states(lines)
    assert all(recorded[process][1] >= steps for process, (_, steps) in before.items() if process in recorded)
