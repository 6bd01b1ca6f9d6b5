"""Every audit check passes on legal lines and fails on lines corrupted in its own way."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise

import pytest
from hypothesis import given, settings
from msgspec.structs import replace

from tests.journal.builder import Book, full_book, raw
from tests.journal.strategies import any_lines
from wakeful.contracts.journal import JournalError
from wakeful.facts.asking import Kind
from wakeful.facts.experience import Verdict
from wakeful.facts.lines import (
    Admitted,
    Answered,
    AnyRecord,
    Asked,
    Concluded,
    Created,
    Decided,
    Duplicate,
    Gained,
    Judged,
    Line,
    Moved,
    Opened,
    Published,
    Refused,
    TrainingAsked,
    Trusted,
    Witnessed,
)
from wakeful.facts.processes import State, Trigger
from wakeful.journal.audit import CHECKS, audit


class Pages:
    """A journal of given lines."""

    def __init__(self, lines: list[Line]) -> None:
        self._lines = lines

    def lines(self, after: int = 0) -> Iterator[Line]:
        return iter(self._lines[after:])


def test_a_legal_journal_passes_every_check_and_every_check_looked_at_something() -> None:
    report = audit(full_book())
    assert report.ok, report.first_offender
    assert [name for name, finding in report.checks.items() if not finding.checked] == []


def test_an_empty_journal_is_in_order() -> None:
    assert audit(Pages([])).ok


def test_an_open_end_is_legal_at_every_instant_of_a_run() -> None:
    lines = list(full_book().lines())
    instants = [index for index, (line, following) in enumerate(pairwise(lines), 1) if line.at_ns != following.at_ns]
    for index in instants:
        report = audit(Pages(lines[:index]))
        assert report.ok, (index, report.first_offender)


Corrupt = Callable[[list[Line]], list[Line]]


def first(lines: list[Line], record: type[AnyRecord], /, **having: object) -> int:
    """The index of the first record of that kind with those values."""
    return next(
        index
        for index, line in enumerate(lines)
        if isinstance(line.record, record) and all(getattr(line.record, name) == value for name, value in having.items())
    )


def without(index: int, lines: list[Line]) -> list[Line]:
    """The lines less one, positions counted anew, so that only the intended rule is broken."""
    return renumbered(lines[:index] + lines[index + 1 :])


def renumbered(lines: list[Line]) -> list[Line]:
    return [Line(position, line.at_ns, line.record) for position, line in enumerate(lines, 1)]


def changed(lines: list[Line], index: int, **values: object) -> list[Line]:
    line = lines[index]
    return [*lines[:index], Line(line.position, line.at_ns, replace(line.record, **values)), *lines[index + 1 :]]


def inserted(lines: list[Line], index: int, record: AnyRecord) -> list[Line]:
    return renumbered([*lines[:index], Line(0, lines[index - 1].at_ns, record), *lines[index:]])


def _gap(lines: list[Line]) -> list[Line]:
    return [line for line in lines if line.position != 5]


def _time_runs_back(lines: list[Line]) -> list[Line]:
    last = lines[-1]
    return [*lines[:-1], Line(last.position, 0, last.record)]


def _admitted_twice(lines: list[Line]) -> list[Line]:
    admitted = lines[first(lines, Admitted)].record
    again = first(lines, Duplicate)
    return [*lines[:again], Line(lines[again].position, lines[again].at_ns, admitted), *lines[again + 1 :]]


def _duplicate_of_nothing(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, Duplicate), event="f" * 20)


def _refused_without_reason(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, Refused), reason="")


def _refused_though_admitted(lines: list[Line]) -> list[Line]:
    admitted = lines[first(lines, Admitted)].record
    assert isinstance(admitted, Admitted)
    return changed(lines, first(lines, Refused), event=admitted.event.id)


def _never_created(lines: list[Line]) -> list[Line]:
    return without(first(lines, Created, process=len([line for line in lines if isinstance(line.record, Created)])), lines)


def _never_decided(lines: list[Line]) -> list[Line]:
    last = max(line.record.process for line in lines if isinstance(line.record, Decided))
    return without(first(lines, Decided, process=last), lines)


def _abandoned(lines: list[Line]) -> list[Line]:
    last = max(line.record.process for line in lines if isinstance(line.record, Created))
    moved = Moved(process=last, before=State.CREATED, trigger=Trigger.ABANDON, after=State.COMPLETED)
    return inserted(lines, len(lines), moved)


def _illegal_transition(lines: list[Line]) -> list[Line]:
    last = max(line.record.process for line in lines if isinstance(line.record, Created))
    moved = Moved(process=last, before=State.CREATED, trigger=Trigger.WAKE, after=State.SUSPENDED)
    return inserted(lines, len(lines), moved)


def _wrong_before(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, Moved, trigger=Trigger.PREEMPT), before=State.SUSPENDED)


def _lost_steps(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, Moved, process=1, trigger=Trigger.DISPATCH), steps=100)


def _created_twice(lines: list[Line]) -> list[Line]:
    index = first(lines, Created)
    return inserted(lines, index + 1, lines[index].record)


def _orphan(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, Created, parent=1), parent=99)


def _reopens_the_open(lines: list[Line]) -> list[Line]:
    last = max(line.record.process for line in lines if isinstance(line.record, Created))
    return changed(lines, first(lines, Created, reopens=1), reopens=last)


def _no_result(lines: list[Line]) -> list[Line]:
    return without(first(lines, Concluded, process=2), lines)


def _concluded_twice(lines: list[Line]) -> list[Line]:
    index = first(lines, Concluded)
    return inserted(lines, index + 1, lines[index].record)


def _wait_without_limit(lines: list[Line]) -> list[Line]:
    last = max(index for index, line in enumerate(lines) if isinstance(line.record, Asked))
    return changed(lines, last, expires_ns=None)


def _wait_without_request(lines: list[Line]) -> list[Line]:
    return without(max(index for index, line in enumerate(lines) if isinstance(line.record, Asked)), lines)


def _wait_past_its_limit(lines: list[Line]) -> list[Line]:
    last = lines[-1]
    return [*lines[:-1], Line(last.position, last.at_ns + 600_000_000_000, last.record)]


def _answer_without_request(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, Answered), seq=77)


def _answer_under_another_request(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, Answered, kind=Kind.DELIBERATE), kind=Kind.EVIDENCE)


def _asked_by_nobody(lines: list[Line]) -> list[Line]:
    return inserted(lines, 1, Asked(process=50, seq=1, kind=Kind.CALL, key="k", expires_ns=1))


def _answered_twice(lines: list[Line]) -> list[Line]:
    index = first(lines, Answered)
    return inserted(lines, index + 1, lines[index].record)


def _asked_again(lines: list[Line]) -> list[Line]:
    index = first(lines, Answered)
    return inserted(lines, index + 1, lines[first(lines, Asked)].record)


def _judged_on_another_forecast(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, Judged), predicted="protective_stop")


def _judged_by_an_outcome_that_never_came(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, Judged), outcome="o999")


def _judged_before_it_concluded(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, Judged), process=40)


def _experience_from_nowhere(lines: list[Line]) -> list[Line]:
    index = first(lines, Gained)
    record = lines[index].record
    assert isinstance(record, Gained)
    return changed(lines, index, experience=replace(record.experience, process=40))


def _experience_unlike_its_verdict(lines: list[Line]) -> list[Line]:
    index = first(lines, Gained)
    record = lines[index].record
    assert isinstance(record, Gained)
    return changed(lines, index, experience=replace(record.experience, outcome="none"))


def _experience_lost(lines: list[Line]) -> list[Line]:
    return without(first(lines, Gained), lines)


def _model_from_nowhere(lines: list[Line]) -> list[Line]:
    return without(first(lines, TrainingAsked), lines)


def _model_other_than_asked(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, TrainingAsked), seed=99)


def _training_from_an_unknown_base(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, TrainingAsked), base=7)


def _training_from_the_future(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, TrainingAsked), watermark=1000)


def _decided_by_a_rejected_model(lines: list[Line]) -> list[Line]:
    index = first(lines, Published)
    record = lines[index].record
    assert isinstance(record, Published)
    return changed(lines, index, card=replace(record.card, accepted=False))


def _version_without_weights(lines: list[Line]) -> list[Line]:
    index = first(lines, Published)
    record = lines[index].record
    assert isinstance(record, Published)
    return changed(lines, index, card=replace(record.card, blob=""))


def _version_twice(lines: list[Line]) -> list[Line]:
    index = first(lines, Published, training=2)
    record = lines[index].record
    assert isinstance(record, Published)
    return changed(lines, index, card=replace(record.card, version=1))


def _another_id(lines: list[Line]) -> list[Line]:
    index = first(lines, Admitted)
    record = lines[index].record
    assert isinstance(record, Admitted)
    return changed(lines, index, event=replace(record.event, id="0" * 20))


def _from_a_source_never_opened(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, Opened), source="elsewhere")


def _automatic_below(**numbers: float) -> Corrupt:
    def corrupt(lines: list[Line]) -> list[Line]:
        index = next(
            index for index, line in enumerate(lines) if isinstance(line.record, Decided) and line.record.decision.mode == "auto"
        )
        decision = lines[index].record.decision  # type: ignore[union-attr]
        return changed(lines, index, decision=replace(decision, gate=replace(decision.gate, **numbers)))

    corrupt.__name__ = f"automatic_with_{next(iter(numbers))}_{next(iter(numbers.values()))}"
    return corrupt


def _concluded_in_another_mode(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, Concluded), mode="auto")


def _concluded_by_another_treatment(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, Concluded), treatment="comparison")


def _trust_from_elsewhere(lines: list[Line]) -> list[Line]:
    index = first(lines, Trusted)
    return inserted(lines, index + 1, lines[index].record)


def _trust_out_of_bounds(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, Trusted), after=1.5)


def _trust_for_no_experience(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, Trusted), experience=99)


def _another_verdict(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, Judged), verdict=Verdict.SUPPORTED)


def _another_label_than_the_outcomes(lines: list[Line]) -> list[Line]:
    return changed(lines, first(lines, Judged), label="none", verdict=Verdict.SUPPORTED)


def _by_an_outcome_before_the_event(lines: list[Line]) -> list[Line]:
    index = first(lines, Witnessed)
    return changed(lines, index, outcome=replace(lines[index].record.outcome, at_ns=0))  # type: ignore[union-attr]


def _by_its_window_before_it_closed(lines: list[Line]) -> list[Line]:
    index = first(lines, Judged, outcome="")
    process = lines[index].record.process  # type: ignore[union-attr]
    return changed(lines, first(lines, Concluded, process=process), closes_ns=10**15)


def _by_its_window_after_an_outcome(lines: list[Line]) -> list[Line]:
    index = first(lines, Judged)
    record = lines[index].record
    return inserted(lines, len(lines), replace(record, outcome="", label="none", verdict=Verdict.SUPPORTED))


def _experience_of_another_mode(lines: list[Line]) -> list[Line]:
    index = first(lines, Gained)
    return changed(lines, index, experience=replace(lines[index].record.experience, mode="auto"))  # type: ignore[union-attr]


CORRUPTIONS: dict[str, list[Corrupt]] = {
    "positions": [_gap],
    "time": [_time_runs_back],
    "conservation": [_admitted_twice, _duplicate_of_nothing, _refused_without_reason, _refused_though_admitted],
    "identities": [_another_id, _from_a_source_never_opened],
    "gates": [
        _automatic_below(confidence=0.1),
        _automatic_below(novelty=0.99),
        _automatic_below(trust=0.1),
        _automatic_below(confidence=float("nan")),
        _concluded_in_another_mode,
        _concluded_by_another_treatment,
    ],
    "trust": [_trust_from_elsewhere, _trust_out_of_bounds, _trust_for_no_experience],
    "coverage": [_never_created, _never_decided],
    "abandoned": [_abandoned],
    "transitions": [_illegal_transition, _wrong_before, _lost_steps, _created_twice, _orphan, _reopens_the_open],
    "results": [_no_result, _concluded_twice],
    "wake-ups": [_wait_without_limit, _wait_without_request, _wait_past_its_limit, _never_decided],
    "answers": [_answer_without_request, _answer_under_another_request, _asked_by_nobody],
    "repeats": [_answered_twice, _asked_again],
    "verdicts": [
        _judged_on_another_forecast,
        _judged_by_an_outcome_that_never_came,
        _judged_before_it_concluded,
        _experience_from_nowhere,
        _experience_unlike_its_verdict,
        _experience_lost,
        _another_verdict,
        _another_label_than_the_outcomes,
        _by_an_outcome_before_the_event,
        _by_its_window_before_it_closed,
        _by_its_window_after_an_outcome,
        _experience_of_another_mode,
    ],
    "lineage": [
        _model_from_nowhere,
        _model_other_than_asked,
        _training_from_an_unknown_base,
        _training_from_the_future,
        _decided_by_a_rejected_model,
        _version_without_weights,
        _version_twice,
    ],
}


@pytest.mark.parametrize(
    ("check", "corrupt"),
    [(check, corrupt) for check, ways in CORRUPTIONS.items() for corrupt in ways],
    ids=lambda way: way if isinstance(way, str) else way.__name__.strip("_"),
)
def test_a_corruption_fails_its_own_check(check: str, corrupt: Corrupt) -> None:
    lines = corrupt(list(full_book().lines()))
    report = audit(Pages(lines))
    assert not report.ok
    found = report.checks[check]
    assert not found.ok
    assert found.count >= 1
    assert found.first_offender is not None
    assert found.first_offender.position in {line.position for line in lines}


def test_every_check_has_a_corruption_that_fails_it() -> None:
    assert set(CORRUPTIONS) == {check.name for check in CHECKS}


def test_the_first_offender_of_the_report_stands_first_in_the_journal() -> None:
    lines = _abandoned(_refused_without_reason(list(full_book().lines())))
    offender = audit(Pages(lines)).first_offender
    assert offender is not None
    assert offender.record == "refused"


def test_weights_that_are_lost_or_altered_are_found() -> None:
    book = full_book()
    assert audit(book).checks["weights"].checked == 1
    name = next(iter(book.blobs))
    book.blobs[name] = b"altered"
    assert "not those" in str(audit(book).checks["weights"].first_offender)
    del book.blobs[name]
    assert "cannot be loaded" in str(audit(book).checks["weights"].first_offender)


def test_lines_without_a_journal_are_audited_without_their_weights() -> None:
    assert "weights" not in audit(Pages(list(full_book().lines()))).checks


def _restarted(second_value: object) -> Book:
    book = Book()
    process = book.admit()
    book.move(process, Trigger.DISPATCH)
    seq = book.ask(process, Kind.CALL, "plc")
    book.answer(process, seq, Kind.CALL, "plc", value=41)
    book.move(process, Trigger.RESTART)
    book.move(process, Trigger.DISPATCH)
    book.ask(process, Kind.CALL, "plc")
    book.write(Answered(process=process, seq=2, kind=Kind.CALL, key="plc", value=raw(second_value)))
    book.move(process, Trigger.WAKE)
    return book


def test_a_restarted_process_may_take_its_recorded_answer_again() -> None:
    assert audit(_restarted(41)).ok


def test_a_restarted_process_that_ran_an_answered_call_again_is_found() -> None:
    assert not audit(_restarted(42)).checks["repeats"].ok


def test_a_process_that_restarts_may_not_wait_on_nothing() -> None:
    book = Book()
    process = book.admit()
    book.move(process, Trigger.DISPATCH)
    book.move(process, Trigger.ASK)
    assert not audit(book).checks["wake-ups"].ok


@settings(max_examples=150, deadline=None)
@given(any_lines())
def test_the_audit_never_raises_on_typed_lines_in_any_order(lines: list[Line]) -> None:
    report = audit(Pages(lines))
    assert report.lines == len(lines)
    assert report.ok == all(finding.count == 0 for finding in report.checks.values())


class Torn(Pages):
    """A journal whose lines cannot be read from some position on."""

    def __init__(self, lines: list[Line], at: int) -> None:
        super().__init__(lines)
        self._at = at

    def lines(self, after: int = 0) -> Iterator[Line]:
        for line in super().lines(after):
            if line.position == self._at:
                raise JournalError(f"line {line.position} cannot be read")
            yield line


def test_a_line_that_cannot_be_read_is_the_offence_and_what_stands_before_it_is_audited() -> None:
    lines = list(full_book().lines())
    report = audit(Torn(lines, 30))
    assert not report.ok
    found = report.checks["readable"]
    assert (found.ok, found.count, found.checked) == (False, 1, 29)
    assert report.first_offender == found.first_offender
    assert report.first_offender is not None
    assert (report.first_offender.position, report.first_offender.record) == (30, "unreadable")
    assert report.checks["positions"].checked == 29
