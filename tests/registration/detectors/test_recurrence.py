"""The point of the cycle at which something went wrong before."""

from __future__ import annotations

from tests.registration.watching import detector, seen
from wakeful.contracts.detector import Detector, Found
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


def stops(cycles: int, at: dict[int, int]) -> list[list[dict[str, Value]]]:
    return [[{"stop": at.get(cycle) == row} for row in range(20)] for cycle in range(cycles)]


def test_the_point_of_an_earlier_stop_is_announced_ahead_of_it() -> None:
    watcher = detector("recurrence", ("t/stop",), cycle="t/cycle", ahead_s=5.0, within=2)
    found = work(watcher, stops(6, {1: 12}))
    assert [(cycle, row) for cycle, row, _ in found] == [(2, 7), (3, 7)]
    assert found[0][2].fields["ahead_s"] == 5.0
    assert found[0][2].fields["times"] == 1


def test_it_counts_how_often_and_is_silent_while_the_flag_is_up() -> None:
    watcher = detector("recurrence", ("t/stop",), cycle="t/cycle", ahead_s=3.0, within=3, least=2)
    found = work(watcher, stops(8, {1: 12, 2: 12, 3: 10}))
    # before cycle 3 it happened twice at 12 s, before cycle 4 three times near there, before cycle 5 still twice
    assert [(cycle, row, item.fields["times"]) for cycle, row, item in found] == [(3, 9, 2), (4, 9, 3), (5, 9, 2)]


def test_a_pause_stops_the_clock_of_the_cycle() -> None:
    watcher = detector("recurrence", ("t/stop",), cycle="t/cycle", ahead_s=2.0, within=1, pause=["t/stop"])
    cycles = stops(3, {1: 12})
    cycles[2] = [{"stop": row in (3, 4, 5)} for row in range(25)]
    found = work(watcher, cycles)
    # eleven seconds of work came before the stop; the three of standing still do not count towards them
    assert [(cycle, row) for cycle, row, _ in found] == [(2, 12)]
