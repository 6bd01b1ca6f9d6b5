"""What a reasoner has cost, as a journal tells it: so that a budget holds over restarts and crashes, to the call."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from wakeful.contracts.journal import JournalError
from wakeful.deliberation.budget import Spent
from wakeful.facts.asking import Kind, Reply
from wakeful.facts.lines import RESUMPTION, Answered, Asked, Line, Moved, Noted
from wakeful.facts.processes import State, Trigger
from wakeful.scheduling.driving import EXPIRED

#: The records that ``spent`` looks at.
KINDS = ("asked", "answered", "moved", "noted")


def spent(lines: Iterable[Line], reasoner: str, reasoner_slots: int = 0) -> Spent:
    """What was spent on a reasoner, and how many of its answers nobody has heard to their end.

    A call is intended when its request is recorded. One whose answer is not recorded may have been made, and paid: it is in doubt
    where a mind ended meanwhile (each recovery notes those that it makes again), where its limit passed, and where its process
    was cancelled or became moot.

    Args:
        lines: of the journal, those of ``KINDS`` at least, before the next mind takes it up.
        reasoner: its name; an answer that failed does not say whose it was, and is charged to whoever is asked now.
        reasoner_slots: how many calls the last mind had under way at most; 0: all that were asked.

    Raises:
        JournalError: an answer in it is none.
    """
    calls, usd, in_doubt = 0, 0.0, 0
    waiting: dict[int, Asked] = {}
    for line in lines:
        record = line.record
        match record:
            case Asked(kind=Kind.DELIBERATE):
                waiting[record.process] = record
            case Answered(kind=Kind.DELIBERATE):
                waiting.pop(record.process, None)
                if record.error == EXPIRED:
                    in_doubt += bool(record.calls)
                elif _was_asked(reasoner, record):
                    calls += record.calls
                    usd += record.cost_usd
            case Moved() if record.after is State.COMPLETED or record.trigger is Trigger.RESTART:
                in_doubt += waiting.pop(record.process, None) is not None
            case Noted(what=what, process=process):
                in_doubt += what == RESUMPTION and process != 0
            case _:
                pass
    under_way = min(len(waiting), reasoner_slots) if reasoner_slots else len(waiting)
    return Spent(calls, usd, in_doubt + under_way)


def _was_asked(name: str, answer: Answered) -> bool:
    """Whether that reasoner was paid for the answer."""
    if answer.error:
        return True
    if not answer.calls:
        return False
    try:
        return msgspec.json.decode(answer.value, type=Reply).reasoner.startswith(name)
    except msgspec.DecodeError as error:
        raise JournalError(
            f"request {answer.seq} of process {answer.process} has an answer that is none ({error}): the journal is damaged; "
            "restore it from a backup, or begin a new one with --journal"
        ) from error
