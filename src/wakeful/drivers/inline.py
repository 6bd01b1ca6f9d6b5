"""A mind inside the user's own synchronous program: it thinks when it is called, and is durable when the call returns."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from uuid import uuid4

import msgspec

from wakeful.contracts.domain import Domain
from wakeful.contracts.journal import Journal
from wakeful.contracts.reasoner import Reasoner
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.drivers.assembly import assemble
from wakeful.drivers.live import LiveDriver, Receipt
from wakeful.drivers.poison import CrashMark
from wakeful.drivers.sd_notify import Heart
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.drivers.stalled import StallMark
from wakeful.facts.events import Context, Criticality, Draft
from wakeful.facts.evidence import Evidence, Outcome
from wakeful.facts.inputs import Input, Mark
from wakeful.facts.lines import Admitted, Concluded, Decided, Duplicate, Line, Refused
from wakeful.facts.results import Result
from wakeful.facts.settings import MindSettings
from wakeful.facts.values import Field
from wakeful.journal import MemoryJournal, open_journal
from wakeful.journal.acts import ActSpool
from wakeful.treatments.registry import Registry

if TYPE_CHECKING:
    from types import TracebackType

_SOURCE = "program"

#: Calls of the reasoner that a live mind has under way at once, unless told otherwise.
REASONER_SLOTS = 4


class Mind:
    """One mind, driven by its caller's calls. Use as ``with``; for asyncio see ``open_live``.

    Args:
        domain: by name, by path of its TOML, or itself.
        journal: the file to keep; None keeps everything in memory only.
        reasoner: answers what is deliberated; the domain's written guidelines where None.
        registry: the treatments; wakeful's own and installed ones where None.
        seed: of everything that is drawn.
        clock_ns: the time of an event that is admitted without its own.

    Raises:
        DomainError: there is no such domain. JournalError: the file cannot be used.
    """

    def __init__(
        self,
        domain: str | Domain = "jsonl",
        journal: str | Path | None = None,
        *,
        reasoner: Reasoner | None = None,
        registry: Registry | None = None,
        seed: int = 0,
        clock_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        kernel, learner = assemble(domain, MindSettings(step_s=0.0, seed=seed), registry=registry)
        self.journal: Journal = MemoryJournal() if journal is None else open_journal(Path(journal))
        thinks = reasoner if reasoner is not None else GuidelineReasoner(kernel.domain.spec)
        acts = None if journal is None else ActSpool(Path(journal))
        mark = None if journal is None else CrashMark(Path(journal))
        self._driver = SimulatedDriver(kernel, self.journal, thinks, learner, acts=acts, crash_mark=mark)
        self._clock_ns = clock_ns
        self._position = self._driver.begin(_SOURCE, uuid4().hex)
        self._concluded: dict[str, Concluded] = {}
        self._decided: dict[str, Decided] = {}

    def __enter__(self) -> Mind:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def admit(
        self,
        kind: str,
        entity: str,
        fields: Mapping[str, Field] | None = None,
        *,
        context: Context | None = None,
        criticality: Criticality = 0,
        deadline_s: float | None = None,
        at_ns: int | None = None,
    ) -> Receipt:
        """Offer an event. When this returns it is durable and has been treated as far as it can be for now."""
        return self.offer(
            Draft(
                kind=kind,
                entity=entity,
                source=_SOURCE,
                position=0,
                at_ns=at_ns if at_ns is not None else self._clock_ns(),
                fields=dict(fields or {}),
                context=context if context is not None else Context(),
                criticality=criticality,
                deadline_s=deadline_s,
            )
        )

    def offer(self, draft: Draft) -> Receipt:
        """The same for a whole draft; its source and position are the mind's own."""
        self._position += 1
        placed = msgspec.structs.replace(draft, source=_SOURCE, position=self._position)
        mark = Mark(source=_SOURCE, position=self._position)
        lines = self._driver.put([placed, mark], draft.at_ns)
        self._remember(lines)
        for line in lines:
            record = line.record
            if isinstance(record, Admitted):
                return Receipt("admitted", record.event.id)
            if isinstance(record, Duplicate):
                return Receipt("duplicate", record.event)
            if isinstance(record, Refused):
                return Receipt("refused", "", record.reason)
        return Receipt("taken")

    def offer_many(self, drafts: Sequence[Draft]) -> list[Receipt]:
        """The same for many at once, at the instant of the last: what each costs is a fraction of what it costs alone."""
        inputs: list[Input] = []
        first = self._position + 1
        for draft in drafts:
            self._position += 1
            inputs.append(msgspec.structs.replace(draft, source=_SOURCE, position=self._position))
            inputs.append(Mark(source=_SOURCE, position=self._position))
        if not inputs:
            return []
        lines = self._driver.put(inputs, max(draft.at_ns for draft in drafts))
        self._remember(lines)
        receipts = [Receipt("taken")] * len(drafts)
        for line in lines:
            record = line.record
            if isinstance(record, Admitted) and record.event.source == _SOURCE:
                receipts[record.event.position - first] = Receipt("admitted", record.event.id)
            elif isinstance(record, Duplicate):
                receipts[record.position - first] = Receipt("duplicate", record.event)
            elif isinstance(record, Refused):
                receipts[record.position - first] = Receipt("refused", "", record.reason)
        return receipts

    def tell(self, later: Evidence | Outcome) -> None:
        """Hand over evidence or an outcome; what waited for it goes on before this returns."""
        self._remember(self._driver.put([later], later.at_ns))

    def outcome(self, event: str, label: str, at_ns: int | None = None) -> None:
        """Tell what the world showed of an event, in one of the domain's outcome labels."""
        spec = self._driver.kernel.domain.spec
        if label not in spec.outcome.labels:
            raise ValueError(f"{label!r} is no outcome of domain {spec.name}; use one of {', '.join(spec.outcome.labels)}")
        when_ns = at_ns if at_ns is not None else self._clock_ns()
        self.tell(
            Outcome(
                id=f"{event}:{label}:{when_ns}",
                topic=spec.outcome.topic,
                entity="*",
                label=label,
                at_ns=when_ns,
                event=event,
                origin="person",
            )
        )

    def decision(self, event: str) -> Decided | None:
        """The decision in force for an event of this run."""
        return self._decided.get(event)

    def conclusion(self, event: str) -> Concluded | None:
        """What was concluded of an event of this run; None while its process is open."""
        return self._concluded.get(event)

    def result(self, event: str) -> Result | None:
        """What was concluded of an event of this run, in its treatment's own type; None while its process is open."""
        concluded = self._concluded.get(event)
        return None if concluded is None else self._driver.kernel.result(concluded)

    def close(self) -> None:
        """Commit and let go of everything. What waits goes on in the next mind on the same journal."""
        self._driver.close()
        self.journal.close()

    def _remember(self, lines: tuple[Line, ...]) -> None:
        for line in lines:
            if isinstance(line.record, Concluded):
                self._concluded[line.record.event] = line.record
            elif isinstance(line.record, Decided):
                self._decided[line.record.event] = line.record


