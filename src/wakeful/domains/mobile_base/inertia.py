"""Inertial sensors as they are mounted: which way is up for them, and how fast the base turns by them."""

from __future__ import annotations

from math import acos, cos, exp, hypot, sin

import msgspec

from wakeful.domains.plain import Values, number
from wakeful.facts.time import to_s

Vector = tuple[float, float, float]

GRAVITY_MPS2 = 9.81


class Up(msgspec.Struct):
    """The direction that is up in the sensor's own frame, as a slow mean of what it feels: it rests on the ground mostly.

    So a sensor that is mounted on its side or upside down is understood without anybody's word for it.
    """

    mean: Vector | None = None
    seen_ns: int = 0
    seen_s: float = 0.0

    def see(self, felt: Vector, at_ns: int, slow_s: float = 10.0) -> Vector:
        """Take up one acceleration (m/s²); returns the direction as a unit vector."""
        passed_s = max(0.0, min(1.0, to_s(at_ns - self.seen_ns))) if self.mean is not None else 0.0
        self.seen_ns, self.seen_s = at_ns, self.seen_s + passed_s
        if self.mean is None:
            self.mean = felt
        else:
            share = 1.0 - exp(-passed_s / min(slow_s, max(self.seen_s, 0.1)))
            self.mean = _mix(self.mean, felt, share)
        return unit(self.mean)

    @property
    def sure(self) -> bool:
        """Whether it has felt gravity for two seconds, and about as much as there is."""
        return self.mean is not None and self.seen_s >= 2.0 and 0.7 < hypot(*self.mean) / GRAVITY_MPS2 < 1.3


def felt(values: Values) -> Vector | None:
    """The acceleration of an Imu message; None where a part is missing, or all are zero (no accelerometer)."""
    parts = (number(values, "ax"), number(values, "ay"), number(values, "az"))
    if parts[0] is None or parts[1] is None or parts[2] is None or not any(parts):
        return None
    return (parts[0], parts[1], parts[2])


def turned(values: Values) -> Vector | None:
    """The angular velocity of an Imu message; None where a part is missing."""
    parts = (number(values, "wx"), number(values, "wy"), number(values, "wz"))
    if parts[0] is None or parts[1] is None or parts[2] is None:
        return None
    return (parts[0], parts[1], parts[2])


def up_of_orientation(values: Values) -> Vector | None:
    """Up in the sensor's frame by the orientation that an Imu message gives; None where it gives none."""
    roll, pitch = number(values, "roll"), number(values, "pitch")
    if roll is None or pitch is None:
        return None
    return (-sin(pitch), sin(roll) * cos(pitch), cos(roll) * cos(pitch))


def unit(vector: Vector) -> Vector:
    """The vector's direction; a zero vector points along z."""
    size = hypot(*vector)
    return (0.0, 0.0, 1.0) if size == 0.0 else (vector[0] / size, vector[1] / size, vector[2] / size)


def dot(one: Vector, other: Vector) -> float:
    """The inner product."""
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def angle(one: Vector, other: Vector) -> float:
    """The angle between two directions in radians."""
    return acos(max(-1.0, min(1.0, dot(unit(one), unit(other)))))


def _mix(one: Vector, other: Vector, share: float) -> Vector:
    keep = 1.0 - share
    return (keep * one[0] + share * other[0], keep * one[1] + share * other[1], keep * one[2] + share * other[2])
