"""A limit is passed, and stays so until well inside again."""

from __future__ import annotations

import pytest

from tests.registration.watching import detector, founds
from wakeful.contracts.domain import DomainError
from wakeful.facts.events import Phase


def test_a_limit_is_passed_once_until_well_inside_again() -> None:
    values = [1.0, 5.0, 4.8, 4.9, 5.1, 3.9, 5.2]
    found = founds(detector("threshold", above=4.85, back=0.5), values)
    assert [(index, item.phase) for index, item in found] == [(1, Phase.RAISED), (5, Phase.CLEARED), (6, Phase.RAISED)]


def test_a_limit_must_be_passed_for_long_enough() -> None:
    found = founds(detector("threshold", below=1.0, hold_s=3.0), [2.0, 0.5, 0.5, 2.0, 0.5, 0.5, 0.5, 0.5, 0.5])
    assert [index for index, _ in found] == [7]


def test_a_threshold_without_a_limit_is_refused() -> None:
    with pytest.raises(DomainError, match=r"give settings\.above or settings\.below"):
        detector("threshold")
