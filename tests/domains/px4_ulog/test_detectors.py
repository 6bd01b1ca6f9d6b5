"""The domain as a whole: any content is passed over, and recorded flights give few and true events."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given, settings

from tests.domains.watching import Watch, observations
from wakeful.bridges.ulog import UlogBridge
from wakeful.contracts.detector import Found, Shown
from wakeful.domains import load
from wakeful.domains.px4_ulog.detectors import DETECTORS
from wakeful.domains.px4_ulog.event_names import NAMES
from wakeful.domains.px4_ulog.flag_names import KINDS
from wakeful.facts.events import Draft, Observation
from wakeful.facts.evidence import Outcome
from wakeful.registration.registrar import SpecRegistrar

TOPICS = [
    "vehicle_status",
    "commander_state",
    "vehicle_land_detected",
    "log",
    "event",
    "failsafe_flags",
    "vehicle_status_flags",
    "actuator_armed",
    "failure_detector_status",
    "battery_status",
    "battery_status.1",
    "estimator_status",
    "estimator_status.1",
    "estimator_status_flags",
    "vehicle_local_position",
    "vehicle_gps_position",
    "sensor_gps",
    "vehicle_imu_status",
    "control_allocator_status",
    "actuator_motors",
    "dropout",
    "battery_status.x",
    "cpuload",
]
NAMES_OF_VALUES = [
    "nav_state",
    "arming_state",
    "nav_state_user_intention",
    "main_state",
    "landed",
    "failsafe",
    "rc_signal_lost",
    "level",
    "text",
    "module",
    "id",
    "log_levels",
    "arguments",
    "global_position_invalid",
    "mode_req_global_position",
    "condition_battery_healthy",
    "fd_motor",
    "voltage_v",
    "cell_count",
    "remaining",
    "warning",
    "connected",
    "mag_test_ratio",
    "filter_fault_flags",
    "fs_bad_mag_x",
    "cs_mag_fault",
    "xy_reset_counter",
    "delta_xy",
    "fix_type",
    "eph",
    "satellites_used",
    "jamming_state",
    "spoofing_state",
    "jamming_indicator",
    "gps_check_fail_flags",
    "accel_vibration_metric",
    "accel_clipping",
    "unallocated_torque",
    "control",
    "duration_ms",
    "load",
]


@given(stream=observations(TOPICS, NAMES_OF_VALUES))
@settings(max_examples=50, deadline=None)
def test_no_content_makes_a_detector_raise(stream: list[Observation]) -> None:
    labels = load("px4_ulog").spec.outcome.labels
    watches = [Watch(factory) for factory in DETECTORS.values()]
    for observation in stream:
        for said in (said for watch in watches for said in watch.look(observation)):
            if isinstance(said, Shown):
                assert said.label in labels
            if isinstance(said, Found):
                assert said.kind
                assert said.entity
                assert said.says
                assert len(said.says) < 1000


def test_every_event_name_has_a_number_of_its_own() -> None:
    assert len(NAMES) == len(set(NAMES.values()))


def test_the_flags_that_selection_knows_exist() -> None:
    known = {*KINDS, "failsafe"}
    assert set(load("px4_ulog").spec.fields["flag"].values) <= known


def _register(path: Path) -> tuple[list[Draft], list[Outcome], int]:
    bridge = UlogBridge()
    registrar = SpecRegistrar(load("px4_ulog"), bridge.digest(path))
    events: list[Draft] = []
    outcomes: list[Outcome] = []
    count = 0
    for item in bridge.read(path):
        if isinstance(item, Observation):
            count += 1
            registered = registrar.observe(item)
            events.extend(registered.events)
            outcomes.extend(registered.outcomes)
    return events, outcomes, count


def test_every_recorded_flight_gives_few_events_for_its_many_observations(shared_data: Path) -> None:
    pytest.importorskip("pyulog", reason="needs the extra wakeful[ulog]")
    for path in sorted((shared_data / "px4_ulog").glob("*.ulg")):
        events, _, count = _register(path)
        assert 1 <= len(events) <= count / 50, path.name


def test_the_lost_barometer_is_one_event_in_the_recorded_flight(shared_data: Path) -> None:
    pytest.importorskip("pyulog", reason="needs the extra wakeful[ulog]")
    events, outcomes, _ = _register(shared_data / "px4_ulog" / "sample.ulg")
    assert [one.says for one in events if one.kind == "error_message"] == [
        "sensors says (error): no barometer found on /dev/baro0 (2) [disarmed]."
    ]
    assert Counter(one.label for one in outcomes)["fault"] == 4


def test_the_simulated_recorded_flight_reads_as_it_was_flown(shared_data: Path) -> None:
    pytest.importorskip("pyulog", reason="needs the extra wakeful[ulog]")
    events, outcomes, _ = _register(shared_data / "px4_ulog" / "sample_px4_events.ulg")
    flown = [one.fields["mode"] for one in events if one.kind == "mode_change"]
    assert flown == ["takeoff", "hold", "return", "hold"]
    assert [one.kind for one in events if one.kind in ("takeoff", "landing")] == ["takeoff", "landing"]
    assert [one.label for one in outcomes if one.entity == "*"] == ["takeoff", "landed"]
