"""Operators' acts on a journal that no mind is writing: recorded by the scheduler's own code, while nobody thinks."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NoReturn

import msgspec

from wakeful.contracts.journal import Journal
from wakeful.facts.asking import Episode, Query, Reply
from wakeful.facts.decisions import Decision
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Event
from wakeful.facts.inputs import Act, Call
from wakeful.facts.lines import Acted, Admitted, AnyRecord, Created, Decided, Line, Noted, Reopened
from wakeful.facts.packs import AnyBurst, Ran
from wakeful.facts.results import Forecast
from wakeful.facts.settings import MindSettings
from wakeful.scheduling import Scheduler, SuspendResume
from wakeful.scheduling.evidence import EvidenceShelf


class _Nothing:
    """Nothing is treated at rest."""

    def get(self, name: str) -> NoReturn:
        """Nothing is treated."""
        raise LookupError(f"treatment {name} was wanted from a mind at rest")


class _AtRest:
    """The scheduler's host where no time passes, nothing is called and nothing is thought."""

    def __init__(self, journal: Journal) -> None:
        self.settings = MindSettings()
        self.now_ns = 0
        self.lines: list[Line] = []
        self._events: dict[str, Event] = {}
        self._decided: dict[int, Decision] = {}
        self._position = journal.last
        spec = DomainSpec(name="", version=0, says="")
        self.scheduler = Scheduler(self, SuspendResume(), _Nothing(), spec, (), EvidenceShelf({}, 0))
        for line in journal.lines():
            self.now_ns = line.at_ns
            self._apply(line.record)

    def write(self, record: AnyRecord) -> None:
        """Record, and apply to the process set."""
        self._position += 1
        self.lines.append(Line(self._position, self.now_ns, record))
        self._apply(record)

    def _apply(self, record: AnyRecord) -> None:
        if isinstance(record, Admitted):
            self._events[record.event.id] = record.event
        elif isinstance(record, Decided):
            self._decided[record.process] = record.decision
        self.scheduler.processes.apply(record, self.now_ns)

    def bring_back(self, process: int) -> NoReturn:
        """Nobody is parked."""
        raise LookupError(f"process {process} was wanted from a mind at rest")

    @property
    def steps_left(self) -> int | None:
        """None: nobody takes a step."""
        return 0

    def spent(self, steps: int) -> None:
        """No step is done at rest."""

    def stir(self, at_ns: int) -> None:
        """Nothing falls due at rest."""

    def resolved(self, burst: Ran, forecast: Forecast | None) -> None:  # noqa: ARG002
        """Nothing is resolved at rest, but a host must be able to."""
        self.pack(burst)

    def pack(self, burst: AnyBurst) -> None:
        """One by one: nothing here is in a hurry."""
        for record in burst.records():
            self.write(record)

    def event(self, identity: str) -> Event:
        """An admitted event."""
        return self._events[identity]

    def note(self, what: str, detail: str, process: int = 0, event: str = "") -> None:
        """Record something that a person should know."""
        self.write(Noted(what=what, detail=detail, process=process, event=event))

    def call(self, call: Call) -> None:
        """Calls that are under way are made again when the mind starts, as after any crash."""

    def concluded(self, process: int) -> None:
        """Nothing concludes at rest."""

    def closed_to(self, act: Act) -> str:
        """Why a completed process cannot be reopened; empty where it can."""
        return "" if act.event in self._events and act.process in self._decided else f"there is no event {act.event!r}"

    def reopen(self, act: Act) -> None:
        """The event gets a new process, to be deliberated: a mind at rest decides nothing anew."""
        because = f"{act.who}: {act.why}"
        before = self._decided[act.process]
        decision = msgspec.structs.replace(before, mode="delib", reasons=(because, *before.reasons))
        process = self.scheduler.processes.next_id
        self.write(Reopened(process=process, reopens=act.process, event=act.event, because=because))
        event = self._events[act.event]
        self.write(
            Created(
                process=process,
                event=event.id,
                treatment=decision.treatment,
                criticality=event.criticality,
                reopens=act.process,
            )
        )
        self.write(Decided(process=process, event=event.id, decision=decision))

    def recall(self, query: Query) -> tuple[Episode, ...]:  # noqa: ARG002
        """Nothing is recalled."""
        return ()

    def closes_ns(self, arrived_ns: int) -> int:
        """At once: no window is waited for."""
        return arrived_ns

    def counselled(self, decision: Decision, reply: Reply) -> dict[str, float]:  # noqa: ARG002
        """The decision's own forecast."""
        return decision.prior


def act_at_rest(journal: Journal, acts: Iterable[Act]) -> list[tuple[int, Acted]]:
    """Record operators' acts, and what they do, in one commit; nobody else moves until a mind takes the journal up again.

    Needs neither the mind's domain nor its treatments, and runs none of them.

    Args:
        journal: open for writing.
        acts: in their order; one whose id is in the journal already does nothing.

    Returns:
        the position and record of each act that was taken up; ``refused`` says why one changed nothing.

    Raises:
        JournalError: it could not be written; nothing was.
    """
    host = _AtRest(journal)
    for act in acts:
        host.scheduler.take(act)
    if host.lines:
        journal.commit(host.lines, {}, {})
    return [(line.position, line.record) for line in host.lines if isinstance(line.record, Acted)]
