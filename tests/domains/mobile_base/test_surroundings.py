"""Obstacles, silence, jumps, reports and safety sensors, from messages made by hand."""

from __future__ import annotations

from math import pi

from tests.domains.watching import Watch
from wakeful.domains.mobile_base.contacts import Contacts
from wakeful.domains.mobile_base.jumps import Jumps
from wakeful.domains.mobile_base.obstacles import Obstacles
from wakeful.domains.mobile_base.reports import Reports
from wakeful.domains.mobile_base.silence import Silence
from wakeful.facts.events import Phase

ODOMETRY, SCAN, IMU, TF = "nav_msgs/msg/Odometry", "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/Imu", "tf2_msgs/msg/TFMessage"


def _approach(watch: Watch, sector: str, speed_mps: float, bearing: float = 0.0) -> None:
    for tick in range(100):
        at_s = tick / 10
        distance_m = max(4.0 - abs(speed_mps) * at_s, 0.2)
        watch.see(at_s, "/o", _type=ODOMETRY, vx=speed_mps, vy=0.0, wz=0.0, x=0.0, y=0.0, yaw=0.0, child_frame="base_link")
        watch.see(at_s + 0.01, "/s", _type=SCAN, frame="laser", **{sector: distance_m, f"{sector}_bearing": bearing})


def test_an_approach_is_raised_in_time_and_gets_worse() -> None:
    watch = Watch(Obstacles)
    _approach(watch, "front", 0.5)
    assert watch.phases("obstacle") == [Phase.RAISED, Phase.CHANGED]
    first = watch.events[0]
    assert first.entity == "front obstacle"
    assert 2.0 <= float(str(first.fields["ttc_s"])) <= 3.0
    assert watch.events[1].criticality == 3


def test_driving_backward_it_is_the_rear_that_counts() -> None:
    watch = Watch(Obstacles)
    _approach(watch, "front", -0.5)
    assert watch.events == []
    watch = Watch(Obstacles)
    _approach(watch, "back", -0.5, pi)
    assert watch.events[0].entity == "rear obstacle"


def test_a_scanner_that_is_mounted_sideways_looks_ahead_all_the_same() -> None:
    turned = {"parent": "base_link", "child": "laser", "x": 0.0, "y": 0.0, "z": 0.2, "yaw": pi / 2}
    watch = Watch(Obstacles)
    watch.see(0.0, "/tf_static", _type=TF, transforms=[turned])
    _approach(watch, "right", 0.5, -pi / 2)
    assert watch.events[0].entity == "front obstacle"
    watch = Watch(Obstacles)
    watch.see(0.0, "/tf_static", _type=TF, transforms=[turned])
    _approach(watch, "front", 0.5)
    assert watch.events == []


def test_a_wall_beside_the_path_is_no_obstacle() -> None:
    watch = Watch(Obstacles)
    for tick in range(100):
        watch.see(tick / 10, "/o", _type=ODOMETRY, vx=0.5, vy=0.0, wz=0.0, x=0.0, y=0.0, yaw=0.0)
        watch.see(tick / 10, "/s", _type=SCAN, frame="base_laser", front=0.9, front_bearing=0.75, left=0.6, left_bearing=1.5)
    assert watch.events == []


def test_what_keeps_its_distance_is_part_of_the_base_or_drives_ahead() -> None:
    watch = Watch(Obstacles)
    for tick in range(100):
        watch.see(tick / 10, "/o", _type=ODOMETRY, vx=0.5, vy=0.0, wz=0.0, x=0.0, y=0.0, yaw=0.0)
        watch.see(tick / 10, "/s", _type=SCAN, frame="base_laser", front=0.3, front_bearing=0.0)
    assert watch.events == []


def test_a_standing_base_approaches_nothing() -> None:
    watch = Watch(Obstacles)
    for tick in range(100):
        watch.see(tick / 10, "/o", _type=ODOMETRY, vx=0.0, vy=0.0, wz=0.0, x=0.0, y=0.0, yaw=0.0)
        watch.see(tick / 10, "/s", _type=SCAN, frame="base_laser", front=0.2, front_bearing=0.0)
    assert watch.events == []


def test_a_stream_that_stops_is_silent_once_and_heard_again_once() -> None:
    watch = Watch(Silence)
    for tick in range(600):
        if not 200 <= tick < 400:
            watch.see(tick / 20, "/scan", _type=SCAN, min=1.0)
        watch.see(tick / 20, "/imu", _type=IMU, az=9.8)
        if tick < 100:
            watch.see(tick / 20, "/cmd_vel", _type="geometry_msgs/msg/Twist", vx=0.0)
    assert [(one.entity, one.phase) for one in watch.found()] == [("/scan", Phase.RAISED), ("/scan", Phase.CLEARED)]
    assert watch.shown == [("fault", "*"), ("recovered", "/scan")]


def test_a_pause_of_the_recorder_is_one_event_and_nobodys_silence() -> None:
    watch = Watch(Silence)
    for tick in [*range(200), *range(400, 600)]:
        for topic, kind in [("/scan", SCAN), ("/imu", IMU), ("/odom", ODOMETRY)]:
            watch.see(tick / 20, topic, _type=kind)
    assert [one.kind for one in watch.found()] == ["recording_gap"]


