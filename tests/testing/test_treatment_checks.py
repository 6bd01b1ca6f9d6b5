"""A contract suite is worth what it catches: each of these treatments breaks one clause."""

from __future__ import annotations

from itertools import count
from random import random

import pytest

from tests.treatments.worlds import DOMAIN, event, script
from wakeful.contracts.treatment import Mind, Refusal, Treatment
from wakeful.facts.asking import Query, Question, Reply
from wakeful.facts.events import Event
from wakeful.facts.results import Forecast, Proposal, Result
from wakeful.testing import ContractBroken, check_treatment
from wakeful.treatments.decorator import FunctionTreatment, Thinks, treatment


class Said(Result, frozen=True, kw_only=True, tag="said"):
    values: tuple[float, ...] = ()


class Other(Result, frozen=True, kw_only=True, tag="other"):
    pass


def said(**changed: object) -> Said:
    """A good result, but for what is changed."""
    good: dict[str, object] = {"says": "so", "confidence": 0.5, "rests_on": ("e",), "would_change": ("more",)}
    return Said(**{**good, **changed})  # type: ignore[arg-type]


def made(thinks: Thinks) -> FunctionTreatment:
    return treatment("tried", result=Said, says="is tried")(thinks)


def returning(result: Result) -> FunctionTreatment:
    async def thinks(_event: Event, mind: Mind) -> Result:
        await mind.work()
        return result

    return made(thinks)


def broken(tried: Treatment, why: str, **about: object) -> None:
    with pytest.raises(ContractBroken, match=why):
        check_treatment(tried, event(**about), DOMAIN, script())  # type: ignore[arg-type]


def test_a_good_treatment_passes_and_gives_its_result_in_every_mode() -> None:
    assert set(check_treatment(returning(said()), event(), DOMAIN, script())) == {"auto", "delib", "fallback"}


@pytest.mark.parametrize(
    ("result", "why"),
    [
        (Other(says="so", confidence=1.0), "returned Other, not Said"),
        (said(values=(float("nan"),)), "does not survive JSON|comes back from JSON changed"),
        (said(values=[1.0]), "comes back from JSON changed"),
        (said(says="  "), "one line for a person"),
        (said(says="a\nb"), "one line for a person"),
        (said(rests_on=()), "rests_on is empty"),
        (said(would_change=()), "would_change is empty"),
        (said(confidence=1.2), "confidence 1.2"),
        (said(forecast=Forecast(label="rain", probability=0.5)), "forecasts 'rain'"),
        (said(forecast=Forecast(label="none", probability=1.5)), "not in"),
        (said(forecast=Forecast(label="none", probability=0.3, probabilities={"none": 0.3, "stop": 0.7})), "another label is"),
        (said(forecast=Forecast(label="none", probability=0.9, probabilities={"none": 0.9, "stop": 0.9})), "sum to"),
        (said(proposes=(Proposal(effect="stop", preconditions=("x",)),)), "end of validity"),
        (said(proposes=(Proposal(effect="stop", valid_until_ns=1),)), "without preconditions"),
    ],
)
def test_a_result_that_does_not_keep_the_contract_is_caught(result: Result, why: str) -> None:
    broken(returning(result), why)


def test_a_treatment_that_draws_lots_is_caught() -> None:
    async def thinks(_event: Event, mind: Mind) -> Result:
        await mind.work()
        return said(confidence=random())

    broken(made(thinks), "a second run over the same script gave another result")


def test_a_treatment_that_remembers_between_runs_is_caught() -> None:
    runs = count(1)

    async def thinks(_event: Event, mind: Mind) -> Result:
        await mind.recall(Query(limit=next(runs)))
        return said()

    broken(made(thinks), "asked for something else")


def test_a_treatment_that_looks_around_itself_between_awaits_is_caught_over_its_recorded_answers() -> None:
    """It compares identities: equal episodes that come from a record are other objects than those that came live."""
    seen: list[object] = []

    async def thinks(_event: Event, mind: Mind) -> Result:
        seen.append(await mind.evidence("heat", "x", 1.0))
        return said(confidence=0.1 if len(seen) < 3 else 0.9)

    broken(made(thinks), "another result")


def test_a_treatment_that_awaits_something_else_is_caught() -> None:
    class Elsewhere:
        def __await__(self):  # type: ignore[no-untyped-def]
            yield "a bird"

    async def thinks(_event: Event, _mind: Mind) -> Result:
        await Elsewhere()
        return said()

    broken(made(thinks), "awaited 'a bird'")


def test_a_treatment_that_will_not_be_evicted_is_caught() -> None:
    async def thinks(_event: Event, mind: Mind) -> Result:
        try:
            await mind.work()
        except GeneratorExit:
            await mind.work()
        return said()

    broken(made(thinks), "did not let itself be evicted")


def test_a_treatment_that_changes_the_event_is_caught() -> None:
    async def thinks(met: Event, mind: Mind) -> Result:
        await mind.work()
        met.fields["load"] = 1.0
        return said()

    broken(made(thinks), "changed the event")


def test_a_treatment_that_waits_past_the_deadline_is_caught() -> None:
    async def thinks(_event: Event, mind: Mind) -> Result:
        await mind.evidence("heat", "x", 30.0)
        return said()

    check_treatment(made(thinks), event(deadline_s=31.0), DOMAIN, script())
    broken(made(thinks), "waited past the deadline", deadline_s=20.0)


def test_a_wait_without_an_end_is_caught() -> None:
    async def thinks(_event: Event, mind: Mind) -> Result:
        await mind.evidence("heat", "x", float("inf"))
        return said()

    broken(made(thinks), "finite limit")


def test_a_treatment_that_spends_more_in_auto_mode_than_it_may_is_caught() -> None:
    async def thinks(_event: Event, mind: Mind) -> Result:
        await mind.work(4)
        return said()

    with pytest.raises(ContractBroken, match="spent 4 steps, 3 are allowed"):
        check_treatment(made(thinks), event(), DOMAIN, script(), auto_steps=3)


def test_only_a_deliberating_treatment_may_give_up_when_nobody_answers() -> None:
    question = Question(about="fault", event="now", asks="which?", options=("a",))

    async def thinks(_event: Event, mind: Mind) -> Result:
        if mind.mode == "delib":
            await mind.deliberate(question)
        return said()

    known = script(replies={"fault": Reply(choice="a", confidence=1.0)})
    check_treatment(made(thinks), event(), DOMAIN, known)

    async def stubborn(_event: Event, mind: Mind) -> Result:
        await mind.work()
        raise Refusal("nobody told me")

    with pytest.raises(Refusal):
        check_treatment(made(stubborn), event(), DOMAIN, known, modes=("fallback",))


def test_a_failure_of_the_treatment_itself_comes_through() -> None:
    async def thinks(_event: Event, mind: Mind) -> Result:
        await mind.work()
        raise ZeroDivisionError("by its author")

    with pytest.raises(ZeroDivisionError):
        check_treatment(made(thinks), event(), DOMAIN, script())
