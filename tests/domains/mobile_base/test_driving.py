"""Starts, stops, stalls, slips, shocks and tilt, from odometry, commands and inertial sensors made by hand."""

from __future__ import annotations

from math import cos, pi, sin
from random import Random

import pytest

from tests.domains.watching import Watch
from wakeful.domains.mobile_base.drive import Drive
from wakeful.domains.mobile_base.following import Following
from wakeful.domains.mobile_base.shocks import Shocks
from wakeful.domains.mobile_base.slip import Slip
from wakeful.facts.events import Phase

ODOMETRY, TWIST, IMU = "nav_msgs/msg/Odometry", "geometry_msgs/msg/Twist", "sensor_msgs/msg/Imu"


def _drive(
    watch: Watch, at_s: float, speed_mps: float, turn_radps: float = 0.0, topic: str = "/anything/odom", child: str = "base_link"
) -> None:
    watch.see(at_s, topic, _type=ODOMETRY, vx=speed_mps, vy=0.0, wz=turn_radps, x=0.0, y=0.0, yaw=0.0, child_frame=child)


def _command(watch: Watch, at_s: float, speed_mps: float, turn_radps: float = 0.0) -> None:
    watch.see(at_s, "/cmd_vel", _type=TWIST, vx=speed_mps, vy=0.0, wz=turn_radps)


def test_a_drive_is_a_start_and_a_stop_however_many_messages_it_takes() -> None:
    watch = Watch(Drive)
    for tick in range(200):
        _drive(watch, tick / 20, 0.5 if 40 <= tick < 160 else 0.0)
    assert [one.kind for one in watch.events] == ["start", "unexpected_stop"]
    assert watch.shown == [("stopped", "*")]


def test_creeping_about_the_threshold_is_no_series_of_starts() -> None:
    watch = Watch(Drive)
    for tick in range(400):
        _drive(watch, tick / 20, 0.05 + 0.02 * (-1) ** tick)
    assert len(watch.events) <= 1


def test_a_stop_that_was_commanded_is_routine() -> None:
    watch = Watch(Drive)
    for tick in range(200):
        if tick % 4 == 0:
            _command(watch, tick / 20, 0.5 if 40 <= tick < 160 else 0.0)
        _drive(watch, tick / 20 + 0.01, 0.5 if 42 <= tick < 162 else 0.0)
    assert [(one.kind, one.criticality) for one in watch.events] == [("start", 0), ("stop", 0)]


def test_resting_against_a_command_is_an_unexpected_stop_and_a_stall() -> None:
    drive, following = Watch(Drive), Watch(Following)
    for tick in range(400):
        for watch in (drive, following):
            if tick % 4 == 0:
                _command(watch, tick / 20, 0.5)
            _drive(watch, tick / 20 + 0.01, 0.5 if 2 <= tick < 160 or tick >= 300 else 0.0)
    assert [one.kind for one in drive.events] == ["start", "unexpected_stop", "start"]
    assert drive.shown == [("stopped", "*"), ("recovered", "base")]
    assert [(one.kind, one.phase) for one in following.found()] == [("stall", Phase.RAISED), ("stall", Phase.CLEARED)]
    assert following.shown == [("recovered", "drive")]


def test_a_base_that_is_limited_falls_short_once() -> None:
    watch = Watch(Following)
    for tick in range(600):
        if tick % 4 == 0:
            _command(watch, tick / 20, 0.5)
        _drive(watch, tick / 20 + 0.01, min(0.3, tick / 20))
    assert [(one.kind, one.phase) for one in watch.found()] == [("shortfall", Phase.RAISED)]
    assert "60% of the 0.50 m/s" in watch.events[0].says


def test_an_old_command_asks_for_nothing() -> None:
    watch = Watch(Drive)
    _command(watch, 0.0, 0.5)
    for tick in range(40, 200):
        _drive(watch, tick / 20, 0.0)
    assert watch.events == []


def test_two_robots_in_one_recording_are_told_apart() -> None:
    for children, spaces in [(("a/base", "b/base"), ()), (("base", "base"), ("/a/tf", "/b/tf"))]:
        watch = Watch(Drive)
        for space in spaces:
            watch.see(0.0, space, _type="tf2_msgs/msg/TFMessage", transforms=[])
        for tick in range(60):
            _drive(watch, tick / 20, 0.0, topic="/a/odom", child=children[0])
            _drive(watch, tick / 20, 0.5 if tick > 20 else 0.0, topic="/b/odom", child=children[1])
        assert [one.entity for one in watch.events] == ["base b"]


def test_two_odometries_of_one_base_give_one_start() -> None:
    watch = Watch(Drive)
    for tick in range(100):
        for topic in ("/wheels/odom", "/odometry/filtered"):
            _drive(watch, tick / 20, 0.5 if tick > 20 else 0.0, topic=topic)
    assert [one.kind for one in watch.events] == ["start"]


