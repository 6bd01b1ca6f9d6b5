"""Registration's statistics: what it heard before the incidents, beside chance."""

from __future__ import annotations

import pytest
from hypothesis import given, settings

from tests.journal.builder import Book
from tests.journal.strategies import any_lines
from tests.journal.test_audit import Pages
from wakeful.facts.lines import Finished, Line
from wakeful.facts.time import NS_PER_S
from wakeful.journal.incidents import _observed_ns, stats


def _signs_before(incidents: int, lead_s: float) -> Book:
    """A book whose every incident has an event ``lead_s`` before, 1,000 seconds apart."""
    book = Book()
    for _ in range(incidents):
        book.wait(1000 - lead_s)
        book.admit(observations=4)
        book.wait(lead_s)
        book.witness("stop")
    book.write(Finished(source="arm.xlsx", observations=incidents * 1000))
    return book


def test_incidents_with_an_event_in_the_window_before_are_heard_and_the_lead_is_measured() -> None:
    told = stats(_signs_before(10, 20), within_s=30)
    everything, stop = told.incidents
    assert (everything.label, stop.label) == ("any", "stop")
    assert (stop.incidents, stop.before, stop.share) == (10, 10, 1.0)
    assert (stop.first_s, stop.last_s) == (20, 20)
    assert stop.by_chance == pytest.approx(1 - (1 - 30 / 9020) ** 10, rel=0.05)


def test_events_that_come_too_early_or_at_the_instant_itself_are_no_signs() -> None:
    assert stats(_signs_before(5, 20), within_s=10).incidents[0].before == 0
    book = Book()
    book.wait(50)
    book.admit()
    book.witness("stop")
    assert stats(book, within_s=10).incidents[0].before == 0


def test_observations_per_event_and_events_per_hour() -> None:
    told = stats(_signs_before(10, 20))
    assert (told.observations, told.events, told.observations_per_event) == (10_000, 10, 1000)
    assert told.kinds[0].observations == 40
    assert told.events_per_hour == pytest.approx(10 / (9020 / 3600))


def test_a_forecast_that_named_the_incident_before_it_came_has_foretold_it() -> None:
    book = Book()
    book.wait(5)
    process = book.admit()
    book.run_through(process, "stop")
    book.wait(5)
    book.judge(process, "stop", "stop", book.witness("stop"))
    assert stats(book).incidents[0].foretold == 1


def test_the_window_is_that_of_the_journals_own_forecasts() -> None:
    book = Book()
    book.run_through(book.admit())
    assert stats(book).within_s == 30


def test_a_recording_without_incidents_has_none() -> None:
    book = Book()
    book.admit()
    assert stats(book).incidents == ()


@settings(max_examples=100, deadline=None)
@given(any_lines())
def test_statistics_never_raise_on_typed_lines(lines: list[Line]) -> None:
    told = stats(Pages(lines))
    assert all(0.0 <= heard.share <= 1.0 and 0.0 <= heard.by_chance <= 1.0 for heard in told.incidents)


def test_a_stretch_in_which_nobody_recorded_is_not_observed_time() -> None:
    minute = 60 * NS_PER_S
    steady = [n * minute for n in range(60)]
    later = [instant + 300 * minute for instant in steady]
    assert _observed_ns(steady) == 59 * minute
    assert _observed_ns([*steady, *later]) == 2 * 59 * minute
    assert _observed_ns([0, 5 * 60 * minute, 11 * 60 * minute]) == 11 * 60 * minute  # rare, but always recorded
