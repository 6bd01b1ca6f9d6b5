"""Packs: what an automatic event writes in one go, as one entry of the journal that reads back as the lines it stands for.

A pack is a way of writing, not another word: every reader sees its lines, with positions of their own. Only the writer, the
journal's file and recovery see the pack (DESIGN section 4: one packed row per burst of steps of an automatic event).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import ClassVar, TypeAlias

import msgspec

from wakeful.facts.choices import Choice
from wakeful.facts.decisions import Mode
from wakeful.facts.events import Event
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience
from wakeful.facts.lines import (
    Admitted,
    Answered,
    AnyRecord,
    Asked,
    Concluded,
    Created,
    Decided,
    Gained,
    Judged,
    Line,
    Moved,
    Trusted,
    Witnessed,
)
from wakeful.facts.processes import State, Trigger
from wakeful.facts.results import Forecast
from wakeful.facts.values import Raw


class Burst(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, tag=str.lower, tag_field="is"):
    """Base of every burst: records that were written at the same instant, one after the other. ``count``: how many."""

    @property
    def count(self) -> int:
        """How many lines it stands for."""
        raise NotImplementedError

    def records(self) -> tuple[AnyRecord, ...]:
        """What it stands for, in order."""
        raise NotImplementedError


class Covered(Burst, frozen=True):
    """An event was admitted and has a root process with an automatic decision (Eq. 3 and 4)."""

    event: Event
    process: int
    choice: Choice
    deadline_ns: int | None = None

    count: ClassVar[int] = 3

    def records(self) -> tuple[AnyRecord, ...]:
        """Admitted, Created, Decided."""
        event = self.event
        return (
            Admitted(event=event),
            Created(
                process=self.process,
                event=event.id,
                treatment=self.choice.basis.treatment,
                criticality=event.criticality,
                deadline_ns=self.deadline_ns,
            ),
            Decided(process=self.process, event=event.id, decision=self.choice.decision()),
        )


class Inquired(Burst, frozen=True):
    """A process took a slot, worked, asked for something that is not there, and waits. ``steps``: its total, as in Moved."""

    before: State
    steps_before: int
    asked: Asked
    steps: int

    count: ClassVar[int] = 3

    def records(self) -> tuple[AnyRecord, ...]:
        """Moved to active, Asked, Moved to waiting."""
        return (
            _dispatched(self.asked.process, self.before, self.steps_before),
            self.asked,
            Moved(
                process=self.asked.process,
                before=State.ACTIVE,
                trigger=Trigger.ASK,
                after=State.WAITING,
                steps=self.steps,
            ),
        )


class Woken(Burst, frozen=True):
    """What a process waited for came, or its limit passed (``trigger`` expire): it can go on."""

    answered: Answered
    trigger: Trigger
    steps: int
    by: str

    count: ClassVar[int] = 2

    def records(self) -> tuple[AnyRecord, ...]:
        """Answered, Moved to suspended."""
        return (
            self.answered,
            Moved(
                process=self.answered.process,
                before=State.WAITING,
                trigger=self.trigger,
                after=State.SUSPENDED,
                steps=self.steps,
                by=self.by,
            ),
        )


class Ran(Burst, frozen=True):
    """A process took a slot, worked and concluded without giving the slot up. ``steps``: its total, as in Moved.

    The forecast is the result's own; it is recorded as one where ``closes_ns`` says until when.
    """

    process: int
    event: str
    before: State
    steps_before: int
    steps: int
    treatment: str
    mode: Mode
    result: Raw
    closes_ns: int | None = None

    count: ClassVar[int] = 3

    @property
    def forecast(self) -> Forecast | None:
        """The result's forecast, where it is one that the world is to judge."""
        return None if self.closes_ns is None else _OF_RESULT.decode(self.result).forecast

    def records(self) -> tuple[AnyRecord, ...]:
        """Moved to active, Concluded, Moved to completed."""
        return (
            _dispatched(self.process, self.before, self.steps_before),
            Concluded(
                process=self.process,
                event=self.event,
                treatment=self.treatment,
                mode=self.mode,
                result=self.result,
                forecast=self.forecast,
                closes_ns=self.closes_ns,
            ),
            Moved(
                process=self.process,
                before=State.ACTIVE,
                trigger=Trigger.RESOLVE,
                after=State.COMPLETED,
                steps=self.steps,
            ),
        )


class Validated(Burst, frozen=True):
    """An outcome arrived and decided one recorded result, which became an experience (Eq. 7 and 10); trust may have moved."""

    outcome: Outcome
    judged: Judged
    experience: Experience
    trusted: Trusted | None = None

    @property
    def count(self) -> int:
        """3, or 4 where trust moved."""
        return 3 if self.trusted is None else 4

    def records(self) -> tuple[AnyRecord, ...]:
        """Witnessed, Judged, Gained, and perhaps Trusted."""
        first = (Witnessed(outcome=self.outcome), self.judged, Gained(experience=self.experience))
        return first if self.trusted is None else (*first, self.trusted)


class _OfResult(msgspec.Struct):
    forecast: Forecast | None = None


_OF_RESULT = msgspec.json.Decoder(_OfResult)


def _dispatched(process: int, before: State, steps: int) -> Moved:
    return Moved(process=process, before=before, trigger=Trigger.DISPATCH, after=State.ACTIVE, steps=steps)


AnyBurst: TypeAlias = Covered | Inquired | Woken | Ran | Validated


class Pack(msgspec.Struct, frozen=True):
    """One burst in the journal: its lines have the positions ``position`` to ``last``, and all the same kernel time."""

    position: int
    at_ns: int
    burst: AnyBurst

    @property
    def last(self) -> int:
        """The position of its last line."""
        return self.position + self.burst.count - 1

    def lines(self) -> tuple[Line, ...]:
        """The lines that it stands for."""
        return tuple(Line(place, self.at_ns, record) for place, record in enumerate(self.burst.records(), self.position))


Entry: TypeAlias = Line | Pack
"""What is committed: a line, or a pack of lines."""


def expanded(entries: Iterable[Entry]) -> Iterator[Line]:
    """The lines that entries stand for, in order."""
    for entry in entries:
        if isinstance(entry, Line):
            yield entry
        else:
            yield from entry.lines()


def last_position(entry: Entry) -> int:
    """The position of an entry's last line."""
    return entry.position if isinstance(entry, Line) else entry.last
