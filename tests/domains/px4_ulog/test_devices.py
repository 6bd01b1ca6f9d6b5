"""Batteries, estimator, GPS, airframe and the recording itself: lasting conditions with memory."""

from __future__ import annotations

from tests.domains.watching import Watch
from wakeful.domains.px4_ulog.airframe import Airframe
from wakeful.domains.px4_ulog.battery import Batteries
from wakeful.domains.px4_ulog.estimator import Estimators
from wakeful.domains.px4_ulog.recording import Recording
from wakeful.domains.px4_ulog.resets import Resets
from wakeful.domains.px4_ulog.satellites import Satellites
from wakeful.facts.events import Phase


def _fly(watch: Watch) -> Watch:
    watch.see(0.0, "vehicle_status", arming_state=2, nav_state=3)
    watch.see(0.0, "vehicle_land_detected", landed=0)
    return watch


def test_a_battery_that_runs_down_is_one_condition_that_gets_worse() -> None:
    watch = _fly(Watch(Batteries))
    for second in range(100):
        watch.see(float(second), "battery_status", voltage_v=15.0, cell_count=4, remaining=0.5 - second / 200, connected=1)
    assert watch.phases("battery_low") == [Phase.RAISED, Phase.CHANGED, Phase.CHANGED]
    assert {one.entity for one in watch.events} == {"battery 1"}


def test_each_battery_is_an_entity_of_its_own() -> None:
    watch = Watch(Batteries)
    for topic in ("battery_status", "battery_status.1"):
        watch.see(1.0, topic, voltage_v=15.0, cell_count=4, warning=2, connected=1)
    assert [one.entity for one in watch.events] == ["battery 1", "battery 2"]
    assert len({one.references for one in watch.events}) == 2


def test_a_voltage_that_gives_way_under_load_is_a_sag() -> None:
    watch = _fly(Watch(Batteries))
    for tenth in range(100):
        watch.see(tenth / 10, "battery_status", voltage_v=16.0, cell_count=4, remaining=0.8)
    for tenth in range(100, 120):
        watch.see(tenth / 10, "battery_status", voltage_v=14.2, cell_count=4, remaining=0.8)
    (sag,) = watch.found("voltage_sag")
    assert sag.phase is Phase.RAISED
    assert "3.55 V a cell" in sag.says


def test_a_test_ratio_above_one_for_a_while_is_a_rejected_sensor() -> None:
    watch = _fly(Watch(Estimators))
    for tenth in range(60):
        watch.see(tenth / 10, "estimator_status.1", mag_test_ratio=0.2 + tenth / 40, vel_test_ratio=0.1)
    assert watch.phases("innovation") == [Phase.RAISED, Phase.CHANGED]
    assert {one.entity for one in watch.events} == {"estimator 2"}
    assert "is rejected" in watch.events[-1].says


def test_one_wild_ratio_is_no_event() -> None:
    watch = _fly(Watch(Estimators))
    for tenth in range(60):
        watch.see(tenth / 10, "estimator_status", pos_test_ratio=9.0 if tenth == 30 else 0.1)
    assert watch.seen == []


def test_a_filter_fault_is_seen_once_by_bits_and_by_flags() -> None:
    watch = _fly(Watch(Estimators))
    watch.see(1.0, "estimator_status", filter_fault_flags=0)
    watch.see(2.0, "estimator_status", filter_fault_flags=0b1)
    watch.see(2.0, "estimator_status_flags", fs_bad_mag_x=1)
    assert [one.kind for one in watch.events] == ["estimator_fault"]
    assert watch.shown == [("fault", "*")]


def test_a_reset_of_several_states_is_one_event_and_a_tiny_one_is_none() -> None:
    watch = _fly(Watch(Resets))
    still = {"xy_reset_counter": 1, "z_reset_counter": 1, "heading_reset_counter": 1}
    watch.see(1.0, "vehicle_local_position", **still, delta_xy=[0.0, 0.0], delta_z=0.0, delta_heading=0.0)
    watch.see(2.0, "vehicle_local_position", **{**still, "heading_reset_counter": 2}, delta_heading=0.001)
    assert watch.events == []
    watch.see(3.0, "vehicle_local_position", xy_reset_counter=2, z_reset_counter=2, delta_xy=[3.0, 4.0], delta_z=-0.5)
    (reset,) = watch.events
    assert reset.fields["size"] == 5.0
    assert "height by 0.50 m" in reset.says


def test_a_lost_fix_in_the_air_is_critical_and_its_return_an_outcome() -> None:
    watch = _fly(Watch(Satellites))
    for at_s, fix in [(0.1, 3), (1.0, 3), (2.0, 0), (8.0, 3)]:
        watch.see(at_s, "vehicle_gps_position", fix_type=fix, eph=1.0, satellites_used=12)
    lost, found = watch.found("gps_fix")
    assert lost.criticality == 3
    assert found.criticality == 0
    assert watch.shown == [("recovered", "gps")]


def test_the_raw_receiver_is_not_heard_beside_the_blended_position() -> None:
    watch = Watch(Satellites)
    for at_s, fix in [(0.0, 3), (0.5, 0), (1.0, 3), (1.5, 0)]:
        watch.see(at_s, "vehicle_gps_position", fix_type=3)
        watch.see(at_s + 0.1, "sensor_gps", fix_type=fix)
    assert watch.found("gps_fix") == []


