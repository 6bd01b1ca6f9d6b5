"""``band``: a number leaves the band it usually stays in. One excursion, one event."""

from __future__ import annotations

from typing import Final

import msgspec

from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.values import Field, Value
from wakeful.registration.channels import Channels
from wakeful.registration.detectors.base import PerChannel, Seen, Settings, settings_of, short
from wakeful.registration.learned_band import Band
from wakeful.registration.plain import elapsed_s, number, scalar

PHASES: Final = 64
"""Phases of a cycle that have a band of their own; the last one takes all that is later."""


class BandSettings(Settings, frozen=True):
    """What `band` may be told.

    ``width``: robust standard deviations from the middle to the band's edge; ``inner``: the share of it that the value must
    come back to before the excursion is over; ``hold``: observations outside before it counts; ``calm``: inside before it is
    over; ``gap_s``: least time between events of one channel; ``learn``, ``memory``: observations until there is a band, and over
    which it forgets; ``floor``: least standard deviation, in the channel's unit; ``size``: look at the number without its sign;
    ``cycle``: a channel whose changes begin a cycle, with bands of their own for each ``phase_s`` of it; ``lasting``: an
    excursion is a condition that is cleared when it is over; ``sides``: ``both``, ``above`` or ``below``.
    """

    width: float = 4.0
    inner: float = 0.7
    hold: int = 1
    calm: int = 2
    gap_s: float = 10.0
    learn: int = 60
    memory: float = 1000.0
    floor: float = 0.0
    size: bool = False
    cycle: str = ""
    phase_s: float = 5.0
    lasting: bool = False
    sides: str = "both"


class Excursion(msgspec.Struct):
    """The memory of one channel."""

    bands: dict[int, Band] = {}
    outside: int = 0
    inside: int = 0
    out: bool = False
    event_ns: int | None = None


class Cycle(msgspec.Struct):
    """Which cycle it is, and since when."""

    value: bool | int | float | str | None = None
    since_ns: int = 0


class BandDetector(PerChannel[Excursion]):
    """Learns the band of each channel (of each phase, where there is a cycle) and registers leaving it."""

    memory_type = Excursion

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:
        super().__init__(spec, domain)
        self._settings = settings_of(spec, BandSettings)
        self._cycle = Cycle()
        self._cycle_channel = Channels((self._settings.cycle,)) if self._settings.cycle else None
        self._sign = {"above": 1.0, "below": -1.0}.get(self._settings.sides, 0.0)

    def observe(self, observation: Observation) -> list[Seen]:
        """What this observation shows on the detector's channels."""
        if self._cycle_channel is not None:
            for _, value in self._cycle_channel.of(observation):
                now = scalar(value)
                if now is not None and now != self._cycle.value:
                    self._cycle = Cycle(now, observation.at_ns)
        return list(super().observe(observation))

    def look(self, channel: str, value: Value, memory: Excursion, observation: Observation) -> Seen | None:
        """Compare with the band as it was before this value, then learn from it."""
        reading = number(value)
        if reading is None:
            return None
        settings = self._settings
        if settings.size:
            reading = abs(reading)
        phase = self._phase(observation.at_ns)
        band = memory.bands.get(phase)
        if band is None:
            band = memory.bands[phase] = Band()
        seen = None
        if band.learned:
            score = band.score(reading, settings.floor)
            seen = self._judge(channel, reading, score, band.middle, memory, observation)
        band.learn(reading, settings.learn, settings.memory)
        return seen

    def state(self) -> bytes:
        """The memory of all channels, and of the cycle."""
        return msgspec.msgpack.encode((self._cycle, self._memory))

    def restore(self, state: bytes) -> None:
        """Take up what ``state`` gave out."""
        self._cycle, self._memory = msgspec.msgpack.decode(state, type=tuple[Cycle, dict[str, Excursion]])

    def _judge(
        self, channel: str, reading: float, score: float, middle: float, memory: Excursion, observation: Observation
    ) -> Seen | None:
        settings = self._settings
        away = score * self._sign if self._sign else abs(score)
        if memory.out:
            if away > settings.width * settings.inner:
                memory.inside = 0
                return None
            memory.inside += 1
            if memory.inside < settings.calm:
                return None
            memory.out, memory.outside = False, 0
            if not settings.lasting:
                return None
            return self.found(channel, observation, {"value": short(reading)}, f"{channel} is back in its band", Phase.CLEARED)
        if away <= settings.width:
            memory.outside = 0
            return None
        memory.outside += 1
        if memory.outside < settings.hold or elapsed_s(observation.at_ns, memory.event_ns) < settings.gap_s:
            return None
        memory.out, memory.inside, memory.event_ns = True, 0, observation.at_ns
        side = "above" if score > 0 else "below"
        fields: dict[str, Field] = {
            "value": short(reading),
            "usual": short(middle),
            "deviation": short(min(abs(score), 1e6)),
            "side": side,
        }
        says = f"{channel} is {reading:.4g}, {abs(score):.1f} deviations {side} its usual {middle:.4g}"
        return self.found(channel, observation, fields, says, Phase.RAISED if settings.lasting else None)

    def _phase(self, at_ns: int) -> int:
        if self._cycle_channel is None or self._cycle.value is None:
            return 0
        gone = elapsed_s(at_ns, self._cycle.since_ns)
        return 1 + int(min(gone / self._settings.phase_s, PHASES - 2))
