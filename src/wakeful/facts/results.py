"""r: what a treatment concluded, typed per treatment."""

from __future__ import annotations

from typing import Literal

import msgspec

from wakeful.facts.values import Fact


class Forecast(Fact, frozen=True):
    """What the result says the world will show: a label of the domain's outcomes, within a window after the event."""

    label: str
    probability: float
    probabilities: dict[str, float] = {}
    topic: str = ""
    entity: str = ""


class Proposal(Fact, frozen=True):
    """An effect that is only proposed: whoever executes it checks the preconditions and the instant again."""

    effect: str
    preconditions: tuple[str, ...] = ()
    authority: Literal["operator", "supervisor", "autonomy"] = "operator"
    valid_until_ns: int | None = None


class Consulted(Fact, frozen=True):
    """What a treatment's own question to the reasoner brought. ``used``: its answer passed the check against the domain."""

    about: str
    used: bool
    why: str
    who: str = ""
    said: str = ""


class Result(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, tag_field="type"):
    """Base of every treatment's result; a treatment subclasses it with its own typed fields.

    ``says`` is one sentence for a person; ``rests_on`` what it used (event, experience or evidence ids, rules);
    ``confidence`` in [0, 1]; ``would_change`` what evidence would change it.
    """

    says: str
    confidence: float
    rests_on: tuple[str, ...] = ()
    would_change: tuple[str, ...] = ()
    forecast: Forecast | None = None
    proposes: tuple[Proposal, ...] = ()
    consulted: Consulted | None = None


class Unresolved(Result, frozen=True, kw_only=True, tag="unresolved"):
    """What is recorded when a treatment failed in fallback mode too; the event is entered as debt."""

    failure: str
