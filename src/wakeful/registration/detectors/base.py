"""What the detectors of registration share: their settings checked, and one bounded memory per channel.

An author fills in ``look``; the framework owns which values come, in what order, and how memory is written down.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Final, Generic, TypeVar

import msgspec

from wakeful.contracts.detector import Found, Offered, Shown
from wakeful.contracts.domain import DomainError
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.values import Field, Value
from wakeful.registration.channels import Channels, named, unknown_placeholder

CHANNELS: Final = 1024
"""Channels that one detector remembers; beyond it the one first met is forgotten."""

Seen = Found | Shown | Offered
Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]
Share = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
Memory = Annotated[float, msgspec.Meta(ge=2.0)]
Count = Annotated[int, msgspec.Meta(ge=1)]

S = TypeVar("S", bound="Settings")
M = TypeVar("M", bound=msgspec.Struct)


class Settings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base of a detector's settings: what a domain may write under ``settings``."""


def settings_of(spec: DetectorSpec, kind: type[S]) -> S:
    """The settings that a domain gives a detector.

    Raises:
        DomainError: a setting that the detector doesn't know, or of the wrong type. The message names those it knows.
    """
    try:
        return msgspec.convert(spec.settings, kind)
    except msgspec.ValidationError as error:
        known = ", ".join(kind.__struct_fields__)
        raise DomainError(f"detect {spec.kind!r} ({spec.detector}): settings: {error}; it knows {known}") from error


def levels_of(spec: DetectorSpec, setting: str, pairs: list[str]) -> dict[str, int]:
    """Numbers by name, out of texts such as ``"FATAL=3"``. Raises DomainError where one is no such pair."""
    found = {}
    for pair in pairs:
        name, sign, level = (part.strip() for part in pair.partition("="))
        if not name or not sign or not level.isdigit():
            raise DomainError(
                f"detect {spec.kind!r} ({spec.detector}): settings.{setting}: {pair!r}; write name=number, such as FATAL=3"
            )
        found[name] = int(level)
    return found


class PerChannel(Generic[M]):
    """A detector that looks at each of its channels by itself, with a memory of type ``memory_type`` for each."""

    memory_type: ClassVar[type[msgspec.Struct]]

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:
        if word := unknown_placeholder(spec.entity, "type"):
            raise DomainError(
                f"detect {spec.kind!r}: entity {spec.entity!r}: nothing is called {{{word}}}; see DetectorSpec.entity"
            )
        self.spec = spec
        self._robot = domain.robot
        self.channels = self._measured = Channels(spec.channels)
        self._memory: dict[str, M] = {}

    def observe(self, observation: Observation) -> list[Seen]:
        """What this observation shows on the detector's channels."""
        found: list[Seen] = []
        for channel, value in self._measured.of(observation):
            memory = self._memory.get(channel)
            if memory is None:
                memory = self._first(channel)
            seen = self.look(channel, value, memory, observation)
            if seen is not None:
                found.append(seen)
        return found

    def look(self, channel: str, value: Value, memory: M, observation: Observation) -> Seen | None:
        """What one value shows, given (and changing) the memory of its channel."""
        raise NotImplementedError

    def state(self) -> bytes:
        """The memory of all channels, as bytes."""
        return msgspec.msgpack.encode(self._memory)

    def restore(self, state: bytes) -> None:
        """Take up what ``state`` gave out."""
        self._memory = msgspec.msgpack.decode(state, type=dict[str, self.memory_type])  # type: ignore[name-defined]

    def entity(self, channel: str, observation: Observation) -> str:
        """The entity that the domain gives this channel."""
        return named(self.spec.entity, channel, observation.topic, observation.robot or self._robot)

    def found(
        self,
        channel: str,
        observation: Observation,
        fields: dict[str, Field],
        says: str,
        phase: Phase | None = None,
        type: str = "",
    ) -> Found:
        """A Found on this channel; with a phase, of the condition that the event's kind is on this entity."""
        entity = self.entity(channel, observation)
        return Found(
            fields={"channel": channel, **fields},
            says=f"{self.spec.says or self.spec.kind}: {says}",
            entity=entity,
            phase=phase,
            type=type or (self.spec.kind if phase else ""),
            references=(entity,) if phase else (),
        )

    def _first(self, channel: str) -> M:
        if len(self._memory) >= CHANNELS:
            del self._memory[next(iter(self._memory))]
        memory: M = self.memory_type()  # type: ignore[assignment]
        self._memory[channel] = memory
        return memory


def said(value: float) -> str:
    """A number to three significant digits as a sentence says it, written out where a person would.

    >>> said(24.31), said(18_812.0)
    ('24.3', '18800')
    """
    rounded = float(f"{value:.3g}")
    return f"{rounded:.0f}" if 100 <= abs(rounded) < 1e9 else f"{rounded:.3g}"


def short(value: float) -> float:
    """A number with five significant digits: as many as a person or a learner can use."""
    return float(f"{value:.5g}")
