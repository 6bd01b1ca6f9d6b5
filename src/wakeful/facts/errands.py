"""Errands: a task as a planning problem over a route graph, and the plan that a planner made of it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TypeAlias

from wakeful.facts.domain import Errand
from wakeful.facts.values import Fact


class Leg(Fact, frozen=True):
    """One free leg, in one direction."""

    start: str
    end: str
    cost: float


class Errands(Fact, frozen=True):
    """A planning problem: from where, what to do where and after what, where to end, over which legs."""

    start: str
    errands: tuple[Errand, ...]
    legs: tuple[Leg, ...]
    end: str = ""
    within_s: float = 5.0

    def places(self) -> tuple[str, ...]:
        """Every place that is named."""
        named = [self.start, *(errand.at for errand in self.errands), *([self.end] if self.end else [])]
        return tuple(dict.fromkeys([*named, *(place for leg in self.legs for place in (leg.start, leg.end))]))


class Plan(Fact, frozen=True):
    """The plan of a task. ``optimal``: the search showed that none costs less. ``pddl``: domain and problem, to be looked at."""

    feasible: bool
    optimal: bool = False
    steps: tuple[str, ...] = ()
    cost: float = 0.0
    pddl: str = ""


#: Who plans: given the problem, its Plan as plain data; to be called outside the kernel.
Planner: TypeAlias = Callable[[Errands], Awaitable[dict[str, object]]]
