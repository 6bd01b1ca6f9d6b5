"""Clocks that differ between topics change nothing of what is seen."""

from __future__ import annotations

import pytest

from tests.domains.watching import Watch
from wakeful.domains.mobile_base.following import Following
from wakeful.domains.mobile_base.silence import Silence

ODOMETRY, SCAN, TWIST = "nav_msgs/msg/Odometry", "sensor_msgs/msg/LaserScan", "geometry_msgs/msg/Twist"


@pytest.mark.parametrize("skew_s", [-8.0, -0.3, 0.0, 0.3, 8.0])
def test_a_shortfall_is_seen_though_commands_are_stamped_by_another_clock(skew_s: float) -> None:
    watch = Watch(Following)
    for tick in range(300):
        at_s = 100.0 + tick / 20
        watch.see(at_s, "/odom", _type=ODOMETRY, vx=0.3, vy=0.0, wz=0.0, x=0.0, y=0.0, yaw=0.0)
        if tick % 5 == 0:
            watch.see(at_s + skew_s, "/cmd_vel", _type=TWIST, vx=0.5, vy=0.0, wz=0.0)
    assert [one.kind for one in watch.events] == ["shortfall"]


@pytest.mark.parametrize("skew_s", [-8.0, 0.0, 8.0])
def test_a_scanner_with_another_clock_is_neither_silent_nor_a_gap_until_it_is(skew_s: float) -> None:
    watch = Watch(Silence)
    for tick in range(600):
        at_s = 100.0 + tick / 20
        watch.see(at_s, "/odom", _type=ODOMETRY, vx=0.0, wz=0.0)
        if tick < 400:
            watch.see(at_s + skew_s, "/scan", _type=SCAN, min=1.0)
    assert [(one.kind, one.entity) for one in watch.events] == [("silence", "/scan")]
