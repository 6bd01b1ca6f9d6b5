from __future__ import annotations

import msgspec
import pytest

from tests.treatments.worlds import DOMAIN, NOW_S, episode, event, script
from wakeful.contracts.treatment import Mind, Refusal
from wakeful.facts.asking import Query, Question, Reply
from wakeful.facts.events import Event
from wakeful.facts.evidence import Evidence
from wakeful.facts.results import Result
from wakeful.facts.time import to_ns
from wakeful.testing import ContractBroken, Exchange, Script, ScriptedMind
from wakeful.treatments.decorator import FunctionTreatment, Thinks, treatment


class Heard(Result, frozen=True, kw_only=True, tag="heard"):
    pass


def made(thinks: Thinks) -> FunctionTreatment:
    return treatment("tried", result=Heard, says="is tried")(thinks)


def reading(id: str, after_s: float, value: bytes = b"1") -> Evidence:
    return Evidence(id=id, topic="heat", key="arm", at_ns=to_ns(NOW_S + after_s), value=msgspec.Raw(value))


def heard(says: str) -> Heard:
    return Heard(says=says, confidence=1.0)


def test_evidence_arrives_at_its_time_each_piece_once_and_a_wait_that_gets_too_little_takes_its_whole_limit() -> None:
    async def thinks(_event: Event, mind: Mind) -> Result:
        first = await mind.evidence("heat", "arm", 10.0)
        at_s = mind.now_s
        both = await mind.evidence("heat", "arm", 10.0, count=3)
        none = await mind.evidence("heat", "leg", 5.0)
        return heard(f"{[e.id for e in first]} at {at_s - NOW_S:g}, {[e.id for e in both]}, {len(none)}")

    mind = ScriptedMind(DOMAIN, "auto", script(evidence=(reading("b", 6.0), reading("a", 2.0), reading("c", 60.0))))
    assert mind.run(made(thinks), event()).says == "['a'] at 2, ['b'], 0"
    assert mind.now_s == NOW_S + 2.0 + 10.0 + 5.0


def test_recall_gives_the_likest_to_an_event_or_the_newest_of_an_entity_never_the_event_itself() -> None:
    async def thinks(met: Event, mind: Mind) -> Result:
        like = await mind.recall(Query(event=met.id, limit=2))
        of_j3 = await mind.recall(Query(entity="J3", limit=9))
        stops = await mind.recall(Query(kind="stop"))
        return heard(f"{[e.event for e in like]} {[(e.event, e.likeness) for e in of_j3]} {[e.event for e in stops]}")

    remembered = (
        episode("old", 90.0, likeness=0.5),
        episode("new", 10.0, likeness=0.2),
        episode("far", 50.0, entity="J4", kind="stop", likeness=0.9),
        episode("now", 0.0, likeness=1.0, entity="J5"),
    )
    result = ScriptedMind(DOMAIN, "auto", script(*remembered)).run(made(thinks), event())
    assert result.says == "['far', 'old'] [('new', 1.0), ('old', 1.0)] ['far']"


def test_a_person_who_is_not_there_costs_the_whole_wait_and_a_reasoner_who_is_not_there_refuses() -> None:
    question = Question(about="fault", event="now", asks="which?", options=("a", "b"))

    async def thinks(_event: Event, mind: Mind) -> Result:
        nobody = await mind.ask("operator", question, 20.0)
        somebody = await mind.ask("supervisor", question, 20.0)
        try:
            reply = await mind.deliberate(question)
        except Refusal as refusal:
            return heard(f"{nobody} {somebody and somebody.choice} {refusal}")
        return heard(f"{nobody} {somebody and somebody.choice} {reply.choice}")

    told = script(people={"supervisor": Reply(choice="b", confidence=1.0)}, replies={"fault": Reply(choice="a", confidence=1.0)})
    assert ScriptedMind(DOMAIN, "delib", told).run(made(thinks), event()).says == "None b a"
    auto = ScriptedMind(DOMAIN, "auto", told)
    assert auto.run(made(thinks), event()).says == "None b a process in auto mode does not deliberate"
    assert auto.now_s == NOW_S + 20.0


def test_a_child_is_driven_over_the_same_script_and_its_time_counts() -> None:
    async def child(met: Event, mind: Mind) -> Result:
        await mind.sleep_s(3.0)
        return heard(f"child of {met.entity}")

    async def parent(met: Event, mind: Mind) -> Result:
        result = await mind.treat("child", met)
        try:
            await mind.treat("stranger", met)
        except Refusal as refusal:
            return heard(f"{result.says}; {refusal}")
        return result

    mind = ScriptedMind(DOMAIN, "auto", script(children={"child": made(child)}, step_s=0.5))
    assert mind.run(made(parent), event()).says == "child of J3; the script has no treatment 'stranger'"
    assert mind.now_s == NOW_S + 3.0


def test_a_call_runs_outside_sync_or_async_and_what_it_raises_is_a_refusal() -> None:
    async def fetched() -> dict[str, int]:
        return {"volts": 12}

    def failed() -> int:
        raise OSError("cable out")

    async def thinks(_event: Event, mind: Mind) -> Result:
        volts = await mind.call(fetched, "volts", 1.0)
        try:
            await mind.call(failed, "amps", 1.0)
        except Refusal as refusal:
            return heard(f"{volts} {refusal}")
        return heard("amps")

    assert ScriptedMind(DOMAIN).run(made(thinks), event()).says == "{'volts': 12} OSError('cable out')"


def test_recorded_exchanges_answer_first_and_nothing_is_run_again() -> None:
    calls: list[int] = []

    def outside() -> int:
        calls.append(1)
        return len(calls)

    async def thinks(_event: Event, mind: Mind) -> Result:
        number = await mind.call(outside, "n", 1.0)
        await mind.sleep_s(2.0)
        return heard(f"{number} at {mind.now_s:g}")

    first = ScriptedMind(DOMAIN)
    said = first.run(made(thinks), event()).says
    again = ScriptedMind(DOMAIN, "auto", Script(now_s=500.0), first.exchanges)
    assert again.run(made(thinks), event()).says == said == "1 at 2"
    assert calls == [1]


def test_a_treatment_that_asks_otherwise_than_recorded_is_named_with_both_requests() -> None:
    async def thinks(_event: Event, mind: Mind) -> Result:
        await mind.work(2)
        return heard("x")

    first = ScriptedMind(DOMAIN)
    first.run(made(thinks), event())
    other = [Exchange(request=msgspec.structs.replace(first.exchanges[0].request, key="3"))]
    with pytest.raises(ContractBroken, match=r"request 1 was work '3'.*now asks for work '2'"):
        ScriptedMind(DOMAIN, "auto", recorded=other).run(made(thinks), event())


def test_steps_take_the_scripts_time() -> None:
    async def thinks(_event: Event, mind: Mind) -> Result:
        await mind.work(4)
        return heard(f"{mind.now_s:g}")

    assert ScriptedMind(DOMAIN, "auto", Script(step_s=0.25)).run(made(thinks), event()).says == "1"


def test_the_priors_most_probable_label_is_its_forecast() -> None:
    forecast = ScriptedMind(DOMAIN, "auto", Script(prior={"none": 0.3, "stop": 0.7})).forecast()
    assert forecast is not None
    assert forecast.label == "stop"
    assert ScriptedMind(DOMAIN).forecast() is None
    assert ScriptedMind(DOMAIN).decision.mode == "auto"
