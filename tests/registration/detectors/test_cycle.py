"""A cycle of work unlike its predecessors."""

from __future__ import annotations

from random import Random

import pytest

from tests.registration.watching import detector, seen
from wakeful.contracts.detector import Detector, Found
from wakeful.contracts.domain import DomainError
from wakeful.facts.values import Value


def work(watcher: Detector, cycles: list[list[dict[str, Value]]]) -> list[tuple[int, int, Found]]:
    """Feed cycles of rows, one a second: (cycle, row within it, what was found)."""
    found, at = [], 0
    for cycle, rows in enumerate(cycles):
        for row, values in enumerate(rows):
            for item in watcher.observe(seen(at, float(at), cycle=cycle, **values)):
                assert isinstance(item, Found)
                found.append((cycle, row, item))
            at += 1
    return found


def usual(random: Random) -> list[dict[str, Value]]:
    return [{"x": 5.0 * (row == 3) + random.gauss(0, 0.1)} for row in range(random.choice((7, 8, 8, 8, 9)))]


def test_a_cycle_unlike_its_predecessors_is_registered_at_its_end_with_its_worst_measure() -> None:
    random = Random(0)
    cycles = [usual(random) for _ in range(60)]
    cycles[50][3] = {"x": -9.0}
    found = work(detector("cycle", ("t/x",), cycle="t/cycle", width=4.0), cycles)
    assert [(cycle, row) for cycle, row, _ in found] == [(51, 0)]
    assert found[0][2].fields["worst"] == "t/x least"
    assert found[0][2].fields["cycle"] == 50


def test_a_cycle_that_goes_on_for_too_long_is_registered_while_it_lasts() -> None:
    random = Random(0)
    cycles = [usual(random) for _ in range(60)]
    cycles[40] = [{"x": 0.0}] * 40
    (found,) = work(detector("cycle", ("t/x",), cycle="t/cycle", width=6.0), cycles)
    cycle, row, item = found
    assert cycle == 40
    assert 10 <= row < 30
    assert item.fields["overdue"] is True


@pytest.mark.parametrize("name", ["cycle", "recurrence"])
def test_a_detector_of_cycles_needs_to_know_the_cycle(name: str) -> None:
    with pytest.raises(DomainError, match=r"give settings\.cycle"):
        detector(name)
