"""Compaction: what is old and owed nothing becomes counts; all else is as it was, whenever the process is killed."""

from __future__ import annotations

import random
from pathlib import Path

import apsw
import pytest

from tests.journal.builder import Book
from wakeful.contracts.journal import JournalError
from wakeful.facts.crash_points import CRASH_POINTS, armed
from wakeful.facts.lines import Acted, Admitted, Compacted, Concluded, Created, Duplicate, Gained, Line, Published, Trusted
from wakeful.facts.processes import Trigger
from wakeful.journal import SqliteJournal, open_journal
from wakeful.journal.audit import audit
from wakeful.journal.compaction import ages, compactor
from wakeful.journal.debt import debt
from wakeful.journal.history import history
from wakeful.journal.readable import event_of, process_of
from wakeful.journal.retention import KEEP_ALL, Retention
from wakeful.testing.faulty_disk import FaultyDisk

EVENTS = 300
SMALL = Retention(days=0.0, events=60, megabytes=0, least=40)
OPEN, OWED = 0.04, 0.07


@pytest.fixture(autouse=True)
def _in_small_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ages, "_EVENTS", 10)
    monkeypatch.setattr(compactor, "_ROWS_PER_STEP", 3)
    monkeypatch.setattr(compactor, "_LINES_PER_STEP", 100)


def book(seed: int = 1, events: int = EVENTS) -> Book:
    """Most events are treated and judged, some are open or in debt; some decisions rest on experience; a model was published."""
    draw = random.Random(seed)
    written = Book()
    trust, gained = 0.8, 0
    for number in range(events):
        written.wait(1.0)
        fate = draw.random()
        rests_on = (draw.randint(1, gained),) if gained > 5 and fate < OWED else ()
        process = written.admit(mode="fallback" if OPEN <= fate < OWED else "delib", rests_on=rests_on)
        if fate < OPEN:
            if fate < OPEN / 2:
                written.move(process, Trigger.DISPATCH)
                written.ask(process, within_s=1e6)
            continue
        written.run_through(process)
        written.wait(1.0)
        outcome = written.witness(draw.choice(["none", "stop"]))
        label = next(line.record.outcome.label for line in reversed(written.written) if hasattr(line.record, "outcome"))
        gained = written.judge(process, "none", label, outcome)
        after = round(draw.random(), 3)
        written.write(Trusted(treatment="diagnosis", before=trust, after=after, why="judged", experience=gained))
        trust = after
        if draw.random() < 0.05:
            written.write(Duplicate(event=written.event_of(process), source="arm.xlsx", position=3))
        if number == EVENTS // 10:
            written.train(1, 0, 1)
            written.write(Acted(who="ann", act="hold", process=process, why="looks odd"))
    return written


def fill(journal: SqliteJournal, written: Book) -> None:
    for start in range(journal.last, len(written.written), 37):
        journal.commit(written.written[start : start + 37], {}, written.blobs if not start else {})


@pytest.fixture(scope="module")
def written() -> Book:
    return book()


@pytest.fixture
def compacted(tmp_path: Path, written: Book) -> SqliteJournal:
    journal = open_journal(tmp_path / "mind.db", full_sync=False, retention=SMALL)
    fill(journal, written)
    tidy(journal)
    return journal


def tidy(journal: SqliteJournal) -> None:
    while journal.tidy(1):
        pass


def counts(journal: SqliteJournal) -> tuple[object, ...]:
    db = apsw.Connection(str(journal.path), flags=apsw.SQLITE_OPEN_READONLY)
    (row,) = db.execute("SELECT received, admitted, duplicate, refused FROM conservation").fetchall()
    db.close()
    return row


def of_events(lines: list[Line], events: set[str]) -> list[Line]:
    """Their lines, but for what came again of them: a duplicate is only counted."""
    processes = {line.record.process for line in lines if isinstance(line.record, Created) and line.record.event in events}
    own = [line for line in lines if event_of(line.record) in events or process_of(line.record) in processes]
    return [line for line in own if not isinstance(line.record, Duplicate)]


