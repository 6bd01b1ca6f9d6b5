"""Log messages and PX4 events in words: one event for each wording, what repeats it is evidence, never a flood."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import msgspec

from wakeful.contracts.detector import Found, Offered, Shown
from wakeful.domains.plain import Values, number, text, whole, within
from wakeful.domains.px4_ulog.event_names import REPORT_BEGINS, REPORT_ENDS, event_name, in_words
from wakeful.domains.px4_ulog.flight import Flight
from wakeful.domains.remembering import Remembering, Seen
from wakeful.domains.template import plain_text, template
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns, to_s

LEVELS = ("emergency", "alert", "critical", "error", "warning", "notice", "info", "debug")
"""Syslog levels as PX4 numbers them, 0 the worst. Beyond them PX4 events have `protocol` and `disabled`: not for people."""

_CRITICAL, _ERROR, _WARNING, _INFO = 2, 3, 4, 6
_BY_NAME: Mapping[str, int] = {**{name: level for level, name in enumerate(LEVELS)}, "err": 3, "warn": 4, "fatal": 2, "crit": 2}
_TWIN_NS = to_ns(2.0)
_KEPT_WORDINGS = 500
_CHECKS = "health_and_arming_checks"
_OF_GROUND, _OF_ARMING = ("Takeoff detected", "Landing detected"), ("Armed by", "Disarmed by")
"""Messages on what the vehicle's state shows by itself, which is registered from there."""


class _Wording(msgspec.Struct):
    last_ns: int
    level: int
    as_event: bool = False
    count: int = 1


class _Memory(msgspec.Struct):
    flight: Flight = msgspec.field(default_factory=Flight)
    wordings: dict[str, _Wording] = {}
    events_in_words: bool = False
    reports: bool = False
    """PX4's checks report by event: their messages say the same once more."""