def test_flapping_gps_checks_are_one_condition() -> None:
    watch = Watch(Satellites)
    for tenth in range(100):
        watch.see(tenth / 10, "estimator_status", gps_check_fail_flags=40 if tenth < 20 or tenth % 3 else 0)
    assert watch.phases("gps_checks") == [Phase.RAISED]


def test_a_receiver_is_settled_once_it_had_a_fix_and_passed_the_checks_with_it() -> None:
    watch = Watch(Satellites)
    for second, fix, bits in [
        (0, 0, 0),
        (1, 0, 9),
        (3, 2, 9),
        (4, 3, 9),
        (5, 3, 0),
        (20, 3, 0),
        (21, 3, 40),
        (23, 3, 40),
        (24, 0, 40),
    ]:
        watch.see(float(second), "vehicle_gps_position", fix_type=fix, eph=1.0, satellites_used=10)
        watch.see(second + 0.1, "estimator_status", gps_check_fail_flags=bits)
    raised = [one for one in watch.found("gps_checks") if one.phase is Phase.RAISED]
    assert [one.fields["settled"] for one in raised] == [False, True]
    assert [one.fields["settled"] for one in watch.found("gps_fix")] == [False, False, True]


def test_vibration_counts_as_flight_review_counts_it() -> None:
    watch = _fly(Watch(Airframe))
    for second in range(10):
        watch.see(float(second), "vehicle_imu_status", accel_vibration_metric=[1.0, 6.0, 6.0, 12.0, 12.0][min(second // 2, 4)])
    assert watch.phases("vibration") == [Phase.RAISED, Phase.CHANGED]


def test_actuators_idling_on_the_ground_are_not_saturated() -> None:
    watch = Watch(Airframe)
    watch.see(0.0, "vehicle_status", arming_state=2, nav_state=3)
    watch.see(0.0, "vehicle_land_detected", landed=1)
    for tenth in range(50):
        watch.see(tenth / 10, "control_allocator_status", unallocated_torque=[0.4, 0.0, 0.0], unallocated_thrust=[0, 0, 0])
    assert watch.seen == []
    watch.see(5.0, "vehicle_land_detected", landed=0)
    for tenth in range(50, 60):
        watch.see(tenth / 10, "control_allocator_status", unallocated_torque=[0.4, 0.0, 0.0], unallocated_thrust=[0, 0, 0])
    assert watch.phases("saturation") == [Phase.RAISED]


def test_dropouts_that_follow_one_another_are_one_condition() -> None:
    watch = Watch(Recording)
    for second in range(200):
        watch.see(float(second), "sensor_combined", x=1)
        if second in (50, 51, 52, 60, 150):
            watch.see(second + 0.5, "dropout", duration_ms=40)
    assert [one.phase for one in watch.found("dropout")] == [
        Phase.RAISED,
        *[Phase.REPEATED] * 3,
        Phase.CLEARED,
        Phase.RAISED,
        Phase.CLEARED,
    ]


def test_a_gap_counts_only_between_two_streams() -> None:
    watch = Watch(Recording)
    for at_s in (0.0, 5.0, 40.0):
        watch.see(at_s, "parameter", name="x")
    for tenth in range(600, 700):
        watch.see(tenth / 10, "sensor_combined", x=1)
    assert watch.seen == []
    for tenth in range(900, 1000):
        watch.see(tenth / 10, "sensor_combined", x=1)
    (gap,) = watch.found("log_gap")
    assert "20.1 s" in gap.says


def test_what_two_filters_show_at_once_is_the_first_ones_condition() -> None:
    watch = _fly(Watch(Estimators))
    for tenth in range(300):
        ratio = 1.5 if 50 <= tenth < 100 else 0.1
        watch.see(tenth / 10, "estimator_status", hgt_test_ratio=ratio)
        watch.see(tenth / 10 + 0.01, "estimator_status.1", hgt_test_ratio=ratio)
    assert watch.phases("innovation") == [Phase.RAISED, Phase.REPEATED, Phase.CLEARED]
    assert len({one.references for one in watch.found()}) == 1


def test_a_ratio_that_hovers_about_the_limit_is_one_condition() -> None:
    watch = _fly(Watch(Estimators))
    for tenth in range(3000):
        watch.see(tenth / 10, "estimator_status", mag_test_ratio=0.45 + 0.1 * ((tenth // 60) % 2))
    assert watch.phases("innovation") == [Phase.RAISED]


def test_an_rtk_fix_that_floats_in_turns_is_no_series_of_events() -> None:
    watch = _fly(Watch(Satellites))
    for second in range(300):
        watch.see(float(second), "vehicle_gps_position", fix_type=5 + second % 2, eph=0.5, satellites_used=20)
    assert watch.found("gps_fix") == []


def test_a_fixed_wing_climbing_at_full_throttle_is_not_saturated() -> None:
    for kind, count in [(1, 1), (2, 0)]:
        watch = Watch(Airframe)
        watch.see(0.0, "vehicle_status", arming_state=2, nav_state=3, vehicle_type=kind)
        watch.see(0.0, "vehicle_land_detected", landed=0)
        for tenth in range(30):
            watch.see(tenth / 10, "actuator_motors", control=[1.0, 0.4, None])
        assert len(watch.found("saturation")) == count
