"""``conditions``: a list of what is wrong, sent again and again: each entry appears, changes, repeats and clears."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import msgspec

from wakeful.contracts.detector import Found
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.values import Field, Value
from wakeful.registration.channels import named
from wakeful.registration.detectors.base import PerChannel, Seen, Settings, levels_of, settings_of
from wakeful.registration.plain import clean, field, scalar

ENTRIES: Final = 256


class ConditionsSettings(Settings, frozen=True):
    """What `conditions` may be told: the names inside an entry.

    ``type``, ``level``, ``text``: its type, how bad it is, its words; ``references``: a list of key/value objects, or of texts,
    that say what it is about; ``criticality``: what levels mean, as ``"FATAL=3"``; ``fields``: more names to take over as fields.
    """

    type: str = "type"
    level: str = "level"
    text: str = "description"
    references: str = "references"
    criticality: list[str] = []
    fields: list[str] = []


class Entry(msgspec.Struct):
    """One condition that is there: its level, and its words as they were sent first."""

    type: str
    references: tuple[str, ...]
    level: str = ""
    text: str = ""


class Listed(msgspec.Struct):
    """The memory of one channel: what it listed last."""

    entries: dict[str, Entry] = {}


class ConditionsDetector(PerChannel[Listed]):
    """Compares each list with the one before. A channel that is absent or null says nothing; an empty list clears all."""

    memory_type = Listed

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:
        super().__init__(spec, domain)
        self._settings = settings_of(spec, ConditionsSettings)
        self._criticality = levels_of(spec, "criticality", self._settings.criticality)

    def observe(self, observation: Observation) -> list[Seen]:
        """What this observation's lists show."""
        found: list[Seen] = []
        for channel, value in self.channels.of(observation):
            if isinstance(value, list | tuple):
                memory = self._memory.get(channel)
                found.extend(self._compare(channel, value, self._first(channel) if memory is None else memory, observation))
        return found

    def _compare(self, channel: str, value: Iterable[Value], memory: Listed, observation: Observation) -> Iterable[Found]:
        now: dict[str, tuple[Entry, dict[str, Value]]] = {}
        for item in list(value)[:ENTRIES]:
            if isinstance(item, dict):
                entry = self._entry(item)
                now.setdefault("|".join((entry.type, *entry.references)), (entry, item))
        before, memory.entries = memory.entries, {key: entry for key, (entry, _) in now.items()}
        for key, (entry, item) in now.items():
            known = before.get(key)
            phase = Phase.RAISED if known is None else Phase.REPEATED if known.level == entry.level else Phase.CHANGED
            yield self._found(channel, entry, item, phase, observation)
        for key, entry in before.items():
            if key not in now:
                yield self._found(channel, entry, {}, Phase.CLEARED, observation)

    def _entry(self, item: dict[str, Value]) -> Entry:
        names = self._settings
        type_ = scalar(item.get(names.type))
        level, text = scalar(item.get(names.level)), item.get(names.text)
        return Entry(
            type=clean(str(type_ if type_ is not None else "unknown")),
            references=_references(item.get(names.references)),
            level="" if level is None else clean(str(level)),
            text=clean(text) if isinstance(text, str) else "",
        )

    def _found(self, channel: str, entry: Entry, item: dict[str, Value], phase: Phase, observation: Observation) -> Found:
        fields: dict[str, Field] = {"channel": channel, "type": entry.type, "references": ", ".join(entry.references)}
        if entry.level:
            fields["level"] = entry.level
        if entry.text:
            fields["text"] = entry.text
        fields.update((name, field(item[name])) for name in self._settings.fields if name in item)
        robot = observation.robot or self._robot
        return Found(
            fields=fields,
            says=": ".join(part for part in (f"{entry.level} {entry.type}".strip(), entry.text) if part),
            entity=named(self.spec.entity, channel, observation.topic, robot).replace("{type}", entry.type),
            criticality=self._criticality.get(entry.level),
            phase=phase,
            type=entry.type,
            references=entry.references,
        )


def _references(value: Value) -> tuple[str, ...]:
    if not isinstance(value, list | tuple):
        return () if scalar(value) is None else (clean(str(value)),)
    parts = []
    for item in list(value)[:16]:
        if isinstance(item, dict):
            parts.append("=".join(clean(str(part)) for part in item.values() if scalar(part) is not None))
        elif scalar(item) is not None:
            parts.append(clean(str(item)))
    return tuple(sorted(parts))
