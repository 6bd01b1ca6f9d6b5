"""The mind that a treatment awaits, as the kernel serves it (contracts/treatment.py)."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import lru_cache
from typing import TypeVar, cast

from wakeful.contracts.treatment import Refusal
from wakeful.facts.asking import Episode, Kind, Query, Question, Reply, Safety
from wakeful.facts.choices import Choice
from wakeful.facts.decisions import Decision, Mode
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Event
from wakeful.facts.evidence import Evidence
from wakeful.facts.results import Forecast, Result
from wakeful.facts.time import to_s
from wakeful.scheduling.wants import Want, Work, give, nothing

T = TypeVar("T")

#: How long a reasoner may take before the process goes on without it.
DELIBERATION_LIMIT_S = 60.0

#: How long a child process may take before its parent goes on without it.
CHILD_LIMIT_S = 600.0


class KernelMind:
    """One process's mind. Reading it costs nothing; each await is a preemption point.

    Args:
        mode: how this attempt is executed.
        decision: the decision with which this attempt began, or the choice that stands for it.
        domain: the domain's data.
        heard_ns: kernel time in nanoseconds of the last recorded answer, at first of the event's arrival.
        consults: whether treatments may put questions of their own to the reasoner.
    """

    __slots__ = ("_advice", "_consults", "_decision", "_domain", "_mode", "current", "heard_ns")

    def __init__(
        self,
        mode: Mode,
        decision: Decision | Choice,
        domain: DomainSpec,
        heard_ns: int,
        consults: bool = False,
    ) -> None:
        self._mode = mode
        self._decision = decision
        self.current: Decision | None = None
        """The decision in force, where deliberation has revised the first one."""
        self._domain = domain
        self.heard_ns = heard_ns
        self._consults = consults
        self._advice: Reply | None = None

    @property
    def mode(self) -> Mode:
        """How this process is executed."""
        return self._mode

    @property
    def decision(self) -> Decision:
        """The decision that started this attempt."""
        if isinstance(self._decision, Choice):
            self._decision = self._decision.decision()
        return self._decision

    @property
    def treatment(self) -> str:
        """The treatment that was chosen when this attempt began."""
        first = self._decision
        return first.basis.treatment if isinstance(first, Choice) else first.treatment

    @property
    def domain(self) -> DomainSpec:
        """The domain's data."""
        return self._domain

    @property
    def advice(self) -> Reply | None:
        """What deliberation said when the treatment was chosen."""
        return self._advice

    @property
    def consults(self) -> bool:
        """Whether a treatment may put questions of its own to the reasoner."""
        return self._consults and self._mode == "delib"

    def advise(self, reply: Reply) -> None:
        """Take the reasoner's answer as advice."""
        self._advice = reply

    @property
    def prior(self) -> dict[str, float]:
        """Probabilities over the domain's outcome labels to start from; after deliberation, with the reasoner's in them."""
        if self.current is not None:
            return self.current.prior
        first = self._decision
        return dict(zip(first.basis.labels, first.prior, strict=True)) if isinstance(first, Choice) else first.prior

    @property
    def now_s(self) -> float:
        """Kernel time of the last recorded answer, at first of the event's arrival, in seconds."""
        return to_s(self.heard_ns)

    def forecast(self) -> Forecast | None:
        """The prior's most probable label; ties go to the label that the domain names first."""
        first = self._decision
        if self.current is None and first.__class__ is Choice:
            shares = first.prior
            highest = max(shares)
            if shares.count(highest) == 1:
                labels = first.basis.labels
                return Forecast(
                    label=labels[shares.index(highest)],
                    probability=highest,
                    probabilities={name: shares[place] for name, place in _sorted(labels)},
                    topic=self._domain.outcome.topic,
                )
        prior = self.prior
        if not prior:
            return None
        order = {label: place for place, label in enumerate(self._domain.outcome.labels)}
        label = min(prior, key=lambda name: (-round(prior[name], 9), order.get(name, len(order))))
        return Forecast(
            label=label,
            probability=round(prior[label], 6),
            probabilities={name: round(prior[name], 6) for name in sorted(prior)},
            topic=self._domain.outcome.topic,
        )

    def work(self, steps: int = 1) -> Awaitable[None]:
        """Spend cognitive effort, in steps; none for ``steps`` < 1."""
        return give(Work(steps)) if steps > 0 else nothing()  # type: ignore[return-value]  # the answer to work is None

    def evidence(self, topic: str, key: str, within_s: float, count: int = 1) -> Awaitable[tuple[Evidence, ...]]:
        """Wait for ``count`` pieces of evidence; fewer when the limit passed."""
        want = Want(kind=Kind.EVIDENCE, key=f"{topic}\x1f{key}", within_s=within_s, count=count)
        return give(want)  # type: ignore[return-value]  # whoever drives it answers with what was wanted

    async def recall(self, query: Query) -> tuple[Episode, ...]:
        """Search episodic memory."""
        return cast("tuple[Episode, ...]", await give(Want(kind=Kind.RECALL, key="episodes", within_s=None, query=query)))

    async def deliberate(self, question: Question) -> Reply:
        """Ask the reasoner. Raises Refusal; in auto and fallback mode always."""
        if self._mode != "delib":
            raise Refusal(f"a process in {self._mode} mode does not deliberate")
        want = Want(kind=Kind.DELIBERATE, key=question.about, within_s=DELIBERATION_LIMIT_S, question=question)
        return cast("Reply", await give(want))

    async def ask(self, role: str, question: Question, within_s: float) -> Reply | None:
        """Ask a person; None when nobody answered in time."""
        want = Want(kind=Kind.ASK, key=f"{role}\x1f{question.about}", within_s=within_s, question=question, role=role)
        return cast("Reply | None", await give(want))

    async def treat(self, name: str, event: Event) -> Result:
        """Start another treatment as a child process and wait for its result."""
        return cast("Result", await give(Want(kind=Kind.TREAT, key=name, within_s=CHILD_LIMIT_S, event=event)))

    async def call(self, function: Callable[[], T | Awaitable[T]], key: str, within_s: float, safety: Safety = "read") -> T:
        """Run a function outside the kernel; its JSON answer is recorded under ``key``. Raises Refusal."""
        want = Want(kind=Kind.CALL, key=key, within_s=within_s, safety=safety, function=function)
        return cast("T", await give(want))

    async def sleep_s(self, seconds: float) -> None:
        """Wait for kernel time to pass."""
        await give(Want(kind=Kind.SLEEP, key="", within_s=max(0.0, seconds)))


@lru_cache(maxsize=64)
def _sorted(labels: tuple[str, ...]) -> tuple[tuple[str, int], ...]:
    """The labels by name, each with its place."""
    return tuple(sorted((name, place) for place, name in enumerate(labels)))
