"""Time to consequence: how long until what the event shows becomes harm, where it carries enough to tell.

Fields are known by the house's names with units in them (``distance_m``, ``speed_mps``, ``tilt_deg``, ``slope_per_s``).
Source: time to collision, Hayward 1972; a trend's time to its limit is the same quotient.
"""

from __future__ import annotations

from collections.abc import Mapping

from wakeful.facts.values import Fact, Field
from wakeful.treatments.measures import number, significant
from wakeful.treatments.wording import figure, quantity, span

_TTC = ("ttc_s", "time_to_collision_s", "time_to_contact_s")
_DISTANCE = ("distance_m", "range_m", "clearance_m", "gap_m", "distance")
_SPEED = ("closing_speed_mps", "closing_mps", "approach_mps", "speed_mps", "velocity_mps", "speed")
_TILT = ("tilt_deg", "roll_deg", "pitch_deg", "tilt_rad")
_TILT_RATE = ("tilt_rate_dps", "tilt_rate_degps", "roll_rate_dps", "pitch_rate_dps", "tilt_rate_radps")
_TILT_LIMIT = ("tilt_limit_deg", "tipping_deg", "limit_deg", "tilt_limit_rad")
_VALUE = ("value", "level", "now")
_SLOPE = ("slope_per_s", "trend_per_s", "rate_per_s")
_SLOPE_PER_MIN = ("slope_per_min", "trend_per_min", "rate_per_min")
_UPPER = ("limit", "limit_high", "high_limit", "maximum", "high")
_LOWER = ("limit", "limit_low", "low_limit", "minimum", "low")

#: Nothing that is farther off than this is a consequence of this event.
HORIZON_S = 86_400.0


class Countdown(Fact, frozen=True):
    """What will happen, in how many seconds, and from which numbers that follows."""

    what: str
    in_s: float
    because: str


def countdown(fields: Mapping[str, Field]) -> Countdown | None:
    """The earliest consequence that the fields' kinematics lead to; None where they lead to none.

    >>> countdown({"distance_m": 1.0, "speed_mps": 0.5}).in_s
    2.0
    """
    found = [each for each in (_told(fields), _contact(fields), _tipping(fields), _limit(fields)) if each is not None]
    return min(found, key=lambda each: each.in_s, default=None)


def to_limit(value: float, slope_per_s: float, fields: Mapping[str, Field]) -> Countdown | None:
    """When a value with this slope reaches the limit that the fields name on that side."""
    _, limit = _first(fields, _UPPER if slope_per_s > 0.0 else _LOWER)
    if limit is None or slope_per_s == 0.0:
        return None
    because = f"{figure(value)} changing by {figure(slope_per_s)} per second towards {figure(limit)}"
    return _within("the limit is reached", (limit - value) / slope_per_s, because)


def _told(fields: Mapping[str, Field]) -> Countdown | None:
    name, value = _first(fields, _TTC)
    return None if value is None else _within("contact", value, f"{name} says {span(value)}")


def _contact(fields: Mapping[str, Field]) -> Countdown | None:
    near, distance = _first(fields, _DISTANCE)
    fast, speed = _first(fields, _SPEED)
    if distance is None or speed is None or speed <= 0.0:
        return None
    return _within("contact", distance / speed, f"{quantity(near, distance)} at {quantity(fast, speed)}")


def _tipping(fields: Mapping[str, Field]) -> Countdown | None:
    name, tilt = _first(fields, _TILT)
    turning, rate = _first(fields, _TILT_RATE)
    edge, limit = _first(fields, _TILT_LIMIT)
    if tilt is None or rate is None or limit is None or rate == 0.0 or len({n[-3:] for n in (name, edge)}) > 1:
        return None
    if name.endswith("rad") != turning.endswith("radps"):
        return None
    side = abs(limit) if rate > 0.0 else -abs(limit)
    return _within("it tips over", (side - tilt) / rate, f"{quantity(name, tilt)} turning at {quantity(turning, rate)}")


def _limit(fields: Mapping[str, Field]) -> Countdown | None:
    _, value = _first(fields, _VALUE)
    _, slope = _first(fields, _SLOPE)
    _, per_min = _first(fields, _SLOPE_PER_MIN)
    slope = slope if slope is not None or per_min is None else per_min / 60.0
    return None if value is None or slope is None else to_limit(value, slope, fields)


def _first(fields: Mapping[str, Field], names: tuple[str, ...]) -> tuple[str, float | None]:
    for name in names:
        value = number(fields.get(name))
        if value is not None:
            return name, value
    return "", None


def _within(what: str, in_s: float, because: str) -> Countdown | None:
    # below zero the consequence lies behind, or the thing moves away from it
    return Countdown(what=what, in_s=significant(in_s), because=because) if 0.0 <= in_s <= HORIZON_S else None
