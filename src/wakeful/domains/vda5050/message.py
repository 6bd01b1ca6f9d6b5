"""A state message of VDA 5050 in one form, whatever the version: 1.1, 2.0, 2.1 (`agvPosition`, `batteryState`, `eStop`) or
3.0 (`mobileRobotPosition`, `powerSupply`, `activeEmergencyStop`).

The standard forbids null where a value is unknown: the field is left out. Messages filled with nulls are met all the same; here
null, a value of the wrong type and a missing field all mean the same: nothing is known, and what was known before still holds. An
empty list is a statement (no error is active), null instead of the list is none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import msgspec

from wakeful.domains.plain import Values, flag, number, whole
from wakeful.domains.plain import text as plain_text

ROWS = 64
"""Rows of a list in a message (errors, actions, loads) that are looked at."""

LEVELS = ("none", "warning", "urgent", "critical", "fatal")
"""Error levels from harmless to worst; 2.x knows WARNING and FATAL only."""

VOLATILE = frozenset({"timestamp", "headerid"})
"""References that say which message reported an error, not what the error is about."""


class Error(msgspec.Struct, frozen=True):
    """One active error. ``references`` are ``key=value``, sorted."""

    type: str
    level: int
    references: tuple[str, ...] = ()
    says: str = ""
    hint: str = ""


class Action(msgspec.Struct, frozen=True):
    """One action of the current order."""

    id: str
    type: str
    status: str
    result: str = ""


class Place(msgspec.Struct, frozen=True):
    """Where the vehicle says it is, in metres on a map."""

    x: float
    y: float
    map: str
    localized: bool
    score: float | None = None


class StateMessage(msgspec.Struct, frozen=True, kw_only=True):
    """What a state message says. None: the message doesn't say."""

    serial: str
    header: int | None = None
    order: str | None = None
    node: str = ""
    node_number: int | None = None
    nodes_left: int | None = None
    driving: bool | None = None
    paused: bool | None = None
    mode: str = ""
    travelled_m: float | None = None
    speed_m_s: float | None = None
    place: Place | None = None
    charge: float | None = None
    charging: bool | None = None
    stop: str = ""
    field_violation: bool | None = None
    errors: tuple[Error, ...] | None = None
    actions: tuple[Action, ...] | None = None
    loads: tuple[str, ...] | None = None

    @property
    def zone(self) -> str:
        """The last node, else the map."""
        return self.node or (self.place.map if self.place is not None else "")


def read(values: Values, robot: str = "") -> StateMessage | None:
    """The message in ``values``; None where it names no vehicle and ``robot`` doesn't either."""
    serial = text(values, "serialNumber", 100) or robot
    if not serial:
        return None
    power = _table(values, "powerSupply") or _table(values, "batteryState") or {}
    safety = _table(values, "safetyState") or {}
    stop = text(safety, "activeEmergencyStop", 20) or text(safety, "eStop", 20)
    charge = number(power, "stateOfCharge")
    return StateMessage(
        serial=serial,
        header=whole(values, "headerId"),
        order=text(values, "orderId", 200) if isinstance(values.get("orderId"), str) else None,
        node=text(values, "lastNodeId", 100),
        node_number=whole(values, "lastNodeSequenceId"),
        nodes_left=_length(values, "nodeStates"),
        driving=_truth(values, "driving"),
        paused=_truth(values, "paused"),
        mode=text(values, "operatingMode", 20).upper().replace("_", ""),
        travelled_m=number(values, "distanceSinceLastNode"),
        speed_m_s=_speed(_table(values, "velocity")),
        place=_place(_table(values, "mobileRobotPosition") or _table(values, "agvPosition")),
        charge=number(power, "batteryCharge") if charge is None else charge,
        charging=_truth(power, "charging"),
        stop=stop.upper(),
        field_violation=_truth(safety, "fieldViolation"),
        errors=_errors(values),
        actions=_actions(values),
        loads=_loads(values),
    )


def text(values: Values, key: str, most: int = 300) -> str:
    """The text under ``key`` as `wakeful.domains.plain.text` gives it; most need no cleaning, and a fleet sends many."""
    value = values.get(key)
    if isinstance(value, str) and len(value) <= most and value.isprintable():
        return value.strip()
    return plain_text(values, key, most)


def _errors(values: Values) -> tuple[Error, ...] | None:
    rows = _rows(values, "errors")
    if rows is None:
        return None
    worst: dict[tuple[str, tuple[str, ...]], Error] = {}
    for row in rows:
        kind = text(row, "errorType", 100)
        if not kind:
            continue
        level = text(row, "errorLevel", 20).lower()
        references = sorted(
            f"{key}={text(reference, 'referenceValue', 100)}"
            for reference in _rows(row, "errorReferences") or ()
            if (key := text(reference, "referenceKey", 50)) and key.lower() not in VOLATILE
        )
        error = Error(
            type=kind,
            level=LEVELS.index(level) if level in LEVELS else 1,
            references=tuple(references),
            says=text(row, "errorDescription"),
            hint=text(row, "errorHint"),
        )
        before = worst.get(key_of := (error.type, error.references))
        if before is None or before.level < error.level:
            worst[key_of] = error
    return tuple(worst.values())


def _actions(values: Values) -> tuple[Action, ...] | None:
    rows = _rows(values, "actionStates")
    if rows is None:
        return None
    return tuple(
        Action(
            id=text(row, "actionId", 100),
            type=text(row, "actionType", 100),
            status=text(row, "actionStatus", 20).upper(),
            result=text(row, "resultDescription") or text(row, "actionResult"),
        )
        for row in rows
        if row.get("actionId")
    )


def _loads(values: Values) -> tuple[str, ...] | None:
    rows = _rows(values, "loads")
    if rows is None:
        return None
    return tuple(sorted(text(row, "loadId", 100) or text(row, "loadType", 100) or "load" for row in rows))


def _place(table: Values | None) -> Place | None:
    if table is None:
        return None
    x, y = number(table, "x"), number(table, "y")
    localized = _truth(table, "localized")
    if localized is None:
        localized = _truth(table, "positionInitialized")
    if x is None or y is None:
        return None
    return Place(
        x=x, y=y, map=text(table, "mapId", 100), localized=localized is not False, score=number(table, "localizationScore")
    )


def _speed(table: Values | None) -> float | None:
    if table is None:
        return None
    vx, vy = number(table, "vx"), number(table, "vy")
    return None if vx is None and vy is None else float(((vx or 0.0) ** 2 + (vy or 0.0) ** 2) ** 0.5)


def _truth(table: Values, key: str) -> bool | None:
    return flag(table, key) if isinstance(table.get(key), bool) else None


def _table(values: Values, key: str) -> Values | None:
    found = values.get(key)
    return found if isinstance(found, Mapping) else None


def _rows(values: Values, key: str) -> list[Values] | None:
    found = values.get(key)
    if not isinstance(found, Sequence) or isinstance(found, str | bytes):
        return None
    return [row for row in found[:ROWS] if isinstance(row, Mapping)]


def _length(values: Values, key: str) -> int | None:
    found = values.get(key)
    return len(found) if isinstance(found, Sequence) and not isinstance(found, str | bytes) else None
