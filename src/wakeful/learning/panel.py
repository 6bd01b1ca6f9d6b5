"""The treatment head's stronger experts: decision lists, and boosted trees over what the lists found worth asking."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt

from wakeful.contracts.grounds import HeardRule
from wakeful.learning.experts import LEAST
from wakeful.learning.forest import Forest, ForestReader, ForestSettings, fit_forest
from wakeful.learning.material import Flags, Floats, Material
from wakeful.learning.network import softmax
from wakeful.learning.rule_lists import RuleLists, RuleReader, fit_rules
from wakeful.learning.rule_search import SearchSettings

EXPERTS: Final = ("network", "rules", "forest")
"""The experts that are pooled, in the order of their weights."""

Input = tuple[int, int, float]
"""A column, another one (-1: none), and by how much the second shifts the first."""


Grow = Callable[[Material, int, int, ForestSettings], Forest]
"""What grows trees: on rows, for so many classes, with a seed."""


class Panel(msgspec.Struct, frozen=True, kw_only=True):
    """Lists and trees that were fitted to the same rows. ``inputs`` are what the trees see."""

    rules: RuleLists
    forest: Forest
    inputs: tuple[Input, ...]


def fit_panels(
    rows: Material,
    held_back: Flags,
    classes: int,
    seed: int,
    search: SearchSettings,
    trees: ForestSettings,
    grow: Grow = fit_forest,
    wide: bool = False,
) -> tuple[Panel, Panel]:
    """The panel that has not seen what was held back, and the one that has learned from all.

    The trees see every column with two values, and of the numeric ones those alone (or those combinations of two) that the first
    lists ask for: an identity's many numbers would otherwise be learned by heart. With ``wide`` a second set of trees sees
    every column, and the set is kept that foretells better what was held back.
    """
    tested, whole = fit_rules(rows, held_back, classes, seed, search)
    every = tuple((column, -1, 0.0) for column in range(rows.x.shape[1]))
    found = []
    for inputs in (_inputs(rows, tested), every) if wide else (_inputs(rows, tested),):
        seen = msgspec.structs.replace(rows, x=_projected(rows.x, inputs))
        found.append((inputs, seen, grow(seen.rows(~held_back), classes, seed, trees)))
    inputs, seen, first = min(found, key=lambda each: _loss(each[2], each[1].rows(held_back)))
    again = grow(seen, classes, seed, trees) if held_back.any() else first
    return Panel(rules=tested, forest=first, inputs=inputs), Panel(rules=whole, forest=again, inputs=inputs)


def _loss(forest: Forest, rows: Material) -> float:
    """Mean cross-entropy on the rows whose treatment is known, by weight; 0 without any."""
    known = (rows.treatment >= 0) & (rows.weight > 0.0)
    if not known.any():
        return 0.0
    shares = softmax(ForestReader(forest).logits_many(rows.x[known]))
    own = shares[np.arange(len(shares)), rows.treatment[known]]
    return float(-np.average(np.log(np.maximum(own, LEAST)), weights=rows.weight[known]))


def _inputs(rows: Material, rules: RuleLists) -> tuple[Input, ...]:
    binary = [column for column in range(rows.x.shape[1]) if len(np.unique(rows.x[:, column])) == 2]
    asked = {(each.column, each.other, each.slope) for each in rules.clauses}
    return (*((column, -1, 0.0) for column in binary), *sorted(each for each in asked if each[0] not in set(binary)))


def _projected(x: Floats, inputs: tuple[Input, ...]) -> Floats:
    columns, others, slopes = _arrays(inputs)
    return np.asarray(x[:, columns] + slopes * x[:, others])


def _arrays(inputs: tuple[Input, ...]) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp], Floats]:
    return (
        np.array([column for column, _, _ in inputs], dtype=np.intp),
        np.array([max(0, other) for _, other, _ in inputs], dtype=np.intp),
        np.array([slope for _, _, slope in inputs]),
    )


class PanelReader:
    """Reads a panel for one event or many."""

    def __init__(self, model: Panel) -> None:
        self._rules, self._forest = RuleReader(model.rules), ForestReader(model.forest)
        self._columns, self._others, self._slopes = _arrays(model.inputs)
        self._shifted = bool(self._slopes.any())
        self._classes = len(model.forest.base)

    def alone(self, x: Floats) -> tuple[list[float], list[float]]:
        """The probabilities by rules, (k,), and the logits of the trees, (k,), for one row (d,)."""
        seen = x.take(self._columns)
        if self._shifted:
            seen = seen + self._slopes * x.take(self._others)
        return self._rules.shares(x).tolist(), self._forest.logits(seen).tolist()

    def heard(self, x: Floats, place: int) -> tuple[HeardRule, ...]:
        """The rules that spoke for one row (d,), and what each says of the class at ``place``."""
        return self._rules.heard(x, place)

    def logs_many(self, x: Floats) -> Floats:
        """Logarithms of probabilities by rules and by trees, up to a constant each, (2, n, k), for rows (n, d)."""
        found = np.empty((2, len(x), self._classes))
        found[0] = np.log(np.maximum(self._rules.shares_many(x), LEAST))
        found[1] = self._forest.logits_many(x[:, self._columns] + self._slopes * x[:, self._others])
        return found