def owed_events(lines: list[Line], written: Book) -> set[str]:
    """The open events, those in debt, the one that was acted on, and those whose experience the decisions of these rest on."""
    read = history(written)
    kept = {row.id for row in debt(read)} | {process.event for process in read.processes.values() if process.open}
    kept |= {read.processes[line.record.process].event for line in lines if isinstance(line.record, Acted)}
    decisions = [each for process in read.processes.values() if process.event in kept for each in process.decisions]
    rest = {id_ for decision in decisions for id_ in decision.rests_on}
    gained = [line.record.experience for line in lines if isinstance(line.record, Gained)]
    return kept | {experience.event for experience in gained if experience.id in rest}


def test_what_is_owed_is_kept_line_by_line_and_little_else(compacted: SqliteJournal, written: Book) -> None:
    lines = list(compacted.lines())
    owed = owed_events(written.written, written)
    assert len(owed) > 15
    assert of_events(lines, owed) == of_events(written.written, owed)
    admitted = {line.record.event.id for line in lines if isinstance(line.record, Admitted)}
    newest = [line.record.event.id for line in written.written if isinstance(line.record, Admitted)][-60:]
    assert admitted >= set(newest)
    assert len(admitted - owed) <= 60 + 10
    assert any(isinstance(line.record, Compacted) for line in lines)


def test_every_line_that_is_left_is_as_it_was_and_every_position_is_accounted_for(
    compacted: SqliteJournal, written: Book
) -> None:
    position = 0
    for line in compacted.lines():
        if isinstance(line.record, Compacted):
            assert line.record.first == position + 1
            gone = written.written[line.record.first - 1 : line.position]
            assert len(gone) == line.record.lines
            assert line.record.admitted == sum(isinstance(each.record, Admitted) for each in gone)
            assert line.at_ns == gone[-1].at_ns
        else:
            assert line == written.written[line.position - 1]
            assert line.position == position + 1
        position = line.position
    assert position == len(written.written)


def test_the_audit_is_clean_and_the_sums_are_what_they_were(compacted: SqliteJournal, tmp_path: Path, written: Book) -> None:
    with open_journal(tmp_path / "whole.db", retention=KEEP_ALL) as whole:
        fill(whole, written)
        tidy(whole)
        assert list(whole.lines()) == written.written
        assert counts(compacted) == counts(whole)
        assert audit(whole).ok
    report = audit(compacted)
    assert report.ok, report.first_offender


def test_models_acts_and_the_last_change_of_trust_are_kept(compacted: SqliteJournal, written: Book) -> None:
    for kind in (Published, Acted):
        own = [line for line in written.written if isinstance(line.record, kind)]
        assert [line for line in compacted.lines() if isinstance(line.record, kind)] == own
    trusted = [line for line in compacted.lines() if isinstance(line.record, Trusted)]
    assert trusted[-1].record.after == next(
        line.record.after for line in reversed(written.written) if isinstance(line.record, Trusted)
    )


def test_what_is_kept_is_found_by_event_process_and_kind(compacted: SqliteJournal, written: Book) -> None:
    owed = sorted(owed_events(written.written, written))
    for event in owed[:5]:
        own = [line for line in of_events(written.written, {event}) if event_of(line.record) == event]
        assert [line for line in compacted.lines_of(event=event) if not isinstance(line.record, Duplicate)] == own
    concluded = [line for line in compacted.lines() if isinstance(line.record, Concluded)]
    assert list(compacted.lines_of(kinds=("concluded",))) == concluded


def test_reading_goes_on_after_any_position(compacted: SqliteJournal) -> None:
    lines = list(compacted.lines())
    for after in range(0, lines[-1].position + 1, 7):
        assert list(compacted.lines(after)) == [line for line in lines if line.position > after]


def test_a_later_round_gives_up_what_has_closed_since(compacted: SqliteJournal, written: Book) -> None:
    before = {line.record.event.id for line in compacted.lines() if isinstance(line.record, Admitted)}
    longer = book(events=2 * EVENTS)
    assert longer.written[: len(written.written)] == written.written
    for process in [process.id for process in history(written).processes.values() if process.open]:
        longer.move(process, Trigger.MOOT)
    fill(compacted, longer)
    tidy(compacted)
    after = {line.record.event.id for line in compacted.lines() if isinstance(line.record, Admitted)}
    gone_before = {line.record.event.id for line in written.written if isinstance(line.record, Admitted)} - before
    assert owed_events(longer.written, longer) - gone_before <= after
    assert len(before - after) > 50
    assert audit(compacted).ok, audit(compacted).first_offender


