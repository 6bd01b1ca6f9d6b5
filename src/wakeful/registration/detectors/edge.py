"""``edge``: a flag rises or falls, a category changes."""

from __future__ import annotations

from typing import Literal

import msgspec

from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.values import Field, Value
from wakeful.registration.detectors.base import PerChannel, Seen, Settings, said, settings_of
from wakeful.registration.plain import Scalar, elapsed_s, scalar


class EdgeSettings(Settings, frozen=True):
    """What `edge` may be told.

    ``on``: ``rising`` (becomes true, or other than zero and empty), ``falling``, or ``change`` (any); ``first``: whether the
    first value counts as an edge where it is already so; ``lasting``: a rising edge raises a condition, the falling clears it;
    ``only``: the new values that count, as text (empty: all).
    """

    on: Literal["rising", "falling", "change"] = "change"
    first: bool = False
    lasting: bool = False
    only: list[str] = []


class Last(msgspec.Struct):
    """The memory of one channel. A value that says nothing (None, blank, NaN) leaves it as it was."""

    value: Scalar | None = None
    since_ns: int | None = None


class EdgeDetector(PerChannel[Last]):
    """Registers a change of a value."""

    memory_type = Last

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:
        super().__init__(spec, domain)
        self._settings = settings_of(spec, EdgeSettings)

    def look(self, channel: str, value: Value, memory: Last, observation: Observation) -> Seen | None:
        """Compare with the last value."""
        now = scalar(value)
        was = memory.value
        if now is None or (now == was and now.__class__ is was.__class__):
            return None
        lasted_s = elapsed_s(observation.at_ns, memory.since_ns)
        memory.value, memory.since_ns = now, observation.at_ns
        if was is None and not self._settings.first:
            return None
        fields: dict[str, Field] = {"value": now}
        if was is not None:
            fields["was"] = was
            if lasted_s != float("inf"):
                fields["lasted_s"] = round(lasted_s, 3)
        phase = self._phase(was, now)
        if phase is None or (phase is Phase.RAISED and self._settings.only and str(now) not in self._settings.only):
            return None
        return self.found(
            channel, observation, fields, _says(channel, was, now, lasted_s), phase if self._settings.lasting else None
        )

    def _phase(self, was: Scalar | None, now: Scalar) -> Phase | None:
        """What the step is: raised where it is an event, cleared where it only ends one, None where it is neither."""
        on = self._settings.on
        if on == "change" and not self._settings.lasting:
            return Phase.RAISED
        if on == "falling":
            rose, fell = bool(was or was is None) and not now, bool(now)
        else:
            rose, fell = bool(now), not now
        if rose:
            same = on != "change" and bool(was) == bool(now) and was is not None
            return None if same else Phase.CHANGED if was and on == "change" else Phase.RAISED
        return Phase.CLEARED if fell and self._settings.lasting else None


def _says(channel: str, was: Scalar | None, now: Scalar, lasted_s: float) -> str:
    before = "" if was is None or lasted_s == float("inf") else f" after {said(lasted_s)} s"
    if isinstance(now, bool):
        return f"{channel} {'came on' if now else 'went off'}{before}"
    return f"{channel} is {now}" + (f"{before} of {was}" if was is not None else "")
