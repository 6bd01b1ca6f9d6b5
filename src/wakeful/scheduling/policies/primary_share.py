"""A declared share of the time for the robot's primary task, whatever policy shares out the rest."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import msgspec

from wakeful.contracts.policy import LearningPolicy, ParkingPolicy, Pick, Policy
from wakeful.facts.events import CRITICAL
from wakeful.facts.processes import ProcessView
from wakeful.facts.time import to_ns


class PrimaryShare:
    """Leaves the slots empty in ``share`` of all quanta, evenly spread, except for critical processes.

    Which quanta are the primary task's is a function of kernel time alone: quantum q is, when ``share`` × q has just passed a
    whole number. What cognition leaves idle comes on top, so the primary task gets at least its share of the time that critical
    processes leave. The inner policy is asked as if nothing had happened.

    Args:
        inner: shares out the rest.
        share: of the time, from 0 to 1. At 1 nothing but critical processes ever runs.
        quantum_s: how long the primary task has the robot to itself at a time; a step's length is a good one.

    Raises:
        ValueError: share or quantum is outside its range.
    """

    def __init__(self, inner: Policy, share: float, quantum_s: float = 1.0) -> None:
        if not 0.0 <= share <= 1.0:
            raise ValueError(f"primary_share is {share}; it must be from 0 to 1")
        if not quantum_s > 0.0:
            raise ValueError(f"primary_quantum_s is {quantum_s}; it must be more than 0")
        self.name = inner.name
        self._inner = inner
        self._parks = inner if isinstance(inner, ParkingPolicy) else None
        self._learns = inner if isinstance(inner, LearningPolicy) else None
        self._share = Fraction(share).limit_denominator(1000)
        self._quantum_ns = max(1, to_ns(quantum_s))
        self._critical: set[int] = set()

    def runnable(self, view: ProcessView, now_ns: int) -> None:
        """Told on; critical ones are remembered."""
        if view.criticality >= CRITICAL:
            self._critical.add(view.id)
        self._inner.runnable(view, now_ns)

    def waiting(self, view: ProcessView, now_ns: int) -> None:
        """Told on."""
        self._inner.waiting(view, now_ns)

    def completed(self, view: ProcessView, now_ns: int) -> None:
        """Told on where the inner policy learns."""
        if self._learns is not None:
            self._learns.completed(view, now_ns)

    def gone(self, process: int, now_ns: int) -> None:
        """Told on."""
        self._critical.discard(process)
        self._inner.gone(process, now_ns)

    def park(self, process: int) -> tuple[int, ...]:
        """What the inner policy gives away, and whether it is critical."""
        critical = process in self._critical
        self._critical.discard(process)
        return int(critical), *(self._parks.park(process) if self._parks is not None else ())

    def bring_back(self, process: int, known: tuple[int, ...]) -> None:
        """As it was."""
        if known[0]:
            self._critical.add(process)
        if self._parks is not None:
            self._parks.bring_back(process, known[1:])

    def pick(self, running: Sequence[int], slots: int, now_ns: int) -> Pick:
        """The inner policy's answer; in the primary task's quanta the critical processes of it alone."""
        pick = self._inner.pick(running, slots, now_ns)
        quantum = now_ns // self._quantum_ns
        if int(self._share * (quantum + 1)) == int(self._share * quantum):
            return pick
        critical = tuple(each for each in pick.run if each in self._critical)
        if critical == pick.run:
            return pick
        return msgspec.structs.replace(pick, run=critical, again_ns=(quantum + 1) * self._quantum_ns)
