"""The recording itself: what the logger dropped, and stretches in which nothing was written at all."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from wakeful.contracts.detector import Found
from wakeful.domains.plain import number, within
from wakeful.domains.px4_ulog.flight import Flight
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns, to_s

_STREAM, _STREAM_NS = 50, to_ns(3.0)
"""So many entries, over so long, without a gap make a stream."""


class _Memory(msgspec.Struct):
    flight: Flight = msgspec.field(default_factory=Flight)
    last_ns: int | None = None
    run: int = 0
    """Entries in a row without a gap."""
    run_ns: int = 0
    """When they began."""
    gap_s: float = 0.0
    """A gap that waits for the stream to go on."""
    dropouts: int = 0
    lost_ms: float = 0.0
    last_dropout_ns: int | None = None


class Recording(Remembering[_Memory]):
    """Registers dropouts as one lasting condition for as long as they follow one another within ``quiet_s`` (default 30), and
    a gap of more than ``gap_s`` (default 2) in the stream of entries as an event of its own, once the stream has gone on.
    Before its stream begins a log repeats what was last said of each topic, with instants far apart: those are no gaps.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())
        self._quiet_ns = to_ns(number(spec.settings, "quiet_s") or 30.0)
        self._gap_s = number(spec.settings, "gap_s") or 2.0

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Look at the time of every entry, and at the dropouts that the logger reported."""
        memory = self.memory
        memory.flight.see(observation)
        before_ns, memory.last_ns = memory.last_ns, observation.at_ns
        passed_s = 0.0 if before_ns is None else to_s(observation.at_ns - before_ns)
        streams = memory.run >= _STREAM and before_ns is not None and before_ns - memory.run_ns >= _STREAM_NS
        if before_ns is None or not 0.0 <= passed_s <= self._gap_s:
            memory.gap_s = passed_s if streams and passed_s > 0.0 else 0.0
            memory.run, memory.run_ns = 0, observation.at_ns
        elif memory.gap_s and streams:
            yield self._gap(memory.gap_s)
            memory.gap_s = 0.0
        memory.run = min(memory.run + 1, _STREAM)
        if observation.topic == "dropout":
            yield self._dropout(observation)
        elif memory.last_dropout_ns is not None and observation.at_ns - memory.last_dropout_ns > self._quiet_ns:
            memory.last_dropout_ns = None
            yield self._found(Phase.CLEARED, f"no data was dropped for {to_s(self._quiet_ns):.0f} s", 0.0)

    def _dropout(self, observation: Observation) -> Found:
        memory = self.memory
        lost_ms = max(0.0, number(observation.values, "duration_ms") or 0.0)
        first = memory.last_dropout_ns is None
        memory.last_dropout_ns = observation.at_ns
        memory.dropouts = 1 if first else memory.dropouts + 1
        memory.lost_ms = lost_ms if first else memory.lost_ms + lost_ms
        said = f"the logger dropped {lost_ms:.0f} ms of data (dropout {memory.dropouts}, {memory.lost_ms:.0f} ms in all)"
        return self._found(Phase.RAISED if first else Phase.REPEATED, said, lost_ms)

    def _found(self, phase: Phase, said: str, lost_ms: float) -> Found:
        flight = self.memory.flight
        return Found(
            kind="dropout",
            entity="logger",
            fields={**flight.fields(), "size": within(lost_ms / 1000, 0.0, 100.0), "severity": within(lost_ms / 1000, 0.1, 1.0)},
            says=f"{said[0].upper()}{said[1:]} ({flight.says()}).",
            criticality=1 if lost_ms >= 200.0 else 0,
            phase=phase,
            type="dropout",
            task=flight.mode,
        )

    def _gap(self, gap_s: float) -> Found:
        flight = self.memory.flight
        return Found(
            kind="log_gap",
            entity="logger",
            fields={**flight.fields(), "size": within(gap_s, 0.0, 100.0), "severity": 0.6 if flight.airborne else 0.3},
            says=f"Nothing was logged for {gap_s:.1f} s; what happened then is not known ({flight.says()}).",
            criticality=2 if flight.airborne else 1,
            task=flight.mode,
            safety=bool(flight.armed),
        )
