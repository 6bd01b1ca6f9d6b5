"""The contract of a domain: data, and a registrar with memory."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Protocol

import msgspec

from wakeful.contracts.detector import DetectorFactory
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Draft, Observation
from wakeful.facts.evidence import Evidence, Outcome


class DomainError(Exception):
    """A domain that cannot be used. The message says which file or part, where in it, and what to do."""


class Registered(msgspec.Struct, frozen=True):
    """What one observation turned out to mean: events, evidence, outcomes (each possibly none)."""

    events: tuple[Draft, ...] = ()
    evidence: tuple[Evidence, ...] = ()
    outcomes: tuple[Outcome, ...] = ()


class Registrar(Protocol):
    """Registration with memory, D(o, c): learned bands, entity memory, open conditions.

    Its state is committed with the source cursor. It never reads a clock and never looks ahead: what it registers at an
    observation depends on that observation and earlier ones alone.
    """

    def observe(self, observation: Observation) -> Registered:
        """Register one observation. Drafts, evidence and outcomes carry the observation's source, position and time."""

    def changed(self) -> dict[str, bytes]:
        """The parts of the state that changed since the last call, each under its own name."""

    def restore(self, parts: Mapping[str, bytes]) -> None:
        """Take up the state that ``changed`` gave out, all parts together."""


class Domain(Protocol):
    """One robot family's vocabulary: data, and the detectors and simulator that data cannot say."""

    @property
    def spec(self) -> DomainSpec:
        """The domain's data."""

    def detectors(self) -> Mapping[str, DetectorFactory]:
        """The domain's own detectors by name, beside those that registration brings."""

    def simulate(self, seed: int) -> Iterator[Observation] | None:
        """An endless, seeded source of this domain, or None where there is none."""
