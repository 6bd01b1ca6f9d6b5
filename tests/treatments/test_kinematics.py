import pytest
from hypothesis import given

from tests.treatments.worlds import fields as any_fields
from wakeful.facts.values import Field
from wakeful.treatments.kinematics import HORIZON_S, countdown


@pytest.mark.parametrize(
    ("fields", "what", "in_s"),
    [
        ({"ttc_s": 1.5}, "contact", 1.5),
        ({"distance_m": 2.0, "speed_mps": 0.5}, "contact", 4.0),
        ({"distance_m": 2.0, "closing_speed_mps": 1.0, "speed_mps": 0.5}, "contact", 2.0),
        ({"tilt_deg": 10.0, "tilt_rate_dps": 5.0, "tilt_limit_deg": 30.0}, "it tips over", 4.0),
        ({"tilt_deg": 10.0, "tilt_rate_dps": -5.0, "tilt_limit_deg": 30.0}, "it tips over", 8.0),
        ({"value": 60.0, "slope_per_s": 0.5, "limit": 70.0}, "the limit is reached", 20.0),
        ({"value": 60.0, "slope_per_min": 30.0, "limit": 70.0}, "the limit is reached", 20.0),
        ({"value": 0.5, "slope_per_s": -0.1, "low": 0.2}, "the limit is reached", 3.0),
        ({"distance_m": 2.0, "speed_mps": 0.5, "ttc_s": 1.0}, "contact", 1.0),
    ],
)
def test_the_earliest_consequence_is_told(fields: dict[str, Field], what: str, in_s: float) -> None:
    found = countdown(fields)
    assert found is not None
    assert found.what == what
    assert found.in_s == pytest.approx(in_s)


@pytest.mark.parametrize(
    "fields",
    [
        {"distance_m": 2.0, "speed_mps": 0.0},
        {"distance_m": 2.0, "speed_mps": -1.0},
        {"distance_m": 2.0},
        {"value": 80.0, "slope_per_s": 0.5, "limit": 70.0},
        {"value": 60.0, "slope_per_s": 0.0, "limit": 70.0},
        {"value": 0.0, "slope_per_s": 1e-9, "limit": 70.0},
        {"tilt_deg": 10.0, "tilt_rate_radps": 5.0, "tilt_limit_deg": 30.0},
        {"distance_m": "near", "speed_mps": True},
    ],
)
def test_where_nothing_follows_nothing_is_told(fields: dict[str, Field]) -> None:
    assert countdown(fields) is None


@given(any_fields)
def test_no_fields_whatever_make_it_fail_or_look_into_the_past(fields: dict[str, Field]) -> None:
    found = countdown(fields)
    assert found is None or 0.0 <= found.in_s <= HORIZON_S
