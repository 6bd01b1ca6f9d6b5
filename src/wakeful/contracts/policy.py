"""The contract of a scheduling policy: which processes hold the slots for the next step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

import msgspec

from wakeful.facts.decisions import Mode
from wakeful.facts.processes import ProcessView


class Pick(msgspec.Struct, frozen=True):
    """The processes that hold the slots for the next step, and those dropped on purpose (only experiments allow it).

    ``again_ns``: a policy that leaves slots empty though somebody could use them says when it wants to be asked again.
    """

    run: tuple[int, ...]
    abandon: tuple[int, ...] = ()
    again_ns: int | None = None


class Policy(Protocol):
    """Chooses among processes. Told of every change, asked at each step's boundary; it sees no future and no clock.

    Its answer depends only on what it was told, never on the order of equal calls: ties go by arrival, then id.
    """

    name: str

    def runnable(self, view: ProcessView, now_ns: int) -> None:
        """The process can use a slot from now on (created, woken, preempted, or its view changed)."""

    def waiting(self, view: ProcessView, now_ns: int) -> None:
        """The process waits; ``view.evidence_due_ns`` says for how long at most."""

    def gone(self, process: int, now_ns: int) -> None:
        """The process has completed or is held by an operator: no longer eligible."""

    def pick(self, running: Sequence[int], slots: int, now_ns: int) -> Pick:
        """At most ``slots`` processes for the next step; ``running`` held them in the last one. O(log n)."""


@runtime_checkable
class LearningPolicy(Policy, Protocol):
    """A policy that learns how much effort processes take. Recovery tells it the same completions again."""

    def completed(self, view: ProcessView, now_ns: int) -> None:
        """The process was resolved: its last view, with all its steps. ``gone`` follows."""


@runtime_checkable
class ConservingPolicy(Policy, Protocol):
    """A policy that leaves no slot empty while a process is ready. Where only one is, it need not be asked."""

    def ran_through(self, treatment: str, mode: Mode, kind: str, steps: int, now_ns: int) -> None:
        """Such a process came, ran its steps and was resolved, all at this instant; of it nothing else is told."""


@runtime_checkable
class ParkingPolicy(Policy, Protocol):
    """A policy that gives away what it knows of a process that waits long, so that it takes no memory. Others keep it."""

    def park(self, process: int) -> tuple[int, ...]:
        """What is known of a waiting process, which is forgotten."""

    def bring_back(self, process: int, known: tuple[int, ...]) -> None:
        """The process waits as before; ``known`` is what ``park`` returned."""
