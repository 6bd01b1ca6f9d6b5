"""State messages written by hand, and a watch over them through the real registrar."""

from __future__ import annotations

from collections.abc import Iterable

from wakeful.contracts.domain import Registered
from wakeful.domains import load
from wakeful.facts.events import Draft, Observation, Phase
from wakeful.facts.evidence import Evidence, Outcome
from wakeful.facts.time import NS_PER_S
from wakeful.facts.values import Value
from wakeful.registration import SpecRegistrar

DOMAIN = load("vda5050")


def message(**changes: Value) -> dict[str, Value]:
    """A quiet state message of version 2.1."""
    return {
        "serialNumber": "AGV-1",
        "orderId": "",
        "lastNodeId": "N1",
        "lastNodeSequenceId": 0,
        "nodeStates": [],
        "edgeStates": [],
        "driving": False,
        "paused": False,
        "operatingMode": "AUTOMATIC",
        "agvPosition": {"x": 0.0, "y": 0.0, "theta": 0.0, "mapId": "m", "positionInitialized": True, "localizationScore": 0.9},
        "actionStates": [],
        "loads": [],
        "batteryState": {"batteryCharge": 80.0, "charging": False},
        "errors": [],
        "safetyState": {"eStop": "NONE", "fieldViolation": False},
        **changes,
    }


def error(type_: str = "scannerDirty", level: str = "WARNING", **references: str) -> dict[str, Value]:
    return {
        "errorType": type_,
        "errorLevel": level,
        "errorReferences": [{"referenceKey": key, "referenceValue": value} for key, value in references.items()],
    }


class Watch:
    """Registers messages, one a second unless told otherwise."""

    def __init__(self) -> None:
        self.registrar = SpecRegistrar(DOMAIN, "digest")
        self.events: list[Draft] = []
        self.evidence: list[Evidence] = []
        self.outcomes: list[Outcome] = []
        self._position = 0
        self._header = 0
        self.now_s = 0.0

    def send(
        self, *, at_s: float | None = None, header: int | None = None, topic: str = "state", **changes: Value
    ) -> list[Draft]:
        """One message; returns the events that it is."""
        self.now_s = self.now_s + 1.0 if at_s is None else at_s
        self._header = self._header + 1 if header is None else header
        values = {"headerId": self._header, **message(**changes)}
        found = self.register(topic, values)
        return list(found.events)

    def register(self, topic: str, values: dict[str, Value]) -> Registered:
        """Any values at all, at the present time."""
        observation = Observation(
            source="wire",
            position=self._position,
            topic=topic,
            at_ns=round(self.now_s * NS_PER_S),
            values=values,
            robot=str(values.get("serialNumber") or ""),
        )
        self._position += 1
        found = self.registrar.observe(observation)
        self.events += found.events
        self.evidence += found.evidence
        self.outcomes += found.outcomes
        return found

    def send_all(self, many: Iterable[dict[str, Value]]) -> None:
        for changes in many:
            self.send(**changes)  # type: ignore[arg-type]

    def kinds(self) -> list[str]:
        return [event.kind for event in self.events]

    def phases(self, kind: str) -> list[Phase]:
        return [event.condition.phase for event in self.events if event.kind == kind and event.condition is not None]

    def labels(self) -> list[tuple[str, str]]:
        return [(outcome.label, outcome.entity) for outcome in self.outcomes]
