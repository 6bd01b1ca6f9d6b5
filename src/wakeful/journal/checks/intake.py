"""Intake: everything that was received became exactly one of admitted, duplicate, refused, and what was admitted is covered."""

from __future__ import annotations

from wakeful.facts.lines import Admitted, Compacted, Created, Decided, Duplicate, Line, Moved, Refused
from wakeful.facts.processes import Trigger
from wakeful.journal.checks.check import Check


class Conservation(Check):
    """received = admitted + duplicate + refused at each position, recounted from the identities and not from the totals.

    What was received is one admission a new identity, one duplicate each time a known identity came again, and one
    refusal with its reason for what was neither. A line that counts twice, or under the wrong head, breaks the sum.
    """

    name = "conservation"
    says = "received = admitted + duplicate + refused at every position"

    def __init__(self) -> None:
        super().__init__()
        self._known: set[str] = set()
        self._given_up = 0

    def see(self, line: Line) -> None:
        """Each intake line under its right head."""
        record = line.record
        match record:
            case Admitted(event=event):
                self.checked += 1
                if event.id in self._known:
                    self.offend(line, f"event {event.id} was admitted before: this is a duplicate, counted as admitted")
                self._known.add(event.id)
            case Compacted():
                self.checked += record.admitted + record.duplicate + record.refused
                self._given_up += record.admitted
            case Duplicate():
                self.checked += 1
                # It may be of an event that was given up: then nothing is known of it any more.
                if record.event not in self._known and not self._given_up:
                    self.offend(line, f"a duplicate of event {record.event}, which was never admitted")
            case Refused():
                self.checked += 1
                if not record.reason:
                    self.offend(line, f"position {record.position} of {record.source} was refused without a reason")
                elif record.event and record.event in self._known:
                    self.offend(line, f"event {record.event} was refused, but it is admitted")
            case _:
                pass


class Coverage(Check):
    """Coverage (Eq. 3) is 100 % at every position: an admitted event has its process and decision before time goes on."""

    name = "coverage"
    says = "every admitted event has a process and a decision before anything else is admitted or time goes on"

    def __init__(self) -> None:
        super().__init__()
        self._bare: dict[str, Line] = {}
        self._undecided: dict[int, tuple[str, Line]] = {}

    def see(self, line: Line) -> None:
        """An admission opens the debt; its process's decision settles it; the next admission finds it settled."""
        record = line.record
        match record:
            case Admitted(event=event):
                self._call_in()
                self.checked += 1
                self._bare[event.id] = line
            case Created():
                admitted = self._bare.pop(record.event, None)
                if admitted is not None:
                    self._undecided[record.process] = (record.event, admitted)
            case Decided():
                self._undecided.pop(record.process, None)
            case _:
                pass

    def settle(self) -> None:
        """Time goes on: nothing may be uncovered."""
        self._call_in()

    def _call_in(self) -> None:
        for event, admitted in self._bare.items():
            self.offend(admitted, f"event {event} was admitted at position {admitted.position} and has no process")
        for process, (event, admitted) in self._undecided.items():
            self.offend(admitted, f"event {event} was admitted, but its process {process} has no decision")
        self._bare.clear()
        self._undecided.clear()


class Abandoned(Check):
    """No process was dropped on purpose. Only experiments allow it, and what it drops is uncovered."""

    name = "abandoned"
    says = "no process was abandoned: what is dropped on purpose is uncovered"

    def see(self, line: Line) -> None:
        """Each end of a process was not an abandonment."""
        record = line.record
        if isinstance(record, Moved):
            self.checked += 1
            if record.trigger is Trigger.ABANDON:
                self.offend(line, f"process {record.process} was abandoned: its event is uncovered")
