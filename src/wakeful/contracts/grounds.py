"""The contract of a model version that can name what it learned: which rules spoke for a treatment, and how its parts weighed."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import msgspec

from wakeful.contracts.learner import Predictor, Vector


class Ask(msgspec.Struct, frozen=True):
    """What a rule asks of an event: ``features[column] + slope · features[other]`` above ``limit``, or not above it. ``other`` is
    -1 where one column is asked for alone."""

    column: int
    limit: float
    above: bool
    other: int = -1
    slope: float = 0.0


class HeardRule(msgspec.Struct, frozen=True):
    """A learned rule that held for the event. ``heard``: the share of the lists' say in which it was the first that held;
    ``share``: what it says of the treatment, mean over these lists; ``support``: the experiences that it speaks for, at most.
    Without ``asks`` it is what a list says where none of its rules holds."""

    asks: tuple[Ask, ...]
    heard: float
    share: float
    support: int


class Part(msgspec.Struct, frozen=True):
    """What one part of a model adds, in nats, to the logarithm of the odds of a treatment against another."""

    name: str
    nats: float


class Grounds(msgspec.Struct, frozen=True):
    """Why the model ranks ``treatment`` as it does. The parts add up to ln(P(treatment) / P(against)), exactly but for rounding;
    the rules' ``heard`` add up to 1, and heard · share to what the lists say of the treatment."""

    treatment: str
    against: str
    parts: tuple[Part, ...]
    rules: tuple[HeardRule, ...]


@runtime_checkable
class Grounded(Predictor, Protocol):
    """A model version of several parts, learned rules among them."""

    def grounds(self, features: Vector, treatment: str) -> Grounds | None:
        """What spoke for the treatment, against the likeliest other one, for one event's features, shape (d,).

        Returns:
            None where the model does not know the treatment, or knows no other.
        """