def open_live(
    domain: str | Domain = "jsonl",
    journal: str | Path | None = None,
    *,
    reasoner: Reasoner | None = None,
    registry: Registry | None = None,
    seed: int = 0,
    slots: int = 1,
    reasoner_slots: int = REASONER_SLOTS,
) -> LiveDriver:
    """A mind that runs by itself on asyncio: ``async with wakeful.open_live("service_robot", "mind.db") as mind``.

    The arguments are those of Mind, and:

    Args:
        slots: processes that may think at once, by turns between their awaits.
        reasoner_slots: calls of the reasoner that may be under way at once; the others queue, criticals first. 0: no limit.
    """
    settings = MindSettings(step_s=0.0, seed=seed, slots=slots, reasoner_slots=reasoner_slots)
    kernel, learner = assemble(domain, settings, registry=registry)
    kept: Journal = MemoryJournal() if journal is None else open_journal(Path(journal))
    thinks = reasoner if reasoner is not None else GuidelineReasoner(kernel.domain.spec)
    acts = None if journal is None else ActSpool(Path(journal))
    try:
        mark = None if journal is None else CrashMark(Path(journal))
        stall_mark = None if journal is None else StallMark(Path(journal))
    except BaseException:
        kept.close()  # the journal stays nobody's
        raise
    return LiveDriver(
        kernel,
        kept,
        thinks,
        learner,
        acts=acts,
        closes_journal=True,
        crash_mark=mark,
        heart=Heart.from_environment(),
        stall_mark=stall_mark,
    )
