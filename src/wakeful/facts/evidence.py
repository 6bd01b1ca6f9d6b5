"""What comes later: evidence that a process asked for, and outcomes that the world showed."""

from __future__ import annotations

from typing import Literal

from wakeful.facts.values import NOTHING, Fact, Raw

Origin = Literal["world", "person", "reasoner"]


class Evidence(Fact, frozen=True):
    """Later information, addressed by topic and key, never by object reference.

    ``id`` makes it idempotent: the same id delivered twice counts once. ``at_ns`` is when it was observed, by the clock of
    whoever says so; ``received_ns`` when it came, by kernel time, which the kernel fills in. For how long it is kept goes by the
    latter, so that a clock that is wrong makes no evidence vanish.
    """

    id: str
    topic: str
    key: str
    at_ns: int
    value: Raw = NOTHING
    origin: Origin = "world"
    received_ns: int = 0


class Outcome(Fact, frozen=True):
    """y: what the world later showed about an entity (Eq. 10). ``label`` is one of the domain's outcome labels.

    ``topic`` names what was observed, ``entity`` whom it concerns (``*`` for the whole robot). ``acted_on`` says
    whether the result had been acted on: what may have been prevented is undecided, not contradicted.
    ``event`` may name one event; otherwise entity, topic and time window decide.
    """

    id: str
    topic: str
    entity: str
    label: str
    at_ns: int
    event: str = ""
    treatment: str = ""
    acted_on: bool = False
    origin: Origin = "world"
    source: str = ""
