"""Boosted trees as one of a model's experts on treatments: small, in numpy alone, as arrays from the first to the last.

Gradient boosting with second-order leaves and row and column sampling (Friedman 2002; Chen and Guestrin 2016). The k trees of a
round grow together, level by level: all their sums of gradients are one matrix product.
"""

from __future__ import annotations

from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt

from wakeful.learning.material import Floats, Material
from wakeful.learning.network import softmax

Places = npt.NDArray[np.int64]

CUTS: Final = 32
"""So many cuts are tried per column, evenly over what lies between the values seen."""
_DIGITS = 9
_SMALL = 1e-9


class ForestSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """``rounds`` of k trees of ``depth``; ``rate`` is how much of each leaf counts, ``ridge`` what shrinks it; each tree is grown
    on a share of the ``rows`` and of the ``columns``."""

    rounds: int = 60
    depth: int = 4
    rate: float = 0.15
    ridge: float = 0.3
    rows: float = 0.7
    columns: float = 0.5


class Forest(msgspec.Struct, frozen=True, kw_only=True):
    """T = rounds · k trees, tree t of class t mod k. Node i of a level has the children 2i + 1 (up to the cut) and 2i + 2.

    ``column`` and ``cut`` (T, 2^depth − 1), ``leaf`` (T, 2^depth), ``base`` (k,) the logits before the first tree. A node that
    splits nothing has an infinite cut.
    """

    column: Places
    cut: Floats
    leaf: Floats
    base: Floats


def fit_forest(rows: Material, classes: int, seed: int, settings: ForestSettings) -> Forest:
    """Boost trees on the rows whose treatment is known, as each weighs; without any, all classes are equally likely."""
    known = (rows.treatment >= 0) & (rows.weight > 0.0)
    x, y = rows.x[known], rows.treatment[known]
    weight = rows.weight[known] / rows.weight[known].mean() if known.any() else rows.weight[known]
    told = np.eye(classes)[y]
    base = np.log((told * weight[:, None]).sum(axis=0) + 0.5)
    columns, cuts = _cuts(x)
    if not len(columns):
        shape = (0, 2**settings.depth - 1)
        return Forest(column=np.zeros(shape, np.int64), cut=np.zeros(shape), leaf=np.zeros((0, 2**settings.depth)), base=base)
    random = np.random.default_rng((seed, 3))
    below = (x[:, columns] <= cuts).astype(np.float64)
    logits = np.tile(base, (len(x), 1))
    grown = []
    for _ in range(settings.rounds):
        shares = softmax(logits)
        drawn = weight * (random.random(len(x)) < settings.rows)
        slope = (shares - told) * drawn[:, None]
        bend = np.maximum(shares * (1.0 - shares), 1e-6) * drawn[:, None]
        allowed = _allowed(columns, classes, settings.columns, random)
        tree, at = _grow(x, below, columns, cuts, slope.T, bend.T, allowed, settings)
        logits += tree[2][np.arange(classes)[:, None], at].T
        grown.append(tree)
    return Forest(
        column=np.concatenate([each[0] for each in grown]),
        cut=np.concatenate([each[1] for each in grown]),
        leaf=np.round(np.concatenate([each[2] for each in grown]), _DIGITS),
        base=np.round(base, _DIGITS),
    )


def _cuts(x: Floats) -> tuple[Places, Floats]:
    """Every (column, cut) that may be tried."""
    columns: list[int] = []
    cuts: list[float] = []
    for column in range(x.shape[1] if len(x) else 0):
        values = np.unique(x[:, column])
        between = (values[1:] + values[:-1]) / 2
        if len(between) > CUTS:
            between = between[np.linspace(0, len(between) - 1, CUTS).round().astype(np.intp)]
        columns += [column] * len(between)
        cuts += between.tolist()
    return np.array(columns, dtype=np.int64), np.array(cuts)


def _allowed(columns: Places, classes: int, share: float, random: np.random.Generator) -> npt.NDArray[np.bool_]:
    """Which cuts each of the round's trees may use, (k, 1, cuts): all those of a share of the columns."""
    different = np.unique(columns)
    count = max(1, round(share * len(different)))
    return np.stack([np.isin(columns, random.choice(different, count, replace=False)) for _ in range(classes)])[:, None, :]


