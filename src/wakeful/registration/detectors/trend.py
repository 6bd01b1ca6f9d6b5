"""``trend``: a number drifts by more than its noise explains."""

from __future__ import annotations

import math

import msgspec

from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation
from wakeful.facts.values import Field, Value
from wakeful.registration.detectors.base import NotNegative, PerChannel, Positive, Seen, Settings, settings_of, short
from wakeful.registration.plain import elapsed_s, number

POINTS = 16
"""The window is summarised by so many means."""


class TrendSettings(Settings, frozen=True):
    """What `trend` may be told.

    ``window_s``: over which the slope is taken; ``strength``: slope over its standard error; ``least``: least change over the
    window, in the channel's unit; ``again_s``: while it goes on, not again before (0: only after it has ended).
    """

    window_s: Positive = 300.0
    strength: Positive = 5.0
    least: NotNegative = 0.0
    again_s: NotNegative = 0.0


class Drift(msgspec.Struct):
    """The memory of one channel: the means so far, and the one being made."""

    at_s: list[float] = []
    means: list[float] = []
    origin_ns: int = 0
    start_ns: int | None = None
    total: float = 0.0
    count: int = 0
    side: int = 0
    event_ns: int | None = None


class TrendDetector(PerChannel[Drift]):
    """Fits a line to the means of the window, each time a mean is complete."""

    memory_type = Drift

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:
        super().__init__(spec, domain)
        self._settings = settings_of(spec, TrendSettings)
        self._piece_s = max(self._settings.window_s, 1e-6) / POINTS

    def look(self, channel: str, value: Value, memory: Drift, observation: Observation) -> Seen | None:
        """Add a value to the mean being made; at its end look at the line."""
        reading = number(value)
        if reading is None:
            return None
        at_ns = observation.at_ns
        gone = elapsed_s(at_ns, memory.start_ns)
        if gone > 2.0 * self._settings.window_s:
            memory.at_s, memory.means, memory.side = [], [], 0
            memory.origin_ns = memory.start_ns = at_ns
            memory.total, memory.count, gone = 0.0, 0, 0.0
        seen = None
        if gone >= self._piece_s and memory.count:
            seen = self._piece(channel, memory, observation)
            memory.start_ns, memory.total, memory.count = at_ns, 0.0, 0
        memory.total += reading
        memory.count += 1
        return seen

    def _piece(self, channel: str, memory: Drift, observation: Observation) -> Seen | None:
        started_ns = memory.origin_ns if memory.start_ns is None else memory.start_ns
        memory.at_s.append((started_ns - memory.origin_ns) / 1e9)
        memory.means.append(memory.total / memory.count)
        del memory.at_s[:-POINTS], memory.means[:-POINTS]
        if len(memory.means) < POINTS // 2:
            return None
        slope, error = line(memory.at_s, memory.means)
        change = slope * self._settings.window_s
        strength = abs(slope) / error if error > 0 else (math.inf if slope else 0.0)
        side = (slope > 0) - (slope < 0)
        if strength < 0.5 * self._settings.strength or abs(change) < 0.5 * self._settings.least or side != memory.side:
            memory.side = 0
        if strength < self._settings.strength or abs(change) <= self._settings.least:
            return None
        going_on = memory.side == side
        if going_on and not 0 < self._settings.again_s <= elapsed_s(observation.at_ns, memory.event_ns):
            return None
        memory.side, memory.event_ns = side, observation.at_ns
        fields: dict[str, Field] = {
            "value": short(memory.means[-1]),
            "slope_per_min": short(60.0 * slope),
            "strength": short(min(strength, 1e3)),
            "side": "rising" if side > 0 else "falling",
        }
        says = f"{channel} is {fields['side']} by {abs(60 * slope):.3g} a minute, now {memory.means[-1]:.4g}"
        return self.found(channel, observation, fields, says)


def line(at: list[float], values: list[float]) -> tuple[float, float]:
    """Slope of the least-squares line and its standard error; (0, 0) where all stand at one instant.

    >>> slope, error = line([0.0, 1.0, 2.0, 3.0], [0.0, 1.1, 1.9, 3.0])
    >>> round(slope, 2), round(error, 3)
    (0.98, 0.042)
    """
    count = len(at)
    middle_t, middle_v = math.fsum(at) / count, math.fsum(values) / count
    square = math.fsum((t - middle_t) ** 2 for t in at)
    if square <= 0.0 or count < 3:
        return 0.0, 0.0
    slope = math.fsum((t - middle_t) * (v - middle_v) for t, v in zip(at, values, strict=True)) / square
    rest = math.fsum((v - middle_v - slope * (t - middle_t)) ** 2 for t, v in zip(at, values, strict=True))
    return slope, math.sqrt(rest / (count - 2) / square)
