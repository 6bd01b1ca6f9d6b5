"""Draws for audits: of known probability, repeatable, and blind."""

from __future__ import annotations

import math

from wakeful.facts.events import event_id
from wakeful.selection.audits import drawn, lot

IDS = [event_id("robot", "digest", position, "contact", 0) for position in range(20_000)]


def test_as_many_events_are_drawn_as_the_probability_says() -> None:
    for probability in (0.05, 0.2, 0.5):
        share = sum(drawn(7, each, probability) for each in IDS) / len(IDS)
        assert abs(share - probability) < 4 * math.sqrt(probability * (1 - probability) / len(IDS))


def test_the_same_event_has_the_same_lot_in_every_run_and_another_under_another_seed() -> None:
    assert [lot(3, each) for each in IDS[:50]] == [lot(3, each) for each in IDS[:50]]
    together = sum(drawn(3, each, 0.5) == drawn(4, each, 0.5) for each in IDS) / len(IDS)
    assert abs(together - 0.5) < 0.02


def test_what_is_drawn_at_one_probability_is_drawn_at_every_higher_one() -> None:
    assert all(drawn(0, each, 0.6) for each in IDS[:2000] if drawn(0, each, 0.2))
    assert all(drawn(0, each, 1.0) and not drawn(0, each, 0.0) for each in IDS)
