"""Results as rows: ours beside the paper's cell, with the distance between them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path
from statistics import fmean, stdev

import msgspec

#: Figures are kept to so many digits, so that the same runs print the same bytes on any machine.
_DIGITS = 6


class PaperCell(msgspec.Struct, frozen=True):
    """One published figure (Tables 2 to 6): its mean and sample standard deviation over the paper's ten seeds."""

    table: str
    method: str
    workload: str
    metric: str
    paper_mean: float
    paper_sd: float | None


class Row(msgspec.Struct, frozen=True):
    """One cell of ours. ``z`` is its distance from the paper's mean in units of the paper's standard deviation.

    ``sd`` is the sample standard deviation over seeds, null with fewer than two; a seed in which there was nothing to count is
    left out of ``n_seeds``. Percentages are 0 to 100. ``z`` is null where the paper has no such cell, or where its deviation is
    0 and ours is another figure.
    """

    table: str
    method: str
    workload: str
    metric: str
    mean: float
    sd: float | None
    n_seeds: int
    paper_mean: float | None = None
    paper_sd: float | None = None
    z: float | None = None

    @property
    def standard_errors(self) -> float | None:
        """The stricter distance: in standard errors of the paper's ten-seed mean; agreement is at most two."""
        return None if self.z is None else self.z * math.sqrt(10)


Progress = Callable[[int, int], None]
"""Told after each run how many are done, and how many events they had in all."""


class Reproduced(msgspec.Struct, frozen=True):
    """An experiment's rows, and sentences on what they show. ``draw``: its figures, where rows alone don't make them."""

    rows: list[Row]
    remarks: list[str] = []
    draw: Callable[[Path], list[Path]] | None = None


@cache
def paper_cells() -> Mapping[tuple[str, str, str], PaperCell]:
    """Every published cell by (method, workload, metric). For comparison only: nothing is computed from them."""
    text = files("wakeful.experiments").joinpath("paper_results.json").read_bytes()
    cells = msgspec.json.decode(text, type=list[PaperCell])
    return {(cell.method, cell.workload, cell.metric): cell for cell in cells}


def row(
    table: str, method: str, workload: str, metric: str, values: Iterable[float | None], beside: str | None = None
) -> Row | None:
    """Mean and sample standard deviation of one figure over the seeds; None where no seed had anything to count.

    The paper's cell of the same names stands beside it, or that of the workload ``beside``.

    >>> row("3", "sequential", "low", "completion", [100.0, 100.0]).z
    0.0
    """
    counted = [value for value in values if value is not None]
    if not counted:
        return None
    mean = round(fmean(counted), _DIGITS)
    sd = round(stdev(counted), _DIGITS) if len(counted) > 1 else None
    cell = paper_cells().get((method, beside if beside is not None else workload, metric))
    if cell is None:
        return Row(table, method, workload, metric, mean, sd, len(counted))
    return Row(cell.table, method, workload, metric, mean, sd, len(counted), cell.paper_mean, cell.paper_sd, _z(mean, cell))


def _z(mean: float, cell: PaperCell) -> float | None:
    if cell.paper_sd:
        return round((mean - cell.paper_mean) / cell.paper_sd, _DIGITS)
    # Figures are published to two decimals.
    return 0.0 if round(mean, 2) == cell.paper_mean and cell.paper_sd is not None else None


def spread(mean: float | None, sd: float | None) -> str:
    """``mean ± sd`` as the paper prints it; a dash where there is none.

    >>> spread(67.1349, 7.9), spread(None, None)
    ('67.13 ± 7.90', '–')
    """
    if mean is None:
        return "–"
    return f"{mean:.2f}" if sd is None else f"{mean:.2f} ± {sd:.2f}"


def table_cells(rows: Sequence[Row]) -> list[list[str]]:
    """Rows as text: method, workload, metric, the paper's figure, ours, z, and the distance in standard errors."""
    return [
        [
            each.method,
            each.workload,
            each.metric,
            spread(each.paper_mean, each.paper_sd),
            spread(each.mean, each.sd),
            "–" if each.z is None else f"{each.z:+.2f}",
            "–" if each.standard_errors is None else f"{each.standard_errors:+.1f}",
        ]
        for each in rows
    ]
