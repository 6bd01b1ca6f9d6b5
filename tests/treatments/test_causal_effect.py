"""What the journal says of one arrow, where causes come in clusters."""

from __future__ import annotations

from math import exp, inf

import pytest

from tests.treatments.worlds import episode, event
from wakeful.treatments.causal_effect import Effect, effect_of
from wakeful.treatments.causal_graph import Arrow
from wakeful.treatments.remembering import Recalled

ARROW = Arrow(cause="temperature_trend", effect="current_high", within_s=60.0, strength=0.6, because="heat thins the grease")


def effect(causes: list[float], effects: list[float]) -> Effect:
    """What is said where causes and effects came so many seconds before the event."""
    before = Recalled(tuple(episode(f"c{at:g}", at, kind="temperature_trend") for at in causes), inf)
    after = Recalled(tuple(episode(f"e{at:g}", at) for at in effects), inf)
    return effect_of(event(), ARROW, (ARROW,), {"temperature_trend": before}, after, arrow_cases=4.0, least_cases=3)


def test_windows_of_causes_that_come_together_are_one_stretch_of_time() -> None:
    found = effect([300.0, 302.5, 305.0, 307.5, 310.0], [110.0, 150.0, 280.0, 290.0])
    # 200 s in all, 70 of them within a minute of some cause; two currents came in the other 130
    assert found.base_rate == pytest.approx(1.0 - exp(-2 * 60.0 / 130.0), abs=1e-5)
    assert found.identified


def test_time_after_the_last_effect_is_neither_free_nor_taken() -> None:
    found = effect([300.0, 120.0, 110.0], [100.0, 200.0, 310.0])
    # from 310 to 100 s before: 300 to 240 and 120 to 100 are in a window
    assert found.base_rate == pytest.approx(1.0 - exp(-2 * 60.0 / (210.0 - 80.0)), abs=1e-5)


def test_where_causes_leave_no_free_time_nothing_is_known_of_effects_without_them() -> None:
    found = effect([300.0, 250.0, 200.0, 150.0], [100.0, 120.0, 140.0])
    assert found.base_rate is None
    assert not found.identified
