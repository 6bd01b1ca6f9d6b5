"""An event whose treatment ends the process every time is quarantined as debt after three tries, while the others go on."""

from __future__ import annotations

import asyncio
import signal
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from wakeful.cli.main import main as wakeful
from wakeful.contracts.journal import JournalError
from wakeful.drivers.poison import CrashMark, marked, take_up
from wakeful.facts.crashes import CRASHED, QUARANTINED, mark
from wakeful.facts.inputs import Call
from wakeful.facts.lines import Line, Noted
from wakeful.journal import MemoryJournal, open_journal
from wakeful.journal.audit import audit
from wakeful.journal.debt import debt
from wakeful.journal.views import History, history

CHILD = [sys.executable, str(Path(__file__).with_name("poisoned.py"))]
EVENTS = 20


def start(driver: str, way: str, journal: Path) -> int:
    """Run the child to its end; returns its code."""
    done = subprocess.run([*CHILD, driver, way, str(journal)], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode in (0, -signal.SIGKILL, -signal.SIGSEGV), done.stderr
    return done.returncode


def read(journal: Path) -> History:
    with open_journal(journal, read_only=True) as opened:
        report = audit(opened)
        assert report.ok, report
        return history(opened)


def check_quarantined(journal: Path) -> None:
    past = read(journal)
    ends = {each.event.entity: past.root(each.event.id) for each in past.events.values()}
    assert len(ends) == EVENTS
    poison = ends.pop("poison")
    assert Counter(str(process.end) for process in ends.values() if process) == {"resolved": EVENTS - 1}
    assert poison is not None
    assert str(poison.end) == "unresolved"
    assert [note.what for _, note in past.noted].count(CRASHED) == 3
    assert QUARANTINED in [note.what for note in poison.notes]
    assert [(row.entity, row.because) for row in debt(past)] == [("poison", "quarantined")]


@pytest.mark.parametrize(
    ("driver", "way"),
    [
        ("run", "kill"),
        ("run", "segfault"),
        ("run", "in-call"),
        ("mind", "at-once"),
        ("mind", "later-in-call"),
        ("live", "kill"),
        ("live", "at-once"),
        ("live", "later-in-call"),
    ],
)
def test_an_event_whose_treatment_kills_the_process_is_quarantined_after_three_tries(
    driver: str, way: str, tmp_path: Path
) -> None:
    journal = tmp_path / "mind.db"
    codes = [start(driver, way, journal)]
    while codes[-1] and len(codes) < 7:
        codes.append(start(driver, way, journal))
    assert codes[-1] == 0, "it still ends every run"
    past = read(journal)
    crashes = [note for _, note in past.noted if note.what == CRASHED]
    # A mind that is called, and a live one, may be offered the event anew before it was ever durable: that crash is recorded
    # under an identity that nobody has any more, and from then on events are durable before their treatment runs.
    unnamed = [note for note in crashes if note.event not in past.events]
    assert len(unnamed) <= (driver != "run")
    assert len(crashes) - len(unnamed) in (3, 3 + len(unnamed))
    poison = next(each for each in past.events.values() if each.event.entity == "poison")
    process = past.root(poison.event.id)
    assert process is not None
    assert str(process.end) == "unresolved"
    assert [(row.entity, row.because) for row in debt(past)] == [("poison", "quarantined")]
    others = [past.root(each.event.id) for each in past.events.values() if each is not poison]
    assert Counter(str(each.end) for each in others if each) == {"resolved": EVENTS - 1}


@pytest.mark.parametrize(("driver", "way"), [("run", "spin"), ("live", "spin-in-call")])
def test_an_event_whose_treatment_never_awaits_is_quarantined_by_the_watchdogs_kills(
    driver: str, way: str, tmp_path: Path
) -> None:
    journal = tmp_path / "mind.db"
    watch = [sys.executable, "-m", "wakeful", "watch", "--stall-s", "4", "--backoff-s", "0.01", "--"]
    done = subprocess.run([*watch, *CHILD, driver, way, str(journal)], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("stalled") >= 3
    assert "in poison" in done.stderr
    past = read(journal)
    assert [(row.entity, row.because) for row in debt(past)] == [("poison", "quarantined")]
    ends = Counter(str(process.end) for _, process in past.roots())
    assert ends == {"resolved": EVENTS - 1, "unresolved": 1}


def test_what_was_quarantined_is_told_by_status_debt_and_why(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    journal = tmp_path / "mind.db"
    while start("run", "kill", journal):
        pass
    check_quarantined(journal)
    event = debt(read(journal))[0].id
    for command in (["status"], ["debt"], ["why", event]):
        with pytest.raises(SystemExit) as ended:
            wakeful([*command, "--journal", str(journal)])
        assert ended.value.code == 0
        assert "uarantined" in capsys.readouterr().out, command


def test_a_quarantined_event_that_is_reopened_has_its_tries_again(tmp_path: Path) -> None:
    journal = tmp_path / "mind.db"
    while start("run", "kill", journal):
        pass
    process = debt(read(journal))[0].process
    reopen = ["reopen", str(process), "--who", "ann", "--why", "mended", "--journal", str(journal)]
    with pytest.raises(SystemExit) as ended:
        wakeful(reopen)
    assert ended.value.code == 0
    assert start("run", "mended", journal) == 0
    past = read(journal)
    assert debt(past) == []
    assert [str(each.end) for each in past.processes.values() if each.reopens == process] == ["resolved"]


def test_a_run_killed_from_outside_between_steps_blames_nobody(tmp_path: Path) -> None:
    crash_mark = CrashMark(tmp_path / "mind.db")
    crash_mark.begin()
    mark(crash_mark.page, "0123456789abcdef0123")
    crash_mark.page[0] = 0
    assert CrashMark(tmp_path / "mind.db").left() is None


def test_a_crash_is_recorded_once_for_each_run_even_if_recording_it_is_interrupted(tmp_path: Path) -> None:
    crash_mark, journal = CrashMark(tmp_path / "mind.db"), MemoryJournal()
    journal.commit([Line(1, 7, Noted(what="before", detail=""))], {}, {})
    crash_mark.begin()
    mark(crash_mark.page, "0123456789abcdef0123")
    left = CrashMark(tmp_path / "mind.db").left()
    assert left is not None
    assert take_up(CrashMark(tmp_path / "mind.db"), journal) == left
    assert [(line.position, line.at_ns, line.record) for line in journal.lines(1)] == [
        (2, 7, Noted(what=CRASHED, detail=left.run, event="0123456789abcdef0123"))
    ]
    assert take_up(CrashMark(tmp_path / "mind.db"), journal) is None


def test_a_mark_from_before_the_machine_restarted_is_not_trusted(tmp_path: Path) -> None:
    crash_mark = CrashMark(tmp_path / "mind.db")
    crash_mark.begin()
    mark(crash_mark.page, "0123456789abcdef0123")
    content = bytearray((tmp_path / "mind.db.running").read_bytes())
    content[-36:] = b"another-boot".ljust(36)
    (tmp_path / "mind.db.running").write_bytes(content)
    assert CrashMark(tmp_path / "mind.db").left() is None


def test_a_mark_is_for_its_owner_only_and_follows_no_link(tmp_path: Path) -> None:
    CrashMark(tmp_path / "mind.db")
    assert (tmp_path / "mind.db.running").stat().st_mode & 0o777 == 0o600
    (tmp_path / "other.db.running").symlink_to(tmp_path / "mind.db.running")
    with pytest.raises(JournalError, match="cannot be written"):
        CrashMark(tmp_path / "other.db")


def test_a_marked_call_gives_what_the_call_gives_and_is_marked_only_while_its_code_runs(tmp_path: Path) -> None:
    crash_mark = CrashMark(tmp_path / "mind.db")
    seen: list[bool] = []

    async def function() -> int:
        seen.append(crash_mark.left() is not None)
        await asyncio.sleep(0)
        seen.append(crash_mark.left() is not None)
        return 5

    async def main() -> object:
        crash_mark.begin()
        call = Call(process=3, seq=1, asked_ns=0, expires_ns=1, function=function, key="0123456789abcdef0123/3/1")
        running = asyncio.ensure_future(marked(call, crash_mark).function())  # type: ignore[misc, arg-type]
        await asyncio.sleep(0)
        seen.append(crash_mark.left() is not None)
        return await running

    assert asyncio.run(main()) == 5
    assert seen == [True, False, True]


def test_a_cancelled_marked_call_is_cancelled_inside(tmp_path: Path) -> None:
    crash_mark = CrashMark(tmp_path / "mind.db")
    ended: list[str] = []

    async def function() -> None:
        try:
            await asyncio.sleep(60)
        except asyncio.CancelledError:
            ended.append("cancelled")
            raise

    async def main() -> None:
        crash_mark.begin()
        call = Call(process=3, seq=1, asked_ns=0, expires_ns=1, function=function, key="e/3/1")
        running = asyncio.ensure_future(marked(call, crash_mark).function())  # type: ignore[misc, arg-type]
        await asyncio.sleep(0)
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)

    asyncio.run(main())
    assert ended == ["cancelled"]
    assert crash_mark.left() is None
