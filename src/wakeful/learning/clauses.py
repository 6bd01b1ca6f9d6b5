"""What a rule may ask of an event: one column against a limit, or one column shifted by another against a limit."""

from __future__ import annotations

import math
from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt

from wakeful.learning.material import Flags, Floats

LIMITS: Final = 64
"""So many limits are tried per numeric column, evenly over what lies between the values seen."""
SLOPES: Final = (-0.5, -0.25, 0.25, 0.5)
"""Of oblique clauses: by how many standard deviations of the first column one of the second shifts it."""


class Clause(msgspec.Struct, frozen=True):
    """``x[column] + slope · x[other] > limit``, or its negation; ``other`` is -1 where one column is asked for alone."""

    column: int
    limit: float
    above: bool
    other: int = -1
    slope: float = 0.0


def holding(clauses: tuple[Clause, ...], x: Floats) -> Flags:
    """Which clauses hold of which rows, (n, d) → (n, clauses)."""
    columns, others, slopes, limits, above = as_arrays(clauses)
    return np.asarray((x[:, columns] + slopes * x[:, others] > limits) == above)


def as_arrays(
    clauses: tuple[Clause, ...],
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp], Floats, Floats, Flags]:
    """Columns, other columns (0 with slope 0 where there is none), slopes, limits and directions."""
    return (
        np.array([each.column for each in clauses], dtype=np.intp),
        np.array([max(0, each.other) for each in clauses], dtype=np.intp),
        np.array([each.slope for each in clauses]),
        np.array([each.limit for each in clauses]),
        np.array([each.above for each in clauses], dtype=np.bool_),
    )


class Clauses:
    """The clauses that can be asked of given rows, by number, made as they are needed.

    A clause's rows are a Python integer, bit i for row i: intersecting and counting 512 rows takes tens of nanoseconds. A
    clause's cost is what it takes to name it, in nats: which column, which limit, and what else it might have been.

    Args:
        x: rows (n, d). Columns with two values become yes-or-no clauses, with more numeric ones, with one none.
    """

    def __init__(self, x: Floats) -> None:
        self._x = x
        self.clauses: list[Clause] = []
        self.bits: list[int] = []
        self.costs: list[float] = []
        self.subject: list[int] = []
        """The column that a clause asks about: a rule asks once about each."""
        self.limited: list[bool] = []
        """Whether the clause has a limit that could lie elsewhere."""
        self._known: dict[tuple[int, int, bool], int] = {}
        self._projections: list[tuple[int, int, float]] = []
        self._limits: dict[int, Floats] = {}
        self._place: dict[int, tuple[int, int, bool]] = {}
        self._numeric: list[int] = []
        columns = [column for column in range(x.shape[1]) if x[:, column].min() < x[:, column].max()]
        self._which = math.log(max(1, len(columns)))
        seen: set[int] = set()
        for column in columns:
            values = np.unique(x[:, column])
            if len(values) > 2:
                self._numeric.append(column)
                continue
            rows = as_bits(x[:, column] > (values[0] + values[1]) / 2)
            if rows not in seen:  # two columns that say the same are one
                seen.add(rows)
                for above in (True, False):
                    limit = float((values[0] + values[1]) / 2)
                    self._add(Clause(column, limit, above), self._which + (0.0 if above else 1.0), limited=False)
        self.plain = tuple(range(len(self.clauses)))
        """The numbers of the yes-or-no clauses."""
        self._projections = [(column, -1, 0.0) for column in self._numeric]
        self._axes = len(self._projections)
        spread = {column: float(x[:, column].std()) for column in self._numeric}
        self._projections += [
            (column, other, slope * spread[column] / spread[other])
            for column in self._numeric
            for other in self._numeric
            if other != column
            for slope in SLOPES
        ]

    @property
    def projections(self) -> tuple[int, int]:
        """How many numeric columns there are, and how many oblique combinations of two."""
        return self._axes, len(self._projections) - self._axes

    def limited_clause(self, projection: int, fraction: float, above: bool) -> int | None:
        """The clause of that projection whose limit lies at ``fraction`` of the way through its limits."""
        limits = self._limits_of(projection)
        return self._at(projection, int(fraction * len(limits)), above) if len(limits) else None

    def through(self, projection: int, fraction: float, row: int) -> int | None:
        """The same, in the direction that holds of the row."""
        clause = self.limited_clause(projection, fraction, True)
        if clause is None or self.bits[clause] >> row & 1:
            return clause
        return self.negated(clause)

    def negated(self, clause: int) -> int:
        """The limited clause with the same limit and the other direction."""
        projection, place, above = self._place[clause]
        return self._at(projection, place, not above)

    def shifted(self, clause: int, steps: int) -> int | None:
        """The limited clause whose limit lies so many steps further; None beyond the last one."""
        projection, place, above = self._place[clause]
        if not 0 <= place + steps < len(self._limits_of(projection)):
            return None
        return self._at(projection, place + steps, above)

    def same_limit(self, clause: int) -> tuple[int, int, float]:
        """What two clauses have in common that share a limit."""
        own = self.clauses[clause]
        return own.column, own.other, own.limit

    def _at(self, projection: int, place: int, above: bool) -> int:
        key = (projection, place, above)
        found = self._known.get(key)
        if found is None:
            column, other, slope = self._projections[projection]
            limits = self._limits_of(projection)
            cost = self._which + math.log(2 * len(limits))
            if self._axes > 1:
                cost += math.log(2.0) + (math.log((len(self._projections) - self._axes) / self._axes) if other >= 0 else 0.0)
            found = self._add(Clause(column, float(limits[place]), above, other, slope), cost, limited=True)
            self._known[key] = found
            self._place[found] = key
        return found

    def _limits_of(self, projection: int) -> Floats:
        limits = self._limits.get(projection)
        if limits is None:
            values = np.unique(np.round(self._values(projection), 9))
            limits = np.asarray((values[1:] + values[:-1]) / 2)
            if len(limits) > LIMITS:
                limits = limits[np.linspace(0, len(limits) - 1, LIMITS).round().astype(np.intp)]
            self._limits[projection] = limits
        return limits

    def _values(self, projection: int) -> Floats:
        column, other, slope = self._projections[projection]
        return np.asarray(self._x[:, column] + slope * self._x[:, max(0, other)])

    def _add(self, clause: Clause, cost: float, *, limited: bool) -> int:
        self.clauses.append(clause)
        self.bits.append(as_bits(holding((clause,), self._x)[:, 0]))
        self.costs.append(cost)
        self.subject.append(clause.column)
        self.limited.append(limited)
        return len(self.clauses) - 1


def as_bits(flags: Flags) -> int:
    """Flags (n,) as an integer: bit i for place i."""
    return int.from_bytes(np.packbits(flags, bitorder="little").tobytes(), "little")
