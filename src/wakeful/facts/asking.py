"""What a treatment may await, and how each request is named. An answer is recorded under its request's own identity."""

from __future__ import annotations

from enum import StrEnum
from typing import Literal

from wakeful.facts.values import NOTHING, Fact, Raw

Safety = Literal["read", "idempotent", "effect"]
"""What may be done with a call in doubt after a crash: again; again with its key; never, a person is told."""


class Kind(StrEnum):
    """The kinds of request. ``work`` is not recorded one by one: its steps are counted in the transitions."""

    EVIDENCE = "evidence"
    RECALL = "recall"
    DELIBERATE = "deliberate"
    ASK = "ask"
    TREAT = "treat"
    CALL = "call"
    SLEEP = "sleep"


class Question(Fact, frozen=True):
    """A typed question for a reasoner. ``event_text`` is data from the world, never instruction.

    ``options`` are the only admissible choices (registered treatments, fault names, …); ``labels`` the outcome labels
    that may be forecast; ``history`` sentences on validated similar experience; ``schema`` a JSON schema for ``Reply.answer``
    where more than a choice is wanted.
    """

    about: str
    event: str
    asks: str
    options: tuple[str, ...]
    labels: tuple[str, ...] = ()
    facts: dict[str, str] = {}
    history: tuple[str, ...] = ()
    schema: Raw = NOTHING


class Reply(Fact, frozen=True):
    """A reasoner's or a person's answer, checked against the question: ``choice`` is one of its options."""

    choice: str
    confidence: float
    forecast: str = ""
    forecast_probability: float = 0.0
    because: tuple[str, ...] = ()
    answer: Raw = NOTHING
    reasoner: str = ""
    cost_usd: float = 0.0
    calls: int = 1


class Query(Fact, frozen=True):
    """What to recall: episodes most like ``event`` (an event id), or about ``entity``, newest first on equal likeness."""

    event: str = ""
    entity: str = ""
    kind: str = ""
    limit: int = 5


class Episode(Fact, frozen=True):
    """A past event as memory returns it: what it was, what was concluded, how it ended."""

    event: str
    kind: str
    entity: str
    at_ns: int
    likeness: float
    treatment: str
    says: str = ""
    predicted: str = ""
    outcome: str = ""
    verdict: str = ""
    experience: int = 0
    robot: str = ""
    fields: dict[str, None | bool | int | float | str | tuple[float, ...]] = {}
