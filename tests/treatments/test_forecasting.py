import pytest

from tests.treatments.worlds import BARE, DOMAIN, episode, event, script
from wakeful.facts.asking import Reply
from wakeful.testing import ScriptedMind
from wakeful.treatments.forecasting import Voice, lately_voice, model_voice, once, pooled, prior_voice, recalled_voice


def mind(mode: str = "auto", **told: object) -> ScriptedMind:
    return ScriptedMind(DOMAIN, mode, script(**told))  # type: ignore[arg-type]


def test_a_pool_is_the_mean_of_its_voices_by_their_weight() -> None:
    voice = Voice(who="cases", probabilities={"stop": 1.0}, cases=20.0)
    forecast = pooled(mind(prior={"none": 0.8, "stop": 0.2}), event(), [voice, None])
    assert forecast is not None
    assert forecast.probabilities == {"none": 0.4, "stop": 0.6, "drop": 0.0}
    assert (forecast.label, forecast.probability) == ("stop", 0.6)


def test_recalled_cases_move_a_learned_prior_less_than_a_reasoners() -> None:
    cases = recalled_voice(mind(), event(), [episode(f"e{at}", 10.0, outcome="stop") for at in range(4)])
    shares = {}
    for mode in ("auto", "delib", "fallback"):
        forecast = pooled(mind(mode, prior={"none": 1.0}), event(), [cases])
        assert forecast is not None
        shares[mode] = forecast.probabilities["stop"]
    assert shares["auto"] < shares["delib"] < shares["fallback"]


def test_few_like_cases_outweigh_many_unlike_ones() -> None:
    like = [episode(f"l{at}", 10.0, outcome="stop", state="hot", load=0.9) for at in range(2)]
    unlike = [episode(f"u{at}", 10.0, outcome="none", state="cold", load=0.2) for at in range(10)]
    voice = recalled_voice(mind(), event(state="hot", load=0.9), [*like, *unlike])
    assert voice is not None
    assert voice.probabilities["stop"] > 0.5


def test_cases_weigh_by_what_their_words_mean_where_that_is_known() -> None:
    past = [episode("e1", 10.0, outcome="stop", thing="passenger lift"), episode("e2", 10.0, outcome="none", thing="apple")]
    assert recalled_voice(mind(), event(thing="elevator"), past) is None
    meant = {"thing": {"passenger lift": 0.8, "apple": 0.1}}
    voice = recalled_voice(mind(), event(thing="elevator"), past, alike=meant)
    assert voice is not None
    assert voice.cases == pytest.approx(0.65)
    assert voice.probabilities["stop"] == pytest.approx(0.64 / 0.65)


def test_labels_that_the_domain_does_not_know_and_cases_that_have_not_ended_say_nothing() -> None:
    assert recalled_voice(mind(), event(), [episode("a", 1.0, outcome="landed"), episode("b", 1.0)]) is None
    assert prior_voice(mind(prior={"landed": 1.0})) is None
    assert pooled(mind(), event(), [None]) is None


def test_advice_speaks_only_where_there_is_no_prior_because_it_has_become_the_prior_otherwise() -> None:
    advice = Reply(choice="memory", confidence=0.9, forecast="drop", forecast_probability=0.7)
    alone = prior_voice(mind("delib", advice=advice))
    assert alone is not None
    assert alone.probabilities == pytest.approx({"none": 0.15, "stop": 0.15, "drop": 0.7})
    beside = prior_voice(mind("delib", advice=advice, prior={"none": 1.0}))
    assert beside is not None
    assert beside.probabilities == {"none": 1.0}


def test_what_a_table_says_leaves_the_rest_to_nothing_having_happened() -> None:
    voice = model_voice(DOMAIN, "table", {"stop": 0.25, "unheard of": 0.9}, 4.0)
    assert voice is not None
    assert voice.probabilities == {"none": 0.75, "stop": 0.25}
    crowded = model_voice(DOMAIN, "table", {"stop": 0.9, "drop": 0.9}, 4.0)
    assert crowded is not None
    assert crowded.probabilities == {"none": 0.0, "stop": 0.5, "drop": 0.5}
    assert model_voice(DOMAIN, "table", {"unheard of": 0.9}, 4.0) is None


def test_where_the_prior_is_silent_a_single_case_is_not_certainty() -> None:
    cases = recalled_voice(mind(), event(), [episode("a", 10.0, outcome="stop")])
    forecast = pooled(mind(), event(), [cases])
    assert forecast is not None
    assert forecast.probabilities == pytest.approx({"none": 1 / 6, "stop": 2 / 3, "drop": 1 / 6}, abs=1e-5)


def test_a_forecast_is_addressed_as_the_domain_matches_outcomes() -> None:
    forecast = pooled(mind(prior={"none": 1.0}), event(entity="J3"), [])
    assert forecast is not None
    assert (forecast.topic, forecast.entity) == ("outcome", "J3")
    robot = ScriptedMind(BARE, "auto", script(prior={"none": 1.0}))
    assert BARE.outcome.scope == "entity"
    assert pooled(robot, event(), []) is not None


def test_the_last_events_of_the_kind_weigh_by_how_long_ago_they_were() -> None:
    past = [
        episode("new", 0.0, outcome="stop"),
        episode("old", 600.0, outcome="none"),
        episode("other", 0.0, kind="door_open", outcome="drop"),
        episode("open", 0.0),
        episode("foreign", 0.0, outcome="explosion"),
    ]
    voice = lately_voice(mind(), event(), past, half_life_s=600.0)
    assert voice is not None
    assert voice.cases == pytest.approx(1.5)
    assert voice.probabilities == pytest.approx({"stop": 1 / 1.5, "none": 0.5 / 1.5})
    assert lately_voice(mind(), event(), past[2:], half_life_s=600.0) is None


def test_a_case_that_is_both_like_and_late_speaks_where_it_weighs_more() -> None:
    both_like = episode("a", 600.0, outcome="stop", state="hot")  # worth 1, recency 1/2
    both_late = episode("b", 0.0, outcome="none", state="cold")  # worth 0, recency 1
    like = (both_like, both_late, episode("c", 1.0, kind="door_open", outcome="drop", state="hot"))
    last = (both_late, both_like, episode("d", 5.0, outcome="stop"))
    kept = once(event(state="hot"), like, last, DOMAIN.fields, half_life_s=600.0)
    assert [[each.event for each in part] for part in kept] == [["a", "c"], ["b", "d"]]
