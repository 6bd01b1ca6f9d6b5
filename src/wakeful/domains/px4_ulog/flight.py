"""The vehicle's own state as every detector of a flight needs it: armed, in the air, in which mode, and who wanted that."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from wakeful.domains.plain import Values, flag, whole
from wakeful.facts.events import Observation
from wakeful.facts.values import Field

NAV_STATES: Mapping[int, str] = {
    0: "manual",
    1: "altitude",
    2: "position",
    3: "mission",
    4: "hold",
    5: "return",
    6: "position_slow",
    8: "land_engine_failure",
    9: "land_gps_failure",
    10: "acro",
    12: "descend",
    13: "termination",
    14: "offboard",
    15: "stabilized",
    16: "rattitude",
    17: "takeoff",
    18: "land",
    19: "follow",
    20: "precision_land",
    21: "orbit",
    22: "vtol_takeoff",
}
"""vehicle_status.nav_state (PX4 msg/VehicleStatus.msg; 8, 9 and 16 in firmware up to 1.11)."""

MAIN_STATES: Mapping[int, int] = {
    **{main: main for main in range(6)},
    6: 10,
    7: 14,
    8: 15,
    9: 16,
    10: 17,
    11: 18,
    12: 19,
    13: 20,
    14: 21,
    15: 22,
}
"""commander_state.main_state, the mode that was asked for in firmware up to 1.13, as the nav_state of that mode."""

SAFE_MODES = frozenset({5, 8, 9, 12, 13, 18})
"""Modes that a failsafe chooses: return, land, descend, terminate."""

_ARMED = frozenset({2, 3, 6})
_FIXED_WING = 2


def split_topic(topic: str) -> tuple[str, int]:
    """A ULog topic as (name, instance).

    >>> split_topic("battery_status.1"), split_topic("battery_status")
    (('battery_status', 1), ('battery_status', 0))
    """
    name, _, instance = topic.rpartition(".")
    return (name, int(instance)) if name and instance.isascii() and instance.isdecimal() and len(instance) < 5 else (topic, 0)


def numbered(what: str, instance: int, always: bool = False) -> str:
    """The name of a device with several instances, counted from 1 as PX4's parameters count them.

    >>> numbered("battery", 1), numbered("estimator", 0)
    ('battery 2', 'estimator')
    """
    return f"{what} {instance + 1}" if instance or always else what


class Flight(msgspec.Struct):
    """What is known of the vehicle so far. Old and new firmware say it in different fields; None is not known yet."""

    armed: bool | None = None
    landed: bool | None = None
    nav: int | None = None
    wanted: int | None = None
    fixed_wing: bool = False

    def see(self, observation: Observation) -> None:
        """Take up what one observation says of the vehicle's state."""
        values = observation.values
        match observation.topic:
            case "vehicle_status":
                self._status(values)
            case "commander_state":
                main = whole(values, "main_state")
                self.wanted = self.wanted if main is None else MAIN_STATES.get(main, main)
            case "vehicle_land_detected":
                landed = flag(values, "landed")
                self.landed = self.landed if landed is None else landed

    def _status(self, values: Values) -> None:
        arming, nav = whole(values, "arming_state"), whole(values, "nav_state")
        wanted = whole(values, "nav_state_user_intention")
        kind, rotary = whole(values, "vehicle_type"), flag(values, "is_rotary_wing")
        self.fixed_wing = kind == _FIXED_WING if kind is not None else rotary is False
        self.armed = self.armed if arming is None else arming in _ARMED
        self.nav = self.nav if nav is None else nav
        self.wanted = self.wanted if wanted is None else wanted

    @property
    def airborne(self) -> bool:
        """Armed and not on the ground; without a land detector, armed."""
        return bool(self.armed) and not self.landed

    @property
    def mode(self) -> str:
        """The name of the flight mode."""
        return mode_name(self.nav)

    def fields(self) -> dict[str, Field]:
        """The part of an event's fields that says in what state the vehicle was."""
        return {"armed": bool(self.armed), "airborne": self.airborne, "mode": self.mode}

    def says(self) -> str:
        """That state in words, to end a sentence with."""
        if not self.armed:
            return "disarmed"
        return f"{'in the air' if self.airborne else 'armed on the ground'}, {self.mode} mode"


def mode_name(nav: int | None) -> str:
    """The name of a nav_state.

    >>> mode_name(5), mode_name(24), mode_name(None)
    ('return', 'external', 'unknown')
    """
    if nav is None:
        return "unknown"
    return NAV_STATES.get(nav, "external" if 23 <= nav <= 30 else "unknown")
