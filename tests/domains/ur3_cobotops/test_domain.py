"""The UR3 domain on its recording: incidents as they stand in the rows, events that are changes, and no look ahead."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise
from pathlib import Path

import pytest

from wakeful.bridges.xlsx import XlsxBridge
from wakeful.contracts.domain import Registered
from wakeful.domains import load, recognise
from wakeful.facts.events import Observation, Phase
from wakeful.registration import SpecRegistrar, incidents_of, recall

RECORDING = Path(__file__).parents[4] / "shared" / "data" / "ur3_cobotops" / "dataset.xlsx"
recorded = pytest.mark.skipif(not RECORDING.exists(), reason="needs ../shared/data/ur3_cobotops")


@pytest.fixture(scope="module")
def rows() -> list[Observation]:
    return [item for item in XlsxBridge().read(RECORDING) if isinstance(item, Observation)]


@pytest.fixture(scope="module")
def registered(rows: list[Observation]) -> list[Registered]:
    registrar = SpecRegistrar(load("ur3_cobotops"), "d")
    return [registrar.observe(row) for row in rows]


@recorded
def test_the_recorded_file_is_recognised() -> None:
    assert recognise(XlsxBridge().peek(RECORDING), RECORDING) == "ur3_cobotops"


@recorded
def test_every_recorded_incident_is_one_outcome_and_one_condition(registered: list[Registered]) -> None:
    outcomes = Counter(outcome.label for each in registered for outcome in each.outcomes)
    assert outcomes == {"protective_stop": 108, "grip_lost": 77}
    raised = Counter(event.kind for each in registered for event in each.events if event.condition)
    assert raised["protective_stop"] == 108
    assert raised["grip_lost"] == 77
    phases = {event.condition.phase for each in registered for event in each.events if event.condition}
    assert phases == {Phase.RAISED}


@recorded
def test_recorded_rows_are_not_events(registered: list[Registered]) -> None:
    events = [event for each in registered for event in each.events]
    assert 185 < len(events) < len(registered) / 5
    by_place = Counter((event.kind, event.entity) for event in events)
    assert len(by_place) > 10
    for kind in ("current_unusual", "speed_unusual", "gripper_unusual"):
        at_s = [event.at_ns / 1e9 for event in events if event.kind == kind]
        assert all(later - earlier >= 5.0 for earlier, later in pairwise(at_s))


@recorded
def test_recorded_stops_are_preceded_by_more_than_chance(rows: list[Observation], registered: list[Registered]) -> None:
    events = [event.at_ns for each in registered for event in each.events if event.kind not in ("protective_stop", "grip_lost")]
    observed_s = sum(min((later.at_ns - earlier.at_ns) / 1e9, 10.0) for earlier, later in pairwise(rows))
    found = recall(incidents_of(outcome for each in registered for outcome in each.outcomes), events, 5.0, observed_s)
    stops = next(each for each in found if each.label == "protective_stop")
    assert stops.chance is not None
    assert stops.share > stops.chance


@recorded
def test_what_is_registered_of_a_recorded_row_does_not_depend_on_later_rows(
    rows: list[Observation], registered: list[Registered]
) -> None:
    registrar = SpecRegistrar(load("ur3_cobotops"), "d")
    assert [registrar.observe(row) for row in rows[:1500]] == registered[:1500]


@recorded
def test_a_recorded_stream_cut_in_two_goes_on_as_if_it_had_not_been(
    rows: list[Observation], registered: list[Registered]
) -> None:
    first, second = SpecRegistrar(load("ur3_cobotops"), "d"), SpecRegistrar(load("ur3_cobotops"), "d")
    for row in rows[:3000]:
        first.observe(row)
    second.restore(first.changed())
    assert [second.observe(row) for row in rows[3000:4500]] == registered[3000:4500]


@recorded
def test_recorded_blank_flags_are_unknown(rows: list[Observation], registered: list[Registered]) -> None:
    blank = [at for at, row in enumerate(rows) if row.values["Robot_ProtectiveStop"] is None]
    assert len(blank) == 54
    for at in blank:
        assert not registered[at].outcomes
        assert not any(event.kind == "protective_stop" for event in registered[at].events)
        assert not any(item.topic == "condition.cleared" and "protective_stop" in item.key for item in registered[at].evidence)
