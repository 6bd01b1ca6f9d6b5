import msgspec
import pytest

from tests.treatments.worlds import BARE, DOMAIN, episode, event, script
from wakeful.facts.asking import Episode
from wakeful.facts.domain import Cause, DomainSpec
from wakeful.testing import ScriptedMind
from wakeful.treatments.causal_analysis import CausalAnalysis, causal_analysis
from wakeful.treatments.causal_graph import arrows_of, chains, confounders


def traced(*episodes: Episode, mode: str = "auto", domain: DomainSpec = DOMAIN, **about: object) -> CausalAnalysis:
    result = ScriptedMind(domain, mode, script(*episodes)).run(causal_analysis, event(**about))  # type: ignore[arg-type]
    assert isinstance(result, CausalAnalysis)
    return result


def warm(id: str, before_s: float, entity: str = "J3") -> Episode:
    return episode(id, before_s, kind="temperature_trend", entity=entity)


def test_an_earlier_event_within_the_usual_delay_is_a_candidate_and_one_outside_is_not() -> None:
    result = traced(warm("in", 120.0), warm("out", 700.0), warm("after", -5.0))
    assert [candidate.event for candidate in result.candidates] == ["in"]
    assert "temperature trend of J3 2 min before" in result.says


def test_the_sooner_and_the_nearer_counts_for_more() -> None:
    result = traced(warm("late", 500.0), warm("soon", 50.0), warm("elsewhere", 50.0, entity="J5"))
    assert [candidate.event for candidate in result.candidates] == ["soon", "elsewhere", "late"]
    assert result.candidates[0].fit == pytest.approx(1.0 - 0.5 * 50 / 600, abs=1e-5)
    assert result.other == pytest.approx(
        (1 - result.candidates[0].score) * (1 - result.candidates[1].score) * (1 - result.candidates[2].score), abs=1e-5
    )


def test_deliberating_follows_the_arrows_back_to_the_root() -> None:
    door = episode("d", 1_000.0, kind="door_open", entity="door")
    assert traced(door).candidates == ()
    result = traced(door, mode="delib")
    assert result.candidates[0].chain == ("door_open", "temperature_trend", "current_high")


def test_with_too_few_cases_the_strength_is_the_written_one_and_said_to_be_unidentified() -> None:
    effect = traced(warm("in", 120.0)).candidates[0].effect
    assert effect.strength == pytest.approx(0.6)
    assert not effect.identified
    assert "only 0 earlier cases" in effect.because
    assert effect.necessity is None


def history(followed: bool) -> list[Episode]:
    """Ten earlier trends, 10 000 s apart and each followed by a high current or not, and three high currents on their own."""
    told = [warm("in", 100.0)]
    for at in range(1, 11):
        told.append(warm(f"w{at:02}", 10_000.0 * at))
        if followed:
            told.append(episode(f"c{at:02}", 10_000.0 * at - 60.0))
    alone = [episode(f"x{at}", 10_000.0 * at + 5_000.0) for at in range(1, 4)]
    return [*told, *alone]


def test_what_was_seen_before_moves_the_strength_and_gives_the_probability_of_necessity() -> None:
    often, never = (traced(*history(followed)).candidates[0].effect for followed in (True, False))
    # twelve of the thirteen currents are recalled: trends older than these can't be told to have had no effect
    assert (often.followed, often.cases) == (8, 8)
    assert often.strength > 0.8
    assert often.identified
    assert often.base_rate is not None
    assert often.necessity == pytest.approx(1.0 - often.base_rate / often.strength, abs=1e-4)
    assert never.followed == 0
    assert never.strength < 0.25


def test_a_common_cause_of_both_leaves_the_effect_unidentified() -> None:
    common = (*DOMAIN.cause, Cause(cause="door_open", effect="current_high", within_s=900.0, strength=0.2))
    domain = msgspec.structs.replace(DOMAIN, cause=common)
    effect = traced(*history(True), domain=domain).candidates[0].effect
    assert not effect.identified
    assert effect.because == "unidentified: door_open may cause both"


def test_the_question_that_would_decide_it_is_asked() -> None:
    result = traced(warm("in", 120.0))
    assert result.question.startswith("would the current high have come without the temperature trend 2 min before")
    assert result.question in result.would_change
    assert traced().question == "was there a temperature trend that was not registered before the current high?"


def test_without_a_causal_graph_the_cause_is_unidentified() -> None:
    assert "unidentified, because domain bare has no causal graph" in traced(domain=BARE).says


def test_what_an_event_leads_to_bears_on_the_forecast() -> None:
    forecast = traced().forecast
    assert forecast is not None
    assert forecast.probabilities["stop"] == pytest.approx((0.4 + 1 / 3) / 2, abs=1e-5)  # beside not knowing
    assert traced().leads_to == {"stop": 0.4}


def test_chains_do_not_go_in_circles_and_arrows_without_a_delay_are_left_out() -> None:
    circle = DomainSpec(
        name="c",
        version=1,
        says="c",
        cause=(
            Cause(cause="a", effect="b", within_s=1.0),
            Cause(cause="b", effect="a", within_s=1.0),
            Cause(cause="c", effect="a", within_s=0.0),
            Cause(cause="a", effect="a", within_s=1.0),
        ),
    )
    arrows = arrows_of(circle)
    assert len(arrows) == 2
    assert [[arrow.cause for arrow in chain] for chain in chains(arrows, "a", 5)] == [["b"]]
    assert confounders(arrows, "b", "a") == ()
