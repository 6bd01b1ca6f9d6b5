"""Temperatures and thresholds."""

from __future__ import annotations

import numpy as np
import pytest

from wakeful.learning.calibration import (
    CANDIDATES,
    NEVER,
    POOLED,
    RESULT,
    Marks,
    choose_thresholds,
    expected_of_advice,
    mark,
    temperature,
)
from wakeful.learning.material import Material
from wakeful.learning.network import softmax


def marks(confidence: np.ndarray, wrong: np.ndarray, chosen: np.ndarray | None = None) -> Marks:
    rows = len(confidence)
    return Marks(
        chosen=np.zeros(rows, dtype=np.int64) if chosen is None else chosen,
        confidence=confidence,
        result_confidence=np.full(rows, 0.95),
        treatment_wrong=wrong,
        result_wrong=np.zeros(rows, dtype=bool),
        judged=np.ones(rows, dtype=bool),
    )


def test_the_candidates_are_the_papers() -> None:
    assert CANDIDATES == (0.45, 0.5, 0.55, 0.6, 0.65, 0.7, 0.75, 0.8, 0.85, 0.9)


@pytest.mark.parametrize("true", [0.5, 1.0, 3.0])
def test_a_temperature_undoes_too_much_or_too_little_confidence(true: float) -> None:
    random = np.random.default_rng(0)
    z = random.normal(size=(6000, 3)) * 2.0
    p = softmax(z / true)
    label = (random.random(6000)[:, None] > p.cumsum(axis=1)).sum(axis=1)
    assert temperature(z, label, np.ones(6000)) == pytest.approx(true, rel=0.1)


def test_a_few_rows_that_came_out_as_predicted_do_not_make_the_network_certain() -> None:
    z = np.array([[4.0, 0.0], [0.0, 4.0], [4.0, 0.0]])
    found = temperature(z, np.array([0, 1, 0]), np.ones(3))
    assert softmax(z[0] / found)[0] < 0.9
    many = temperature(np.tile(z, (60, 1)), np.tile([0, 1, 0], 60), np.ones(180))
    assert softmax(z[0] / many)[0] > 0.98


def test_without_labelled_rows_the_temperature_is_left_alone() -> None:
    assert temperature(np.eye(3), np.full(3, -1), np.ones(3)) == 1.0
    assert temperature(np.zeros((0, 3)), np.zeros(0, dtype=np.int64), np.zeros(0)) == 1.0


def test_the_threshold_is_the_lowest_that_keeps_the_errors_under_the_target() -> None:
    confidence = np.linspace(0.4, 1.0, 400)
    wrong = confidence < 0.7
    chosen = choose_thresholds(marks(confidence, wrong), ("a",), 0.10)
    passing = confidence >= chosen[POOLED]
    assert (wrong[passing].sum() + 1) / (passing.sum() + 2) <= 0.10
    looser = confidence >= chosen[POOLED] - 0.05
    assert (wrong[looser].sum() + 1) / (looser.sum() + 2) > 0.10
    assert chosen[RESULT] == 0.9


def test_where_no_candidate_will_do_nothing_is_automatic() -> None:
    confidence = np.linspace(0.4, 1.0, 100)
    assert choose_thresholds(marks(confidence, np.arange(100) % 2 == 0), ("a",), 0.1) == {POOLED: NEVER, RESULT: 0.9, "a": NEVER}


def test_what_was_got_wrong_anyway_is_no_reason_to_deliberate() -> None:
    confidence, wrong = np.linspace(0.5, 0.9, 100), np.arange(100) % 2 == 0
    assert choose_thresholds(marks(confidence, wrong), ("a",), 0.1)[POOLED] == NEVER
    assert choose_thresholds(marks(confidence, wrong), ("a",), 0.1, right=~wrong)[POOLED] == 0.5
    assert choose_thresholds(marks(confidence, wrong), ("a",), 0.1, right=np.ones(100, dtype=bool))[POOLED] == NEVER


def test_a_reliable_treatment_beside_an_unreliable_one_gets_its_own_threshold() -> None:
    chosen = np.repeat([0, 1, 2], [100, 100, 5])
    wrong = (chosen == 1) & (np.arange(205) % 2 == 0)
    found = choose_thresholds(marks(np.full(205, 0.8), wrong, chosen), ("a", "b", "c"), 0.1)
    assert found["a"] == 0.8
    assert found["b"] == NEVER
    assert "c" not in found


def test_few_rows_choose_nothing() -> None:
    assert choose_thresholds(marks(np.full(5, 0.9), np.zeros(5, dtype=bool)), ("a",), 0.1) == {}


def test_a_row_is_wrong_in_its_treatment_or_in_its_result() -> None:
    p = np.array([[0.9, 0.1], [0.9, 0.1], [0.9, 0.1], [0.9, 0.1]])
    q = np.array([[0.8, 0.2]] * 4)
    rows = Material(
        x=np.zeros((4, 1)),
        treatment=np.array([0, 1, -1, -1]),
        result=np.array([1, 0, 0, -1]),
        refuted=np.array([-1, -1, 0, -1]),
        weight=np.ones(4),
        result_weight=np.ones(4),
    )
    found = mark(p, q, rows)
    assert found.treatment_wrong.tolist() == [False, True, True, False]
    assert found.result_wrong.tolist() == [True, False, False, False]
    assert found.judged.tolist() == [True, True, True, False]


def advised(rows: int, right: int, confidence: float) -> dict[str, float]:
    """What is expected of a reasoner that was right on so many rows of treatment a, at that confidence of the model."""
    truth = np.zeros(rows, dtype=np.int64)
    none, ones = np.full(rows, -1), np.ones(rows)
    known = Material(x=np.zeros((rows, 1)), treatment=truth, result=none, refuted=none, weight=ones, result_weight=ones)
    said = np.where(np.arange(rows) < right, 0, 1)
    found = marks(np.full(rows, confidence), np.zeros(rows, dtype=bool))
    return expected_of_advice(found, known, said, ("a", "b"))


def test_a_reasoner_has_to_have_shown_that_it_is_right() -> None:
    few, many = advised(4, 4, 0.5), advised(400, 400, 0.5)
    assert few["a"] < 0.85 < 0.95 < many["a"]
    assert few["b"] < few["a"]


def test_more_answers_bring_what_is_expected_nearer_to_the_rate() -> None:
    found = [advised(rows, rows // 2, 0.5)["a"] for rows in (10, 100, 10_000)]
    assert found == sorted(found)
    assert found[-1] == pytest.approx(0.5, abs=0.02)


def test_right_answers_where_the_model_is_sure_say_little() -> None:
    assert advised(40, 40, 1.0)["a"] < advised(40, 40, 0.5)["a"]


def test_nothing_is_expected_where_nothing_was_asked() -> None:
    none = np.full(3, -1)
    known = Material(
        x=np.zeros((3, 1)),
        treatment=np.zeros(3, dtype=np.int64),
        result=none,
        refuted=none,
        weight=np.ones(3),
        result_weight=np.ones(3),
    )
    assert expected_of_advice(marks(np.full(3, 0.9), np.zeros(3, dtype=bool)), known, none, ("a",)) == {}
