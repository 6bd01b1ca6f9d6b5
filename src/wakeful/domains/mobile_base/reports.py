"""What the robot says of itself: diagnostics as lasting conditions, and warnings and errors of its log."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import msgspec

from wakeful.contracts.detector import Found, Shown
from wakeful.domains.mobile_base.messages import message_type
from wakeful.domains.mobile_base.motion import Bases
from wakeful.domains.plain import number, text, whole, within
from wakeful.domains.remembering import Remembering, Seen
from wakeful.domains.template import plain_text, template
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns, to_s
from wakeful.facts.values import Field, Value

LEVELS = ("ok", "warning", "error", "stale")
"""diagnostic_msgs/DiagnosticStatus levels."""

_SEVERITIES: Mapping[str, int] = {"warn": 2, "warning": 2, "error": 3, "fatal": 4, "critical": 4}
_MOST = 1000


class _Wording(msgspec.Struct):
    last_ns: int
    severity: int
    count: int = 1


class _Memory(msgspec.Struct):
    bases: Bases = msgspec.field(default_factory=Bases)
    levels: dict[str, int] = {}
    wordings: dict[str, _Wording] = {}


class Reports(Remembering[_Memory]):
    """``diagnostic``: a lasting condition of each component that is not ok; it changes with its level and clears at ok.
    ``log_message``: a lasting condition of each wording of a node's warnings and errors; what repeats it is evidence, and one
    that returns after ``quiet_s`` (60) is a change. A diagnostic that becomes an error, and an error in the log, show ``fault``.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())
        self._quiet_ns = to_ns(number(spec.settings, "quiet_s") or 60.0)

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Look at diagnostics and at log messages."""
        self.memory.bases.see(observation)
        match message_type(observation):
            case "DiagnosticArray":
                listed = observation.values.get("status")
                for status in listed[:_MOST] if isinstance(listed, list | tuple) else ():
                    if isinstance(status, Mapping):
                        yield from self._diagnostic(observation, status)
            case "DiagnosticStatus":
                yield from self._diagnostic(observation, observation.values)
            case "Log":
                yield from self._log(observation)

    def _diagnostic(self, observation: Observation, status: Mapping[str, Value]) -> Iterator[Seen]:
        name, level = text(status, "name", 120), _level(status)
        if not name or level is None:
            return
        key = f"{text(status, 'hardware_id', 80)}/{name}"
        levels = self.memory.levels
        before = levels.get(key, 0)
        if level == before or (key not in levels and len(levels) >= _MOST):
            return
        levels[key] = level
        phase = Phase.CLEARED if level == 0 else Phase.CHANGED if before else Phase.RAISED
        if level == 0:
            yield Shown(label="recovered", entity=name)
        elif level == 2:
            yield Shown(label="fault")
        said = plain_text(text(status, "message"))
        motion = self.memory.bases.of(observation.topic)
        yield Found(
            kind="diagnostic",
            entity=name,
            fields={
                **motion.fields(),
                "level": LEVELS[level],
                "severity": (0.0, 0.5, 0.9, 0.7)[level],
                "worse": level > before,
            },
            says=f"Diagnostics of {name}: {LEVELS[before]} became {LEVELS[level]}: {said or 'no message'} ({motion.says()}).",
            criticality=2 if level >= 2 else 1,
            deadline_s=30.0,
            phase=phase,
            type="diagnostic",
            references=(key,),
        )

    def _log(self, observation: Observation) -> Iterator[Seen]:
        values = observation.values
        severity, said = _severity(values), plain_text(text(values, "msg") or text(values, "message"))
        if severity < 2 or not said:
            return
        node = text(values, "name", 120) or "unknown node"
        wording = f"{node}: {template(said)}"
        now_ns, wordings = observation.at_ns, self.memory.wordings
        seen = wordings.get(wording)
        if severity >= 3:
            yield Shown(label="fault")
        if seen is None:
            while len(wordings) >= _MOST:
                del wordings[min(wordings, key=lambda one: (wordings[one].last_ns, one))]
            seen = wordings[wording] = _Wording(now_ns, severity)
            phase, more = Phase.RAISED, ""
        else:
            quiet_ns = now_ns - seen.last_ns
            again = quiet_ns > self._quiet_ns
            phase = Phase.CHANGED if again or severity > seen.severity else Phase.REPEATED
            seen.last_ns, seen.severity, seen.count = now_ns, max(severity, seen.severity), seen.count + 1
            more = f", again after {to_s(quiet_ns):.0f} s" if again else f", {seen.count} times by now"
        motion = self.memory.bases.of(observation.topic)
        word = ("debug", "info", "warning", "error", "fatal")[severity]
        fields: dict[str, Field] = {
            **motion.fields(),
            "level": word,
            "severity": 0.25 * severity,
            "count": within(seen.count, 0.0, 100.0),
        }
        yield Found(
            kind="log_message",
            entity=node,
            fields=fields,
            says=f"{node} says ({word}): {said}{more} ({motion.says()}).",
            criticality=min(3, severity - 1),
            deadline_s=30.0 if severity >= 3 else None,
            phase=phase,
            type="log_message",
            references=(wording,),
        )


def _level(status: Mapping[str, Value]) -> int | None:
    if word := text(status, "level", 10).lower():
        return {"ok": 0, "warn": 1, "warning": 1, "error": 2, "stale": 3}.get(word)
    level = whole(status, "level")
    return level if level is not None and 0 <= level <= 3 else None


def _severity(values: Mapping[str, Value]) -> int:
    if word := text(values, "level", 20).lower():
        return _SEVERITIES.get(word, 0)
    severity = whole(values, "severity")
    return severity if severity is not None and 0 <= severity <= 4 else 0
