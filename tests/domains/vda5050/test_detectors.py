"""What state messages show of a vehicle, through the registrar: events, evidence, outcomes, and never a flood."""

from __future__ import annotations

import json
from itertools import islice
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.domains.vda5050.fleet import DOMAIN, Watch, error, message
from wakeful.contracts.domain import Registrar
from wakeful.domains.vda5050.detectors import DETECTORS
from wakeful.domains.vda5050.simulate import simulate
from wakeful.facts.domain import DetectorSpec
from wakeful.facts.events import Phase, Relation
from wakeful.facts.values import Value
from wakeful.registration import SpecRegistrar


def test_an_error_that_500_messages_repeat_is_one_event_and_the_rest_evidence() -> None:
    watch = Watch()
    for _ in range(500):
        watch.send(errors=[error(nodeId="N1")])
    (event,) = watch.events
    assert (event.kind, event.entity) == ("error", "AGV-1/scannerDirty nodeId=N1")
    assert event.condition is not None
    assert event.condition.phase is Phase.RAISED
    assert [evidence.topic for evidence in watch.evidence] == ["condition.repeated"] * 499
    assert {evidence.key for evidence in watch.evidence} == {event.condition.key}


def test_what_clears_is_evidence_and_an_outcome_and_no_event() -> None:
    watch = Watch()
    watch.send(errors=[error()])
    assert watch.send(errors=[]) == []
    assert [evidence.topic for evidence in watch.evidence] == ["condition.cleared"]
    assert watch.labels() == [("cleared", "AGV-1/scannerDirty")]


def test_a_change_of_level_is_an_event_of_the_same_condition_and_an_outcome_of_the_first() -> None:
    watch = Watch()
    watch.send(errors=[error()])
    (changed,) = watch.send(errors=[error(level="FATAL")])
    first = watch.events[0]
    assert first.condition is not None
    assert changed.condition is not None
    assert changed.condition.key == first.condition.key
    assert changed.condition.phase is Phase.CHANGED
    assert (first.criticality, changed.criticality) == (1, 3)
    assert watch.labels() == [("escalated", "AGV-1/scannerDirty")]


def test_two_errors_of_one_type_with_other_references_are_two_conditions() -> None:
    watch = Watch()
    for _ in range(10):
        watch.send(errors=[error(nodeId="N1"), error(nodeId="N2")])
    assert len({event.condition.key for event in watch.events if event.condition}) == 2
    watch.send(errors=[error(nodeId="N2")])
    assert watch.labels() == [("cleared", "AGV-1/scannerDirty nodeId=N1")]


def test_references_that_change_with_every_message_are_no_flood() -> None:
    watch = Watch()
    for i in range(300):
        watch.send(errors=[error(nodeId="N1", timestamp=str(i)), error("rejected", messageNumber=str(i))])
    assert watch.kinds().count("error") <= 6


def test_an_error_that_comes_and_goes_is_no_flood() -> None:
    watch = Watch()
    for i in range(300):
        watch.send(errors=[error()] if i % 2 else [])
    assert watch.kinds().count("error") <= 6


def test_a_level_that_wavers_is_no_flood() -> None:
    watch = Watch()
    for i in range(300):
        watch.send(errors=[error(level="FATAL" if i % 2 else "WARNING")])
    assert watch.kinds().count("error") == 2


def test_two_vehicles_with_the_same_error_are_two_conditions() -> None:
    watch = Watch()
    watch.send(errors=[error()])
    watch.send(errors=[error()], serialNumber="AGV-2")
    assert len({event.condition.key for event in watch.events if event.condition}) == 2


def test_the_same_error_elsewhere_is_known_and_moved() -> None:
    watch = Watch()
    watch.send(errors=[error()])
    watch.send(errors=[])
    watch.send(errors=[], lastNodeId="N9")
    watch.send(errors=[error()], lastNodeId="N9")
    assert [event.relation for event in watch.events] == [Relation.NEW, Relation.MOVED]


def test_an_emergency_stop_is_critical_and_the_outcome_of_what_was_open() -> None:
    watch = Watch()
    watch.send(errors=[error()])
    (stop,) = watch.send(errors=[error()], safetyState={"eStop": "MANUAL", "fieldViolation": False})
    assert (stop.kind, stop.criticality, stop.deadline_s) == ("emergency_stop", 3, 10.0)
    assert watch.labels() == [("stopped", "AGV-1/scannerDirty")]


def test_a_vehicle_that_stands_already_does_not_stop_again() -> None:
    watch = Watch()
    stopped: dict[str, Value] = {"eStop": "MANUAL", "fieldViolation": False}
    watch.send(safetyState=stopped)
    watch.send(safetyState=stopped, errors=[error(level="FATAL")])
    assert watch.kinds() == ["emergency_stop", "error"]
    assert watch.labels() == []


