"""Calibration on held-back experience: one temperature a head, and the thresholds of the paper's gate (0.45 … 0.90)."""

from __future__ import annotations

import math
from typing import Final

import msgspec
import numpy as np

from wakeful.learning.material import Flags, Floats, Ints, Material
from wakeful.learning.network import softmax

CANDIDATES: Final = tuple(round(0.45 + 0.05 * step, 2) for step in range(10))
"""The paper's candidate thresholds (Section IV-A)."""
NEVER: Final = 1.01
"""A threshold that no confidence reaches: held-back experience speaks against automatic execution."""
POOLED: Final = "*"
RESULT: Final = "@result"

_EVEN_ROWS = 2.0
_UNTESTED = 0.5
"""What is expected of deliberation on doubtful events before any of its answers to such events has been validated."""
_DOUBT = 1.0
_SURE = 0.02
_FEW = 8
_FEW_OF_ONE = 20
_DIGITS = 9


class Marks(msgspec.Struct, frozen=True):
    """How held-back rows came out: the treatment chosen (n,), both confidences (n,), and whether it was wrong (n,), apart.

    ``judged`` are rows that anything is known of: a right treatment, a wrong one, or an outcome.
    """

    chosen: Ints
    confidence: Floats
    result_confidence: Floats
    treatment_wrong: Flags
    result_wrong: Flags
    judged: Flags

    @property
    def wrong(self) -> Flags:
        """Wrong in the result, or in the treatment where it is labelled."""
        return self.treatment_wrong | self.result_wrong


def temperature(z: Floats, label: Ints, weight: Floats) -> float:
    """The temperature that minimises the weighted cross-entropy of softmax(z / T) over rows with a label; 1 without any.

    As if two further rows had come out evenly over all classes: a handful of rows that all came out as predicted doesn't make
    the network certain. Golden-section search on ln T within [0.25, 8]; the loss has one minimum there.

    Args:
        z: logits, (n, k).
        label: indices or -1, (n,).
        weight: of each row, (n,); only their proportions count.
    """
    known = label >= 0
    n = int(known.sum())
    if n == 0 or float(weight[known].sum()) <= 0.0:
        return 1.0
    z, label = z[known], label[known]
    share = weight[known] * (n / weight[known].sum())
    rows = np.arange(n)

    def loss(log_temperature: float) -> float:
        logs = np.log(np.maximum(softmax(z / math.exp(log_temperature)), 1e-300))
        return float(-(share * logs[rows, label]).sum() - _EVEN_ROWS * logs.mean())

    low, high, golden = math.log(0.25), math.log(8.0), (math.sqrt(5.0) - 1.0) / 2.0
    for _ in range(40):
        left, right = high - golden * (high - low), low + golden * (high - low)
        if loss(left) <= loss(right):
            high = right
        else:
            low = left
    return round(math.exp((low + high) / 2.0), 6)


def mark(treatments: Floats, labels: Floats, rows: Material) -> Marks:
    """Compare calibrated probabilities (n, k) and (n, l) with what is known of held-back rows."""
    chosen = np.argmax(np.round(treatments, _DIGITS), axis=1)
    said = np.argmax(np.round(labels, _DIGITS), axis=1)
    labelled, refuted, decided = rows.treatment >= 0, rows.refuted >= 0, rows.result >= 0
    return Marks(
        chosen=chosen,
        confidence=np.round(treatments.max(axis=1), 6),
        result_confidence=np.round(labels.max(axis=1), 6),
        treatment_wrong=np.where(labelled, chosen != rows.treatment, refuted & (chosen == rows.refuted)),
        result_wrong=decided & (said != rows.result),
        judged=labelled | refuted | decided,
    )


