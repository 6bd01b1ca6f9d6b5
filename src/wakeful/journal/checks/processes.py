"""Processes: only legal transitions, and every open process is ready or will be woken by something that has a limit."""

from __future__ import annotations

import heapq

import msgspec

from wakeful.facts.asking import Kind
from wakeful.facts.lines import Answered, Asked, Concluded, Created, Decided, Line, Moved, Noted
from wakeful.facts.processes import COMPLETIONS, TRANSITIONS, Completion, State
from wakeful.journal.checks.check import Check


class Transitions(Check):
    """Each transition stands in the process table, and starts where the last one ended."""

    name = "transitions"
    says = "every transition stands in the process table and starts where the last one ended"

    def __init__(self) -> None:
        super().__init__()
        self._state: dict[int, State] = {}
        self._steps: dict[int, int] = {}
        self._concluded: set[int] = set()

    def see(self, line: Line) -> None:
        """Follow each process through its states."""
        record = line.record
        match record:
            case Created():
                self.checked += 1
                if record.process in self._state:
                    self.offend(line, f"process {record.process} was created before")
                elif record.parent and record.parent not in self._state:
                    self.offend(line, f"process {record.process} is a child of {record.parent}, which does not exist")
                elif record.reopens and self._state.get(record.reopens) is not State.COMPLETED:
                    self.offend(line, f"process {record.process} reopens {record.reopens}, which had not completed")
                self._state[record.process] = State.CREATED
            case Concluded():
                self._concluded.add(record.process)
            case Moved():
                self.checked += 1
                self._move(line, record)
            case _:
                pass

    def _move(self, line: Line, record: Moved) -> None:
        state = self._state.get(record.process)
        if state is None:
            self.offend(line, f"process {record.process} moves, but was never created")
            return
        if record.before is not state:
            self.offend(line, f"process {record.process} moves from {record.before}, but it is {state}")
        elif TRANSITIONS.get((record.before, record.trigger)) is not record.after:
            self.offend(line, f"process {record.process}: a {record.before} process cannot {record.trigger} to {record.after}")
        elif record.steps < self._steps.get(record.process, 0):
            self.offend(line, f"process {record.process} lost steps: {self._steps[record.process]} before, {record.steps} now")
        self._state[record.process] = record.after
        self._steps[record.process] = record.steps


class Results(Check):
    """What ended with a result recorded it, and nothing concluded twice."""

    name = "results"
    says = "every resolved or unresolved process recorded one result, and only such a process did"

    def __init__(self) -> None:
        super().__init__()
        self._results: set[int] = set()
        self._ended: dict[int, tuple[Completion, Line]] = {}

    def see(self, line: Line) -> None:
        """Pair the ends with their results."""
        record = line.record
        if isinstance(record, Concluded):
            self.checked += 1
            if record.process in self._results:
                self.offend(line, f"process {record.process} concluded before")
            self._results.add(record.process)
        elif isinstance(record, Moved) and record.after is State.COMPLETED and record.trigger in COMPLETIONS:
            self._ended[record.process] = (COMPLETIONS[record.trigger], line)

    def settle(self) -> None:
        """The result stands in the same commit as the end."""
        for process, (end, ended) in self._ended.items():
            if end in (Completion.RESOLVED, Completion.UNRESOLVED) and process not in self._results:
                self.offend(ended, f"process {process} ended {end}, but no result is recorded")
        self._ended.clear()


class _Wait(msgspec.Struct):
    state: State = State.CREATED
    decided: bool = False
    asks: dict[int, Asked] = {}
    children: set[int] = set()


class Wakeups(Check):
    """At every instant each open process has a decision and is ready, or waits for something that has a limit still to come."""

    name = "wake-ups"
    says = "every open process has a decision, and is ready or has a live wake-up with a limit"

    def __init__(self) -> None:
        super().__init__()
        self._open: dict[int, _Wait] = {}
        self._parent: dict[int, int] = {}
        self._touched: dict[int, Line] = {}
        self._limits: list[tuple[int, int, int]] = []
        self._last = Line(0, 0, Noted(what="", detail=""))

    def see(self, line: Line) -> None:
        """Keep what each open process waits for."""
        self._last = line
        record = line.record
        if isinstance(record, Created):
            self._open.setdefault(record.process, _Wait())
            if record.parent in self._open:
                self._open[record.parent].children.add(record.process)
                self._parent[record.process] = record.parent
            self._touched[record.process] = line
            return
        if not isinstance(record, Moved | Decided | Asked | Answered):
            return
        wait = self._open.get(record.process)
        if wait is None:
            return
        self._touched[record.process] = line
        match record:
            case Decided():
                wait.decided = True
            case Asked():
                wait.asks[record.seq] = record
                if record.expires_ns is not None:
                    heapq.heappush(self._limits, (record.expires_ns, record.process, record.seq))
            case Answered():
                wait.asks.pop(record.seq, None)
            case Moved():
                wait.state = record.after
                if record.after is State.COMPLETED:
                    self._close(record.process)

    def _close(self, process: int) -> None:
        self._open.pop(process, None)
        self._touched.pop(process, None)
        parent = self._open.get(self._parent.pop(process, 0))
        if parent is not None:
            parent.children.discard(process)

    def settle(self) -> None:
        """Put the rule to every process that changed, and to every limit that has passed."""
        for process, touched in self._touched.items():
            self.checked += 1
            wait = self._open[process]
            if not wait.decided:
                self.offend(touched, f"process {process} is {wait.state} without a decision")
            elif wait.state is State.WAITING and not self._wakes(wait):
                self.offend(touched, f"process {process} waits, and nothing with a limit will wake it")
        self._touched.clear()
        self._expire(self._last)

    def _expire(self, line: Line) -> None:
        while self._limits and self._limits[0][0] < line.at_ns:
            expires_ns, process, seq = heapq.heappop(self._limits)
            waiting = self._open.get(process)
            asked = waiting.asks.get(seq) if waiting else None
            if waiting is None or asked is None or asked.expires_ns != expires_ns or waiting.state is not State.WAITING:
                continue
            if not any(_ahead(other, line.at_ns) for other in waiting.asks.values()):
                self.offend(line, f"process {process} still waits for {asked.kind} {asked.key!r}, whose limit has passed")

    def _wakes(self, wait: _Wait) -> bool:
        return any(
            asked.expires_ns is not None or (asked.kind is Kind.TREAT and bool(wait.children)) for asked in wait.asks.values()
        )


def _ahead(asked: Asked, now_ns: int) -> bool:
    return asked.expires_ns is None or asked.expires_ns >= now_ns
