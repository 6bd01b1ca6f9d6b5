"""Coverage at every position of a journal at which it may end: at the end of each commit (Eq. 3)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import msgspec

from wakeful.facts.asking import Kind
from wakeful.facts.lines import Admitted, Answered, Asked, Created, Decided, Line, Moved
from wakeful.facts.processes import State


class _Process(msgspec.Struct):
    event: str
    parent: int
    state: State = State.CREATED
    decided: bool = False
    pending: Asked | None = None


def uncovered(lines: Iterable[Line], commits: Sequence[int]) -> list[str]:
    """What is wrong at the end of some commit: an event without a process, a process that nothing will wake.

    Written without the product's audit, so that the two check one another.

    Args:
        lines: the journal's, in order.
        commits: the last position of each commit.

    Returns:
        one sentence for each violation; none where every admitted event is covered at every commit.
    """
    ends = set(commits)
    open_: dict[int, _Process] = {}
    bare: dict[str, int] = {}
    wrong: list[str] = []
    for line in lines:
        record = line.record
        match record:
            case Admitted(event=event):
                bare[event.id] = line.position
            case Created():
                open_[record.process] = _Process(record.event, record.parent)
            case Decided():
                open_[record.process].decided = True
                bare.pop(record.event, None)
            case Asked():
                open_[record.process].pending = record
            case Answered():
                open_[record.process].pending = None
            case Moved():
                process = open_[record.process]
                process.state = record.after
                if record.after is State.COMPLETED:
                    del open_[record.process]
            case _:
                pass
        if line.position in ends:
            wrong += [f"at {line.position}: event {event} has no process" for event in bare]
            wrong += [f"at {line.position}: {said}" for said in _asleep(open_, line.at_ns)]
    return wrong


def _asleep(open_: dict[int, _Process], now_ns: int) -> list[str]:
    wrong = []
    parents = {each.parent for each in open_.values()}
    for number, process in open_.items():
        if not process.decided:
            wrong.append(f"process {number} has no decision")
        elif process.state is State.WAITING:
            pending = process.pending
            if pending is None:
                wrong.append(f"process {number} waits for nothing")
            elif (pending.expires_ns is None or pending.expires_ns < now_ns) and not (
                pending.kind is Kind.TREAT and number in parents
            ):
                wrong.append(f"process {number} waits for {pending.kind} {pending.key!r} without a limit to come")
    return wrong
