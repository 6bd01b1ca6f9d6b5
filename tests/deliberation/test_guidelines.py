"""The guideline reasoner: what was written decides, and says so."""

from __future__ import annotations

import asyncio
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wakeful.contracts.reasoner import ReasonerError
from wakeful.deliberation.guidelines import GuidelineError, GuidelineReasoner
from wakeful.facts.asking import Question, Reply
from wakeful.facts.domain import DomainSpec, Fault, Guideline, Hazard

SPEC = DomainSpec(
    name="warehouse",
    version=2,
    says="",
    guideline=(
        Guideline(
            treat="planning",
            because="A blocked route needs another one.",
            when={"kind": "obstacle", "load": ">0.6"},
            expect="intervention",
            probability=0.8,
        ),
        Guideline(treat="risk_prediction", because="Near people, think of harm first.", when={"safety": True}, weight=2.0),
        Guideline(treat="description", because="What is only seen is described.", weight=0.5),
    ),
    hazard=(Hazard(name="collision", severity=4, exposure=0.5, likelihood=0.4, when={"safety": True}, control="Slow down."),),
    fault=(
        Fault(name="worn_belt", prior=0.1, causes={"obstacle": 0.1, "slip": 0.9}, check="Look at the belt."),
        Fault(name="bad_encoder", prior=0.1, causes={"slip": 0.3}),
    ),
)


def decide(**changes: Any) -> Reply:
    asked = Question(
        about="treatment",
        event="a pallet",
        asks="Which?",
        options=("description", "planning", "risk_prediction"),
        labels=("none", "intervention"),
        facts={"kind": "obstacle", "load": "0.7", "safety": "False"},
    )
    return GuidelineReasoner(SPEC).decide(msgspec.structs.replace(asked, **changes))


def test_the_guideline_that_applies_decides_and_is_quoted() -> None:
    reply = decide()
    assert (reply.choice, reply.forecast, reply.forecast_probability) == ("planning", "intervention", 0.8)
    assert reply.because[0] == "A blocked route needs another one. (as kind is obstacle and load is >0.6)"
    assert reply.because[1].startswith("Against it, for description:")


def test_weight_goes_before_order() -> None:
    reply = decide(facts={"kind": "obstacle", "load": "0.7", "safety": "True"})
    assert reply.choice == "risk_prediction"
    assert "Hazard collision, severity 4 of 4. Slow down." in reply.because


def test_a_guideline_for_what_is_no_option_does_not_decide() -> None:
    assert decide(options=("description", "risk_prediction")).choice == "description"


def test_more_conditions_that_hold_settle_it_more_firmly() -> None:
    assert decide().confidence > decide(facts={"kind": "shadow"}).confidence


def test_a_rival_guideline_lowers_the_confidence() -> None:
    assert decide(options=("planning",)).confidence > decide().confidence


def test_validated_history_moves_the_confidence_both_ways() -> None:
    supported = ("treated with planning, outcome none: supported",) * 3
    contradicted = ("treated with planning, outcome none: contradicted",) * 3
    assert decide(history=supported).confidence > decide().confidence > decide(history=contradicted).confidence
    assert "In like cases planning was supported 3 times and contradicted 0 times." in decide(history=supported).because


def test_one_contradiction_does_not_overrule_the_text_and_many_do() -> None:
    against = "treated with planning, outcome intervention: contradicted"
    instead = "treated with risk_prediction, outcome none: supported"
    assert decide(history=(against,)).choice == "planning"
    reply = decide(history=(against, against, instead))
    assert reply.choice == "risk_prediction"
    assert any("planning was contradicted 2 times" in one for one in reply.because)


def test_what_like_cases_ended_in_moves_the_forecast() -> None:
    reply = decide(history=("outcome none: supported",) * 5)
    assert reply.forecast == "none"
    assert reply.forecast_probability == pytest.approx((2 * 0.2 + 5) / 7, abs=1e-6)
    assert "Like cases ended 5 of 5 times in none." in reply.because


def test_hazards_make_the_forecast_where_no_guideline_expects_anything() -> None:
    reply = decide(facts={"kind": "person", "safety": "True"})
    assert (reply.forecast, reply.forecast_probability) == ("none", 0.8)


def test_without_labels_there_is_no_forecast() -> None:
    reply = decide(labels=())
    assert (reply.forecast, reply.forecast_probability) == ("", 0.0)


def test_among_faults_the_one_that_explains_the_facts_is_chosen() -> None:
    reply = decide(options=("bad_encoder", "worn_belt"), facts={"kind": "slip"})
    assert reply.choice == "worn_belt"
    assert reply.confidence == pytest.approx(0.75, abs=1e-6)
    assert "To check: Look at the belt." in reply.because


def test_among_labels_the_expected_one_is_chosen() -> None:
    assert decide(options=("none", "intervention"), labels=()).choice == "intervention"


def test_among_hazards_the_gravest_that_holds_is_chosen() -> None:
    assert decide(options=("fire", "collision"), facts={"safety": "True"}).choice == "collision"


def test_where_nothing_is_written_the_reply_says_that_it_is_a_draw() -> None:
    reply = decide(options=("left", "right", "wait"))
    assert (reply.choice, reply.confidence) == ("left", pytest.approx(1 / 3, abs=1e-6))
    assert "No guideline of warehouse speaks to this" in reply.because[0]


def test_it_gives_no_answer_of_its_own_form() -> None:
    with pytest.raises(ReasonerError, match="choose among options"):
        decide(schema=msgspec.Raw(b'{"type": "object"}'))
    assert decide(schema=msgspec.Raw(b'{"anyOf": [{"type": "object"}, {"type": "null"}]}')).choice == "planning"


def test_a_question_without_options_is_refused() -> None:
    with pytest.raises(ReasonerError, match="no options"):
        decide(options=())


@pytest.mark.parametrize("wanted", [">heavy", "<", ">=", "<1,5"])
def test_a_comparison_with_what_is_no_number_is_named_at_once(wanted: str) -> None:
    spec = DomainSpec(name="d", version=1, says="", guideline=(Guideline(treat="a", because="", when={"load": wanted}),))
    with pytest.raises(GuidelineError, match=r"guideline 1 \(a\) of domain d compares load"):
        GuidelineReasoner(spec)


def test_it_takes_declared_virtual_time_and_describes_itself() -> None:
    reasoner = GuidelineReasoner(SPEC, latency_s=0.4)
    assert (reasoner.name, reasoner.latency_s) == ("guidelines", 0.4)
    assert reasoner.describe() == "the 3 written guidelines and 1 hazards of warehouse (version 2)"


@given(
    st.dictionaries(st.sampled_from(["kind", "load", "safety", "zone"]), st.text(max_size=10)),
    st.lists(st.sampled_from(["planning", "description", "worn_belt", "collision", "other"]), min_size=1, unique=True),
    st.lists(st.text() | st.sampled_from(["planning: supported", "description: contradicted", "outcome none"]), max_size=5),
)
def test_any_question_gets_an_admissible_reply_and_the_same_one_again(
    facts: dict[str, str], options: list[str], history: list[str]
) -> None:
    asked = Question(
        about="", event="", asks="", options=tuple(options), labels=("none", "intervention"), facts=facts, history=tuple(history)
    )
    first, second = (asyncio.run(GuidelineReasoner(SPEC).answer(asked)) for _ in range(2))
    assert first == second
    assert first.choice in options
    assert first.forecast in asked.labels
    assert 0.0 <= first.confidence <= 1.0
    assert 0.0 <= first.forecast_probability <= 1.0
    assert first.because
