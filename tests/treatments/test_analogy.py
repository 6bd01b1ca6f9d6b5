import pytest

from tests.treatments.worlds import DOMAIN, episode, event, script
from wakeful.facts.asking import Episode
from wakeful.testing import ScriptedMind
from wakeful.treatments.analogy import Analogy, analogy


def likened(*episodes: Episode, mode: str = "fallback", **fields: object) -> Analogy:
    result = ScriptedMind(DOMAIN, mode, script(*episodes)).run(analogy, event("current_high", "thing", **fields))  # type: ignore[arg-type]
    assert isinstance(result, Analogy)
    return result


def test_what_is_shared_transfers_and_what_is_not_does_not() -> None:
    case = episode("a", 10.0, entity="pump 2", treatment="diagnosis", state="hot", load=0.9, colour="red")
    result = likened(case, state="hot", load=0.3)
    assert result.transfers == ("state",)
    assert result.does_not_transfer == ("load", "colour")
    assert "it shares state, but not load, colour" in result.says


def test_the_treatment_that_served_like_cases_is_taken_over_and_only_its_own_cases_tell_how_often_it_is_wrong() -> None:
    good = [episode(f"g{at}", 10.0, treatment="diagnosis", verdict="supported", outcome="stop", state="hot") for at in range(2)]
    bad = [episode(f"b{at}", 10.0, treatment="planning", verdict="contradicted", outcome="none", state="hot") for at in range(4)]
    result = likened(*good, *bad, state="hot")
    assert result.treat_as == "diagnosis"
    assert result.wrong == pytest.approx(0.6 / (2.0 + 2), abs=1e-3)
    failed = episode("f", 10.0, treatment="diagnosis", verdict="contradicted", outcome="none", state="hot")
    assert likened(*good, failed, *bad[:3], state="hot").wrong == pytest.approx((0.6 + 1) / (2.0 + 3), abs=1e-3)
    assert result.wrong_low < result.wrong < result.wrong_high


def test_a_case_that_shares_no_attribute_carries_nothing() -> None:
    result = likened(episode("a", 10.0, likeness=1.0, treatment="planning", state="cold"), state="hot")
    assert result.treat_as == ""
    assert "like nothing known; the nearest of 1 is worth 0 of 1" in result.says
    assert result.confidence <= 0.1


def test_analogy_never_recommends_itself() -> None:
    case = episode("a", 10.0, treatment="analogy", verdict="supported", state="hot")
    assert likened(case, state="hot").treat_as == ""


def test_a_case_of_another_kind_is_worth_half() -> None:
    same, other = episode("s", 10.0, state="hot"), episode("o", 10.0, kind="object", state="hot")
    assert [(case.event, case.worth) for case in likened(same, other, state="hot").cases] == [("s", 1.0), ("o", 0.5)]


def test_the_nearer_case_is_worth_more() -> None:
    near = episode("n", 10.0, likeness=0.9, state="hot", load=0.5)
    far = episode("f", 10.0, likeness=0.9, state="hot", load=0.0)
    result = likened(far, near, state="hot", load=0.5)
    assert [case.event for case in result.cases] == ["n", "f"]


def test_where_no_case_of_the_treatment_was_judged_the_risk_is_taken_for_as_high_as_it_may_be() -> None:
    other = [episode(f"m{at}", 10.0, treatment="memory", verdict="contradicted", outcome="stop", state="hot") for at in range(3)]
    unjudged, judged = (
        ScriptedMind(DOMAIN, "auto", script(episode("d", 10.0, verdict=verdict, state="hot"), *other)).run(
            analogy, event("current_high", "thing", state="hot")
        )
        for verdict in ("", "supported")
    )
    assert isinstance(unjudged, Analogy)
    assert isinstance(judged, Analogy)
    assert unjudged.treat_as == judged.treat_as == "diagnosis"
    assert "no case of it has been judged yet" in unjudged.says
    assert unjudged.wrong == pytest.approx(0.3)
    assert unjudged.confidence == pytest.approx(1.0 - unjudged.wrong_high, abs=1e-3)
    assert unjudged.confidence < judged.confidence == pytest.approx(1.0 - judged.wrong, abs=1e-3)
