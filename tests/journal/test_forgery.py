"""A journal that a mind wrote, forged in each way that would hide something: the audit names the forgery."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import apsw
import pytest
from click.testing import CliRunner
from msgspec.structs import replace

from tests.journal.forging import lines_in, rewrite
from wakeful.cli.main import main
from wakeful.facts.experience import Verdict
from wakeful.facts.lines import Admitted, AnyRecord, Concluded, Decided, Gained, Judged, Line, Opened, Trusted, Witnessed
from wakeful.journal import open_journal
from wakeful.journal.audit import Audit, audit

#: Enough that some are automatic and some contradicted.
EVENTS = 250


@pytest.fixture(scope="module")
def genuine(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The journal of a simulated robot's first events: contradictions, automatic decisions, and changes of trust."""
    path = tmp_path_factory.mktemp("genuine") / "robot.db"
    result = CliRunner().invoke(main, ["run", "service_robot", "--events", str(EVENTS), "--journal", str(path)])
    assert result.exit_code == 0, result.output
    db = apsw.Connection(str(path))
    db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    db.close()
    return path


@pytest.fixture
def journal(genuine: Path, tmp_path: Path) -> Path:
    return Path(shutil.copy(genuine, tmp_path / "forged.db"))


def audited(path: Path) -> Audit:
    with open_journal(path, read_only=True) as opened:
        return audit(opened)


Forge = Callable[[AnyRecord], AnyRecord]


def forge(path: Path, forged: Forge, most: int = 0) -> int:
    """Rewrite the records that ``forged`` changes, at most so many; returns how many."""
    lines, changed = lines_in(path), 0
    for place, line in enumerate(lines):
        record = forged(line.record)
        if record is not line.record and not (most and changed >= most):
            lines[place] = Line(line.position, line.at_ns, record)
            changed += 1
    rewrite(path, lines)
    return changed


def run_sql(path: Path, *statements: str) -> None:
    db = apsw.Connection(str(path))
    for statement in statements:
        db.execute(statement)
    db.close()


def test_what_the_mind_wrote_passes_and_every_check_looked_at_something(genuine: Path) -> None:
    report = audited(genuine)
    assert report.ok, report.first_offender
    assert [name for name, finding in report.checks.items() if not finding.checked] == []
    with open_journal(genuine, read_only=True) as opened:
        records = [line.record for line in opened.lines()]
    verdicts = {record.verdict for record in records if isinstance(record, Judged)}
    assert {Verdict.SUPPORTED, Verdict.CONTRADICTED} <= verdicts
    assert any(isinstance(record, Decided) and record.decision.mode == "auto" for record in records)
    assert sum(isinstance(record, Trusted) for record in records) > 2


def all_supported(record: AnyRecord) -> AnyRecord:
    """Every contradiction hidden, in verdicts and experiences alike."""
    if isinstance(record, Judged) and record.verdict is Verdict.CONTRADICTED:
        return replace(record, verdict=Verdict.SUPPORTED)
    if isinstance(record, Gained) and record.experience.verdict is Verdict.CONTRADICTED:
        label = record.experience.treatment
        return replace(record, experience=replace(record.experience, verdict=Verdict.SUPPORTED, treatment_label=label))
    return record


def all_as_forecast(record: AnyRecord) -> AnyRecord:
    """Every outcome as it had been forecast, in verdicts and experiences alike."""
    if isinstance(record, Judged) and record.verdict is Verdict.CONTRADICTED:
        return replace(record, verdict=Verdict.SUPPORTED, label=record.predicted)
    if isinstance(record, Gained) and record.experience.verdict is Verdict.CONTRADICTED:
        gained = record.experience
        gained = replace(gained, verdict=Verdict.SUPPORTED, outcome=gained.predicted, treatment_label=gained.treatment)
        return replace(record, experience=gained)
    return record


def contradictions_undecided(record: AnyRecord) -> AnyRecord:
    if isinstance(record, Judged) and record.verdict is Verdict.CONTRADICTED and record.outcome:
        return replace(record, verdict=Verdict.UNDECIDED)
    return record


def another_forecast(record: AnyRecord) -> AnyRecord:
    if isinstance(record, Judged) and record.verdict is Verdict.CONTRADICTED:
        return replace(record, predicted=record.label, verdict=Verdict.SUPPORTED)
    return record


def experience_alone(record: AnyRecord) -> AnyRecord:
    if isinstance(record, Gained):
        return replace(
            record, experience=replace(record.experience, mode="auto" if record.experience.mode == "delib" else "delib")
        )
    return record


def windows_closed_early(record: AnyRecord) -> AnyRecord:
    if isinstance(record, Concluded) and record.closes_ns is not None:
        return replace(record, closes_ns=record.closes_ns + 3600 * 10**9)
    return record


def outcomes_dropped_for_the_window(record: AnyRecord) -> AnyRecord:
    if isinstance(record, Judged) and record.outcome:
        return replace(record, outcome="", label="none", verdict=Verdict.SUPPORTED, predicted="none")
    return record