def choose_thresholds(
    marks: Marks, treatments: tuple[str, ...], target_error: float, right: Flags | None = None
) -> dict[str, float]:
    """The thresholds of both heads' confidence, chosen on held-back rows among the paper's candidates.

    Of the pairs that may do, the one that lets most rows pass, and of equal ones the stricter. A pair may do if of the rows that
    pass the share of wrong ones, estimated as (wrong + 1) / (rows + 2), is at most ``target_error``; or if it is at most
    what was wrong of what was concluded on these very rows at the time: what deliberation got wrong as well is no reason to
    deliberate. A treatment that was chosen for at least 20 rows gets a threshold of its own, by the same rule and beside
    the same threshold of the result.

    Args:
        marks: how the held-back rows came out.
        treatments: the names that ``marks.chosen`` counts.
        target_error: the share of automatic decisions that may be wrong.
        right: whether what was concluded at the time was right, (n,); None where that is not known.

    Returns:
        Thresholds by treatment, ``*`` and ``@result``; empty below 8 judged rows: too few to choose by.
    """
    judged = marks.judged
    if int(judged.sum()) < _FEW:
        return {}
    confidence, result, chosen = marks.confidence[judged], marks.result_confidence[judged], marks.chosen[judged]
    wrong = marks.wrong[judged]
    was_wrong = None if right is None else ~right[judged]

    def may_do(passing: Flags) -> bool:
        """Whether so few of these decisions were wrong, or no more than were wrong at the time."""
        rows = int(passing.sum())
        if rows == 0:
            return False
        errors = int(wrong[passing].sum())
        if (errors + 1) / (rows + 2) <= target_error:
            return True
        return was_wrong is not None and rows >= _FEW and errors <= int(was_wrong[passing].sum())

    best = (0, NEVER, NEVER)
    for needed_result in CANDIDATES:
        for needed in CANDIDATES:
            passing = (confidence >= needed) & (result >= needed_result)
            if may_do(passing):
                best = max(best, (int(passing.sum()), needed_result, needed))
    passed, needed_result, pooled = best
    if not passed:
        # No common pair will do; a single treatment may still be reliable beside the strictest demand on the result.
        needed_result = CANDIDATES[-1]
    thresholds = {POOLED: pooled, RESULT: needed_result}
    for index, name in enumerate(treatments):
        own = chosen == index
        if int(own.sum()) >= _FEW_OF_ONE:
            passing_at = {needed: own & (confidence >= needed) & (result >= needed_result) for needed in CANDIDATES}
            doing = [(int(rows.sum()), needed) for needed, rows in passing_at.items() if may_do(rows)]
            thresholds[name] = max(doing, default=(0, NEVER))[1]
    return thresholds


def expected_of_advice(marks: Marks, rows: Material, advised: Ints, treatments: tuple[str, ...]) -> dict[str, float]:
    """How often deliberation is right at least where the model is in doubt, by the treatment that the model ranks first.

    Asking pays where this exceeds the model's own confidence, and nowhere else. It is one standard deviation below what is
    expected: a reasoner has to have shown that it does better before it is asked in earnest. Learned from held-back rows on which
    deliberation's answer was validated. A row counts as much as the model doubted it (a fiftieth at least): how the reasoner does
    on easy events says little of those that it would be asked about. Each treatment's own rate is drawn towards that of all.

    Args:
        marks: how the held-back rows came out.
        rows: what is known of them.
        advised: the treatment that deliberation chose, (n,), or -1.
        treatments: the names that ``marks.chosen`` and ``advised`` count.

    Returns:
        Rates by treatment, and ``*`` for all; empty where nothing was asked.
    """
    known = (advised >= 0) & (rows.treatment >= 0)
    if not known.any():
        return {}
    right = (advised == rows.treatment)[known].astype(np.float64)
    doubt = np.maximum(_SURE, 1.0 - marks.confidence[known])
    pooled = (float((doubt * right).sum()) + _DOUBT * _UNTESTED) / (float(doubt.sum()) + _DOUBT)
    rates = {POOLED: _at_least(pooled, float(doubt.sum()) + _DOUBT)}
    for index, name in enumerate(treatments):
        own = marks.chosen[known] == index
        cases = float(doubt[own].sum()) + _DOUBT
        rates[name] = _at_least((float((doubt * right)[own].sum()) + _DOUBT * pooled) / cases, cases)
    return rates


def _at_least(rate: float, cases: float) -> float:
    """A standard deviation below the rate: that of a beta distribution which so many cases have made."""
    return round(max(0.0, rate - math.sqrt(rate * (1.0 - rate) / (cases + 1.0))), 6)
