"""What the read side needs of a journal: its lines in order, and what each is about."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import msgspec

from wakeful.facts.lines import (
    Acted,
    Admitted,
    Answered,
    AnyRecord,
    Asked,
    Concluded,
    Created,
    Decided,
    Duplicate,
    Gained,
    Judged,
    Line,
    Moved,
    Noted,
    Refused,
    Reopened,
)


class View(msgspec.Struct, frozen=True, kw_only=True):
    """Base of what the read side tells. Unlike a recorded fact it leaves out no field: a program that reads it finds each one."""


class Readable(Protocol):
    """Anything that has lines: every Journal, and a list of lines in a test."""

    def lines(self, after: int = 0) -> Iterator[Line]:
        """The lines with position > ``after``, in order."""


def tag_of(record: AnyRecord) -> str:
    """The word that the record carries in its ``is`` field."""
    return type(record).__name__.lower()


def event_of(record: AnyRecord) -> str:
    """The id of the event that a record is about; empty where it is about none."""
    match record:
        case Admitted(event=event):
            return event.id
        case Duplicate() | Refused() | Created() | Decided() | Concluded() | Judged() | Reopened() | Noted():
            return record.event
        case Gained(experience=experience):
            return experience.event
        case _:
            return ""


def process_of(record: AnyRecord) -> int:
    """The id of the process that a record is about; 0 where it is about none."""
    match record:
        case Created() | Decided() | Moved() | Asked() | Answered() | Concluded() | Judged() | Reopened() | Acted() | Noted():
            return record.process
        case Gained(experience=experience):
            return experience.process
        case _:
            return 0
