"""The contract of a detector: looks at observations, remembers, and says what it found."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Protocol

import msgspec

from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.values import Field, Value

BOOKKEEPING = frozenset(
    ("usual", "usual_s", "deviation", "joined", "limit", "was", "times", "lasted_s", "type", "references", "wording", "text")
)
"""Fields in which the detectors that registration brings say how they found something: what was usual, how far out of its band,
how many joined in, what was there before, in which words. They are no measurements: treatments don't compare events by them."""


class Found(msgspec.Struct, frozen=True, kw_only=True):
    """Something that may be an event. The registrar adds source, position, time, context and the relation to what it
    remembers of the entity, and turns repeats and clearings of a condition into evidence.

    ``type`` and ``references`` name the condition where ``phase`` is set. ``kind``, ``entity`` and ``criticality`` default to
    the detector's spec. ``at_ns`` overrides the observation's time where the thing began earlier.
    """

    fields: Mapping[str, Field]
    says: str = ""
    kind: str = ""
    entity: str = ""
    zone: str = ""
    task: str = ""
    safety: bool = False
    criticality: int | None = None
    deadline_s: float | None = None
    phase: Phase | None = None
    type: str = ""
    references: tuple[str, ...] = ()
    observations: int = 1
    truth_treatment: str | None = None


class Shown(msgspec.Struct, frozen=True, kw_only=True):
    """An outcome that a detector saw: the world shows ``label`` of ``entity`` (``*``: of the robot)."""

    label: str
    entity: str = "*"
    event_position: int | None = None
    treatment: str = ""
    acted_on: bool = False


class Offered(msgspec.Struct, frozen=True, kw_only=True):
    """Evidence for whoever asks for (topic, key)."""

    topic: str
    key: str
    value: Value


class Detector(Protocol):
    """One detector with memory. It sees observations in order and never the future."""

    def observe(self, observation: Observation) -> Iterable[Found | Shown | Offered]:
        """What this observation shows, usually nothing. Values may be missing, None, NaN or of the wrong type: a detector
        passes over what it can't use and never raises on data."""

    def state(self) -> bytes:
        """All that must be remembered, as bytes."""

    def restore(self, state: bytes) -> None:
        """Take up what ``state`` gave out."""


DetectorFactory = Callable[[DetectorSpec, DomainSpec], Detector]
