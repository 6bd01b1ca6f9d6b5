"""``cycle``: a cycle of work that is unlike its predecessors, by how long it took and what its channels did in it."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from wakeful.contracts.detector import Found
from wakeful.contracts.domain import DomainError
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation
from wakeful.facts.values import Field
from wakeful.registration.channels import Channels, named
from wakeful.registration.cycle_clock import CycleClock, Place
from wakeful.registration.detectors.base import CHANNELS, Count, Memory, Positive, Seen, Settings, said, settings_of, short
from wakeful.registration.learned_band import Band
from wakeful.registration.plain import number

MOST = 6.0
"""A single measure counts at most so many deviations towards a cycle's unlikeness."""


class CycleSettings(Settings, frozen=True):
    """What `cycle` may be told.

    ``cycle``: the channel whose changes begin a cycle; ``width``: how many deviations beyond the usual unlikeness (or duration) a
    cycle must be; ``learn``, ``memory``: cycles until there is a usual one, and over which it forgets; ``overdue``: whether one
    that goes on for too long is registered while it lasts, rather than at its end.
    """

    cycle: str = ""
    width: Positive = 3.0
    learn: Count = 15
    memory: Memory = 200.0
    overdue: bool = True


class Sum(msgspec.Struct):
    """What one channel did in the cycle so far."""

    count: int = 0
    total: float = 0.0
    least: float = 0.0
    most: float = 0.0


class Cycles(msgspec.Struct):
    """The cycle under way, and what is usual. ``usual``: a band by measure (``duration``, ``<channel> mean`` …)."""

    place: Place = msgspec.field(default_factory=Place)
    told: bool = False
    sums: dict[str, Sum] = {}
    usual: dict[str, Band] = {}
    unlike: Band = msgspec.field(default_factory=Band)


class CycleDetector:
    """Summarises each cycle's channels (mean, least, most) and its duration; the first cycle, seen in part, is left out."""

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:
        self.spec = spec
        self._robot = domain.robot
        self._settings = settings_of(spec, CycleSettings)
        if not self._settings.cycle:
            raise DomainError(f"detect {spec.kind!r} (cycle): give settings.cycle, the channel whose changes begin a cycle")
        self.channels = Channels((*spec.channels, self._settings.cycle))
        self._clock = CycleClock(self._settings.cycle)
        self._measured = Channels(spec.channels)
        self._cycles = Cycles()

    def observe(self, observation: Observation) -> Iterable[Seen]:
        """Add to the cycle under way; at its end, or when it is overdue, say how unlike it is."""
        cycles, found = self._cycles, []
        place = self._clock.observe(observation)
        if place is not cycles.place:
            if cycles.place.number > 1 and (seen := self._end(cycles.place, observation)):
                found.append(seen)
            cycles.place, cycles.told, cycles.sums = place, False, {}
        self._add(observation)
        if self._settings.overdue and place.number > 1 and not cycles.told and (seen := self._overdue(observation)):
            found.append(seen)
        return found

    def state(self) -> bytes:
        """The cycle under way and what is usual, as bytes."""
        return msgspec.msgpack.encode(self._cycles)

    def restore(self, state: bytes) -> None:
        """Take up what ``state`` gave out."""
        self._cycles = msgspec.msgpack.decode(state, type=Cycles)
        self._clock.place = self._cycles.place

    def _add(self, observation: Observation) -> None:
        sums = self._cycles.sums
        for channel, value in self._measured.of(observation):
            reading = number(value)
            if reading is None:
                continue
            so_far = sums.get(channel)
            if so_far is None:
                if len(sums) < CHANNELS:
                    sums[channel] = Sum(1, reading, reading, reading)
                continue
            so_far.count += 1
            so_far.total += reading
            so_far.least, so_far.most = min(so_far.least, reading), max(so_far.most, reading)

    def _overdue(self, observation: Observation) -> Found | None:
        usual = self._cycles.usual.get("duration")
        gone_s = self._cycles.place.gone_s
        if usual is None or not usual.learned:
            return None
        score = usual.score(gone_s, 0.05 * usual.middle)
        if score <= self._settings.width:
            return None
        self._cycles.told = True
        says = f"cycle {self._cycles.place.value} goes on for {said(gone_s)} s, usually {said(usual.middle)} s"
        return self._found("duration", score, gone_s, usual.middle, says, True, observation)

    def _end(self, place: Place, observation: Observation) -> Found | None:
        cycles, settings = self._cycles, self._settings
        duration_s = place.gone_s
        measures = {"duration": duration_s}
        for name, so_far in cycles.sums.items():
            measures[f"{name} mean"] = so_far.total / so_far.count
            measures[f"{name} least"], measures[f"{name} most"] = so_far.least, so_far.most
        scores = {}
        for name, value in measures.items():
            usual = cycles.usual.setdefault(name, Band()) if len(cycles.usual) < 4 * CHANNELS else cycles.usual.get(name)
            if usual is not None:
                if usual.learned:
                    scores[name] = usual.score(value)
                usual.learn(value, settings.learn, settings.memory)
        if not scores:
            return None
        unlike = sum(min(abs(score), MOST) for score in scores.values()) / len(scores)
        usual_s = cycles.usual["duration"].middle
        odd = cycles.unlike.learned and cycles.unlike.score(unlike, 0.05) > settings.width
        score = cycles.unlike.score(unlike, 0.05)
        cycles.unlike.learn(unlike, settings.learn, settings.memory)
        if not odd or cycles.told:
            return None
        worst = max(scores, key=lambda name: abs(scores[name]))
        says = f"cycle {place.value} is unlike those before it, most in {worst} ({scores[worst]:+.1f} deviations)"
        return self._found(worst, score, duration_s, usual_s, says, False, observation)

    def _found(
        self, worst: str, score: float, duration_s: float, usual_s: float, says: str, overdue: bool, observation: Observation
    ) -> Found:
        fields: dict[str, Field] = {
            "cycle": self._cycles.place.value,
            "deviation": short(min(score, 1e6)),
            "worst": worst,
            "duration_s": short(duration_s),
            "usual_s": short(usual_s),
            "overdue": overdue,
        }
        robot = observation.robot or self._robot
        entity = named(self.spec.entity, self._settings.cycle, observation.topic, robot)
        return Found(fields=fields, says=f"{self.spec.says or self.spec.kind}: {says}", entity=entity)
