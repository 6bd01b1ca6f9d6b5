"""Boosted trees grown by LightGBM (Ke et al. 2017) in place of our own: quicker on wide inputs. The extra `wakeful[boosting]`.

Only growing them needs the package: the trees become a `Forest`, which is stored and read as ever, on any machine.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from wakeful.contracts.learner import MissingLearner
from wakeful.learning.forest import Forest, ForestSettings
from wakeful.learning.material import Floats, Material

if TYPE_CHECKING:
    from types import ModuleType

_DIGITS = 9
_Node: TypeAlias = Mapping[str, Any]


def package() -> ModuleType:
    """LightGBM.

    Raises:
        MissingLearner: it is not installed.
    """
    try:
        import lightgbm  # noqa: PLC0415
    except (ImportError, OSError) as error:
        raise MissingLearner(f"the learner 'boosted' needs LightGBM: pip install 'wakeful[boosting]' ({error})") from error
    found: ModuleType = lightgbm
    return found


def grow_packaged(rows: Material, classes: int, seed: int, settings: ForestSettings) -> Forest:
    """What ``fit_forest`` does, by LightGBM: the same numbers of trees, of the same depth, rate and sampling.

    Raises:
        MissingLearner: LightGBM is not installed.
    """
    lightgbm = package()
    known = (rows.treatment >= 0) & (rows.weight > 0.0)
    x, y, weight = rows.x[known], rows.treatment[known], rows.weight[known]
    inner = 2**settings.depth - 1
    present = np.unique(y)
    base: Floats = np.full(classes, np.log(0.5 / max(1, len(y))), dtype=np.float64)
    if len(present) < 2 or not x.shape[1]:
        base[present] = 0.0
        return _forest([], inner, np.round(base, _DIGITS))
    base[present] = 0.0  # LightGBM's first trees hold how frequent each class is
    data = lightgbm.Dataset(
        x,
        label=np.searchsorted(present, y),
        weight=weight / weight.mean(),
        params={"verbose": -1, "min_data_in_bin": 1, "feature_pre_filter": False, "use_missing": False},
    )
    grown = lightgbm.train(
        {
            "objective": "multiclass",
            "num_class": len(present),
            "max_depth": settings.depth,
            "num_leaves": 2**settings.depth,
            "learning_rate": settings.rate,
            "lambda_l2": settings.ridge,
            "bagging_fraction": settings.rows,
            "bagging_freq": 1,
            "feature_fraction": settings.columns,
            "min_data_in_leaf": 2,
            "seed": seed,
            "num_threads": 1,
            "deterministic": True,
            "force_row_wise": True,
            "verbose": -1,
        },
        data,
        num_boost_round=settings.rounds,
    )
    trees = [each["tree_structure"] for each in grown.dump_model()["tree_info"]]
    rounds: list[_Node | None] = []
    for first in range(0, len(trees), len(present)):
        of_round: list[_Node | None] = [None] * classes
        for place, tree in zip(present.tolist(), trees[first : first + len(present)], strict=True):
            of_round[place] = tree
        rounds += of_round
    return _forest(rounds, inner, np.round(base, _DIGITS))


def _forest(trees: list[_Node | None], inner: int, base: Floats) -> Forest:
    """The trees as complete ones of arrays; None where a class has none."""
    column = np.zeros((len(trees), inner), dtype=np.int64)
    cut = np.full((len(trees), inner), np.inf)
    leaf = np.zeros((len(trees), inner + 1))

    def fill(tree: int, node: int, found: _Node) -> None:
        if "split_feature" in found:
            column[tree, node], cut[tree, node] = int(found["split_feature"]), float(found["threshold"])
            fill(tree, 2 * node + 1, found["left_child"])
            fill(tree, 2 * node + 2, found["right_child"])
        elif node >= inner:
            leaf[tree, node - inner] = round(float(found["leaf_value"]), _DIGITS)
        else:  # a leaf above the last level: nothing is split below it, so only the leftmost of its leaves is reached
            while node < inner:
                node = 2 * node + 1
            leaf[tree, node - inner] = round(float(found["leaf_value"]), _DIGITS)

    for place, structure in enumerate(trees):
        if structure is not None:
            fill(place, 0, structure)
    return Forest(column=column, cut=cut, leaf=leaf, base=base)
