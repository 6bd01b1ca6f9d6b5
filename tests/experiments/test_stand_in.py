"""The stand-in for a model: errors at stated rates, the same whenever asked."""

from __future__ import annotations

import asyncio

import pytest

from wakeful.contracts.reasoner import ReasonerError
from wakeful.experiments.stand_in import Rate, StandIn, Truth
from wakeful.facts.asking import Question
from wakeful.testing.reasoner_checks import check_reasoner

OPTIONS = ("description", "planning", "diagnosis", "memory")
RATES = {"easy": Rate(right=1.0), "hard": Rate(right=0.35), "odd": Rate(right=0.1, instead="diagnosis")}
TRUTHS = {f"{kind}{number}": Truth(kind=kind, treatment="planning") for kind in RATES for number in range(1000)}


def question(event: str) -> Question:
    return Question(about="treatment", event=event, asks="which?", options=OPTIONS)


def said(stand_in: StandIn, kind: str) -> list[str]:
    async def ask() -> list[str]:
        return [(await stand_in.answer(question(f"{kind}{number}"))).choice for number in range(1000)]

    return asyncio.run(ask())


@pytest.mark.parametrize(("kind", "rate"), [("easy", 1.0), ("hard", 0.35), ("odd", 0.1)])
def test_it_is_right_as_often_as_its_rate_says(kind: str, rate: float) -> None:
    assert said(StandIn(RATES, TRUTHS), kind).count("planning") / 1000 == pytest.approx(rate, abs=0.04)


def test_its_errors_are_even_over_the_other_options_or_the_one_that_is_named() -> None:
    hard = said(StandIn(RATES, TRUTHS), "hard")
    assert all(hard.count(name) == pytest.approx(650 / 3, abs=45) for name in ("description", "diagnosis", "memory"))
    assert set(said(StandIn(RATES, TRUTHS), "odd")) == {"planning", "diagnosis"}


def test_it_says_the_same_when_asked_again_and_something_else_with_another_seed() -> None:
    assert said(StandIn(RATES, TRUTHS, seed=1), "hard") == said(StandIn(RATES, TRUTHS, seed=1), "hard")
    assert said(StandIn(RATES, TRUTHS, seed=1), "hard") != said(StandIn(RATES, TRUTHS, seed=2), "hard")


def test_it_keeps_the_contract_of_reasoners() -> None:
    replies = check_reasoner(StandIn(RATES, TRUTHS), [question("easy1"), question("hard1"), question("nobody")])
    assert len(replies) == 2


def test_an_event_that_it_was_not_told_of_is_refused() -> None:
    with pytest.raises(ReasonerError, match="no admissible truth"):
        asyncio.run(StandIn(RATES, TRUTHS).answer(question("elsewhere")))


def test_rates_that_cannot_be_are_named() -> None:
    with pytest.raises(ValueError, match="right on easy with"):
        StandIn({"easy": Rate(right=1.5)}, {})
    with pytest.raises(ValueError, match="no rate for other"):
        StandIn(RATES, {"e": Truth(kind="other", treatment="planning")})
