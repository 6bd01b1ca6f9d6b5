"""``band``: a number leaves the band it usually stays in. One excursion, one event."""

from __future__ import annotations

from typing import Final, Literal

import msgspec

from wakeful.contracts.detector import Found
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.values import Field, Value
from wakeful.registration.channels import Channels
from wakeful.registration.cycle_clock import CycleClock, Place
from wakeful.registration.detectors.base import (
    Count,
    Memory,
    NotNegative,
    PerChannel,
    Positive,
    Seen,
    Settings,
    Share,
    settings_of,
    short,
)
from wakeful.registration.learned_band import Band
from wakeful.registration.plain import elapsed_s, number

PHASES: Final = 64
"""Phases of a cycle that have a band of their own; the last one takes all that is later."""


class BandSettings(Settings, frozen=True):
    """What `band` may be told.

    ``width``: robust standard deviations from the middle to the band's edge; ``inner``: the share of it that the value must
    come back to before the excursion is over; ``hold``: observations outside before it counts; ``calm``: inside before it is
    over; ``gap_s``: least time between events of one channel; ``learn``, ``memory``: observations until there is a band, and over
    which it forgets; ``floor``: least standard deviation, in the channel's unit; ``size``: look at the number without its sign;
    ``cycle``: a channel whose changes begin a cycle, with bands of their own for each ``phase_s`` of it; ``pause``: flags
    while one of which is up nothing is judged or learned, and the cycle stands still; ``lasting``: an
    excursion is a condition that is cleared when it is over; ``sides``: ``both``, ``above`` or ``below``; ``together_s``:
    excursions of several channels within so long are one event, that of the farthest out (0: each for itself).
    """

    width: Positive = 4.0
    inner: Share = 0.7
    hold: Count = 1
    calm: Count = 2
    gap_s: NotNegative = 10.0
    learn: Count = 60
    memory: Memory = 1000.0
    floor: NotNegative = 0.0
    size: bool = False
    cycle: str = ""
    pause: list[str] = []
    phase_s: Positive = 5.0
    lasting: bool = False
    sides: Literal["both", "above", "below"] = "both"
    together_s: NotNegative = 0.0


class Excursion(msgspec.Struct):
    """The memory of one channel."""

    bands: dict[int, Band] = {}
    outside: int = 0
    inside: int = 0
    out: bool = False
    event_ns: int | None = None


class BandDetector(PerChannel[Excursion]):
    """Learns the band of each channel (of each phase, where there is a cycle) and registers leaving it."""

    memory_type = Excursion

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:
        super().__init__(spec, domain)
        self._settings = settings_of(spec, BandSettings)
        self._clock = CycleClock(self._settings.cycle, tuple(self._settings.pause))
        self._phase = 0
        self._joined_ns: int | None = None
        if self._clock.patterns:
            # the cycle may be told by a topic that none of the measured channels is of
            self.channels = Channels((*spec.channels, *self._clock.patterns))
        self._sign = {"above": 1.0, "below": -1.0}.get(self._settings.sides, 0.0)

    def observe(self, observation: Observation) -> list[Seen]:
        """What this observation shows on the detector's channels."""
        if self._clock.patterns:
            place = self._clock.observe(observation)
            if place.paused:
                return []
            self._phase = 1 + int(min(place.gone_s / self._settings.phase_s, PHASES - 2)) if place.number else 0
        found = super().observe(observation)
        return self._join(found, observation) if found and self._settings.together_s > 0 else found

    def look(self, channel: str, value: Value, memory: Excursion, observation: Observation) -> Seen | None:
        """Compare with the band as it was before this value, then learn from it."""
        reading = number(value)
        if reading is None:
            return None
        settings = self._settings
        if settings.size:
            reading = abs(reading)
        band = memory.bands.get(self._phase)
        if band is None:
            band = memory.bands[self._phase] = Band()
        seen = None
        if band.learned:
            score = band.score(reading, settings.floor)
            if memory.out or score > settings.width or -score > settings.width:
                seen = self._judge(channel, reading, score, band.usual, memory, observation)
            else:
                memory.outside = 0
        band.learn(reading, settings.learn, settings.memory)
        return seen

    def state(self) -> bytes:
        """The memory of all channels, and of the cycle."""
        return msgspec.msgpack.encode((self._clock.place, self._joined_ns, self._memory))

    def restore(self, state: bytes) -> None:
        """Take up what ``state`` gave out."""
        kept = tuple[Place, int | None, dict[str, Excursion]]
        self._clock.place, self._joined_ns, self._memory = msgspec.msgpack.decode(state, type=kept)

    def _judge(
        self, channel: str, reading: float, score: float, usual: float, memory: Excursion, observation: Observation
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
            "usual": short(usual),
            "deviation": short(min(abs(score), 1e6)),
            "side": side,
        }
        says = f"{channel} is {reading:.4g}, {abs(score):.1f} deviations {side} its usual {usual:.4g}"
        return self.found(channel, observation, fields, says, Phase.RAISED if settings.lasting else None)

    def _join(self, found: list[Seen], observation: Observation) -> list[Seen]:
        left = [item for item in found if not isinstance(item, Found) or item.phase is Phase.CLEARED]
        out = [item for item in found if isinstance(item, Found) and item.phase is not Phase.CLEARED]
        if out and elapsed_s(observation.at_ns, self._joined_ns) >= self._settings.together_s:
            self._joined_ns = observation.at_ns
            farthest = max(out, key=lambda item: abs(number(item.fields.get("deviation")) or 0.0))
            left.append(msgspec.structs.replace(farthest, fields={**farthest.fields, "joined": len(out)}))
        return left