def _grow(
    x: Floats,
    below: Floats,
    columns: Places,
    cuts: Floats,
    slope: Floats,
    bend: Floats,
    allowed: npt.NDArray[np.bool_],
    settings: ForestSettings,
) -> tuple[tuple[Places, Floats, Floats], Places]:
    """One tree per class, all at once: its arrays, and in which leaf each row came to lie, (k, n)."""
    k, n = slope.shape
    trees, rows = np.arange(k)[:, None], np.arange(n)
    inner = 2**settings.depth - 1
    column, cut = np.zeros((k, inner), dtype=np.int64), np.full((k, inner), np.inf)
    node = np.zeros((k, n), dtype=np.int64)
    for level in range(settings.depth):
        first, width = 2**level - 1, 2**level
        member = np.zeros((k, width, n))
        member[trees, node - first, rows] = 1.0
        slopes, bends = member * slope[:, None, :], member * bend[:, None, :]
        left, left_bend = slopes @ below, bends @ below
        whole, whole_bend = slopes.sum(axis=2, keepdims=True), bends.sum(axis=2, keepdims=True)
        ridge = settings.ridge
        gain = (
            left**2 / (left_bend + ridge)
            + (whole - left) ** 2 / (whole_bend - left_bend + ridge)
            - whole**2 / (whole_bend + ridge)
        )
        gain = np.where(allowed & (left_bend > _SMALL) & (whole_bend - left_bend > _SMALL), np.round(gain, _DIGITS), 0.0)
        best = gain.argmax(axis=2)
        worth = np.take_along_axis(gain, best[:, :, None], axis=2)[:, :, 0] > _SMALL
        column[:, first : first + width] = columns[best]
        cut[:, first : first + width] = np.where(worth, cuts[best], np.inf)
        node = 2 * node + 1 + (x[rows, column[trees, node]] > cut[trees, node])
    at = node - inner
    leaf = np.zeros((k, 2**settings.depth))
    for tree in range(k):
        sums = np.bincount(at[tree], slope[tree], minlength=2**settings.depth)
        leaf[tree] = -settings.rate * sums / (np.bincount(at[tree], bend[tree], minlength=2**settings.depth) + settings.ridge)
    return (column, cut, leaf), at


class ForestReader:
    """Reads a forest for one event at a time: every tree takes its step down together."""

    def __init__(self, model: Forest) -> None:
        trees, inner = model.column.shape
        self._depth = (inner + 1).bit_length() - 1
        self._column, self._cut = model.column.ravel(), model.cut.ravel()
        self._leaf, self._base = model.leaf.ravel(), model.base
        self._first_node = np.arange(trees) * inner
        self._step = 1 - self._first_node
        self._second_node = self._first_node + 1
        self._root_column, self._root_cut = self._column[self._first_node], self._cut[self._first_node]
        self._to_leaf = np.arange(trees) - inner

    def logits(self, x: Floats) -> Floats:
        """Logits (k,) for one row (d,)."""
        # The children of node i of a tree whose nodes begin at f lie at f + 2 (i - f) + 1 and + 2.
        node = self._second_node + (x.take(self._root_column) > self._root_cut)
        for _ in range(self._depth - 1):
            further = x.take(self._column.take(node)) > self._cut.take(node)
            node += node
            node += self._step
            node += further
        node += self._to_leaf
        return np.asarray(self._base + self._leaf.take(node).reshape(-1, len(self._base)).sum(axis=0))

    def logits_many(self, x: Floats) -> Floats:
        """The same for rows, (n, k)."""
        node = np.tile(self._first_node, (len(x), 1))
        rows = np.arange(len(x))[:, None]
        for _ in range(self._depth):
            node = 2 * node + self._step + (x[rows, self._column[node]] > self._cut[node])
        return np.asarray(self._base + self._leaf[node + self._to_leaf].reshape(len(x), -1, len(self._base)).sum(axis=1))
