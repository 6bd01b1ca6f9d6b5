"""Neighbours among more episodes than an exact search is quick enough for: a graph that is searched greedily.

An extra (`pip install 'wakeful[memory]'`, usearch). Source: hierarchical navigable small worlds, Malkov and Yashunin 2018.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from usearch.index import Index

#: Up to so many episodes the search is exact.
EXACT = 100_000

#: So many times the wanted neighbours are looked at: those of another kind or entity are left out afterwards.
LOOKED_AT = 16


class Approximate:
    """An index over rows that are added one by one, in one thread, so that the same rows give the same index.

    Raises:
        ImportError: usearch is not installed.
    """

    def __init__(self, width: int) -> None:
        from usearch.index import Index  # noqa: PLC0415

        self._index: Index = Index(ndim=width, metric="l2sq", dtype="f32")

    def __len__(self) -> int:
        return len(self._index)

    def add(self, place: int, row: npt.NDArray[np.float32]) -> None:
        """Take up a row, shape (d,), under its place."""
        self._index.add(place, row, threads=1)

    def search(self, row: npt.NDArray[np.float32], count: int) -> npt.NDArray[np.intp]:
        """The places of about the ``count`` nearest rows."""
        found = self._index.search(row, count, threads=1)
        return np.asarray(found.keys, dtype=np.intp)


def installed() -> bool:
    """Whether the extra is there."""
    try:
        import usearch.index  # noqa: F401, PLC0415
    except ImportError:
        return False
    return True