def test_what_happened_longer_ago_than_the_window_was_not_stopped_by_it() -> None:
    watch = Watch()
    watch.send(errors=[error()])
    watch.send(errors=[error()], at_s=400.0)
    watch.send(errors=[error()], safetyState={"eStop": "MANUAL", "fieldViolation": False})
    assert watch.labels() == [("stopped", "AGV-1/silence")]


def test_version_3_is_read_in_its_own_words() -> None:
    watch = Watch()
    watch.send()
    values = message(errors=[error(level="URGENT")])
    del values["agvPosition"], values["batteryState"]
    values |= {
        "headerId": 2,
        "mobileRobotPosition": {"x": 0.0, "y": 0.0, "theta": 0.0, "mapId": "m", "localized": False},
        "powerSupply": {"stateOfCharge": 8.0, "charging": False},
        "safetyState": {"activeEmergencyStop": "REMOTE", "fieldViolation": False},
        "operatingMode": "TEACH_IN",
    }
    found = watch.register("state", values)
    kinds = {event.kind: event for event in found.events}
    assert set(kinds) == {"error", "battery", "battery_drop", "position", "emergency_stop", "mode"}
    assert kinds["error"].fields["level"] == "urgent"


def test_battery_is_raised_when_low_changed_when_critical_and_cleared_well_above() -> None:
    watch = Watch()
    for charge in (30.0, 25.0, 26.0, 24.0, 11.0, 9.0, 10.5, 12.0, 20.0, 27.0, 29.0):
        watch.send(batteryState={"batteryCharge": charge, "charging": False}, at_s=watch.now_s + 30)
    assert watch.phases("battery")[:2] == [Phase.RAISED, Phase.CHANGED]
    assert ("escalated", "AGV-1/battery") in watch.labels()
    assert watch.labels()[-1] == ("cleared", "AGV-1/battery")


def test_driving_without_getting_anywhere_is_a_stall_until_it_moves() -> None:
    watch = Watch()
    for i in range(60):
        watch.send(driving=True, agvPosition={"x": 0.01 * (i % 3), "y": 0.0, "mapId": "m", "positionInitialized": True})
    assert watch.kinds() == ["stall"]
    watch.send(driving=True, agvPosition={"x": 2.0, "y": 0.0, "mapId": "m", "positionInitialized": True})
    assert watch.labels() == [("cleared", "AGV-1/stall")]


def test_a_vehicle_that_is_paused_or_held_by_a_field_does_not_stall() -> None:
    watch = Watch()
    for _ in range(60):
        watch.send(driving=True, safetyState={"eStop": "NONE", "fieldViolation": True})
    assert watch.kinds() == ["field_violation"]


def test_a_lost_position_and_a_jump_are_seen_but_not_normal_driving() -> None:
    watch = Watch()
    for i in range(20):
        watch.send(driving=True, agvPosition={"x": 1.5 * i, "y": 0.0, "mapId": "m", "positionInitialized": True})
    assert watch.kinds() == []
    watch.send(agvPosition={"x": 60.0, "y": 0.0, "mapId": "m", "positionInitialized": True})
    watch.send(agvPosition={"x": 60.0, "y": 0.0, "mapId": "m", "positionInitialized": False})
    assert watch.kinds() == ["position_jump", "position"]


