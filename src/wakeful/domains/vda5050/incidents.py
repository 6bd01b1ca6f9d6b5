"""What goes wrong with a simulated vehicle, and how it ends: each kind of incident with its own course."""

from __future__ import annotations

from random import Random

import msgspec

WARNING, FATAL = "WARNING", "FATAL"


class Incident(msgspec.Struct, kw_only=True):
    """One thing that is wrong now, from ``began_s`` until ``ends_s``; at ``turns_s`` (where it turns) it becomes FATAL."""

    type: str
    says: str
    began_s: float
    ends_s: float
    hint: str = ""
    level: str = WARNING
    references: tuple[tuple[str, str], ...] = ()
    turns_s: float | None = None
    stop: str = "NONE"
    """The emergency stop that it brings about, from the beginning or once it has turned."""
    stops_at_once: bool = False
    violates: bool = False
    loses_position: bool = False
    holds: bool = False
    """Whether the vehicle can't drive while it lasts."""

    @property
    def stopping(self) -> bool:
        """Whether it holds the vehicle in an emergency stop now."""
        return self.stop != "NONE" and (self.stops_at_once or self.level == FATAL)


PER_HOUR = {
    "obstacleDetected": 14.0,
    "localizationUncertain": 6.0,
    "driveOvertemperature": 5.0,
    "wifiWeak": 6.0,
    "maintenanceDue": 0.7,
}
"""How often each begins, in an hour of driving."""

RISKY_ROWS = ("N4", "N5")
"""Rows of nodes with few features to localize by: there it happens four times as often, and ends badly more often."""


def begins(kind: str, random: Random, now_s: float, node: str, loaded: bool) -> Incident:
    """An incident of this kind that begins now; whether it turns bad depends on place and load, in part."""
    match kind:
        case "obstacleDetected":
            stays = random.random() < 0.08
            touches = random.random() < 0.35
            return Incident(
                type=kind,
                says="Obstacle in the driving lane",
                hint="Clear the lane",
                began_s=now_s,
                ends_s=now_s + (random.uniform(150, 400) if stays else random.uniform(6, 45)),
                references=(("nodeId", node),),
                turns_s=now_s + random.uniform(40, 90) if stays else None,
                stop="MANUAL" if stays else "AUTOACK" if touches else "NONE",
                stops_at_once=touches and not stays,
                violates=touches or stays,
                holds=True,
            )
        case "localizationUncertain":
            lost = random.random() < (0.7 if node.startswith(RISKY_ROWS) else 0.2)
            turns_s = now_s + random.uniform(25, 60)
            return Incident(
                type=kind,
                says="Localization score below threshold",
                hint="Check the laser scanner, compare the map",
                began_s=now_s,
                ends_s=turns_s + random.uniform(60, 200) if lost else now_s + random.uniform(15, 70),
                turns_s=turns_s if lost else None,
                stop="MANUAL" if lost else "NONE",
                loses_position=True,
            )
        case "driveOvertemperature":
            worse = random.random() < (0.6 if loaded else 0.1)
            turns_s = now_s + random.uniform(40, 120)
            return Incident(
                type=kind,
                says="Drive motor temperature above 85 °C",
                hint="Let the drive cool down",
                began_s=now_s,
                ends_s=turns_s + random.uniform(120, 300) if worse else now_s + random.uniform(60, 180),
                turns_s=turns_s if worse else None,
                holds=worse,
            )
        case "wifiWeak":
            return Incident(
                type=kind,
                says="Signal strength below -80 dBm",
                began_s=now_s,
                ends_s=now_s + random.uniform(10, 60),
                references=(("nodeId", node),),
            )
        case _:
            return Incident(
                type=kind,
                says="Service interval exceeded",
                hint="Plan a service",
                began_s=now_s,
                ends_s=now_s + random.uniform(3_600, 10_800),
            )
