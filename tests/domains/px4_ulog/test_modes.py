"""Changes of the vehicle's state are events; its first state is not."""

from __future__ import annotations

from tests.domains.watching import Watch
from wakeful.domains.px4_ulog.modes import Modes


def test_the_first_state_is_no_change() -> None:
    watch = Watch(Modes)
    watch.see(0.0, "vehicle_status", nav_state=4, arming_state=2, nav_state_user_intention=4)
    assert watch.seen == []


def test_a_mode_that_nobody_asked_for_is_a_failsafe_for_earlier_events() -> None:
    watch = Watch(Modes)
    watch.see(0.0, "vehicle_land_detected", landed=False)
    watch.see(0.1, "vehicle_status", nav_state=3, arming_state=2, nav_state_user_intention=3)
    watch.see(9.0, "vehicle_status", nav_state=5, arming_state=2, nav_state_user_intention=3)
    (change,) = watch.events
    assert change.kind == "mode_change"
    assert change.fields["intended"] is False
    assert change.criticality == 3
    assert watch.shown == [("failsafe", "*")]


def test_old_firmware_says_what_was_asked_for_in_commander_state() -> None:
    watch = Watch(Modes)
    watch.see(0.0, "vehicle_status", nav_state=2, arming_state=2)
    watch.see(1.0, "commander_state", main_state=5)
    watch.see(1.1, "vehicle_status", nav_state=5, arming_state=2)
    assert watch.events[0].fields["intended"] is True
    assert watch.shown == []


def test_take_off_and_landing_are_outcomes_and_events_once_each() -> None:
    watch = Watch(Modes)
    watch.see(0.0, "vehicle_status", nav_state=17, arming_state=2)
    for at_s, landed in [(0, 1), (1, 1), (2, 0), (3, 0), (4, 1), (5, 1)]:
        watch.see(float(at_s), "vehicle_land_detected", landed=landed)
    assert [one.kind for one in watch.events] == ["takeoff", "landing"]
    assert watch.shown == [("takeoff", "*"), ("landed", "*")]


def test_disarming_in_the_air_is_a_fault() -> None:
    watch = Watch(Modes)
    watch.see(0.0, "vehicle_land_detected", landed=0)
    watch.see(0.1, "vehicle_status", nav_state=0, arming_state=2)
    watch.see(5.0, "vehicle_status", nav_state=0, arming_state=1)
    assert watch.shown == [("fault", "*")]
    assert watch.events[0].criticality == 3
