import msgspec
import pytest

from tests.treatments.worlds import BARE, DOMAIN, NOW_S, episode, event, script
from wakeful.facts.domain import DomainSpec, Hazard, OutcomeSpec
from wakeful.facts.evidence import Evidence
from wakeful.facts.time import to_ns
from wakeful.testing import ScriptedMind
from wakeful.treatments.risk_prediction import RiskPrediction, risk_prediction


def assessed(mind: ScriptedMind, **fields: object) -> RiskPrediction:
    result = mind.run(risk_prediction, event(**fields))  # type: ignore[arg-type]
    assert isinstance(result, RiskPrediction)
    return result


def test_only_hazards_whose_conditions_hold_are_open_and_the_worst_is_said() -> None:
    calm = assessed(ScriptedMind(DOMAIN, "auto", script()))
    assert [row.hazard for row in calm.hazards] == ["stop"]
    shaky = assessed(ScriptedMind(DOMAIN, "auto", script()), state="unstable")
    assert [row.hazard for row in shaky.hazards] == ["falls", "stop"]
    assert "high risk (falls): 30 % by the hazard table alone, no like case has ended yet" in shaky.says
    assert shaky.proposes[0].effect == "keep away"


def test_the_likelihood_starts_at_the_table_and_moves_with_how_like_cases_ended() -> None:
    table = assessed(ScriptedMind(DOMAIN, "auto", script())).hazards[0]
    assert table.likelihood == pytest.approx(0.2)
    assert (table.cases, table.harmed) == (0.0, 0.0)
    stops = tuple(episode(f"s{at}", 100.0 + at, outcome="stop", likeness=1.0) for at in range(8))
    risky = assessed(ScriptedMind(DOMAIN, "auto", script(*stops))).hazards[0]
    assert risky.likelihood == pytest.approx((0.2 * 4 + 8) / (4 + 8))
    assert risky.low < risky.likelihood < risky.high
    assert risky.high - risky.low < table.high - table.low


def test_an_outcome_that_is_not_this_hazard_counts_as_a_case_without_harm() -> None:
    drops = tuple(episode(f"d{at}", 100.0 + at, outcome="drop", likeness=1.0) for at in range(8))
    row = assessed(ScriptedMind(DOMAIN, "auto", script(*drops))).hazards[0]
    assert row.likelihood == pytest.approx(0.2 * 4 / 12)


def test_of_several_labels_none_is_taken_for_harm_unless_the_table_says_so() -> None:
    outcome = OutcomeSpec(labels=("none", "cleared", "escalated"))
    silent = Hazard(name="hits somebody", severity=4, exposure=0.2, likelihood=0.1)
    telling = msgspec.structs.replace(silent, outcomes=("escalated",))
    ended = tuple(episode(f"c{at}", 100.0 + at, outcome="cleared", likeness=1.0) for at in range(6))
    for hazard, cases in ((silent, 0.0), (telling, 6.0)):
        domain = DomainSpec(name="d", version=1, says="d", outcome=outcome, hazard=(hazard,))
        row = assessed(ScriptedMind(domain, "auto", script(*ended))).hazards[0]
        assert row.cases == cases
        assert row.likelihood <= 0.1 + 1e-9


def test_without_a_table_it_says_what_may_follow_and_does_not_call_it_a_risk() -> None:
    domain = msgspec.structs.replace(DOMAIN, hazard=())
    ended = tuple(episode(f"c{at}", 100.0 + at, outcome="stop" if at % 2 else "none") for at in range(6))
    result = assessed(ScriptedMind(domain, "auto", script(*ended)))
    assert "no hazard of the table is open" in result.says
    assert "stop may follow" in result.says
    assert not result.hazards[0].listed
    assert result.proposes == ()
    unknown = assessed(ScriptedMind(BARE, "auto", script()))
    assert "its risk is unknown" in unknown.says
    assert unknown.confidence == 0.1


def test_the_time_to_consequence_bounds_how_long_the_control_is_proposed() -> None:
    result = assessed(ScriptedMind(DOMAIN, "auto", script()), state="unstable", distance_m=1.0, speed_mps=0.5)
    assert result.consequence is not None
    assert result.consequence.in_s == 2.0
    assert "contact in 2 s" in result.says
    [proposal] = result.proposes
    assert proposal.valid_until_ns == to_ns(NOW_S + 2.0)
    assert proposal.authority == "supervisor"


def test_a_fresh_reading_turns_a_value_into_a_trend_and_a_time_to_its_limit() -> None:
    fresh = Evidence(id="h", topic="heat", key="arm/temperature_3", at_ns=to_ns(NOW_S + 4.0), value=msgspec.Raw(b"64.0"))
    mind = ScriptedMind(DOMAIN, "delib", script(evidence=(fresh,)))
    result = assessed(mind, channel="arm/temperature_3", value=60.0, limit=70.0)
    assert result.asked == ("heat/arm/temperature_3",)
    assert result.consequence is not None
    assert result.consequence.in_s == pytest.approx(6.0)
    assert "by another reading" in result.says


def test_it_asks_only_for_fresh_readings_of_the_events_own_channel() -> None:
    mind = ScriptedMind(DOMAIN, "delib", script())
    assert assessed(mind, value=60.0).asked == ()
    assert mind.now_s == NOW_S


def test_it_says_how_many_outcomes_would_halve_the_interval() -> None:
    row = assessed(ScriptedMind(DOMAIN, "auto", script())).hazards[0]
    assert row.cases_to_halve == 15  # 3 × (4 + 1)
    assert "about 15 more like cases" in assessed(ScriptedMind(DOMAIN, "auto", script())).halves


def test_an_outcome_that_no_open_hazard_speaks_of_is_told_beside_the_table() -> None:
    drops = tuple(episode(f"d{at}", 100.0 + at, outcome="drop", likeness=1.0) for at in range(8))
    result = assessed(ScriptedMind(DOMAIN, "auto", script(*drops)))
    assert [(row.hazard, row.listed) for row in result.hazards] == [("stop", True), ("drop", False)]
    assert "medium risk (stop): 7 % by the hazard table and how like cases ended (90 % credible" in result.says
    assert "drop may follow: 94 % by how like cases ended" in result.says


def test_one_outcome_speaks_once_however_it_was_recalled() -> None:
    result = assessed(ScriptedMind(DOMAIN, "auto", script(episode("s", 0.0, outcome="stop"))))
    heard = [each for each in result.rests_on if each.startswith("forecast: ") and "hazard table" not in each]
    assert heard == ["forecast: not knowing, weighing 1 cases", "forecast: the last current_high events, weighing 1 cases"]
