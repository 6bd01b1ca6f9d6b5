"""Repayment: what was treated provisionally, for want of an answer or of time, is thought about again later, by risk."""

from __future__ import annotations

import msgspec

from wakeful.facts.asking import Kind
from wakeful.facts.lines import Answered, AnyRecord, Concluded, Created, Decided, Moved, Reopened
from wakeful.facts.overload import SHED
from wakeful.facts.processes import State
from wakeful.facts.time import to_ns

#: The longest pause between two tries of a reasoner that does not answer.
LONGEST_PAUSE_S = 3_600.0

#: So many debts are repaid at once while the reasoner answers; one while it does not: that one is the question whether it does.
AT_ONCE = 4

#: A debt whose repayment was refused so often while others were answered stays one; a person finds it in ``wakeful debt``.
TRIES = 3


class Debt(msgspec.Struct, kw_only=True):
    """One event that holds a provisional treatment because its deliberation was refused, or shed under overload."""

    event: str
    process: int
    criticality: int
    since_ns: int
    tries: int = 0
    """How often its repayment was refused although the reasoner answered others."""
    passes: int = 0
    """How often it was asked about while the reasoner did not answer: then the next one is, until somebody is answered."""
    under_way: int = 0
    """The process that repays it; 0: none."""


class _Root(msgspec.Struct):
    event: str
    criticality: int
    owed: bool = False


class Debts:
    """Who is owed a better treatment, and when the next one is given it. A fold over records, live and in recovery alike.

    A refused question begins a pause of ``pause_s``, twice as long after each further one, at most LONGEST_PAUSE_S. After it the
    riskiest debt is reopened, after the next pause the next: one question that is always refused must not hide that the others
    would be answered. Where one is answered, all follow, the most critical first, then the oldest, at most AT_ONCE at a time
    and one each ``every_s``.

    Args:
        pause_s: the first pause; 0: nothing is repaid.
        every_s: the least time between two repayments.
    """

    def __init__(self, pause_s: float, every_s: float) -> None:
        self._first_pause_ns = to_ns(pause_s)
        self._every_ns = to_ns(every_s)
        self._pause_ns = self._first_pause_ns
        self._answers = True
        self._next_ns = 0
        self._shed_ns: int | None = None
        self._roots: dict[int, _Root] = {}
        self._debts: dict[str, Debt] = {}
        self._under_way: dict[int, str] = {}

    def __len__(self) -> int:
        return len(self._debts)

    def next_due_ns(self) -> int | None:
        """When the next debt may be repaid; None where there is none, or enough are being repaid."""
        if not self._first_pause_ns or len(self._under_way) >= (AT_ONCE if self._answers else 1):
            return None
        return self._next_ns if len(self._debts) > len(self._under_way) else None

    def due(self, now_ns: int) -> Debt | None:
        """The debt to repay now: its event is to be reopened, which the record of it makes known here."""
        next_ns = self.next_due_ns()
        return self._riskiest() if next_ns is not None and next_ns <= now_ns else None

    def forget(self, event: str) -> None:
        """The event cannot be thought about again: it is no longer in memory. It stays listed as debt."""
        self._end(event)

    def apply(self, record: AnyRecord, now_ns: int) -> None:
        """Take up one record of the journal. Those that concern other rooms are passed over."""
        match record:
            case Created(parent=0):
                self._roots[record.process] = _Root(record.event, record.criticality)
            case Decided(decision=decision) if decision.mode == "fallback" and decision.reasons:
                self._shed(record.process, decision.reasons[0], now_ns)
            case Answered(kind=Kind.DELIBERATE):
                self._answered(record, now_ns)
            case Concluded():
                self._concluded(record, now_ns)
            case Reopened(event=event) if event in self._debts and not self._debts[event].under_way:
                self._debts[event].under_way = record.process
                self._under_way[record.process] = event
                self._next_ns = max(self._next_ns, now_ns + self._every_ns)
            case Moved(after=State.COMPLETED):
                self._roots.pop(record.process, None)
                if record.process in self._under_way:  # moot, cancelled, abandoned: it ended without a result
                    self._end(self._under_way[record.process])
            case _:
                pass

    def _end(self, event: str) -> Debt | None:
        """The event is no longer owed anything, as far as is known."""
        debt = self._debts.pop(event, None)
        if debt is not None:
            self._under_way.pop(debt.under_way, None)
        return debt

    def _riskiest(self) -> Debt | None:
        waiting = (debt for debt in self._debts.values() if not debt.under_way)
        return min(waiting, key=_place, default=None)

    def _shed(self, process: int, why: str, now_ns: int) -> None:
        """Deliberation was put off: nothing is repaid before there was none of that for a pause."""
        root = self._roots.get(process)
        if root is not None and why.startswith(SHED):
            root.owed = True
            self._shed_ns = now_ns
            self._next_ns = max(self._next_ns, now_ns + self._first_pause_ns)

    def _shedding(self, now_ns: int) -> bool:
        return self._shed_ns is not None and now_ns < self._shed_ns + self._first_pause_ns

    def _answered(self, record: Answered, now_ns: int) -> None:
        if not record.error:
            if not self._answers:
                for each in self._debts.values():
                    each.passes = 0
            self._answers = True
            self._pause_ns = self._first_pause_ns
            if not self._shedding(now_ns):
                self._next_ns = min(self._next_ns, now_ns + self._every_ns)
            return
        root = self._roots.get(record.process)
        if root is not None:
            root.owed = True
        debt = self._debts.get(self._under_way.get(record.process, ""))
        if debt is not None:
            debt.tries += self._answers
            debt.passes += not self._answers
        if not self._answers and debt is not None:
            self._pause_ns = min(2 * self._pause_ns, to_ns(LONGEST_PAUSE_S))
        self._answers = False
        self._next_ns = max(self._next_ns, now_ns + self._pause_ns)

    def _concluded(self, record: Concluded, now_ns: int) -> None:
        root = self._roots.get(record.process)
        if root is None:
            return
        before = self._end(root.event)
        if record.mode != "fallback" or not root.owed:
            return
        debt = before or Debt(event=root.event, process=0, criticality=root.criticality, since_ns=now_ns)
        debt.process, debt.under_way = record.process, 0
        if debt.tries < TRIES:
            self._debts[root.event] = debt


def _place(debt: Debt) -> tuple[int, int, int, int]:
    return debt.tries + debt.passes, -debt.criticality, debt.since_ns, debt.process
