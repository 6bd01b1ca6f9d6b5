"""A step far beyond the usual one."""

from __future__ import annotations

from random import Random

from tests.registration.watching import detector, founds


def test_a_step_far_beyond_the_usual_one_is_a_jump() -> None:
    random = Random(0)
    values, at = [], 0.0
    for index in range(300):
        at += random.gauss(0, 0.1) + (5.0 if index == 200 else 0.0)
        values.append(at)
    found = founds(detector("jump", times=8.0), values)
    assert [index for index, _ in found] == [200]


def test_an_angle_that_wraps_does_not_jump() -> None:
    angles = [(0.1 * step + 3.14159) % 6.28318 - 3.14159 for step in range(300)]
    assert founds(detector("jump", turn=6.28318), angles) == []
    assert founds(detector("jump"), angles) != []


def test_values_too_far_apart_in_time_are_not_compared() -> None:
    watcher = detector("jump", longest_s=5.0)
    founds(watcher, [float(step % 2) for step in range(100)])
    assert founds(watcher, [50.0], start=200) == []
