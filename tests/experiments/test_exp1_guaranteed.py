"""What the guarantee gate would have allowed from a calibration set of fixed size."""

from __future__ import annotations

import msgspec

from wakeful.experiments.exp1_guaranteed import guaranteed, levels, said_of
from wakeful.experiments.exp1_methods import Choice
from wakeful.experiments.worlds.service_events import A, Case, world

ONE = world(A, 0).calibration[0]


def told(right: int, wrong: int = 0, treatment: str = "memory") -> tuple[list[Choice], list[Case]]:
    choices = [Choice(treatment=treatment, learned=treatment, confidence=0.95)] * (right + wrong)
    cases = [msgspec.structs.replace(ONE, truth=treatment)] * right + [msgspec.structs.replace(ONE, truth="other")] * wrong
    return choices, cases


def test_forty_two_events_without_an_error_allow_nothing_and_fifty_nine_do() -> None:
    choice = told(1)[0]
    assert not guaranteed(choice, levels(*told(42)))[0].guaranteed
    assert not guaranteed(choice, levels(*told(58)))[0].guaranteed
    assert guaranteed(choice, levels(*told(59)))[0].guaranteed


def test_events_of_one_treatment_say_nothing_of_another() -> None:
    choices, cases = told(59)
    assert not guaranteed(told(1, treatment="planning")[0], levels(choices, cases))[0].guaranteed


def test_an_error_in_a_hundred_is_allowed_and_ten_are_not() -> None:
    assert guaranteed(told(1)[0], levels(*told(99, 1)))[0].guaranteed
    assert not guaranteed(told(1)[0], levels(*told(90, 10)))[0].guaranteed


def test_what_is_said_names_risk_probability_and_how_many_it_takes() -> None:
    said = said_of({"wakeful on A": 0.0})
    assert "wakeful on A 0.00 %" in said
    assert "risk 5%, held with 95%" in said
    assert "59 events of its own" in said
