"""A simulated vehicle: it drives its orders over a grid of nodes, gets into trouble, and tells all of it in state messages."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from random import Random

import msgspec

from wakeful.domains.vda5050.incidents import FATAL, PER_HOUR, RISKY_ROWS, Incident, begins
from wakeful.facts.values import Value

VERSION = "2.1.0"
MANUFACTURER = "Wakeful Works"
MAP = "hall_1"
SIDE = 6
SPACING_M = 5.0
SPEED_M_S = 1.2
HANDLING_S = 12.0
START = datetime(2026, 1, 5, 6, 0, tzinfo=UTC)

Body = dict[str, Value]


class Action(msgspec.Struct):
    """A pick or drop at the order's node ``sequence``."""

    id: str
    type: str
    sequence: int
    status: str = "WAITING"
    until_s: float = 0.0


class Vehicle:
    """One vehicle of the fleet. ``step`` lets time pass and gives the state message of that instant."""

    def __init__(self, serial: str, seed: int) -> None:
        self.serial = serial
        self._random = Random(f"vda5050 {seed} {serial}")
        self._header = -1
        self._now_s = 0.0
        self._orders = 0
        self._order = ""
        self._path: list[str] = []
        self._at = 0
        self._gone_m = 0.0
        self._node = f"N{self._random.randrange(SIDE)}{self._random.randrange(SIDE)}"
        self._actions: list[Action] = []
        self._load = ""
        self._charge = self._random.uniform(45, 95)
        self._charging = False
        self._incidents: list[Incident] = []
        self._score = 0.93
        self._shift_m = 0.0
        self._mode = "AUTOMATIC"
        self._attended_until_s = 0.0
        self._spins_until_s = 0.0
        self._paused_until_s = 0.0
        self._rests_until_s = self._random.uniform(0, 10)

    def step(self, elapsed_s: float) -> Body:
        """Let time pass and tell the state."""
        self._now_s += elapsed_s
        self._suffer(elapsed_s)
        if not self._held():
            self._work(elapsed_s)
        self._charge += elapsed_s * (0.05 if self._charging else -0.012 if self._driving() else -0.002)
        self._charge = min(100.0, max(1.0, self._charge))
        self._header += 1
        return self._message()

    def pause_s(self) -> float:
        """How long until the next message: often while it works, seldom while it rests."""
        busy = self._driving() or any(action.status == "RUNNING" for action in self._actions) or self._incidents
        return self._random.uniform(0.9, 1.1) if busy else self._random.uniform(4.5, 5.5)

    def loses(self) -> bool:
        """Whether the next message is lost on the way; it is numbered all the same."""
        weak = any(incident.type == "wifiWeak" for incident in self._incidents)
        return weak and self._random.random() < 0.5

    def _suffer(self, elapsed_s: float) -> None:
        random, ended = self._random, []
        if self._driving():
            open_ = {incident.type for incident in self._incidents}
            for kind, per_hour in PER_HOUR.items():
                risky = 4.0 if kind == "localizationUncertain" and self._node.startswith(RISKY_ROWS) else 1.0
                if kind not in open_ and random.random() < risky * per_hour * elapsed_s / 3600:
                    self._incidents.append(begins(kind, random, self._now_s, self._node, bool(self._load)))
            if random.random() < 1.5 * elapsed_s / 3600:
                self._spins_until_s = self._now_s + random.uniform(25, 70)
            if random.random() < 1.0 * elapsed_s / 3600:
                self._paused_until_s = self._now_s + random.uniform(10, 60)
        for incident in self._incidents:
            if incident.turns_s is not None and self._now_s >= incident.turns_s:
                incident.level = FATAL
            if self._now_s >= incident.ends_s:
                ended.append(incident)
        for incident in ended:
            self._incidents.remove(incident)
            if incident.level == FATAL:
                # A person saw to it, by hand, and set its position anew where that was lost.
                self._attended_until_s = self._now_s + random.uniform(10, 40)
                if incident.loses_position:
                    self._shift_m = 0.0
            if incident.type == "actionFailed":
                self._order, self._path, self._actions = "", [], []
        drifting = any(incident.loses_position for incident in self._incidents)
        self._score += elapsed_s * (-0.02 if drifting else 0.04) + random.gauss(0, 0.005)
        self._score = min(0.97, max(0.05, self._score))
        if drifting and self._driving():
            self._shift_m += 0.05 * elapsed_s
        low = self._charge < 22.0
        if low and not any(incident.type == "batteryLow" for incident in self._incidents):
            self._incidents.append(
                Incident(type="batteryLow", says="State of charge below 22 %", began_s=self._now_s, ends_s=float("inf"))
            )
        if self._charge > 40.0:
            self._incidents = [incident for incident in self._incidents if incident.type != "batteryLow"]

    def _held(self) -> bool:
        self._mode = "MANUAL" if self._now_s < self._attended_until_s else "AUTOMATIC"
        held = any(incident.holds or incident.level == FATAL or incident.stopping for incident in self._incidents)
        return held or self._mode == "MANUAL" or self._now_s < self._paused_until_s

    def _driving(self) -> bool:
        return self._at < len(self._path) - 1 and not self._held() and not self._handling()

    def _handling(self) -> bool:
        return any(action.sequence == 2 * self._at and action.status in ("WAITING", "RUNNING") for action in self._actions)

    def _work(self, elapsed_s: float) -> None:
        if self._charging:
            self._charging = self._charge < 85.0
            return
        if not self._path or (self._at == len(self._path) - 1 and not self._handling()):
            self._rest()
            return
        if self._handling():
            self._handle()
            return
        if self._now_s < self._spins_until_s:
            return
        self._gone_m += SPEED_M_S * elapsed_s
        if self._gone_m >= SPACING_M:
            self._gone_m = 0.0
            self._at += 1
            self._node = self._path[self._at]

    def _rest(self) -> None:
        """An order is done: charge when that is due, else take the next after a while."""
        if self._charge < 30.0:
            self._charging = True
        elif self._rests_until_s < self._now_s - 60.0:
            self._rests_until_s = self._now_s + self._random.uniform(5, 40)
        elif self._now_s >= self._rests_until_s:
            self._take_order()

    def _take_order(self) -> None:
        random = self._random
        self._orders += 1
        self._order = f"{self.serial}-order-{self._orders:04d}"
        pick, drop = (f"N{random.randrange(SIDE)}{random.randrange(SIDE)}" for _ in range(2))
        to_pick = _way(self._node, pick)
        self._path = to_pick + _way(pick, drop)[1:]
        self._at, self._gone_m = 0, 0.0
        handling = [("drop", 2 * (len(self._path) - 1))] if self._load else []
        if not self._load:
            handling = [("pick", 2 * (len(to_pick) - 1)), ("drop", 2 * (len(self._path) - 1))]
            if handling[0][1] == handling[1][1]:
                handling.pop()
        self._actions = [Action(f"{self._order}-{type_}", type_, sequence) for type_, sequence in handling]

    def _handle(self) -> None:
        action = next(one for one in self._actions if one.sequence == 2 * self._at and one.status in ("WAITING", "RUNNING"))
        if action.status == "WAITING":
            action.status, action.until_s = "RUNNING", self._now_s + HANDLING_S
        elif self._now_s >= action.until_s:
            if action.type == "pick" and self._random.random() < 0.06:
                action.status = "FAILED"
                self._incidents.append(
                    Incident(
                        type="actionFailed",
                        says="No load detected at pick position",
                        hint="Check the load and the sensor",
                        began_s=self._now_s,
                        ends_s=self._now_s + self._random.uniform(60, 240),
                        references=(("actionId", action.id), ("nodeId", self._node)),
                        holds=True,
                    )
                )
                return
            action.status = "FINISHED"
            self._load = f"pallet-{self._order[-4:]}" if action.type == "pick" else ""

    def _message(self) -> Body:
        row, column = int(self._node[1]), int(self._node[2])
        x, y = column * SPACING_M, row * SPACING_M
        if self._at < len(self._path) - 1:
            ahead = self._path[self._at + 1]
            share = self._gone_m / SPACING_M
            x += share * (int(ahead[2]) * SPACING_M - x)
            y += share * (int(ahead[1]) * SPACING_M - y)
        spinning = self._now_s < self._spins_until_s
        driving = self._driving()
        lost = any(incident.loses_position and incident.level == FATAL for incident in self._incidents)
        stop = next((incident.stop for incident in self._incidents if incident.stopping), "NONE")
        left = range(self._at + 1, len(self._path))
        return {
            "headerId": self._header,
            "timestamp": (START + timedelta(seconds=round(self._now_s, 2)))
            .isoformat(timespec="milliseconds")
            .replace("+00:00", "Z"),
            "version": VERSION,
            "manufacturer": MANUFACTURER,
            "serialNumber": self.serial,
            "orderId": self._order,
            "orderUpdateId": 0,
            "lastNodeId": self._node,
            "lastNodeSequenceId": 2 * self._at,
            "nodeStates": [{"nodeId": self._path[i], "sequenceId": 2 * i, "released": True} for i in left],
            "edgeStates": [
                {"edgeId": f"{self._path[i - 1]}-{self._path[i]}", "sequenceId": 2 * i - 1, "released": True} for i in left
            ],
            "driving": driving,
            "paused": self._now_s < self._paused_until_s,
            "distanceSinceLastNode": round(self._gone_m, 2),
            "operatingMode": self._mode,
            "agvPosition": {
                "x": round(x + self._shift_m, 3),
                "y": round(y, 3),
                "theta": 0.0,
                "mapId": MAP,
                "positionInitialized": not lost,
                "localizationScore": round(self._score, 3),
            },
            "velocity": {"vx": SPEED_M_S if driving and not spinning else 0.0, "vy": 0.0, "omega": 0.0},
            "loads": [{"loadId": self._load, "loadType": "EPAL1", "weight": 320.0}] if self._load else [],
            "actionStates": [{"actionId": one.id, "actionType": one.type, "actionStatus": one.status} for one in self._actions],
            "batteryState": {"batteryCharge": round(self._charge, 1), "charging": self._charging},
            "errors": [_error(incident) for incident in self._incidents],
            "information": [],
            "safetyState": {"eStop": stop, "fieldViolation": any(incident.violates for incident in self._incidents)},
        }


def _error(incident: Incident) -> Body:
    body: Body = {
        "errorType": incident.type,
        "errorLevel": incident.level,
        "errorReferences": [{"referenceKey": key, "referenceValue": value} for key, value in incident.references],
        "errorDescription": incident.says,
    }
    return body | {"errorHint": incident.hint} if incident.hint else body


def _way(start: str, end: str) -> list[str]:
    """The nodes from start to end, along the row first."""
    row, column = int(start[1]), int(start[2])
    way = [start]
    while column != int(end[2]):
        column += 1 if int(end[2]) > column else -1
        way.append(f"N{row}{column}")
    while row != int(end[1]):
        row += 1 if int(end[1]) > row else -1
        way.append(f"N{row}{column}")
    return way
