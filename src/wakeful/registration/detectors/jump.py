"""``jump``: a number steps from one observation to the next by far more than it usually does."""

from __future__ import annotations

import msgspec

from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation
from wakeful.facts.values import Field, Value
from wakeful.registration.detectors.base import (
    Count,
    Memory,
    NotNegative,
    PerChannel,
    Positive,
    Seen,
    Settings,
    settings_of,
    short,
)
from wakeful.registration.plain import elapsed_s, number


class JumpSettings(Settings, frozen=True):
    """What `jump` may be told.

    ``times``: the usual step so many times over; ``least``: the least step, in the channel's unit; ``learn``, ``memory``: steps
    until there is a usual one, and over which it forgets; ``gap_s``: least time between events of one channel; ``longest_s``: the
    longest time between two values that are still compared (0: any); ``turn``: the channel is an angle that wraps at so much.
    """

    times: Positive = 8.0
    least: NotNegative = 0.0
    learn: Count = 30
    memory: Memory = 500.0
    gap_s: NotNegative = 5.0
    longest_s: NotNegative = 0.0
    turn: NotNegative = 0.0


class Steps(msgspec.Struct):
    """The memory of one channel."""

    last: float | None = None
    last_ns: int = 0
    count: int = 0
    usual: float = 0.0
    event_ns: int | None = None


class JumpDetector(PerChannel[Steps]):
    """Follows the mean step, each step counted as at most twice the limit so that a jump doesn't become usual."""

    memory_type = Steps

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:
        super().__init__(spec, domain)
        self._settings = settings_of(spec, JumpSettings)

    def look(self, channel: str, value: Value, memory: Steps, observation: Observation) -> Seen | None:
        """Compare the step with the usual one."""
        reading = number(value)
        if reading is None:
            return None
        last, last_ns = memory.last, memory.last_ns
        memory.last, memory.last_ns = reading, observation.at_ns
        settings = self._settings
        if last is None or (settings.longest_s > 0 and elapsed_s(observation.at_ns, last_ns) > settings.longest_s):
            return None
        step = reading - last
        if settings.turn > 0:
            step = (step + settings.turn / 2) % settings.turn - settings.turn / 2
        size = abs(step)
        limit = max(settings.times * memory.usual, settings.least)
        jumped = memory.count >= settings.learn and size > limit
        usual = memory.usual
        memory.count += 1
        counted = min(size, 2.0 * limit) if memory.count > settings.learn and limit > 0 else size
        memory.usual += (counted - memory.usual) / min(memory.count, settings.memory)
        if not jumped or elapsed_s(observation.at_ns, memory.event_ns) < settings.gap_s:
            return None
        memory.event_ns = observation.at_ns
        fields: dict[str, Field] = {
            "value": short(reading),
            "was": short(last),
            "step": short(step),
            "times": short(min(size / max(usual, 1e-12), 1e6)),
        }
        return self.found(channel, observation, fields, f"{channel} steps by {step:.4g} to {reading:.4g}; usual is {usual:.3g}")