def test_a_journal_that_is_opened_again_goes_on_with_it(tmp_path: Path, written: Book) -> None:
    with open_journal(tmp_path / "mind.db", retention=KEEP_ALL) as journal:
        fill(journal, written)
    with open_journal(tmp_path / "mind.db", retention=SMALL) as journal:
        tidy(journal)
        again = list(journal.lines())
        assert len(again) < len(written.written) / 2
        assert audit(journal).ok
    with open_journal(tmp_path / "mind.db", retention=SMALL) as journal:
        tidy(journal)
        assert list(journal.lines()) == again


class _Killed(BaseException):
    """The process is gone: nobody cleans up."""


def test_every_crash_point_of_compaction_is_tried() -> None:
    assert {name for name in CRASH_POINTS if name.startswith("compaction:")} == {name for name, _ in KILLS}


#: Once in a round are its rows made the journal's; many times are some put beside the old ones.
KILLS = [(f"compaction: {place}", nth) for place, nth in (("begun", 1), ("begun", 4), ("rows replaced", 1), ("done", 1))]


@pytest.mark.parametrize(("place", "nth"), KILLS)
def test_killed_at_any_instant_it_is_whole_and_goes_on(tmp_path: Path, written: Book, place: str, nth: int) -> None:
    left = nth

    def kill(reached: str) -> None:
        nonlocal left
        left -= reached == place
        if not left:
            raise _Killed

    with FaultyDisk() as disk:
        journal = open_journal(tmp_path / "mind.db", retention=SMALL, vfs=disk.name)
        fill(journal, written)
        with pytest.raises(_Killed), armed(kill):
            tidy(journal)
        disk.cut_power()
        with pytest.raises(JournalError):
            journal.close()
        disk.restore_power("none")
    with open_journal(tmp_path / "mind.db", retention=SMALL) as journal:
        assert audit(journal).ok, audit(journal).first_offender
        tidy(journal)
        owed = owed_events(written.written, written)
        assert of_events(list(journal.lines()), owed) == of_events(written.written, owed)
        assert audit(journal).ok


def test_a_full_disk_stops_compaction_and_nothing_else(tmp_path: Path, written: Book) -> None:
    with FaultyDisk() as disk, open_journal(tmp_path / "mind.db", retention=SMALL, vfs=disk.name) as journal:
        fill(journal, written)
        disk.fail("broken")
        with pytest.raises(JournalError, match="could not be compacted"):
            tidy(journal)
        disk.mend()
        assert list(journal.lines()) == written.written
        tidy(journal)
        assert audit(journal).ok


def test_pages_are_given_back_to_the_disk(tmp_path: Path) -> None:
    large = book(events=2_000)
    with open_journal(tmp_path / "mind.db", full_sync=False, retention=KEEP_ALL) as journal:
        fill(journal, large)
    whole_bytes = (tmp_path / "mind.db").stat().st_size
    with open_journal(tmp_path / "mind.db", full_sync=False, retention=SMALL) as journal:
        tidy(journal)
    assert (tmp_path / "mind.db").stat().st_size < whole_bytes / 3


@pytest.mark.parametrize(
    ("retention", "kept"),
    [
        (Retention(days=0.0, events=0, megabytes=0, least=0), EVENTS),
        (Retention(days=0.0, events=100, megabytes=0, least=0), 100),
        (Retention(days=0.0, events=100, megabytes=0, least=200), 200),
        (Retention(days=100.0 / 86_400, events=0, megabytes=0, least=10), 50),
        (Retention(days=0.0, events=0, megabytes=1, least=150), 150),
    ],
)
def test_each_limit_keeps_what_it_says(retention: Retention, kept: int) -> None:
    known = ages.Ages()
    for number in range(EVENTS):
        known.add(10 * (number + 1), number * 2_000_000_000, 1)
    boundary = known.boundary(retention, used_bytes=10_000_000, least_events=1)
    assert EVENTS - boundary // 10 - kept in range(11)
