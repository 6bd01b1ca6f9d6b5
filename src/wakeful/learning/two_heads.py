"""The learner of Eq. 8: a shared encoder of 64-64 units, a treatment head and a result head, champion against challenger."""

from __future__ import annotations

from hashlib import blake2b

import msgspec
import numpy as np

from wakeful.contracts.learner import Predictor
from wakeful.facts.experience import ModelCard
from wakeful.facts.inputs import TrainingJob
from wakeful.learning.calibration import POOLED, choose_thresholds, expected_of_advice, mark
from wakeful.learning.material import Flags, Floats, Material, material_of
from wakeful.learning.model import Model, calibrated, continued, probabilities, restandardised
from wakeful.learning.network import Fit, Shape, start, train
from wakeful.learning.novelty import learn_novelty
from wakeful.learning.predictor import TwoHeadsPredictor
from wakeful.learning.score import Score, score
from wakeful.learning.weights import from_bytes, to_bytes

_DIGITS = 9


class TwoHeadsSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The network and its training. The defaults are the paper's (Section IV-A) where it states them.

    ``treatment_loss`` and ``result_loss`` are λ_m and λ_r of Eq. 8. ``tolerance`` is by how much the challenger's held-back loss
    may exceed the champion's, in nats; ``target_error`` what share of automatic decisions may be wrong on held-back rows;
    ``scale_floor`` the least standard deviation a feature is divided by, so that one never seen before doesn't explode;
    ``epochs_again`` the least epochs of a training whose base can't be continued.

    Three settings keep a small network that learns from few and noisy outcomes from learning them by heart. ``kept`` is how much
    of the base's parameters a continued training begins with, the rest being fresh random ones (shrink and perturb, Ash and
    Adams 2020): 1 goes on exactly from the base. ``result_half_life`` is how many rows later an outcome weighs half, since what
    comes of an event drifts faster than how it should be thought about; None for no such weighting. Of the training's
    passes the one with the least held-back loss is kept, among the last and its halves; ``choose_from`` is the least number
    of held-back rows to choose by, and with fewer the last is kept.
    """

    hidden: int = 64
    dropout: float = 0.1
    learning_rate: float = 1e-3
    weight_decay: float = 1e-4
    batch: int = 32
    treatment_loss: float = 1.0
    result_loss: float = 1.0
    tolerance: float = 0.02
    target_error: float = 0.10
    exemplars: int = 256
    scale_floor: float = 0.25
    epochs_again: int = 140
    kept: float = 0.5
    result_half_life: float | None = 200.0
    choose_from: int = 5


class Lineage(msgspec.Struct, frozen=True, kw_only=True):
    """What a training came from: ``continued`` from its base, or ``again`` from scratch though there was one; its epochs."""

    again: bool
    continued: bool
    epochs: int


class TwoHeads:
    """Trains and loads two-headed networks. Without state: the same job gives the same bytes."""

    name = "two_heads"

    def __init__(self, settings: TwoHeadsSettings | None = None) -> None:
        self.settings = settings or TwoHeadsSettings()

    def train(self, job: TrainingJob) -> tuple[ModelCard, bytes]:
        """Train a challenger and compare it with the champion that it came from.

        Both are calibrated on the held-back rows (a temperature a head) before they are compared there. Without held-back rows
        nothing is calibrated, no threshold is chosen, and the challenger is accepted. A base of other features, or one that
        knows a treatment or label that the job doesn't, is not continued: the training starts from scratch and says so.

        Raises:
            ValueError: the job's arrays don't fit together, hold NaN, or leave nothing to learn from; or the base is no model.
        """
        rows, held_back = material_of(job, self.settings.result_half_life)
        learned, kept = rows.rows(~held_back), rows.rows(held_back)
        if not len(learned.x):
            raise ValueError(f"training {job.training} has nothing to learn from: all {len(rows.x)} rows are held back")
        champion = from_bytes(job.base_weights) if job.base_weights else None
        challenger, base, epochs = self.fitted(job, learned, kept, champion)
        weights = to_bytes(challenger)
        own = self._score(challenger, kept)
        other = None if base is None else self._score(calibrated(base, kept), kept)
        lineage = Lineage(again=champion is not None and base is None, continued=base is not None, epochs=epochs)
        return self.card(job, weights, lineage, own, other, probabilities(challenger, kept)), weights

    def fitted(
        self, job: TrainingJob, learned: Material, kept: Material, champion: Model | None
    ) -> tuple[Model, Model | None, int]:
        """A calibrated network, the champion in the job's terms (None where it can't be continued), and after how many epochs."""
        base = None if champion is None else continued(champion, job, self.settings.hidden)
        again = champion is not None and base is None
        fit = self._fit(job.seed, max(job.epochs, self.settings.epochs_again) if again else job.epochs)
        return self._best(self._begin(job, learned, kept, base), learned, kept, fit), base, fit.epochs

    def card(
        self,
        job: TrainingJob,
        weights: bytes,
        lineage: Lineage,
        own: Score | None,
        other: Score | None,
        shares: tuple[Floats, Floats],
    ) -> ModelCard:
        """What is recorded of the training: lineage, how challenger and champion did on held-back rows, thresholds, support.

        Args:
            job: the training.
            weights: the challenger's bytes.
            lineage: what it came from.
            own: the challenger's score.
            other: the champion's; None where there is none to compare with.
            shares: the challenger's probabilities on the held-back rows.
        """
        rows, held_back = material_of(job, self.settings.result_half_life)
        kept = rows.rows(held_back)
        accepted, why = self._verdict(own, other, len(kept.x), job.base_version)
        if lineage.again:
            why = f"started from scratch: its base was made for other features, treatments or labels; {why}"
        seen = rows.treatment[rows.treatment >= 0]
        return ModelCard(
            version=job.training,
            base=job.base_version if lineage.continued else 0,
            watermark=job.watermark,
            seed=job.seed,
            epochs=lineage.epochs,
            blob=blake2b(weights, digest_size=16).hexdigest(),
            accepted=accepted,
            champion_loss=None if other is None else other.loss,
            challenger_loss=None if own is None else own.loss,
            champion_accuracy=None if other is None else other.accuracy,
            challenger_accuracy=None if own is None else own.accuracy,
            held_back=len(kept.x),
            treatment_accuracy=None if own is None else own.treatment_accuracy,
            result_accuracy=None if own is None else own.result_accuracy,
            thresholds=self._thresholds(job, shares, kept, held_back),
            support={name: int((seen == index).sum()) for index, name in enumerate(job.treatments) if (seen == index).any()},
            why=why,
        )

    def load(self, weights: bytes) -> Predictor:
        """The predictor of stored weights. Raises ValueError on bytes that are not a model."""
        return TwoHeadsPredictor(from_bytes(weights))

    def _begin(self, job: TrainingJob, learned: Material, kept: Material, base: Model | None) -> Model:
        """What the training starts from: the base, shrunk and perturbed, or random parameters."""
        mean = np.round(learned.x.mean(axis=0), _DIGITS)
        scale = np.round(np.maximum(learned.x.std(axis=0), self.settings.scale_floor), _DIGITS)
        shape = Shape(learned.x.shape[1], self.settings.hidden, len(job.treatments), len(job.labels))
        theta: Floats = start(shape, job.seed)
        if base is not None:
            share = self.settings.kept
            theta = share * restandardised(base, mean, scale) + (1.0 - share) * theta
        return Model(
            treatments=job.treatments,
            labels=job.labels,
            shape=shape,
            theta=theta,
            mean=mean,
            scale=scale,
            temperatures=(1.0, 1.0),
            novelty=learn_novelty((learned.x - mean) / scale, (kept.x - mean) / scale, self.settings.exemplars),
        )

    def _best(self, untrained: Model, learned: Material, kept: Material, fit: Fit) -> Model:
        """The trained model after that number of passes, among the last and its halves, which does best on held-back rows."""
        stops = {-(-fit.epochs // 2**halvings) for halvings in range(6)} if len(kept.x) >= self.settings.choose_from else set()
        standard = msgspec.structs.replace(learned, x=untrained.standardise(learned.x))
        best: tuple[float, Model] | None = None
        for epoch, theta in enumerate(train(untrained.theta, untrained.shape, standard, fit), 1):
            if epoch == fit.epochs or epoch in stops:
                model = calibrated(msgspec.structs.replace(untrained, theta=theta.copy()), kept)
                found = self._score(model, kept)
                loss = found.loss if found is not None else 0.0
                if best is None or loss <= best[0]:
                    best = (loss, model)
        return untrained if best is None else best[1]

    def _fit(self, seed: int, epochs: int) -> Fit:
        own = self.settings
        return Fit(
            epochs=epochs,
            seed=seed,
            treatment_loss=own.treatment_loss,
            result_loss=own.result_loss,
            dropout=own.dropout,
            learning_rate=own.learning_rate,
            weight_decay=own.weight_decay,
            batch=own.batch,
        )

    def _score(self, model: Model, kept: Material) -> Score | None:
        return score(model, kept, self.settings.treatment_loss, self.settings.result_loss)

    def _verdict(self, own: Score | None, other: Score | None, held_back: int, champion: int) -> tuple[bool, str]:
        """Whether the challenger is accepted, and why."""
        if own is None:
            return True, "nothing was held back to compare on"
        if other is None:
            return True, "there is nothing to compare it with"
        accepted = own.loss <= round(other.loss + self.settings.tolerance, _DIGITS)
        losses = f"held-back loss {own.loss:.3f} against {other.loss:.3f} of version {champion} on {held_back} experiences"
        return accepted, f"{losses}: " + ("not worse" if accepted else f"worse by more than {self.settings.tolerance:g}")

    def _thresholds(self, job: TrainingJob, shares: tuple[Floats, Floats], kept: Material, held_back: Flags) -> dict[str, float]:
        if not len(kept.x):
            return {}
        right = None if job.right is None else np.asarray(job.right, dtype=np.bool_)[held_back]
        marks = mark(*shares, kept)
        thresholds = choose_thresholds(marks, job.treatments, self.settings.target_error, right)
        if job.advised is None or not thresholds:
            return thresholds
        advised = np.asarray(job.advised, dtype=np.int64)[held_back]
        rates = expected_of_advice(marks, kept, advised, job.treatments)
        # Where deliberation is expected to do worse than the model's confidence, it is not asked.
        return {**thresholds, **{name: min(thresholds.get(name, thresholds[POOLED]), rate) for name, rate in rates.items()}}
