"""The pooled learner: the two-headed network of Eq. 8, its treatment head joined by decision lists and boosted trees."""

from __future__ import annotations

from typing import Literal

import msgspec
import numpy as np

from wakeful.contracts.learner import Predictor
from wakeful.facts.experience import ModelCard
from wakeful.facts.inputs import TrainingJob
from wakeful.learning.experts import logs_of, pooled, weigh
from wakeful.learning.forest import ForestSettings, fit_forest
from wakeful.learning.material import Floats, Material, material_of
from wakeful.learning.model import Model, calibrated, probabilities
from wakeful.learning.packaged_trees import grow_packaged, package
from wakeful.learning.panel import Panel, PanelReader, fit_panels
from wakeful.learning.pooled_predictor import PooledPredictor
from wakeful.learning.pooled_weights import PooledModel, is_pooled, pooled_from_bytes, pooled_to_bytes
from wakeful.learning.rule_search import SearchSettings
from wakeful.learning.score import score_of
from wakeful.learning.two_heads import Lineage, TwoHeads, TwoHeadsSettings
from wakeful.learning.weights import from_bytes, to_bytes

_NEGLIGIBLE = 0.02
_NOTHING_HELD_BACK = 5
"""So many times ``joined_from`` rows without a held-back one are no accident: whoever made the plan vouches for its material."""
_NETWORK_ALONE = np.array([1.0, 0.0, 0.0])


class PooledSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """``joined``: with False the network is trained alone, whatever it goes on from. ``prior`` are the weights of network, rules
    and forest without any held-back row, ``ridge`` what it takes, in nats, to move a weight by 1 (docs/selector_choice.md).
    ``trees``: who grows the trees, wakeful itself or LightGBM (the extra ``boosting``), whose trees see every column where that
    foretells held-back experience better.
    ``joined_from``: with fewer held-back rows of known treatment the network alone is heard: lists are sure from the first few
    experiences on, and nobody could yet tell whether rightly so. Where nothing at all is held back, five times as many
    will do."""

    joined: bool = True
    trees: Literal["own", "lightgbm"] = "own"
    network: TwoHeadsSettings = TwoHeadsSettings()
    rules: SearchSettings = SearchSettings()
    forest: ForestSettings = ForestSettings()
    prior: tuple[float, float, float] = (0.1, 0.7, 0.4)
    ridge: float = 30.0
    joined_from: int = 20


class Pooled(TwoHeads):
    """Trains and loads pooled models. Without state: the same job gives the same bytes.

    The result head, novelty and cells are the network's. The experts' weights are fitted on the held-back rows with experts that
    have not seen them, and so is all that is compared: champion, challenger, thresholds. What is published then has lists and
    trees that have learned from all rows.

    Raises:
        MissingLearner: the settings want LightGBM, which is not installed; it is needed to train, not to load.
    """

    name = "pooled"

    def __init__(self, settings: PooledSettings | None = None) -> None:
        self.pooling = settings or PooledSettings()
        super().__init__(self.pooling.network)
        packaged = self.pooling.trees == "lightgbm"
        if not self.pooling.joined:
            self.name = "two_heads"
        elif packaged:
            self.name = "boosted"
            package()
        self._grow = grow_packaged if packaged else fit_forest

    def train(self, job: TrainingJob) -> tuple[ModelCard, bytes]:
        """Train a challenger and compare it with the champion that it came from, which may be a network alone.

        Raises:
            ValueError: the job's arrays don't fit together, hold NaN, or leave nothing to learn from; or the base is no model.
        """
        own = self.pooling
        if not own.joined:
            network = to_bytes(_loaded(job.base_weights).network) if job.base_weights else b""
            return super().train(msgspec.structs.replace(job, base_weights=network))
        rows, held_back = material_of(job, own.network.result_half_life)
        learned, kept = rows.rows(~held_back), rows.rows(held_back)
        if not len(learned.x):
            raise ValueError(f"training {job.training} has nothing to learn from: all {len(rows.x)} rows are held back")
        champion = _loaded(job.base_weights) if job.base_weights else None
        model, base, epochs = self.fitted(job, learned, kept, None if champion is None else champion.network)
        tested, whole = fit_panels(
            rows, held_back, len(job.treatments), job.seed, own.rules, own.forest, self._grow, wide=own.trees == "lightgbm"
        )
        p, q = probabilities(model, kept)
        logs = np.concatenate([logs_of(p)[None], PanelReader(tested).logs_many(kept.x)]) if len(kept.x) else np.zeros((3, 0, 1))
        weights = weigh(logs, kept.treatment, kept.weight, np.array(own.prior), own.ridge)
        weights = np.where(weights < _NEGLIGIBLE, 0.0, weights)
        if not (self._heard(learned, kept) and weights.any()):
            weights = _NETWORK_ALONE
        shares = (pooled(logs, weights), q) if len(kept.x) else (p, q)
        blob = pooled_to_bytes(PooledModel(network=model, tested=tested, whole=whole, weights=tuple(weights.tolist())))
        lineage = Lineage(again=champion is not None and base is None, continued=base is not None, epochs=epochs)
        losses = own.network.treatment_loss, own.network.result_loss
        other = None if champion is None or base is None else score_of(*_champion(champion, base, kept), kept, *losses)
        return self.card(job, blob, lineage, score_of(*shares, kept, *losses), other, shares), blob

    def _heard(self, learned: Material, kept: Material) -> bool:
        """Whether lists and trees are heard: there is enough to judge them by, or a plan that holds nothing back at all."""
        least = self.pooling.joined_from
        told = int((learned.treatment >= 0).sum())
        return int((kept.treatment >= 0).sum()) >= least if len(kept.x) else told >= _NOTHING_HELD_BACK * least

    def load(self, weights: bytes) -> Predictor:
        """The predictor of stored weights, pooled ones or a network's. Raises ValueError on bytes that are not a model."""
        return PooledPredictor(pooled_from_bytes(weights)) if is_pooled(weights) else super().load(weights)


class _Champion(msgspec.Struct, frozen=True):
    """The base of a training: a network, and the panel beside it where there is one."""

    network: Model
    tested: Panel | None = None
    weights: tuple[float, ...] = ()


def _loaded(weights: bytes) -> _Champion:
    if not is_pooled(weights):
        return _Champion(from_bytes(weights))
    model = pooled_from_bytes(weights)
    return _Champion(model.network, model.tested, model.weights)


def _champion(champion: _Champion, base: Model, kept: Material) -> tuple[Floats, Floats]:
    """The champion's probabilities on held-back rows, by experts that have not seen them.

    Args:
        champion: as it was published.
        base: its network in the job's terms.
        kept: the held-back rows.
    """
    p, q = probabilities(calibrated(base, kept), kept)
    if champion.tested is None or champion.network.treatments != base.treatments or not len(kept.x):
        return p, q
    logs = np.concatenate([logs_of(p)[None], PanelReader(champion.tested).logs_many(kept.x)])
    return pooled(logs, np.array(champion.weights)), q