def test_a_pose_that_moves_faster_than_it_claims_is_a_jump() -> None:
    watch = Watch(Jumps)
    for tick in range(100):
        x = 0.5 * tick / 20 + (3.0 if tick >= 60 else 0.0)
        watch.see(tick / 20, "/o", _type=ODOMETRY, vx=0.5, vy=0.0, wz=0.0, x=x, y=0.0, yaw=0.0, frame="odom", child_frame="base")
    (jump,) = watch.events
    assert jump.entity == "odom→base"
    assert jump.fields["jump_m"] == 3.025
    assert watch.shown == [("fault", "*")]


def test_crossing_the_seam_of_the_circle_is_no_jump() -> None:
    watch = Watch(Jumps)
    for tick in range(100):
        yaw = 3.0 + 0.5 * tick / 20
        yaw = yaw - 2 * pi if yaw > pi else yaw
        watch.see(tick / 20, "/o", _type=ODOMETRY, vx=0.0, vy=0.0, wz=0.5, x=0.0, y=0.0, yaw=yaw)
    assert watch.events == []


def test_a_localisation_that_is_corrected_by_a_metre_is_a_jump_of_its_transform() -> None:
    watch = Watch(Jumps)
    for tick in range(100):
        x = 0.01 * tick + (1.2 if tick >= 70 else 0.0)
        transform = {"parent": "map", "child": "odom", "x": x, "y": 0.0, "z": 0.0, "yaw": 0.0, "at_s": tick / 20}
        watch.see(tick / 20, "/tf", _type=TF, transforms=[transform])
    assert [one.entity for one in watch.events] == ["map→odom"]


def test_a_lost_fix_is_a_condition_and_a_receiver_without_one_is_none() -> None:
    watch = Watch(Jumps)
    for tick in range(100):
        fix = -1 if 40 <= tick < 60 else 0
        watch.see(tick / 5, "/fix", _type="sensor_msgs/msg/NavSatFix", fix=fix, latitude=47.0, longitude=8.0)
        watch.see(tick / 5, "/never", _type="sensor_msgs/msg/NavSatFix", fix=-1, latitude=0.0, longitude=0.0)
    assert [(one.entity, one.phase) for one in watch.found()] == [("/fix", Phase.RAISED), ("/fix", Phase.CLEARED)]


def test_a_diagnostic_changes_with_its_level_and_clears_at_ok() -> None:
    watch = Watch(Reports)
    for second, level in enumerate([0, 0, 1, 1, 1, 2, 2, 0, 0]):
        status = [{"name": "motor left", "level": level, "message": "hot"}, {"name": "camera", "level": 0, "message": "ok"}]
        watch.see(float(second), "/diagnostics", _type="diagnostic_msgs/msg/DiagnosticArray", status=status)
    assert watch.phases() == [Phase.RAISED, Phase.CHANGED, Phase.CLEARED]
    assert watch.shown == [("fault", "*"), ("recovered", "motor left")]


def test_a_node_that_repeats_its_warning_gives_one_event() -> None:
    watch = Watch(Reports)
    for second in range(50):
        text = f"Control loop missed its desired rate of 20.0 Hz, took {second / 100} s"
        watch.see(float(second), "/rosout", _type="rcl_interfaces/msg/Log", level="warning", name="controller", msg=text)
        watch.see(float(second), "/rosout", _type="rcl_interfaces/msg/Log", level="info", name="controller", msg="tick")
    assert len(watch.events) == 1
    assert len(watch.found()) == 50


def test_a_bumper_is_a_contact_whatever_its_message_is_called() -> None:
    watch = Watch(Contacts)
    for at_s, left in enumerate([0, 0, 1, 1, 0]):
        watch.see(float(at_s), "/bump", _type="neato_interfaces/msg/Bump", left_front=left, right_front=0)
    for at_s, state in enumerate([0, 1, 0]):
        watch.see(float(at_s), "/events/b", _type="kobuki_msgs/msg/BumperEvent", bumper=2, state=state)
    for at_s, kinds in enumerate([[], [1], []]):
        flat = {"detections.count": len(kinds), **{f"detections.{index}.type": kind for index, kind in enumerate(kinds)}}
        watch.see(float(at_s), "/h", _type="irobot_create_msgs/msg/HazardDetectionVector", **flat)
    assert watch.phases("contact") == [Phase.RAISED, Phase.CLEARED] * 3
    assert [one.entity for one in watch.events] == ["bumper", "bumper 3", "bumper"]


def test_a_battery_is_low_once_in_either_way_of_counting() -> None:
    for whole in (1.0, 100.0):
        watch = Watch(Contacts)
        for minute in range(60):
            share = (0.5 - minute / 100) * whole
            watch.see(
                60.0 * minute, "/b", _type="sensor_msgs/msg/BatteryState", percentage=max(share, 0.05 * whole), present=True
            )
        assert watch.phases("battery_low")[0] is Phase.RAISED
        assert len(watch.events) <= 2
