"""The contract of a treatment: a coroutine that the kernel itself drives, and the mind that it may await."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Protocol, TypeVar

from wakeful.facts.asking import Episode, Query, Question, Reply, Safety
from wakeful.facts.decisions import Decision, Mode
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Event
from wakeful.facts.evidence import Evidence
from wakeful.facts.results import Forecast, Result

T = TypeVar("T")


class Refusal(Exception):
    """What was awaited did not come: a reasoner refused, a call failed, a person was not there. Recorded like any answer."""


class Mind(Protocol):
    """All that a treatment may await, and what it may read without awaiting. Every await is a preemption point."""

    @property
    def mode(self) -> Mode:
        """How this process is executed."""

    @property
    def decision(self) -> Decision:
        """The decision that started this process."""

    @property
    def domain(self) -> DomainSpec:
        """The domain's data."""

    @property
    def prior(self) -> dict[str, float]:
        """Probabilities over outcome labels to start from: the result head's in auto mode, the reasoner's or the
        guidelines' otherwise."""

    @property
    def advice(self) -> Reply | None:
        """What deliberation said when the treatment was chosen, in delib mode."""

    @property
    def consults(self) -> bool:
        """Whether a treatment may put questions of its own to the reasoner: in delib mode, where the mind's settings say so."""

    @property
    def now_s(self) -> float:
        """Kernel time of the last recorded answer (at first: of the event's arrival), in seconds.

        Steps of work since then don't move it, so that a process which is rebuilt after a crash is told the same.
        """

    def work(self, steps: int = 1) -> Awaitable[None]:
        """Spend cognitive effort."""

    def evidence(self, topic: str, key: str, within_s: float, count: int = 1) -> Awaitable[tuple[Evidence, ...]]:
        """Wait for ``count`` pieces of evidence; fewer (perhaps none) when the limit passed."""

    def recall(self, query: Query) -> Awaitable[tuple[Episode, ...]]:
        """Search episodic memory."""

    def deliberate(self, question: Question) -> Awaitable[Reply]:
        """Ask the reasoner. Raises Refusal; in auto mode always."""

    def ask(self, role: str, question: Question, within_s: float) -> Awaitable[Reply | None]:
        """Ask a person; None when nobody answered in time."""

    def treat(self, name: str, event: Event) -> Awaitable[Result]:
        """Start another treatment as a child process and wait for its result."""

    def call(self, function: Callable[[], T | Awaitable[T]], key: str, within_s: float, safety: Safety = "read") -> Awaitable[T]:
        """Run a function outside the kernel; its JSON answer is recorded under ``key``. Raises Refusal."""

    def sleep_s(self, seconds: float) -> Awaitable[None]:
        """Wait for kernel time to pass."""

    def forecast(self) -> Forecast | None:
        """The prior's most probable label as a forecast; None where there is no prior."""


Treat = Callable[[Event, Mind], Awaitable[Result]]


class Treatment(Protocol):
    """One way of thinking. Made by ``@wakeful.treatment``; found through the entry-point group ``wakeful.treatments``."""

    name: str
    version: int
    says: str
    result: type[Result]

    async def treat(self, event: Event, mind: Mind) -> Result:
        """Think about one event. Deterministic between awaits; awaits only ``mind``."""
