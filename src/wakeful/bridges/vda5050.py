"""How the messages of VDA 5050 are told apart: they arrive as bare JSON, and their topic is that of the standard."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from wakeful.facts.values import Value

#: Every message of the standard begins with these.
_HEADER: Final = frozenset(("version", "manufacturer", "serialNumber"))
#: Topic → fields of which one at least stands in such a message and in no other; the first topic that fits is taken.
_MARKS: Final[tuple[tuple[str, frozenset[str]], ...]] = (
    ("state", frozenset(("operatingMode", "batteryState", "powerSupply", "safetyState", "actionStates", "nodeStates"))),
    ("connection", frozenset(("connectionState",))),
    ("factsheet", frozenset(("typeSpecification", "physicalParameters"))),
    ("instantActions", frozenset(("instantActions", "actions"))),
    ("order", frozenset(("nodes", "edges", "orderUpdateId"))),
    ("visualization", frozenset(("agvPosition", "mobileRobotPosition", "velocity"))),
)


def topic_of(message: Mapping[str, Value]) -> str:
    """The standard's topic of a message; empty where it is none of the standard's.

    >>> topic_of({"version": "2.0.0", "manufacturer": "m", "serialNumber": "s", "operatingMode": "AUTOMATIC"})
    'state'
    >>> topic_of({"operatingMode": "AUTOMATIC"})
    ''
    """
    if len(_HEADER & message.keys()) < 2:
        return ""
    return next((topic for topic, marks in _MARKS if not marks.isdisjoint(message)), "")
