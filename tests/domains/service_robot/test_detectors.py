"""What of a sighting is an event, on observations written by hand."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wakeful.contracts.detector import Detector, Found, Offered, Shown
from wakeful.domains import load
from wakeful.domains.service_robot.detectors import DETECTORS, KEPT
from wakeful.facts.domain import DetectorSpec
from wakeful.facts.events import Observation
from wakeful.facts.values import Value

SPEC = load("service_robot").spec
CRATE = {"identity": "item-1", "category": "item", "place": "hall", "location": "center", "x": 1.0, "y": 2.0, "state": "normal"}


def made(detector: str) -> Detector:
    return DETECTORS[detector](next(spec for spec in SPEC.detect if spec.detector == detector), SPEC)


def sighting(position: int, **changes: Value) -> Observation:
    values: dict[str, Value] = {**CRATE, "route": "none", "load": 0.5, "context": "none", **changes}
    return Observation(source="s", position=position, topic="sighting", at_ns=position, values=values)


def events(detector: Detector, *observations: Observation) -> list[Found]:
    return [found for one in observations for found in detector.observe(one) if isinstance(found, Found)]


def test_an_object_that_stays_as_it_was_is_one_event() -> None:
    (event,) = events(made("sightings"), *(sighting(i) for i in range(500)))
    assert event.entity == "item-1"
    assert event.zone == "hall"


def test_the_next_event_says_how_many_observations_it_stands_for() -> None:
    _, event = events(made("sightings"), *(sighting(i) for i in range(20)), sighting(20, state="unstable"))
    assert event.observations == 20
    assert "normal to unstable" in event.says


@pytest.mark.parametrize(
    "change", [{"x": 2.0}, {"place": "corridor_a"}, {"state": "abnormal"}, {"route": "blocking"}, {"load": 0.8}]
)
def test_a_change_of_place_state_route_or_load_is_an_event(change: dict[str, Value]) -> None:
    assert len(events(made("sightings"), sighting(0), sighting(1, **change), sighting(2, **change))) == 2


def test_a_wavering_position_is_no_change_of_place_but_a_creeping_one_becomes_one() -> None:
    detector = made("sightings")
    assert len(events(detector, *(sighting(i, x=1.0 + 0.2 * (i % 2)) for i in range(50)))) == 1
    assert len(events(detector, *(sighting(i, x=1.0 + 0.05 * i) for i in range(12)))) == 1


def test_a_change_of_context_alone_is_no_event() -> None:
    assert len(events(made("sightings"), sighting(0), sighting(1, context="safety"))) == 1


def test_what_may_fall_near_people_is_critical_and_has_a_deadline() -> None:
    (event,) = events(made("sightings"), sighting(0, state="unstable", context="safety", location="edge"))
    assert (event.criticality, event.deadline_s, event.safety) == (3, 10.0, True)


def test_memory_survives_being_written_down() -> None:
    first, second = made("sightings"), made("sightings")
    events(first, sighting(0))
    second.restore(first.state())
    assert events(second, sighting(1)) == []
    assert first.state() != b""


def test_memory_is_bounded() -> None:
    detector = made("sightings")
    events(detector, *(sighting(i, identity=f"item-{i}") for i in range(KEPT + 10)))
    assert len(events(detector, sighting(0, identity="item-1"))) == 1
    assert len(events(detector, sighting(0, identity=f"item-{KEPT}"))) == 0


def test_a_report_shows_an_outcome_of_the_sighting_it_is_about() -> None:
    report = Observation(
        source="s", position=9, topic="report", at_ns=9, values={"identity": "item-1", "about": 3, "needed": "intervention"}
    )
    (shown,) = made("reports").observe(report)
    assert isinstance(shown, Shown)
    assert (shown.label, shown.entity, shown.event_position) == ("intervention", "item-1", 3)


def test_a_report_in_unknown_words_shows_nothing() -> None:
    report = Observation(source="s", position=9, topic="report", at_ns=9, values={"identity": "item-1", "needed": "a miracle"})
    assert list(made("reports").observe(report)) == []


def test_a_reading_is_offered_under_the_name_of_its_device() -> None:
    reading = Observation(
        source="s", position=9, topic="reading", at_ns=9, values={"identity": "device-1", "temperature_c": 71.5, "fault": ""}
    )
    (offered,) = made("reports").observe(reading)
    assert offered == Offered(topic="reading", key="device-1", value={"temperature_c": 71.5, "fault": ""})


def test_a_setting_of_the_wrong_type_is_said_at_once() -> None:
    with pytest.raises(ValueError, match="moved_m must be a number"):
        DETECTORS["sightings"](DetectorSpec(detector="sightings", kind="object", settings={"moved_m": "far"}), SPEC)


ODD = st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=5), st.lists(st.integers()))


@given(
    st.sampled_from(["sighting", "report", "reading", "pose"]),
    st.dictionaries(
        st.sampled_from(["identity", "x", "y", "place", "state", "route", "load", "context", "needed", "about", "category"]), ODD
    ),
)
def test_no_value_whatever_makes_a_detector_raise(topic: str, values: dict[str, Value]) -> None:
    for name in DETECTORS:
        list(made(name).observe(Observation(source="s", position=0, topic=topic, at_ns=0, values=values)))
