"""Rollouts: a box tips over beyond the angle at which its weight passes its edge, and not before."""

from __future__ import annotations

from math import atan2, degrees

import pytest

from tests.treatments.worlds import DOMAIN, event, script
from wakeful.contracts.treatment import Mind
from wakeful.facts.events import Event
from wakeful.testing import ScriptedMind
from wakeful.treatments.risk_prediction import RiskPrediction, RiskSettings, assess_risk
from wakeful.treatments.rollout import Body, RolloutError, tip_over

pytest.importorskip("mujoco")


@pytest.mark.parametrize(("width_m", "height_m"), [(0.4, 1.0), (0.6, 0.8), (0.2, 1.5)])
def test_it_falls_beyond_the_angle_at_which_its_weight_passes_its_edge(width_m: float, height_m: float) -> None:
    critical = degrees(atan2(width_m, height_m))
    assert tip_over(Body(width_m=width_m, height_m=height_m, tilt_deg=critical - 3.0), 4.0).falls_in_s is None
    over = tip_over(Body(width_m=width_m, height_m=height_m, tilt_deg=critical + 3.0), 4.0)
    assert over.falls_in_s is not None
    further = tip_over(Body(width_m=width_m, height_m=height_m, tilt_deg=critical + 10.0), 4.0)
    assert further.falls_in_s is not None
    assert further.falls_in_s < over.falls_in_s


def test_the_same_body_rolls_out_the_same() -> None:
    body = Body(width_m=0.4, height_m=1.0, tilt_deg=30.0, tilt_rate_dps=5.0)
    assert tip_over(body) == tip_over(body)


@pytest.mark.parametrize("body", [Body(width_m=0.0, height_m=1.0), Body(width_m=1.0, height_m=1.0, tilt_deg=float("nan"))])
def test_what_is_no_body_is_refused_in_words(body: Body) -> None:
    with pytest.raises(RolloutError, match="cannot be rolled out"):
        tip_over(body)


class Rolling:
    """Risk prediction that rolls bodies out."""

    name, version, says, result = "risk_prediction", 1, "rolls out", RiskPrediction

    async def treat(self, about: Event, mind: Mind) -> RiskPrediction:
        """Two seconds ahead."""
        return await assess_risk(about, mind, RiskSettings(rollout_s=2.0))


def test_risk_prediction_says_when_a_tilting_thing_falls() -> None:
    tilting = event("unstable", "cabinet", state="unstable", width_m=0.4, height_m=1.0, tilt_deg=30.0)
    result = ScriptedMind(DOMAIN, "delib", script()).run(Rolling(), tilting)
    assert isinstance(result, RiskPrediction)
    assert result.rollout is not None
    assert result.consequence is not None
    assert result.consequence.what == "it falls over"
    assert "falls over in" in result.says
