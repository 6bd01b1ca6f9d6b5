"""Overload as a journal tells it: what waits to be treated and for how long, what was shed, what was refused."""

from __future__ import annotations

from wakeful.facts.events import CRITICAL
from wakeful.facts.overload import REFUSED, SHED
from wakeful.facts.processes import State
from wakeful.facts.time import to_s
from wakeful.journal.history import History, ProcessPast
from wakeful.journal.readable import View


class Backlog(View, frozen=True):
    """The backlog at the journal's last line, and its worst over all of it. Ages are of kernel time, in seconds.

    ``not_begun`` processes have not had their first treatment, the oldest for ``oldest_s``; the longest that any event waited
    for its own was ``worst_s``, any critical one ``worst_critical_s``. ``most`` stood at once at the worst instant. ``shed``
    events were treated provisionally where deliberation would have been due; ``refused`` by reason.
    """

    not_begun: int
    oldest_s: float
    most: int
    worst_s: float
    worst_critical_s: float
    shed: int
    refused: dict[str, int]


def backlog(read: History) -> Backlog:
    """The backlog of a journal. O(processes · log)."""
    processes = list(read.processes.values())
    waiting = [process for process in processes if process.state is State.CREATED and not process.held_by]
    waits = [(process, _waited_s(read, process)) for process in processes]
    return Backlog(
        not_begun=len(waiting),
        oldest_s=max((to_s(read.now_ns - process.created_ns) for process in waiting), default=0.0),
        most=_most(read, processes),
        worst_s=max((waited_s for _, waited_s in waits), default=0.0),
        worst_critical_s=max((waited_s for process, waited_s in waits if process.criticality >= CRITICAL), default=0.0),
        shed=sum(1 for process in processes if _shed(process)),
        refused={reason: number for reason, number in read.refused.items() if reason.startswith(REFUSED)},
    )


def _shed(process: ProcessPast) -> bool:
    return bool(process.decisions) and process.decisions[0].reasons[:1] != () and process.decisions[0].reasons[0].startswith(SHED)


def _until_ns(read: History, process: ProcessPast) -> int:
    """Until when it had not begun: its first dispatch, its end without one, or now."""
    if process.first_treated_ns is not None:
        return process.first_treated_ns
    return read.now_ns if process.open else process.since_ns


def _waited_s(read: History, process: ProcessPast) -> float:
    return to_s(_until_ns(read, process) - process.created_ns)


def _most(read: History, processes: list[ProcessPast]) -> int:
    """How many had not begun at once, at most: what begins at the instant at which another comes leaves first."""
    changes = sorted(
        [(_until_ns(read, process), -1) for process in processes if _until_ns(read, process) > process.created_ns]
        + [(process.created_ns, 1) for process in processes if _until_ns(read, process) > process.created_ns]
    )
    most = standing = 0
    for _, change in changes:
        standing += change
        most = max(most, standing)
    return most
