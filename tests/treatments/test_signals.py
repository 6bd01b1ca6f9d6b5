"""Rules on signals: robustness as it is defined, and a hazard that is open only where its rule is broken."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from tests.treatments.worlds import DOMAIN, event, script
from wakeful.facts.domain import Hazard
from wakeful.testing import ScriptedMind
from wakeful.treatments.risk_prediction import RiskPrediction, risk_prediction
from wakeful.treatments.signals import SignalError, margin

pytest.importorskip("rtamt")

FORCE = Hazard(
    name="stop", severity=2, exposure=0.8, likelihood=0.2, when={"kind": "current_high"}, rule="always[0:3](force_n < 40.0)"
)


@given(st.lists(st.floats(-100.0, 100.0), min_size=4, max_size=20))
def test_always_below_a_bound_is_robust_by_the_least_distance_to_it(trace: list[float]) -> None:
    found = margin("always[0:3](force_n < 40.0)", {"force_n": tuple(trace)})
    assert found == pytest.approx(min(40.0 - each for each in trace[:4]), rel=1e-4, abs=1e-6)


def test_a_number_stands_for_a_signal_that_does_not_change_and_a_missing_signal_for_nobody_knows() -> None:
    assert margin("always[0:2](force_n < limit_n)", {"force_n": (1.0, 2.0, 3.0), "limit_n": 5.0}) == pytest.approx(2.0)
    assert margin("always[0:2](force_n < limit_n)", {"force_n": (1.0, 2.0, 3.0)}) is None
    assert margin("always[0:2](force_n < 3)", {"force_n": 2.0}) is None


def test_a_rule_that_cannot_be_read_is_named() -> None:
    with pytest.raises(SignalError, match="cannot be read as signal temporal logic"):
        margin("always[0:2](force_n < ", {"force_n": (1.0, 2.0, 3.0)})


@pytest.mark.parametrize(("trace", "opened"), [((10.0, 20.0, 30.0, 39.0), False), ((10.0, 20.0, 45.0, 10.0), True)])
def test_a_hazard_with_a_rule_is_open_where_the_signals_break_it(trace: tuple[float, ...], opened: bool) -> None:
    domain = replace(DOMAIN, hazard=(FORCE,))
    result = ScriptedMind(domain, "auto", script()).run(risk_prediction, event(force_n=trace))
    assert isinstance(result, RiskPrediction)
    rows = [row for row in result.hazards if row.listed]
    assert bool(rows) is opened
    assert not opened or rows[0].margin == pytest.approx(-5.0)
