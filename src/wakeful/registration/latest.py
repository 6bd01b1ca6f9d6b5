"""Channels that a domain wants beside every event: their last value, or the seconds since they last changed."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final, TypeVar

import msgspec

from wakeful.facts.domain import FieldSpec
from wakeful.facts.events import Observation
from wakeful.facts.values import Field
from wakeful.registration.channels import Channels, number_in
from wakeful.registration.plain import Scalar, elapsed_s, field, scalar

KEPT: Final = 1024
_SPECIAL = re.compile(r"([*?\[])")


class Seen(msgspec.Struct):
    """Last values by channel, and for channels watched for changes the instant of the last one."""

    values: dict[str, Field] = {}
    before: dict[str, Scalar] = {}
    changed_ns: dict[str, int] = {}


class Latest:
    """Keeps what `FieldSpec.channel` and `FieldSpec.since` ask for. A value that says nothing (None) leaves the last one."""

    def __init__(self, fields: Mapping[str, FieldSpec]) -> None:
        self._values = {name: spec.channel for name, spec in fields.items() if spec.channel}
        self._since = {name: spec.since for name, spec in fields.items() if spec.since}
        self._value_channels = Channels(tuple(_pattern(channel) for channel in self._values.values()))
        self._since_channels = Channels(tuple(_pattern(channel) for channel in self._since.values()))
        self.seen = Seen()

    def concerns(self, topic: str) -> bool:
        """Whether a topic carries any of the channels."""
        return self._value_channels.concern(topic) or self._since_channels.concern(topic)

    def observe(self, observation: Observation) -> None:
        """Take up the values of one observation."""
        seen = self.seen
        for channel, value in self._value_channels.of(observation):
            if (kept := field(value)) is not None:
                _keep(seen.values, channel, kept)
        for channel, value in self._since_channels.of(observation):
            now = scalar(value)
            if now is not None and now != seen.before.get(channel):
                _keep(seen.before, channel, now)
                _keep(seen.changed_ns, channel, observation.at_ns)

    def fields(self, entity: str, now_ns: int) -> dict[str, Field]:
        """The fields for an event of this entity."""
        seen, number = self.seen, number_in(entity)
        fields: dict[str, Field] = {}
        for name, channel in self._values.items():
            value = seen.values.get(channel.replace("{number}", number))
            if value is not None:
                fields[name] = value
        for name, channel in self._since.items():
            gone = elapsed_s(now_ns, seen.changed_ns.get(channel.replace("{number}", number)))
            if gone != float("inf"):
                fields[name] = round(gone, 3)
        return fields


V = TypeVar("V")


def _keep(kept: dict[str, V], channel: str, value: V) -> None:
    if channel not in kept and len(kept) >= KEPT:
        del kept[next(iter(kept))]
    kept[channel] = value


def _pattern(channel: str) -> str:
    return "*".join(_SPECIAL.sub(r"[\1]", part) for part in channel.split("{number}"))
