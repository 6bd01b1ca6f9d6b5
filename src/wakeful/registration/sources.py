"""A domain's outcome and evidence sources: built in, and shaped like detectors."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from wakeful.contracts.detector import Offered, Shown
from wakeful.contracts.domain import DomainError
from wakeful.facts.domain import EvidenceSource, OutcomeSource
from wakeful.facts.events import Observation
from wakeful.facts.values import Value
from wakeful.registration.channels import Channels, named, unknown_placeholder
from wakeful.registration.plain import Scalar, elapsed_s, number, scalar


class OutcomeDetector:
    """Shows an outcome where its channel becomes true, or changes to another value that isn't zero, false or empty.

    A value that says nothing (None, blank, NaN) is unknown: it neither begins nor ends anything, so true, blank, true is one
    outcome. A text's first value is where things stand, not an outcome.
    """

    def __init__(self, source: OutcomeSource, robot: str) -> None:
        if word := unknown_placeholder(source.entity):
            raise DomainError(f"outcomes {source.label!r}: entity {source.entity!r}: nothing is called {{{word}}}")
        self.channels = Channels((source.channel,))
        self._source = source
        self._robot = robot
        self._last: dict[str, Scalar] = {}

    def observe(self, observation: Observation) -> Iterable[Shown]:
        """The outcomes that this observation shows."""
        found = []
        for channel, value in self.channels.of(observation):
            now = scalar(value)
            if now is None:
                continue
            was = self._last.get(channel)
            self._last[channel] = now
            if now and now != was and not (was is None and isinstance(now, str)):
                entity = named(self._source.entity, channel, observation.topic, observation.robot or self._robot)
                found.append(Shown(label=self._source.label, entity=entity))
        return found

    def state(self) -> bytes:
        """The last value of each channel."""
        return msgspec.msgpack.encode(self._last)

    def restore(self, state: bytes) -> None:
        """Take up what ``state`` gave out."""
        self._last = msgspec.msgpack.decode(state, type=dict[str, Scalar])


class Gathering(msgspec.Struct):
    """One channel's values since the last evidence."""

    start_ns: int
    total: float = 0.0
    count: int = 0
    last: Scalar | None = None


class EvidenceDetector:
    """Offers, every ``every_s``, the mean of a channel's numbers since the last time, or its last value where it has none."""

    def __init__(self, source: EvidenceSource, robot: str) -> None:
        if word := unknown_placeholder(source.key):
            raise DomainError(f"evidence {source.topic!r}: key {source.key!r}: nothing is called {{{word}}}")
        self.channels = Channels(source.channels)
        self._source = source
        self._robot = robot
        self._gathering: dict[str, Gathering] = {}

    def observe(self, observation: Observation) -> Iterable[Offered]:
        """The evidence that is due with this observation; one that begins a new stretch is not part of the old one."""
        offered = []
        for channel, value in self.channels.of(observation):
            now = scalar(value)
            if now is None:
                continue
            so_far = self._gathering.get(channel)
            if so_far is None:
                so_far = self._gathering[channel] = Gathering(observation.at_ns)
            elif elapsed_s(observation.at_ns, so_far.start_ns) >= self._source.every_s:
                mean: Value = so_far.total / so_far.count if so_far.count else so_far.last
                key = named(self._source.key, channel, observation.topic, observation.robot or self._robot)
                offered.append(Offered(topic=self._source.topic, key=key, value=mean))
                so_far = self._gathering[channel] = Gathering(observation.at_ns)
            if (reading := number(now)) is not None:
                so_far.total += reading
                so_far.count += 1
            so_far.last = now
        return offered

    def state(self) -> bytes:
        """What has been gathered, by channel."""
        return msgspec.msgpack.encode(self._gathering)

    def restore(self, state: bytes) -> None:
        """Take up what ``state`` gave out."""
        self._gathering = msgspec.msgpack.decode(state, type=dict[str, Gathering])