def outcomes_before_their_events(record: AnyRecord) -> AnyRecord:
    if isinstance(record, Witnessed):
        return replace(record, outcome=replace(record.outcome, at_ns=-(10**15)))
    return record


def automatic_at_any_confidence(record: AnyRecord) -> AnyRecord:
    if isinstance(record, Decided) and record.decision.mode == "auto":
        gate = record.decision.gate
        return replace(record, decision=replace(record.decision, gate=replace(gate, confidence=gate.threshold / 2)))
    return record


def automatic_without_a_gate(record: AnyRecord) -> AnyRecord:
    if isinstance(record, Decided) and record.decision.mode == "delib":
        return replace(record, decision=replace(record.decision, mode="auto"))
    return record


def results_said_to_be_automatic(record: AnyRecord) -> AnyRecord:
    if isinstance(record, Concluded) and record.mode == "delib":
        return replace(record, mode="auto")
    return record


def results_of_another_treatment(record: AnyRecord) -> AnyRecord:
    if isinstance(record, Concluded) and record.treatment:
        return replace(record, treatment="another")
    return record


def trust_regained_in_between(record: AnyRecord) -> AnyRecord:
    if isinstance(record, Trusted):
        return replace(record, before=0.99)
    return record


def events_under_other_ids(record: AnyRecord) -> AnyRecord:
    if isinstance(record, Admitted):
        return replace(record, event=replace(record.event, kind=record.event.kind + "x"))
    return record


def another_source(record: AnyRecord) -> AnyRecord:
    return replace(record, digest="another") if isinstance(record, Opened) else record


FORGERIES: dict[str, list[Forge]] = {
    "verdicts": [
        all_supported,
        all_as_forecast,
        contradictions_undecided,
        another_forecast,
        experience_alone,
        windows_closed_early,
        outcomes_dropped_for_the_window,
        outcomes_before_their_events,
    ],
    "gates": [
        automatic_at_any_confidence,
        automatic_without_a_gate,
        results_said_to_be_automatic,
        results_of_another_treatment,
    ],
    "trust": [trust_regained_in_between],
    "identities": [events_under_other_ids, another_source],
}


@pytest.mark.parametrize(
    ("check", "forged"),
    [(check, each) for check, each_of in FORGERIES.items() for each in each_of],
    ids=lambda each: each if isinstance(each, str) else each.__name__,
)
def test_a_forgery_is_named(journal: Path, check: str, forged: Forge) -> None:
    assert forge(journal, forged)
    report = audited(journal)
    assert not report.checks[check].ok
    assert not report.ok


@pytest.mark.parametrize("forged", [all_supported, all_as_forecast, contradictions_undecided])
def test_one_forged_line_is_enough(journal: Path, forged: Forge) -> None:
    assert forge(journal, forged, most=1) == 1
    assert audited(journal).checks["verdicts"].count >= 1


def test_a_journal_whose_end_was_cut_off_is_not_whole(journal: Path) -> None:
    rewrite(journal, lines_in(journal)[:-40])
    report = audited(journal)
    assert not report.checks["whole"].ok
    assert "the last commit ended at" in str(report.checks["whole"].first_offender)


def test_a_line_beyond_the_last_commit_is_not_whole(journal: Path) -> None:
    lines = lines_in(journal)
    rewrite(journal, [*lines, Line(lines[-1].position + 1, lines[-1].at_ns, lines[-1].record)])
    assert not audited(journal).checks["whole"].ok


def test_a_tail_cut_off_with_its_commits_is_found_by_what_was_offered(journal: Path) -> None:
    lines = lines_in(journal)
    keep = len(lines) // 2
    db = apsw.Connection(str(journal))
    ((keep,),) = db.execute("SELECT max(last) FROM commits WHERE last <= ?", (keep,)).fetchall()
    db.close()
    rewrite(journal, lines[:keep])
    run_sql(journal, f"DELETE FROM commits WHERE last > {keep}")
    report = audited(journal)
    assert report.checks["whole"].ok
    assert not report.checks["offered"].ok


def test_an_event_that_was_never_written_is_found_by_what_was_offered(journal: Path) -> None:
    run_sql(
        journal,
        f"""UPDATE state SET value = CAST(json_set(CAST(value AS TEXT), '$.sources.service_robot.offered', {EVENTS + 1}) AS BLOB)
        WHERE key = 'kernel'""",
    )
    found = audited(journal).checks["offered"]
    assert not found.ok
    assert found.first_offender is not None
    assert found.first_offender.says == f"{EVENTS + 1} inputs were offered, but {EVENTS} became a line of the intake"


def test_a_journal_without_that_count_says_that_it_was_not_looked_at(journal: Path) -> None:
    run_sql(
        journal,
        """UPDATE state SET value = CAST(json_remove(CAST(value AS TEXT), '$.sources.service_robot.offered') AS BLOB)
        WHERE key = 'kernel'""",
    )
    found = audited(journal).checks["offered"]
    assert (found.ok, found.checked) == (True, 0)
    assert "not counted" in found.skipped
