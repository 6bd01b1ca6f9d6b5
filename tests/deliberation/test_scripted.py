"""The scripted reasoner: its errors are as many as it states, and belong to the question."""

from __future__ import annotations

import asyncio

import pytest

from wakeful.contracts.reasoner import ReasonerError
from wakeful.deliberation.scripted import ScriptedReasoner, from_table
from wakeful.facts.asking import Question, Reply

RULE = from_table({"obstacle": "planning"}, default="memory", forecasts={"obstacle": "none"})


def questions(count: int) -> list[Question]:
    return [
        Question(
            about="",
            event=f"event {number}",
            asks="",
            options=("planning", "memory", "description"),
            labels=("none", "intervention"),
            facts={"kind": "obstacle"},
        )
        for number in range(count)
    ]


def answers(reasoner: ScriptedReasoner, asked: list[Question]) -> list[Reply | None]:
    async def one(question: Question) -> Reply | None:
        try:
            return await reasoner.answer(question)
        except ReasonerError:
            return None

    async def all_of_them() -> list[Reply | None]:
        return [await one(question) for question in asked]

    return asyncio.run(all_of_them())


def test_without_errors_it_says_what_the_script_says() -> None:
    (reply,) = answers(ScriptedReasoner(RULE), questions(1))
    assert reply is not None
    assert (reply.choice, reply.forecast, reply.reasoner) == ("planning", "none", "scripted")


def test_its_errors_are_as_many_as_it_states() -> None:
    reasoner = ScriptedReasoner(RULE, seed=7, error_rate=0.2, forecast_error_rate=0.3, refusal_rate=0.1)
    replies = answers(reasoner, questions(4000))
    given = [reply for reply in replies if reply is not None]
    assert len(replies) - len(given) == pytest.approx(400, abs=80)
    assert sum(reply.choice != "planning" for reply in given) == pytest.approx(0.2 * len(given), abs=110)
    assert sum(reply.forecast != "none" for reply in given) == pytest.approx(0.3 * len(given), abs=130)
    assert {reply.choice for reply in given} == {"planning", "memory", "description"}


def test_errors_belong_to_the_question_and_not_to_the_order() -> None:
    asked = questions(200)
    forwards = answers(ScriptedReasoner(RULE, seed=1, error_rate=0.5), asked)
    backwards = answers(ScriptedReasoner(RULE, seed=1, error_rate=0.5), asked[::-1])
    assert forwards == backwards[::-1]
    assert forwards != answers(ScriptedReasoner(RULE, seed=2, error_rate=0.5), asked)


def test_a_rate_of_1_errs_always_and_never_outside_the_options() -> None:
    replies = answers(ScriptedReasoner(RULE, error_rate=1.0, forecast_error_rate=1.0), questions(100))
    assert {reply and reply.choice for reply in replies} == {"memory", "description"}
    assert {reply and reply.forecast for reply in replies} == {"intervention"}


def test_it_states_its_rates() -> None:
    described = ScriptedReasoner(RULE, seed=3, error_rate=0.125, refusal_rate=0.01).describe()
    assert described == "scripted, not a model (seed 3): 12.5 % wrong choices, 0 % wrong forecasts, 1 % refusals"


def test_a_script_that_names_what_is_no_option_is_a_refusal() -> None:
    assert answers(ScriptedReasoner(from_table({}, default="flying")), questions(1)) == [None]


def test_a_table_without_a_line_is_a_refusal() -> None:
    assert answers(ScriptedReasoner(from_table({"door": "planning"})), questions(1)) == [None]


@pytest.mark.parametrize("rate", [-0.1, 1.1, float("nan")])
def test_a_rate_outside_0_to_1_is_a_mistake(rate: float) -> None:
    with pytest.raises(ValueError, match="between 0 and 1"):
        ScriptedReasoner(RULE, error_rate=rate)
