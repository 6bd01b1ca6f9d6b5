"""One outcome against one forecast, in the order in which the world may be heard."""

from __future__ import annotations

from tests.validation.test_recordings import entry, outcome
from wakeful.facts.experience import Verdict
from wakeful.validation.judging import against, silence, supersedes, undecided

QUIET = "none"


def test_the_first_outcome_decides() -> None:
    judged = against(entry(), outcome("a", 150), 150, QUIET)
    assert judged is not None
    assert (judged.verdict, judged.label, judged.why) == (Verdict.CONTRADICTED, "stop", "")


def test_an_outcome_inside_a_window_that_has_closed_is_late_and_counts() -> None:
    judged = against(entry(), outcome("a", 150), 300, QUIET)
    assert judged is not None
    assert "came late" in judged.why


def test_the_earlier_outcome_in_source_time_supersedes_the_later_one() -> None:
    decided = entry()
    decided.verdict, decided.shown, decided.decided_by, decided.decided_ns = Verdict.SUPPORTED, "none", "first", 180
    assert supersedes(outcome("a", 150), decided)
    judged = against(decided, outcome("a", 150), 190, QUIET)
    assert judged is not None
    assert "supersedes" in judged.why


def test_the_later_outcome_that_says_otherwise_is_recorded_and_changes_nothing() -> None:
    decided = entry()
    decided.verdict, decided.shown, decided.decided_by, decided.decided_ns = Verdict.SUPPORTED, "none", "first", 120
    judged = against(decided, outcome("a", 150), 190, QUIET)
    assert judged is not None
    assert judged.verdict is Verdict.UNDECIDED


def test_the_same_outcome_says_nothing_twice() -> None:
    decided = entry()
    decided.verdict, decided.shown, decided.decided_by, decided.decided_ns = Verdict.CONTRADICTED, "stop", "o", 150
    assert against(decided, outcome("a", 150), 190, QUIET) is None


def test_silence_is_the_quiet_label_and_doubt_is_none() -> None:
    assert silence(entry(), QUIET).verdict is Verdict.SUPPORTED
    assert undecided(entry(), "a gap").verdict is Verdict.UNDECIDED
