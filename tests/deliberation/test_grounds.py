"""Reading facts and history as grounds."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wakeful.deliberation.grounds import Tally, applying, blame, history_of, holds, readings, risk, shown
from wakeful.facts.domain import DomainSpec, Fault, Guideline, Hazard, matches


def facts(**texts: str) -> dict[str, tuple[object, ...]]:
    return {name: readings(text) for name, text in texts.items()}


@pytest.mark.parametrize(
    ("when", "has", "expected"),
    [
        ({"load": ">0.6"}, {"load": "0.7"}, True),
        ({"load": ">0.6"}, {"load": "0.6"}, False),
        ({"load": ">=0.6"}, {"load": "0.6"}, True),
        ({"load": ">0.6"}, {"load": "heavy"}, False),
        ({"load": ">0.6"}, {}, False),
        ({"safety": True}, {"safety": "True"}, True),
        ({"safety": True}, {"safety": "true"}, True),
        ({"safety": True}, {"safety": "False"}, False),
        ({"code": "0042"}, {"code": "0042"}, True),
        ({"code": "42"}, {"code": "42"}, True),
        ({"code": 42}, {"code": "42"}, True),
        ({"zone": ["edge", "dock"]}, {"zone": "dock"}, True),
        ({"level": [1, 2]}, {"level": "2"}, True),
        ({"load": "<0"}, {"load": "NaN"}, False),
        ({"load": ">0"}, {"load": "9" * 100_000}, False),
    ],
)
def test_conditions_hold_of_facts_in_text(when: dict[str, object], has: dict[str, str], expected: bool) -> None:
    assert holds(when, facts(**has)) is expected  # type: ignore[arg-type]


@given(st.none() | st.booleans() | st.integers(-1000, 1000) | st.floats(-1e6, 1e6) | st.sampled_from(["edge", "a b", ""]))
def test_a_scalar_survives_being_written_as_text(value: None | bool | int | float | str) -> None:
    assert readings(str(value))[0] == value
    if value is not None:
        assert holds({"a": value}, {"a": readings(str(value))}) == matches({"a": value}, {"a": value})


@given(st.text(max_size=200))
def test_no_text_makes_reading_raise_and_the_text_itself_is_always_a_reading(text: str) -> None:
    assert readings(text)[-1] == text


def test_guidelines_come_by_weight_and_then_by_order_and_hazards_gravest_first() -> None:
    spec = DomainSpec(
        name="d",
        version=1,
        says="",
        guideline=(
            Guideline(treat="a", because="1"),
            Guideline(treat="b", because="2", weight=2.0),
            Guideline(treat="c", because="3", weight=2.0),
            Guideline(treat="d", because="4", when={"never": 1}, weight=9.0),
        ),
        hazard=(
            Hazard(name="slight", severity=1, exposure=1.0, likelihood=1.0),
            Hazard(name="fatal", severity=4, exposure=0.1, likelihood=0.1),
        ),
    )
    guidelines, hazards = applying(spec, {})
    assert [one.treat for one in guidelines] == ["b", "c", "a"]
    assert [one.name for one in hazards] == ["fatal", "slight"]
    assert risk(hazards) == 1.0
    assert risk(hazards[:1]) == pytest.approx(0.01)
    assert risk(()) == 0.0


FAULTS = (
    Fault(name="worn_belt", prior=0.1, causes={"slip": 0.9, "noise=high": 0.5}),
    Fault(name="bad_encoder", prior=0.1, causes={"slip": 0.6, "jump": 0.9}),
    Fault(name="flat_battery", prior=0.01, causes={"undervoltage": 0.95}),
)


def test_the_fault_that_explains_the_facts_is_blamed_most() -> None:
    posterior = blame(FAULTS, facts(kind="slip", noise="high"))
    assert max(posterior, key=lambda name: posterior[name]) == "worn_belt"
    assert sum(posterior.values()) == pytest.approx(1.0)
    quiet = blame(FAULTS, facts(kind="slip", noise="low"))
    assert quiet["worn_belt"] < posterior["worn_belt"]


def test_nobody_is_blamed_without_a_symptom() -> None:
    assert blame(FAULTS, facts(kind="obstacle")) == {}
    assert blame((), facts(kind="slip")) == {}


HISTORY = (
    "3 days ago at dock: obstacle, treated with risk_prediction; predicted none, outcome intervention: contradicted",
    "yesterday: obstacle, treated with risk prediction; predicted none, outcome none: supported",
    "obstacle, treated with planning; the world showed none, supported",
    "obstacle, treated with planning_ahead; ended in none: supported",
    "nothing was concluded",
)


def test_history_is_counted_for_and_against_each_option() -> None:
    assert history_of("risk_prediction", HISTORY) == Tally(supported=1, contradicted=1)
    assert history_of("planning", HISTORY) == Tally(supported=1, contradicted=0)
    assert history_of("memory", HISTORY) == Tally()


def test_the_kernels_own_sentences_are_understood() -> None:
    history = (
        "object at memory shelf, likeness 0.93: treated by planning, ended in none (supported)",
        "object at box, likeness 0.90: treated by risk_prediction, ended in intervention (contradicted)",
    )
    assert history_of("planning", history) == Tally(1, 0)
    assert history_of("risk_prediction", history) == Tally(0, 1)
    assert history_of("memory", history) == Tally()
    assert shown(("none", "intervention"), history) == {"none": 1, "intervention": 1}


def test_a_symptom_may_be_a_comparison() -> None:
    faults = (
        Fault(name="overheating", prior=0.1, causes={"temperature_c=>70": 0.9}),
        Fault(name="stalled", prior=0.1, causes={"current_a=>6": 0.9}),
    )
    posterior = blame(faults, facts(temperature_c="85.5", current_a="2"))
    assert posterior["overheating"] > 0.9


def test_what_the_world_showed_is_counted_and_not_what_was_predicted() -> None:
    assert shown(("none", "intervention"), HISTORY) == {"none": 3, "intervention": 1}


def test_the_longer_of_two_labels_that_begin_alike_is_meant() -> None:
    assert shown(("stop", "stop hard"), ("outcome stop hard",)) == {"stop": 0, "stop hard": 1}
