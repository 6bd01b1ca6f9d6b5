"""``threshold``: a number passes a limit, and stays a condition until it is well inside again."""

from __future__ import annotations

import msgspec

from wakeful.contracts.domain import DomainError
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.values import Field, Value
from wakeful.registration.detectors.base import NotNegative, PerChannel, Seen, Settings, settings_of, short
from wakeful.registration.plain import elapsed_s, number


class ThresholdSettings(Settings, frozen=True):
    """What `threshold` may be told.

    ``above``, ``below``: the limits, at least one; ``back``: how far inside it must come, in the channel's unit, before it is
    over; ``hold_s``: how long it must last before it counts; ``lasting``: whether it is a condition.
    """

    above: float | None = None
    below: float | None = None
    back: NotNegative = 0.0
    hold_s: NotNegative = 0.0
    lasting: bool = True


class Passed(msgspec.Struct):
    """The memory of one channel: 1 above, -1 below, 0 inside; ``raised`` once it has held."""

    side: int = 0
    since_ns: int | None = None
    raised: bool = False


class ThresholdDetector(PerChannel[Passed]):
    """Registers passing a limit."""

    memory_type = Passed

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:
        super().__init__(spec, domain)
        self._settings = settings_of(spec, ThresholdSettings)
        if self._settings.above is None and self._settings.below is None:
            raise DomainError(f"detect {spec.kind!r} (threshold): give settings.above or settings.below")

    def look(self, channel: str, value: Value, memory: Passed, observation: Observation) -> Seen | None:
        """Compare with the limits."""
        reading = number(value)
        if reading is None:
            return None
        side = self._side(reading, memory.side)
        if side != memory.side:
            was_raised = memory.raised
            memory.side, memory.since_ns, memory.raised = side, observation.at_ns, False
            if side == 0 and was_raised and self._settings.lasting:
                says = f"{channel} is {reading:.4g}, back inside"
                return self.found(channel, observation, {"value": short(reading)}, says, Phase.CLEARED)
        if side == 0 or memory.raised or elapsed_s(observation.at_ns, memory.since_ns) < self._settings.hold_s:
            return None
        memory.raised = True
        limit = self._settings.above if side > 0 else self._settings.below
        word = "above" if side > 0 else "below"
        fields: dict[str, Field] = {"value": short(reading), "limit": limit, "side": word}
        says = f"{channel} is {reading:.4g}, {word} {limit:.4g}"
        return self.found(channel, observation, fields, says, Phase.RAISED if self._settings.lasting else None)

    def _side(self, reading: float, before: int) -> int:
        settings = self._settings
        if settings.above is not None and reading > settings.above - (settings.back if before > 0 else 0.0):
            return 1
        if settings.below is not None and reading < settings.below + (settings.back if before < 0 else 0.0):
            return -1
        return 0
