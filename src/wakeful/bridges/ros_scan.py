"""A laser scan in a few numbers: how much it sees, how near, and how near in which direction."""

from __future__ import annotations

from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from wakeful.facts.values import Value

#: A decoded sensor_msgs/LaserScan; its class is made when the recording is read.
Scan: TypeAlias = Any
Numbers: TypeAlias = NDArray[np.float64]

_QUARTER: Final = np.pi / 4
_SECTORS: Final = ("front", "left", "right", "back")


def laser_scan(message: Scan) -> dict[str, Value]:
    """Reduces a scan's ranges to their number, the share that is valid, and the nearest ones.

    A ray is valid when it is finite and between ``range_min`` and ``range_max`` (a ``range_max`` of 0 is none). Ahead is within
    45° of the scan's zero bearing, left the next 90° anticlockwise. Bearings in radians within ±π.
    """
    ranges = np.asarray(message.ranges, dtype=np.float64)
    nearest, farthest = float(message.range_min), float(message.range_max)
    with np.errstate(invalid="ignore"):
        valid = np.isfinite(ranges) & (ranges >= nearest)
        if farthest > 0:
            valid &= ranges <= farthest
        bearings = float(message.angle_min) + float(message.angle_increment) * np.arange(len(ranges))
        bearings = np.arctan2(np.sin(bearings), np.cos(bearings))
    limits = ("angle_min", "angle_max", "angle_increment", "range_min", "range_max")
    values: dict[str, Value] = {name: _finite(float(getattr(message, name))) for name in limits}
    seen, toward = ranges[valid], bearings[valid]
    values |= {
        "rays": len(ranges),
        "valid_share": round(float(valid.mean()), 6) if len(ranges) else None,
        "p05": _finite(float(np.quantile(seen, 0.05))) if len(seen) else None,
        "median": _finite(float(np.median(seen))) if len(seen) else None,
        **_nearest("min", "min_bearing", seen, toward),
    }
    sides = np.abs(toward)
    within = {
        "front": sides <= _QUARTER,
        "left": (sides > _QUARTER) & (sides <= 3 * _QUARTER) & (toward > 0),
        "right": (sides > _QUARTER) & (sides <= 3 * _QUARTER) & (toward < 0),
        "back": sides > 3 * _QUARTER,
    }
    for sector in _SECTORS:
        values |= _nearest(sector, f"{sector}_bearing", seen[within[sector]], toward[within[sector]])
    return values


def _nearest(name: str, bearing_name: str, ranges: Numbers, bearings: Numbers) -> dict[str, Value]:
    if not len(ranges):
        return {name: None, bearing_name: None}
    at = int(np.argmin(ranges))
    return {name: float(ranges[at]), bearing_name: _finite(float(bearings[at]))}


def _finite(number: float) -> float | None:
    return number if np.isfinite(number) else None
