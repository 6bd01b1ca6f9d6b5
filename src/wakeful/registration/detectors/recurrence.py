"""``recurrence``: the work comes to the point of its cycle at which, in one of the last cycles, something went wrong."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import msgspec

from wakeful.contracts.detector import Found
from wakeful.contracts.domain import DomainError
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation
from wakeful.facts.values import Field
from wakeful.registration.channels import Channels, named
from wakeful.registration.cycle_clock import CycleClock, Place
from wakeful.registration.detectors.base import Count, Positive, Seen, Settings, said, settings_of, short
from wakeful.registration.plain import Scalar, scalar

TIMES: Final = 32
"""Occurrences that one flag remembers."""


class RecurrenceSettings(Settings, frozen=True):
    """What `recurrence` may be told.

    ``cycle``: the channel whose changes begin a cycle; ``pause``: flags at which the work stands still;
    ``ahead_s``: how long before that point of the cycle; ``within``: how many
    cycles back it counts; ``least``: how many times it must have happened there by then.
    """

    cycle: str = ""
    pause: list[str] = []
    ahead_s: Positive = 5.0
    within: Count = 2
    least: Count = 1


class Flag(msgspec.Struct):
    """One flag: its last value, where it rose (number of the cycle, seconds into it), and the last cycle it was told in."""

    last: Scalar | None = None
    rose: list[tuple[int, float]] = []
    told: int = 0


class RecurrenceDetector:
    """Remembers where in the cycle each of its flags rose, and says so when the work is about to be there again."""

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:
        self.spec = spec
        self._robot = domain.robot
        self._settings = settings_of(spec, RecurrenceSettings)
        if not self._settings.cycle:
            raise DomainError(f"detect {spec.kind!r} (recurrence): give settings.cycle, the channel whose changes begin a cycle")
        self._clock = CycleClock(self._settings.cycle, tuple(self._settings.pause))
        self.channels = Channels((*spec.channels, *self._clock.patterns))
        self._watched = Channels(spec.channels)
        self._flags: dict[str, Flag] = {}

    def observe(self, observation: Observation) -> Iterable[Seen]:
        """Follow the flags and the cycle."""
        place = self._clock.observe(observation)
        found: list[Seen] = []
        for channel, value in self._watched.of(observation):
            flag = self._flags.setdefault(channel, Flag())
            now = scalar(value)
            if now is not None:
                if now and flag.last is not None and not flag.last and place.number:
                    flag.rose = [*flag.rose[-(TIMES - 1) :], (place.number, place.gone_s)]
                flag.last = now
            if place.number and not flag.last and (seen := self._near(channel, flag, place, observation)):
                found.append(seen)
        return found

    def state(self) -> bytes:
        """The cycle and the flags, as bytes."""
        return msgspec.msgpack.encode((self._clock.place, self._flags))

    def restore(self, state: bytes) -> None:
        """Take up what ``state`` gave out."""
        self._clock.place, self._flags = msgspec.msgpack.decode(state, type=tuple[Place, dict[str, Flag]])

    def _near(self, channel: str, flag: Flag, place: Place, observation: Observation) -> Found | None:
        number, gone_s, settings = place.number, place.gone_s, self._settings
        if flag.told == number:
            return None
        near = [
            at_s for cycle, at_s in flag.rose if 0 < number - cycle <= settings.within and 0 < at_s - gone_s <= settings.ahead_s
        ]
        if len(near) < settings.least:
            return None
        flag.told = number
        ahead_s = min(near) - gone_s
        fields: dict[str, Field] = {
            "channel": channel,
            "times": len(near),
            "ahead_s": short(ahead_s),
            "into_cycle_s": short(min(near)),
        }
        entity = named(self.spec.entity, channel, observation.topic, observation.robot or self._robot)
        says = (
            f"{channel} rose {said(min(near))} s into {len(near)} of the last {settings.within} cycles, {ahead_s:.2g} s from now"
        )
        return Found(fields=fields, says=f"{self.spec.says or self.spec.kind}: {says}", entity=entity)