def test_an_order_without_progress_is_stuck_and_one_under_way_is_not() -> None:
    watch = Watch()
    ahead: list[Value] = [{"nodeId": "N2", "sequenceId": 2, "released": True}]
    for i in range(200):
        watch.send(orderId="o", nodeStates=ahead, lastNodeSequenceId=2 * (i // 50))
    assert watch.kinds() == []
    for _ in range(150):
        watch.send(orderId="o", nodeStates=ahead, lastNodeSequenceId=8)
    assert watch.kinds() == ["order_stuck"]


def test_a_failed_action_is_one_condition_until_it_is_listed_no_more() -> None:
    watch = Watch()
    failed: list[Value] = [{"actionId": "a", "actionType": "pick", "actionStatus": "FAILED", "resultDescription": "no pallet"}]
    for _ in range(50):
        watch.send(orderId="o", actionStates=failed)
    (event,) = watch.events
    assert (event.kind, event.fields["action"]) == ("action_failed", "pick")
    assert "no pallet" in event.says
    watch.send(orderId="p")
    assert watch.labels() == [("cleared", "AGV-1/action_failed actionId=a")]


def test_a_load_that_is_handled_is_the_work_and_one_that_vanishes_is_an_event() -> None:
    watch = Watch()
    running: list[Value] = [{"actionId": "a", "actionType": "pick", "actionStatus": "RUNNING"}]
    finished: list[Value] = [{"actionId": "a", "actionType": "pick", "actionStatus": "FINISHED"}]
    watch.send(actionStates=running)
    watch.send(actionStates=finished, loads=[{"loadId": "pallet"}])
    assert watch.events == []
    (event,) = watch.send(actionStates=finished, driving=True, loads=[])
    assert (event.kind, event.criticality) == ("load", 2)


@pytest.mark.parametrize(
    ("header", "at_s", "kind", "words"),
    [
        (14, 11.0, "stream_fault", "3 messages are missing"),
        (10, 10.0, "stream_fault", "came twice"),
        (7, 7.0, "stream_fault", "came after 10"),
        (11, 4.0, "stream_fault", "clock ran back"),
        (0, 11.0, "restart", "anew"),
        (11, 100.0, "silence", "90 s"),
    ],
)
def test_a_fault_of_the_stream_is_said(header: int, at_s: float, kind: str, words: str) -> None:
    watch = Watch()
    for i in range(1, 11):
        watch.send(header=i, at_s=float(i))
    (event,) = watch.send(header=header, at_s=at_s)
    assert event.kind == kind
    assert words in event.says


def test_a_stream_that_loses_messages_all_the_time_is_no_flood() -> None:
    watch = Watch()
    for i in range(400):
        watch.send(header=3 * i, at_s=float(i))
    assert watch.kinds() == ["stream_fault"]


def test_a_message_that_came_late_changes_nothing_that_is_known() -> None:
    watch = Watch()
    watch.send(header=1, at_s=1.0)
    watch.send(header=3, at_s=3.0, errors=[error()])
    watch.send(header=2, at_s=2.0, errors=[])
    assert watch.labels() == []


def test_a_vehicle_that_does_not_count_its_messages_is_not_at_fault() -> None:
    watch = Watch()
    for i in range(20):
        watch.send(header=0, at_s=float(i))
    assert watch.events == []


def test_null_means_that_nothing_is_known_and_clears_nothing() -> None:
    watch = Watch()
    watch.send(errors=[error()])
    nulls = dict.fromkeys(message())
    watch.register("state", {**nulls, "serialNumber": "AGV-1", "headerId": 2})
    assert watch.labels() == []
    assert len(watch.events) == 1


def test_a_broken_connection_is_a_condition_until_it_is_back() -> None:
    watch = Watch()
    for state in ("ONLINE", "CONNECTIONBROKEN", "CONNECTIONBROKEN", "ONLINE"):
        watch.register("connection", {"serialNumber": "AGV-1", "connectionState": state})
    assert watch.kinds() == ["connection"]
    assert watch.labels() == [("cleared", "AGV-1/connection")]


def test_memory_survives_being_written_down_in_the_middle() -> None:
    observations = list(islice(simulate(3), 4_000))
    whole = SpecRegistrar(DOMAIN, "d")
    expected = [whole.observe(one) for one in observations]
    first: Registrar = SpecRegistrar(DOMAIN, "d")
    parts: dict[str, bytes] = {}
    found = []
    for i, one in enumerate(observations):
        if i % 500 == 499:
            parts |= first.changed()
            first = SpecRegistrar(DOMAIN, "d")
            first.restore(parts)
        found.append(first.observe(one))
    assert found == expected


def test_an_unknown_setting_is_said_at_once() -> None:
    with pytest.raises(ValueError, match="it knows low, critical"):
        DETECTORS["state_messages"](DetectorSpec(detector="state_messages", kind="error", settings={"lo": 1.0}), DOMAIN.spec)


def test_every_recorded_example_is_read_without_a_word_of_complaint(shared_data: Path) -> None:
    watch = Watch()
    states = sorted((shared_data / "vda5050").rglob("*tate*.json"))
    assert len(states) > 5
    for path in states:
        watch.register("state", json.loads(path.read_text()))
    assert {"error", "action_failed", "emergency_stop"} <= set(watch.kinds())


ODD: st.SearchStrategy[Value] = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=6,
)
ROWS = st.lists(
    st.dictionaries(
        st.sampled_from(["errorType", "errorLevel", "errorReferences", "actionId", "actionStatus", "loadId", "referenceKey"]), ODD
    ),
    max_size=4,
)


@settings(max_examples=30, deadline=None)
@given(
    st.lists(
        st.dictionaries(st.sampled_from([*message(), "headerId", "powerSupply", "velocity", "connectionState"]), ODD | ROWS),
        max_size=5,
    )
)
def test_no_message_whatever_makes_the_watch_raise(messages: list[dict[str, Value]]) -> None:
    watch = Watch()
    for values in messages:
        for topic in ("state", "connection"):
            watch.register(topic, {**message(), **values})