def test_when_the_first_odometry_ends_the_other_takes_over() -> None:
    watch = Watch(Drive)
    for tick in range(400):
        if tick < 100:
            _drive(watch, tick / 20, 0.0, topic="/wheels/odom")
        _drive(watch, tick / 20, 0.5 if tick > 200 else 0.0, topic="/odometry/filtered")
    assert [one.kind for one in watch.events] == ["start"]


def test_of_several_commands_none_that_asks_for_rest_makes_a_stall() -> None:
    watch = Watch(Following)
    for tick in range(200):
        _drive(watch, tick / 20, 0.0)
        for name, speed in [("cmd_vel_nav", 0.5), ("cmd_vel_stop", 0.0)]:
            watch.see(tick / 20 + 0.01, f"/{name}", _type=TWIST, vx=speed, vy=0.0, wz=0.0)
    assert watch.events == []


@pytest.mark.parametrize("mounted_rad", [0.0, pi / 2, pi])
def test_slip_is_found_however_the_sensor_is_mounted(mounted_rad: float) -> None:
    watch = Watch(Slip)
    up = (0.0, sin(mounted_rad), cos(mounted_rad))
    for tick in range(400):
        at_s = tick / 20
        wheels_radps = 1.0 if tick >= 100 else 0.0
        felt_radps = 1.0 if 100 <= tick < 200 else 0.1 if tick >= 200 else 0.0
        _drive(watch, at_s, 0.3, wheels_radps)
        turn = {f"w{axis}": felt_radps * part for axis, part in zip("xyz", up, strict=True)}
        force = {f"a{axis}": 9.81 * part for axis, part in zip("xyz", up, strict=True)}
        watch.see(at_s, "/anything/imu", _type=IMU, **turn, **force)
    assert [one.phase for one in watch.found("slip") if one.phase is Phase.RAISED] == [Phase.RAISED]
    assert watch.events[0].fields["wheels_faster"] is True


def test_an_unbiased_turn_is_no_slip_even_with_a_gyroscope_that_drifts() -> None:
    watch = Watch(Slip)
    for tick in range(600):
        turning = 0.8 if tick >= 300 else 0.0
        _drive(watch, tick / 20, 0.0 if tick < 300 else 0.3, turning)
        watch.see(tick / 20, "/imu", _type=IMU, wx=0.0, wy=0.0, wz=turning + 0.08, ax=0.0, ay=0.0, az=9.8)
    assert watch.events == []


def test_one_crash_is_one_shock_and_a_contact() -> None:
    watch = Watch(Shocks)
    for tick in range(400):
        az = 40.0 if 200 <= tick < 206 else 9.81 + 0.3 * (-1) ** tick
        watch.see(tick / 50, "/imu", _type=IMU, ax=0.0, ay=0.0, az=az)
    assert [one.kind for one in watch.events] == ["shock"]
    assert watch.shown == [("contact", "*")]


def test_rough_ground_is_usual_after_a_while() -> None:
    watch = Watch(Shocks)
    for tick in range(3000):
        watch.see(tick / 50, "/imu", _type=IMU, ax=0.0, ay=0.0, az=9.81 + (4.0 if tick % 2 else -4.0))
    assert watch.events == []


def test_tilt_counts_from_how_the_sensor_stood_first() -> None:
    watch = Watch(Shocks)
    for tick in range(600):
        roll = pi / 2 + (0.5 if 300 <= tick < 450 else 0.0)
        values = {"ax": 0.0, "ay": 9.81 * sin(roll), "az": 9.81 * cos(roll)}
        watch.see(tick / 50, "/imu", _type=IMU, **values, roll=roll, pitch=0.0, yaw=0.0)
    assert watch.phases("tilt") == [Phase.RAISED, Phase.CLEARED]
    assert watch.found("tilt")[0].criticality == 3


def test_two_inertial_sensors_feel_one_shock_and_one_slip() -> None:
    shocks, slips = Watch(Shocks), Watch(Slip)
    for tick in range(400):
        at_s = tick / 50
        _drive(slips, at_s, 0.3, 1.0 if tick > 200 else 0.0)
        for topic in ("/imu/one", "/imu/two"):
            shocks.see(at_s, topic, _type=IMU, ax=0.0, ay=0.0, az=40.0 if 300 <= tick < 303 else 9.8)
            slips.see(at_s, topic, _type=IMU, ax=0.0, ay=0.0, az=9.8, wx=0.0, wy=0.0, wz=0.0)
    assert [one.kind for one in shocks.events] == ["shock"]
    assert {one.phase for one in slips.events if one.phase is Phase.RAISED} == {Phase.RAISED}
    assert len({one.references for one in slips.events}) == 1


def test_noise_on_the_odometry_is_no_motion() -> None:
    watch = Watch(Drive)
    noise = Random(0)
    for tick in range(1200):
        asked_mps = 0.5 if 400 <= tick < 800 else 0.0
        _drive(watch, tick / 20, asked_mps + noise.gauss(0.0, 0.02), noise.gauss(0.0, 0.1))
    assert [one.kind for one in watch.events if one.kind == "start"] == ["start"]
    assert len(watch.events) == 2
