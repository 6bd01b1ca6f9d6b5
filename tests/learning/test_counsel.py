"""Pooling the reasoner's forecast with the model's."""

from __future__ import annotations

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wakeful.facts.asking import Kind, Reply
from wakeful.facts.decisions import Candidate, Decision, Gate
from wakeful.facts.experience import Verdict
from wakeful.facts.lines import Answered, Decided, Judged
from wakeful.learning.counsel import Counsel

LABELS = ("none", "stop")
GATE = Gate(confidence=0, threshold=0, novelty=0, novelty_limit=1, trust=1, trust_limit=0)


def says(label: str, probability: float) -> Reply:
    return Reply(choice="diagnosis", confidence=0.5, forecast=label, forecast_probability=probability)


def live_through(counsel: Counsel, process: int, model: float, reasoner: float, ended: str) -> None:
    """One deliberated event: both give ``stop`` a probability, then the world shows how it ended."""
    decision = Decision(
        treatment="diagnosis",
        mode="delib",
        confidence=0.5,
        candidates=(Candidate(treatment="diagnosis", probability=1.0),),
        reasons=(),
        gate=GATE,
        prior={"none": 1 - model, "stop": model},
        model=1,
    )
    counsel.apply(Decided(process=process, event="e", decision=decision))
    value = msgspec.Raw(msgspec.json.encode(says("stop", reasoner)))
    counsel.apply(Answered(process=process, seq=1, kind=Kind.DELIBERATE, key="treatment", value=value))
    counsel.apply(Judged(process=process, event="e", predicted="stop", label=ended, verdict=Verdict.SUPPORTED))


def test_both_weigh_the_same_before_anything_was_judged() -> None:
    pooled = Counsel().pool({"none": 0.9, "stop": 0.1}, True, says("stop", 0.7), LABELS)
    assert pooled == pytest.approx({"none": 0.6, "stop": 0.4})


def test_who_forecast_better_is_believed_more_and_can_lose_it_again() -> None:
    counsel = Counsel()
    for process in range(1, 11):
        live_through(counsel, process, model=0.8, reasoner=0.2, ended="stop")
    assert counsel.weights[0] > 0.95
    for process in range(11, 31):
        live_through(counsel, process, model=0.8, reasoner=0.2, ended="none")
    assert counsel.weights[1] > 0.5


def test_without_a_model_the_reasoners_forecast_stands_alone() -> None:
    assert Counsel().pool({"none": 0.5, "stop": 0.5}, False, says("stop", 0.7), LABELS) == {"none": 0.3, "stop": 0.7}


def test_a_reply_without_a_forecast_leaves_the_prior() -> None:
    prior = {"none": 0.4, "stop": 0.6}
    assert Counsel().pool(prior, True, says("", 0.0), LABELS) == prior


@given(
    st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1), st.sampled_from(LABELS)), max_size=30), st.floats(0, 1), st.floats(0, 1)
)
def test_what_is_pooled_is_a_distribution(lived: list[tuple[float, float, str]], model: float, reasoner: float) -> None:
    counsel = Counsel()
    for process, (one, other, ended) in enumerate(lived, 1):
        live_through(counsel, process, one, other, ended)
    pooled = counsel.pool({"none": 1 - model, "stop": model}, True, says("stop", reasoner), LABELS)
    assert sum(pooled.values()) == pytest.approx(1.0, abs=1e-6)
    assert all(-1e-9 <= value <= 1 + 1e-9 for value in pooled.values())
