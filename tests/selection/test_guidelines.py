"""Ranking by written guidelines."""

from __future__ import annotations

from tests.selection.test_features import event
from wakeful.facts.domain import DomainSpec, Guideline
from wakeful.facts.events import Context
from wakeful.selection.guidelines import UNWRITTEN_WEIGHT, advise, expected

ALLOWED = ("description", "risk_prediction", "planning")


def spec(*lines: Guideline) -> DomainSpec:
    return DomainSpec(name="d", version=1, says="", guideline=lines)


def test_the_heaviest_guideline_that_holds_leads_and_equal_ones_go_by_their_order() -> None:
    lines = (
        Guideline(treat="description", because="nothing else", weight=0.2),
        Guideline(treat="planning", because="first", when={"kind": "current_left_band"}),
        Guideline(treat="risk_prediction", because="second", when={"load": ">0.5"}),
    )
    advice = advise(spec(*lines), ALLOWED, event({"load": 0.9}))
    assert advice.leading == lines[1]
    assert [line.treat for line in advice.also] == ["risk_prediction", "description"]
    assert advice.shares[1] == advice.shares[2] > advice.shares[0]
    assert abs(sum(advice.shares) - 1.0) < 1e-6


def test_no_guideline_holds_or_is_allowed() -> None:
    lines = (Guideline(treat="diagnosis", because="not allowed"), Guideline(treat="planning", because="no", when={"load": ">2"}))
    advice = advise(spec(*lines), ALLOWED, event({"load": 1.0}))
    assert advice.leading is None
    assert set(advice.shares) == {round(UNWRITTEN_WEIGHT / (3 * UNWRITTEN_WEIGHT), 9)}


def test_a_guideline_may_name_the_events_own_words_and_its_context() -> None:
    line = Guideline(
        treat="planning",
        because="",
        when={
            "relation": "changed",
            "zone": ["A", "B"],
            "safety": True,
            "criticality": ">=2",
            "visitors": "<3",
            "entity": "joint_3",
        },
    )
    context = Context(zone="A", safety=True, fields={"visitors": 1})
    assert advise(spec(line), ALLOWED, event(context=context, criticality=2)).leading == line
    assert advise(spec(line), ALLOWED, event(context=context, criticality=1)).leading is None


def test_an_expectation_becomes_probabilities_over_the_outcome_labels() -> None:
    one = spec()
    assert expected(one, Guideline(treat="planning", because="", expect="intervention", probability=0.7)) == {
        "none": 0.3,
        "intervention": 0.7,
    }


def test_where_nothing_is_expected_every_label_is_equally_likely() -> None:
    even = {"none": 0.5, "intervention": 0.5}
    assert expected(spec(), Guideline(treat="planning", because="", expect="unheard_of")) == even
    assert expected(spec(), None) == even