class Messages(Remembering[_Memory]):
    """Registers messages of the topics ``log`` (``level``, ``text``) and ``event`` (decoded by the bridge, or numbers alone).

    PX4 writes many events twice, as an event and as a message that ends in a tab; those two are one. A warning or error is a
    lasting condition of its module, keyed by its wording: the next one of the same wording repeats it, and one that returns
    after ``quiet_s`` (default 60) is a change. An error (or worse) shows the outcome ``fault``. What ``quiet_modules`` merely
    inform about (files opened, tones played) is no event.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())
        self._quiet_ns = to_ns(number(spec.settings, "quiet_s") or 60.0)
        modules = spec.settings.get("quiet_modules")
        self._quiet_modules = frozenset(str(one) for one in modules) if isinstance(modules, list) else frozenset()

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Register a message that has not been said lately."""
        match observation.topic:
            case "log" | "event":
                yield from self._message(observation)
            case _:
                self.memory.flight.see(observation)

    def _message(self, observation: Observation) -> Iterator[Seen]:
        values = observation.values
        level, said = _level(values), _text(values)
        doubled = isinstance(raw := values.get("text"), str) and raw.endswith("\t")
        module = text(values, "module", 40)
        if observation.topic == "event":
            name = text(values, "name", 80) or event_name(whole(values, "id") or 0)
            self.memory.reports = self.memory.reports or name in (REPORT_BEGINS, REPORT_ENDS)
            if name.startswith("check_") or text(values, "group", 40) not in ("", "default"):
                return
            module = name.partition("_")[0]
            if said:
                self.memory.events_in_words = True
            else:
                said = self._of_number(whole(values, "id"), name, level, observation.at_ns)
        elif doubled and self.memory.events_in_words:
            return
        if level is None or level > _INFO or not said:
            return
        module, words = _module(said, module)
        if (level > _WARNING and module in self._quiet_modules) or (module == _CHECKS and self.memory.reports):
            return
        flight = self.memory.flight
        by_ground = flight.landed is not None and words.startswith(_OF_GROUND)
        if level > _WARNING and (by_ground or (flight.armed is not None and words.startswith(_OF_ARMING))):
            yield Offered(topic="message", key=template(words), value={"text": words, "count": 1})
            return
        wording = template(words)
        now_ns, seen = observation.at_ns, self.memory.wordings.get(wording)
        as_event = observation.topic == "event"
        if seen is not None and 0 <= now_ns - seen.last_ns <= _TWIN_NS and seen.as_event != as_event:
            return
        if level <= _ERROR:
            yield Shown(label="fault")
        if seen is None:
            self._make_room()
            self.memory.wordings[wording] = _Wording(now_ns, level, as_event)
            yield self._found(Phase.RAISED, level, module, words, wording, 1, "")
            return
        quiet_ns = now_ns - seen.last_ns
        seen.last_ns, seen.as_event, seen.count = now_ns, as_event, seen.count + 1
        if quiet_ns > self._quiet_ns or level < seen.level:
            after = f", again after {to_s(quiet_ns):.0f} s" if quiet_ns > self._quiet_ns else ", more severe than before"
            yield self._found(Phase.CHANGED, level, module, words, wording, seen.count, after)
        elif level <= _WARNING:
            yield self._found(Phase.REPEATED, level, module, words, wording, seen.count, f", {seen.count} times by now")
        else:
            yield Offered(topic="message", key=wording, value={"text": words, "count": seen.count})
        seen.level = min(seen.level, level)

    def _of_number(self, number_of: int | None, name: str, level: int | None, at_ns: int) -> str:
        """Words for an event that came without, where it is worth some and no message of its own stands beside it."""
        if number_of is None or level is None or level > (_WARNING if name else _CRITICAL):
            return ""
        for seen in self.memory.wordings.values():
            if seen.level == level and 0 <= at_ns - seen.last_ns <= _TWIN_NS:
                return ""
        return in_words(name) if name else f"PX4 event {number_of}"

    def _found(self, phase: Phase, level: int, module: str, words: str, wording: str, count: int, more: str) -> Found:
        flight = self.memory.flight
        lasting = level <= _WARNING
        worst = 2 if level <= _ERROR else 1 if level == _WARNING else 0
        return Found(
            kind=("error_message" if level <= _ERROR else "warning_message") if lasting else "message",
            entity=f"module {module}",
            fields={
                **flight.fields(),
                "level": LEVELS[level],
                "severity": within((7 - level) / 7, 0.0, 1.0),
                "count": within(float(count), 0.0, 100.0),
            },
            says=f"{module} says ({LEVELS[level]}): {words}{more} [{flight.says()}].",
            criticality=min(3, worst + 1) if flight.airborne and lasting else worst,
            deadline_s=10.0 if level <= _ERROR else None,
            phase=phase if lasting else None,
            type="message" if lasting else "",
            references=(module, wording) if lasting else (),
            task=flight.mode,
            safety=bool(flight.armed),
        )

    def _make_room(self) -> None:
        wordings = self.memory.wordings
        while len(wordings) >= _KEPT_WORDINGS:
            del wordings[min(wordings, key=lambda one: (wordings[one].last_ns, one))]


def _level(values: Values) -> int | None:
    for key in ("level", "log_level"):
        if name := text(values, key, 20).lower():
            if name.isascii() and name.isdecimal() and len(name) == 1:
                return int(name)
            return _BY_NAME.get(name)
        if (found := whole(values, key)) is not None:
            return found - 48 if 48 <= found <= 57 else found if 0 <= found <= 7 else None
    both = whole(values, "log_levels")
    return None if both is None else (both >> 4) & 0xF


def _text(values: Values) -> str:
    return next((plain_text(said) for key in ("text", "message", "msg") if (said := text(values, key))), "")


def _module(said: str, known: str = "") -> tuple[str, str]:
    """The module that speaks (``known`` where the text doesn't begin with it), and what it says.

    >>> _module("[sensors] no barometer found"), _module("Takeoff detected")
    (('sensors', 'no barometer found'), ('autopilot', 'Takeoff detected'))
    """
    if said.startswith("[") and 1 < (end := said.find("]")) <= 40 and said[1:end].strip():
        return said[1:end].strip(), said[end + 1 :].strip() or said
    return known or "autopilot", said
