"""Flags are lasting conditions, and only those that matter."""

from __future__ import annotations

from tests.domains.watching import Watch
from wakeful.domains.px4_ulog.flags import Flags
from wakeful.facts.events import Phase

ARMED = {"arming_state": 2, "nav_state": 3}


def test_a_flag_that_is_on_all_flight_and_that_the_mode_does_not_need_is_no_event() -> None:
    watch = Watch(Flags)
    watch.see(0.0, "vehicle_status", **ARMED)
    for second in range(20):
        watch.see(second + 0.1, "failsafe_flags", offboard_control_signal_lost=1, mode_req_offboard_signal=1 << 14)
    assert watch.seen == []


def test_a_flag_that_the_mode_needs_is_raised_at_arming_though_it_was_on_before() -> None:
    watch = Watch(Flags)
    watch.see(0.0, "vehicle_status", arming_state=1, nav_state=3)
    watch.see(0.1, "failsafe_flags", global_position_invalid=1, mode_req_global_position=1 << 3)
    assert watch.seen == []
    watch.see(1.0, "vehicle_status", **ARMED)
    watch.see(1.1, "failsafe_flags", global_position_invalid=1, mode_req_global_position=1 << 3)
    for at_s in (2.1, 3.1, 4.2):
        watch.see(at_s, "failsafe_flags", global_position_invalid=0, mode_req_global_position=1 << 3)
    assert watch.phases() == [Phase.RAISED, Phase.CLEARED]
    assert watch.found()[0].fields["needed"] is True
    assert watch.shown == [("recovered", "estimator")]


def test_old_and_new_names_of_a_flag_are_one_flag() -> None:
    old, new = Watch(Flags), Watch(Flags)
    for at_s, lost in [(0.0, 0), (1.0, 1), (2.0, 1), (3.0, 0), (6.0, 0)]:
        old.see(at_s, "vehicle_status", **ARMED, rc_signal_lost=lost)
        new.see(at_s, "vehicle_status", **ARMED)
        new.see(at_s, "failsafe_flags", manual_control_signal_lost=lost)
    assert [(one.references, one.phase, one.entity) for one in old.found()] == [
        (one.references, one.phase, one.entity) for one in new.found()
    ]


def test_a_good_flag_that_turns_false_is_bad() -> None:
    watch = Watch(Flags)
    watch.see(0.0, "vehicle_status_flags", condition_global_position_valid=1)
    watch.see(1.0, "vehicle_status_flags", condition_global_position_valid=0)
    assert watch.found()[0].references == ("global_position_invalid",)


def test_a_failsafe_is_an_outcome_and_a_critical_condition_in_the_air() -> None:
    watch = Watch(Flags)
    watch.see(0.0, "vehicle_land_detected", landed=0)
    watch.see(0.1, "vehicle_status", **ARMED, failsafe=0)
    watch.see(5.0, "vehicle_status", **ARMED, failsafe=1)
    watch.see(6.0, "vehicle_status", **ARMED, failsafe=1)
    watch.see(9.0, "vehicle_status", **ARMED, failsafe=0)
    assert watch.phases("failsafe") == [Phase.RAISED, Phase.CLEARED]
    assert watch.found("failsafe")[0].criticality == 3
    assert watch.shown == [("failsafe", "*"), ("recovered", "vehicle")]


def test_a_motor_failure_is_a_fault() -> None:
    watch = Watch(Flags)
    watch.see(0.0, "failure_detector_status", fd_motor=0)
    watch.see(1.0, "failure_detector_status", fd_motor=1)
    assert watch.shown == [("fault", "*")]


def test_a_flag_that_flickers_is_one_condition() -> None:
    watch = Watch(Flags)
    watch.see(0.0, "vehicle_status", **ARMED)
    for tick in range(100):
        watch.see(tick / 2, "failsafe_flags", manual_control_signal_lost=tick % 2)
    assert watch.phases() == [Phase.RAISED]


def test_a_flag_that_comes_back_every_ten_seconds_is_soon_one_condition() -> None:
    watch = Watch(Flags)
    watch.see(0.0, "vehicle_status", **ARMED)
    for tick in range(1200):
        watch.see(tick / 2, "failsafe_flags", local_position_accuracy_low=int(tick % 20 == 10))
    assert len(watch.events) == 2
