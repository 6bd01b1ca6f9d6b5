"""What explicit reasoning may cost: calls and money, charged when a call is intended, never exceeded by one call."""

from __future__ import annotations

import math
from threading import Lock

import msgspec

from wakeful.contracts.reasoner import ReasonerError

_NANO = 1_000_000_000


class OverBudget(ReasonerError):
    """The next call could cost more than is left. Nothing was charged."""


class Spent(msgspec.Struct, frozen=True):
    """What a budget has spent so far; calls under way count at their reservation.

    ``in_doubt``: answers that were asked for and not heard to their end, whose calls may have been made and paid.
    """

    calls: int
    usd: float
    in_doubt: int = 0


class Budget:
    """Limits on calls and money, shared by every reasoner that is given it, from any thread.

    A call is charged its worst case before it is made, and settled at its true price afterwards. A call that is never
    settled (it failed, or timed out) stays charged at its worst case: the provider may have billed it.
    Money is counted in whole nanodollars, so that no rounding hides a call.

    Args:
        max_usd: limit in dollars, or None for no limit.
        max_calls: limit on calls, or None for no limit.
        spent: what was spent before, such as by an earlier run of the same journal.

    >>> budget = Budget(max_usd=0.010, max_calls=None)
    >>> charge = budget.charge(0.006)
    >>> budget.settle(charge, 0.002)
    >>> budget.spent
    Spent(calls=1, usd=0.002, in_doubt=0)
    """

    def __init__(self, max_usd: float | None, max_calls: int | None, spent: Spent | None = None) -> None:
        self._limit = None if max_usd is None else math.floor(max_usd * _NANO)
        self._max_calls = max_calls
        self._calls = spent.calls if spent else 0
        self._nanodollars = math.ceil(spent.usd * _NANO) if spent else 0
        self._open: dict[int, int] = {}
        self._next = 0
        self._lock = Lock()

    @property
    def spent(self) -> Spent:
        """Calls made and money spent or reserved."""
        with self._lock:
            return Spent(self._calls, self._nanodollars / _NANO)

    def charge(self, worst_usd: float) -> int:
        """Reserve one call of at most ``worst_usd``.

        Returns:
            A number under which to settle the call.

        Raises:
            OverBudget: a limit would be passed; nothing is charged.
        """
        worst = math.ceil(max(0.0, worst_usd) * _NANO)
        with self._lock:
            if self._max_calls is not None and self._calls >= self._max_calls:
                raise OverBudget(f"the budget of {self._max_calls} reasoner calls is used up; raise WAKEFUL_MAX_CALLS")
            if self._limit is not None and self._nanodollars + worst > self._limit:
                left = max(0, self._limit - self._nanodollars) / _NANO
                raise OverBudget(
                    f"the next reasoner call could cost ${worst / _NANO:.6f} and ${left:.6f} of the budget is left; "
                    "raise WAKEFUL_MAX_USD"
                )
            self._calls += 1
            self._nanodollars += worst
            self._next += 1
            self._open[self._next] = worst
            return self._next

    def settle(self, charge: int, actual_usd: float) -> None:
        """Replace a charge's worst case by what the call did cost. A charge is settled once; later settlements do nothing."""
        actual = math.ceil(max(0.0, actual_usd) * _NANO)
        with self._lock:
            worst = self._open.pop(charge, None)
            if worst is not None:
                self._nanodollars += actual - worst
