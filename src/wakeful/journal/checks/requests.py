"""Requests and answers: each answer under its own request, and nothing that was answered is done again."""

from __future__ import annotations

from collections import deque
from typing import TypeAlias

from wakeful.facts.asking import Kind
from wakeful.facts.lines import Answered, Asked, Created, Line, Moved
from wakeful.facts.processes import Trigger
from wakeful.journal.checks.check import Check

_OUTSIDE = (Kind.DELIBERATE, Kind.ASK, Kind.CALL)


class Answers(Check):
    """Every answer stands under its own request: same process, sequence number, kind and key."""

    name = "answers"
    says = "every answer stands under its own request: process, sequence number, kind and key"

    def __init__(self) -> None:
        super().__init__()
        self._asked: dict[tuple[int, int], Asked] = {}
        self._created: set[int] = set()

    def see(self, line: Line) -> None:
        """Find each answer's request."""
        record = line.record
        match record:
            case Created():
                self._created.add(record.process)
            case Asked():
                if record.process not in self._created:
                    self.offend(line, f"process {record.process} asks, but was never created")
                self._asked[record.process, record.seq] = record
            case Answered():
                self.checked += 1
                asked = self._asked.get((record.process, record.seq))
                if asked is None:
                    self.offend(line, f"process {record.process} never asked request {record.seq}")
                elif (asked.kind, asked.key) != (record.kind, record.key):
                    self.offend(
                        line,
                        f"process {record.process} request {record.seq} asked {asked.kind} {asked.key!r}, "
                        f"and was answered {record.kind} {record.key!r}",
                    )
            case _:
                pass


class Repeats(Check):
    """No answered request is asked again or answered twice.

    A process that was restarted, because its code had changed, asks anew: an outside call that its earlier run had been
    answered takes that answer again, by the hash of its arguments. Another answer means that the call was run again.
    """

    name = "repeats"
    says = "no answered request is asked or answered again, also after a restart"

    def __init__(self) -> None:
        super().__init__()
        self._asked: dict[tuple[int, int], Asked] = {}
        self._answered: dict[tuple[int, int], Answered] = {}
        self._earlier: dict[_Content, deque[bytes]] = {}

    def see(self, line: Line) -> None:
        """Each request is answered at most once."""
        record = line.record
        match record:
            case Asked():
                if (record.process, record.seq) in self._answered:
                    self.offend(line, f"process {record.process} asks request {record.seq} again, which was answered")
                self._asked[record.process, record.seq] = record
            case Answered():
                self.checked += 1
                self._answer(line, record)
            case Moved(trigger=Trigger.RESTART):
                self._restart(record.process)
            case _:
                pass

    def _answer(self, line: Line, record: Answered) -> None:
        if (record.process, record.seq) in self._answered:
            self.offend(line, f"process {record.process} request {record.seq} was answered before")
        self._answered[record.process, record.seq] = record
        asked = self._asked.get((record.process, record.seq))
        earlier = self._earlier.get(_content(asked)) if asked else None
        if earlier and earlier.popleft() != bytes(record.value):
            self.offend(line, f"process {record.process} ran {record.kind} {record.key!r} again, answered before its restart")

    def _restart(self, process: int) -> None:
        self._earlier = {content: answers for content, answers in self._earlier.items() if content[0] != process}
        for (owner, seq), answered in self._answered.items():
            asked = self._asked.get((owner, seq))
            if owner == process and asked and asked.kind in _OUTSIDE and not answered.error:
                self._earlier.setdefault(_content(asked), deque()).append(bytes(answered.value))


_Content: TypeAlias = tuple[int, Kind, str, str]


def _content(asked: Asked) -> _Content:
    return asked.process, asked.kind, asked.key, asked.args
