"""Recent experience beside the result head: silent while the model is right, heard where it proves to know better."""

from __future__ import annotations

from random import Random

import msgspec
import numpy as np

from tests.learning.worlds import LABELS, event
from wakeful.contracts.learner import Vector
from wakeful.facts.choices import Basis, Choice
from wakeful.facts.decisions import Decision, Gate
from wakeful.facts.events import Event
from wakeful.facts.experience import Experience, Verdict
from wakeful.facts.lines import Decided
from wakeful.learning.recent import Recent

GATE = Gate(confidence=1.0, threshold=0.5, novelty=0.0, novelty_limit=1.0, trust=1.0, trust_limit=0.4)
SURE = {LABELS[0]: 0.9, LABELS[1]: 0.1}
BASIS = Basis(
    treatment="planning",
    model=1,
    watermark=1,
    treatments=("planning",),
    labels=LABELS,
    threshold=0.5,
    result_threshold=0.5,
    novelty_limit=1.0,
    trust_limit=0.4,
    support=9,
)


def encode(each: Event) -> Vector:
    return np.array([float(each.fields["load"] or 0.0), 1.0])  # type: ignore[arg-type]


def new() -> Recent:
    return Recent(encode, lambda events: [encode(each) for each in events], LABELS)


def decided(process: int, prior: dict[str, float], foretold: dict[str, float] | None = None, recalled: int = 0) -> Decided:
    decision = Decision(
        treatment="planning",
        mode="delib",
        confidence=1.0,
        candidates=(),
        reasons=(),
        gate=GATE,
        prior=prior,
        model=1,
        recalled=recalled,
        foretold=foretold or {},
    )
    return Decided(process=process, event=f"e{process}", decision=decision)


def gained(process: int, outcome: str) -> Experience:
    return Experience(
        id=process,
        event=f"e{process}",
        process=process,
        treatment="planning",
        treatment_label="",
        predicted=LABELS[0],
        outcome=outcome,
        verdict=Verdict.SUPPORTED if outcome == LABELS[0] else Verdict.CONTRADICTED,
        mode="delib",
    )


def lived(recent: Recent, rows: int, noise: float = 0.0, first: int = 1, delay: int = 5) -> None:
    """A model that always says label 0 in a world whose label is 1 from load .5 on; outcomes come ``delay`` events later."""
    random = Random(first)
    waiting: list[tuple[int, float]] = []
    for process in range(first, first + rows):
        recent.apply(decided(process, SURE))
        waiting.append((process, random.random() if noise < 1.0 else 0.0))
        if len(waiting) > delay:
            known, load = waiting.pop(0)
            label = LABELS[int(load >= 0.5) if noise < 1.0 else 0]
            recent.gain(gained(known, label), event(known, load=load))


def test_a_model_that_is_right_speaks_alone() -> None:
    recent = new()
    lived(recent, 300, noise=1.0)
    assert not recent.heard
    assert recent.weights == (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert recent.join((0.9, 0.1), np.array([0.9, 1.0])).tolist() == [0.9, 0.1]


def test_recent_experience_is_heard_where_the_model_is_wrong() -> None:
    recent = new()
    lived(recent, 300)
    assert recent.heard
    assert recent.join((0.9, 0.1), np.array([0.95, 1.0])).argmax() == 1
    assert recent.join((0.9, 0.1), np.array([0.05, 1.0])).argmax() == 0
    assert "recent experience joins them" in recent.says(SURE)


def test_asking_changes_nothing() -> None:
    asked, quiet = new(), new()
    for recent in (asked, quiet):
        lived(recent, 100)
    for load in np.linspace(0.0, 1.0, 30):
        asked.join((0.5, 0.5), np.array([load, 1.0]))
    for recent in (asked, quiet):
        lived(recent, 100, first=500)
    assert asked.weights == quiet.weights


def test_an_automatic_decision_in_a_pack_teaches_what_its_record_would() -> None:
    packed, recorded = new(), new()
    for process in range(1, 80):
        load = process % 10 / 10
        packed.covered(process, Choice(basis=BASIS, shares=(1.0,), prior=(0.9, 0.1), novelty=0.0, trust=1.0))
        recorded.apply(decided(process, SURE))
        for recent in (packed, recorded):
            recent.gain(gained(process, LABELS[int(load >= 0.5)]), event(process, load=load))
    assert packed.weights == recorded.weights
    assert packed.weights[0] < 1.0


def test_deliberation_that_decides_again_does_not_replace_what_the_model_had_said() -> None:
    once, again = new(), new()
    for process in range(1, 60):
        load = process % 10 / 10
        for recent in (once, again):
            recent.apply(decided(process, SURE))
        again.apply(decided(process, {LABELS[0]: 0.0, LABELS[1]: 1.0}))
        for recent in (once, again):
            recent.gain(gained(process, LABELS[int(load >= 0.5)]), event(process, load=load))
    assert once.weights == again.weights


def test_memory_is_not_asked_any_more_where_these_forecasts_outdo_it() -> None:
    recent = new()
    said = {LABELS[0]: 0.1, LABELS[1]: 0.9}
    for process in range(1, 4):
        assert not recent.outdoes_memory
        recent.apply(decided(process, said, foretold=SURE, recalled=1))
        recent.gain(gained(process, LABELS[0]), event(process, load=0.1))
    assert recent.outdoes_memory


def test_memory_that_is_right_stays() -> None:
    recent = new()
    said = {LABELS[0]: 0.1, LABELS[1]: 0.9}
    for process in range(1, 40):
        recent.apply(decided(process, said, foretold=SURE, recalled=1))
        recent.gain(gained(process, LABELS[1]), event(process, load=0.1))
    assert not recent.outdoes_memory


def test_who_is_heard_falls_silent_again_where_it_knows_no_better_than_the_model_alone() -> None:
    recent, random = new(), Random(3)
    lived(recent, 1_200)
    assert recent.heard
    heard = 0
    for process in range(2_000, 3_500):  # from here on the model is right but for noise, which nobody can foretell
        load = random.random()
        right = int(load >= 0.5)
        recent.apply(decided(process, {LABELS[right]: 0.85, LABELS[1 - right]: 0.15}))
        told = right if random.random() > 0.15 else 1 - right
        recent.gain(gained(process, LABELS[told]), event(process, load=load))
        heard += recent.heard
    assert heard < 600


def test_a_model_of_fewer_labels_teaches_the_same_packed_or_not() -> None:
    packed, recorded = new(), new()
    basis = msgspec.structs.replace(BASIS, labels=LABELS[:1])
    for process in range(1, 80):
        load = process % 10 / 10
        packed.covered(process, Choice(basis=basis, shares=(1.0,), prior=(1.0,), novelty=0.0, trust=1.0))
        recorded.apply(decided(process, {LABELS[0]: 1.0}))
        for recent in (packed, recorded):
            recent.gain(gained(process, LABELS[int(load >= 0.5)]), event(process, load=load))
    assert packed.weights == recorded.weights
    assert packed.weights[0] < 1.0
