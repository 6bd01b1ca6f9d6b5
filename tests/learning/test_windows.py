"""Windows of recent experience: the likest of the newest speak, as of the instant that is asked about."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from tests.learning.worlds import event
from wakeful.contracts.learner import Vector
from wakeful.facts.events import Event
from wakeful.learning.windows import LONGEST, WINDOWS, Windows


class Encoded:
    """Encodes an event as its load, and counts how often."""

    def __init__(self) -> None:
        self.events = 0

    def __call__(self, events: Sequence[Event]) -> Iterable[Vector]:
        self.events += len(events)
        return [np.array([float(each.fields["load"] or 0.0), 1.0]) for each in events]  # type: ignore[arg-type]


def filled(rows: int, encode: Encoded | None = None, ask: bool = False) -> Windows:
    """Loads 0, .1 … .9 in turn; label 1 from .5 on, and after half of the rows the other way round."""
    found = Windows(encode or Encoded(), 2)
    for number in range(rows):
        load = number % 10 / 10
        found.add(event(number, load=load), int(load >= 0.5) ^ int(number >= rows // 2))
        if ask and number % 37 == 0:
            found.shares(np.array([0.3, 1.0]), found.count)
    return found


def test_nothing_is_said_before_the_first_experience() -> None:
    assert Windows(Encoded(), 2).shares(np.array([0.3, 1.0]), 0) is None


def test_the_likest_speak() -> None:
    windows = filled(40)
    shares = windows.shares(np.array([0.9, 1.0]), 20)
    assert shares is not None
    assert shares.shape == (len(WINDOWS), 2)
    assert (shares[:-1].argmax(axis=1) == 1).all()


def test_a_short_window_turns_first_when_the_world_changes() -> None:
    shares = filled(400).shares(np.array([0.9, 1.0]), 260)
    assert shares is not None
    assert shares[0].argmax() == 0
    assert shares[0, 0] > shares[3, 0]


def test_what_came_after_the_decision_does_not_count() -> None:
    windows, then = filled(400), filled(400)
    for number in range(50):
        then.add(event(1000 + number, load=0.9), 0)
    now, later = (each.shares(np.array([0.9, 1.0]), 300) for each in (windows, then))
    assert now is not None
    assert later is not None
    assert (now == later).all()


def test_it_says_the_same_whether_or_not_it_was_asked_before() -> None:
    rows = 5 * LONGEST + 123
    once, often = filled(rows), filled(rows, ask=True)
    for before in (rows, rows - 200, rows - LONGEST):
        first, second = (each.shares(np.array([0.42, 1.0]), before) for each in (once, often))
        assert first is not None
        assert second is not None
        assert (first == second).all()


def test_what_nobody_asks_for_is_never_encoded() -> None:
    encode = Encoded()
    windows = filled(10 * LONGEST, encode)
    assert encode.events == 0
    windows.shares(np.array([0.3, 1.0]), windows.count)
    assert encode.events <= 3 * LONGEST


def test_of_what_is_too_long_ago_nothing_is_said() -> None:
    assert filled(5 * LONGEST).shares(np.array([0.3, 1.0]), LONGEST) is None
