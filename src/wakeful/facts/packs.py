"""Packs: what one automatic event writes in one go, as one entry of the journal that reads back as the lines it stands for.

A pack is a way of writing, not another word: every reader sees its lines, with positions of their own. Only the writer, the
journal's file and recovery see the pack (DESIGN section 4: one packed row per burst of steps of an automatic event).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TypeAlias

import msgspec

from wakeful.facts.decisions import Decision
from wakeful.facts.events import Event
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience
from wakeful.facts.lines import Admitted, AnyRecord, Concluded, Created, Decided, Gained, Judged, Line, Moved, Witnessed
from wakeful.facts.processes import State, Trigger
from wakeful.facts.results import Forecast
from wakeful.facts.values import Raw


class Burst(msgspec.Struct, frozen=True, kw_only=True, tag=str.lower, tag_field="is"):
    """Base of every burst: records that were written at the same instant, one after the other."""


class Covered(Burst, frozen=True):
    """An event was admitted and has a root process with its decision (Eq. 3 and 4)."""

    event: Event
    process: int
    decision: Decision
    deadline_ns: int | None = None

    def records(self) -> tuple[AnyRecord, ...]:
        """Admitted, Created, Decided."""
        event, decision = self.event, self.decision
        return (
            Admitted(event=event),
            Created(
                process=self.process,
                event=event.id,
                treatment=decision.treatment,
                criticality=event.criticality,
                deadline_ns=self.deadline_ns,
            ),
            Decided(process=self.process, event=event.id, decision=decision),
        )


class Ran(Burst, frozen=True):
    """A process took a slot, worked and concluded without giving the slot up. ``steps``: its total, as in Moved."""

    process: int
    event: str
    before: State
    steps_before: int
    steps: int
    treatment: str
    mode: str
    result: Raw
    forecast: Forecast | None = None
    closes_ns: int | None = None

    def records(self) -> tuple[AnyRecord, ...]:
        """Moved to active, Concluded, Moved to completed."""
        return (
            Moved(
                process=self.process,
                before=self.before,
                trigger=Trigger.DISPATCH,
                after=State.ACTIVE,
                steps=self.steps_before,
            ),
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
    """An outcome arrived and decided one recorded result, which became an experience (Eq. 7 and 10)."""

    outcome: Outcome
    judged: Judged
    experience: Experience

    def records(self) -> tuple[AnyRecord, ...]:
        """Witnessed, Judged, Gained."""
        return (Witnessed(outcome=self.outcome), self.judged, Gained(experience=self.experience))


AnyBurst: TypeAlias = Covered | Ran | Validated

LINES_PER_BURST = 3


class Pack(msgspec.Struct, frozen=True):
    """One burst in the journal: its lines have the positions ``position`` to ``last``, and all the same kernel time."""

    position: int
    at_ns: int
    burst: AnyBurst

    @property
    def last(self) -> int:
        """The position of its last line."""
        return self.position + LINES_PER_BURST - 1

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
