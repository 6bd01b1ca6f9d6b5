"""Reliability, expected calibration error, and risk against coverage."""

from __future__ import annotations

import pytest

from wakeful.experiments.exp1_shape import Cell, calibration_error, deferral_curve, oracle_curve, reliability


def cell(confidence: float, right: bool) -> Cell:
    return Cell(confidence=confidence, right=right, gained=right)


def test_a_selector_as_right_as_it_says_has_no_calibration_error() -> None:
    cells = [cell(0.75, place < 75) for place in range(100)]
    assert calibration_error(reliability(cells)) == pytest.approx(0.0)


def test_overconfidence_is_the_distance_from_what_was_right() -> None:
    cells = [cell(0.95, place < 6) for place in range(10)]
    assert calibration_error(reliability(cells)) == pytest.approx(0.35)


def test_full_confidence_falls_into_the_last_bin() -> None:
    assert [each.events for each in reliability([cell(1.0, True), cell(0.95, True), cell(0.05, False)])] == [1, 2]


def test_risk_rises_from_the_most_confident_and_ends_at_the_share_that_is_wrong() -> None:
    curve = deferral_curve([cell(0.9, True), cell(0.8, False), cell(0.7, True), cell(0.6, False)])
    assert curve == [(0.25, 0.0), (0.5, 0.5), (0.75, pytest.approx(1 / 3)), (1.0, 0.5)]


def test_events_of_equal_confidence_are_covered_together() -> None:
    assert [share for share, _ in deferral_curve([cell(0.9, True), cell(0.9, False), cell(0.5, True)])] == [2 / 3, 1.0]


def test_the_oracle_covers_what_is_wrong_last() -> None:
    assert oracle_curve([cell(0.9, False), cell(0.5, True)]) == [(0.5, 0.0), (1.0, 0.5)]
