"""How a model does on held-back experience: what champion and challenger are compared by."""

from __future__ import annotations

import msgspec

from wakeful.learning.calibration import mark
from wakeful.learning.material import Flags, Floats, Material
from wakeful.learning.model import Model, probabilities
from wakeful.learning.network import result_losses, treatment_losses

_DIGITS = 9


class Score(msgspec.Struct, frozen=True):
    """How a model does on held-back rows: its loss, and how often treatment, result, and both were right."""

    loss: float
    treatment_accuracy: float | None
    result_accuracy: float | None
    accuracy: float


def score(model: Model, rows: Material, treatment_loss: float = 1.0, result_loss: float = 1.0) -> Score | None:
    """How the model does on these rows, by λ_m L_m + λ_r L_r (Eq. 8); None where nothing is known of any of them."""
    return score_of(*probabilities(model, rows), rows, treatment_loss, result_loss)


def score_of(p: Floats, q: Floats, rows: Material, treatment_loss: float = 1.0, result_loss: float = 1.0) -> Score | None:
    """The same for probabilities over treatments (n, k) and labels (n, l), whoever gave them."""
    marks = mark(p, q, rows) if len(rows.x) else None
    if marks is None or not marks.judged.any():
        return None
    loss = 0.0
    for share, (each, weight) in (
        (treatment_loss, treatment_losses(p, rows)),
        (result_loss, result_losses(q, rows)),
    ):
        total = float(weight.sum())
        loss += share * float((each * weight).sum()) / total if total > 0.0 else 0.0
    told, decided = (rows.treatment >= 0) | (rows.refuted >= 0), rows.result >= 0
    return Score(
        loss=round(loss, _DIGITS),
        treatment_accuracy=_share(~marks.treatment_wrong[told]),
        result_accuracy=_share(~marks.result_wrong[decided]),
        accuracy=_share(~marks.wrong[marks.judged]) or 0.0,
    )


def _share(right: Flags) -> float | None:
    return round(float(right.mean()), _DIGITS) if right.size else None
