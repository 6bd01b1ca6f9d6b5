"""A batch foresees for each event what it would have been told alone; decisions then depend on trust and experience as of now."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from wakeful.facts.domain import DetectorSpec, DomainSpec, FieldSpec
from wakeful.facts.events import Draft, Event
from wakeful.facts.inputs import TrainingJob
from wakeful.facts.time import Stamp
from wakeful.learning.two_heads import TwoHeads
from wakeful.selection.gating import SelectionSettings
from wakeful.selection.selector import Selector

TREATMENTS = ("description", "memory", "planning")
SPEC = DomainSpec(
    name="bench",
    version=1,
    says="a bench",
    fields={"state": FieldSpec(values=("normal", "odd")), "load": FieldSpec(low=0.0, high=1.0)},
    detect=(DetectorSpec(detector="band", kind="seen"),),
    treatments=("description", "memory"),
)


def _event(number: int) -> Event:
    fields = {"state": "odd" if number % 3 else "normal", "load": number * 7 % 11 / 10.0}
    return Event(
        id=f"e{number}",
        kind="seen",
        entity=f"cup-{number:03d}",
        source="s",
        position=number,
        stamp=Stamp(source_ns=1),
        fields=fields,
    )


@pytest.fixture(scope="module")
def selector() -> Selector:
    learner = TwoHeads()
    made = Selector(SPEC, TREATMENTS, learner, SelectionSettings(confidence=0.5, result_confidence=0.5, novelty_limit=1.0))
    features = np.array([made.encoder.encode(_event(number)) for number in range(60)])
    state = features[:, made.encoder.columns.index("state=odd")]
    job = TrainingJob(
        training=1,
        base_version=0,
        base_weights=b"",
        watermark=60,
        seed=1,
        epochs=30,
        treatments=TREATMENTS,
        labels=("none", "intervention"),
        features=features,
        treatment=np.where(state > 0, 1, 0),
        result=np.where(state > 0, 1, 0),
        refuted=np.full(60, -1),
        weight=np.ones(60),
        held_back=np.arange(60) % 5 == 0,
    )
    card, weights = learner.train(job)
    made.use(msgspec.structs.replace(card, thresholds={"*": 0.6, "@result": 0.55}), weights)
    return made


def test_a_batch_is_seen_as_each_of_its_events_alone(selector: Selector) -> None:
    events = [_event(number) for number in range(40)]
    together = selector.foresee(events)
    assert together is not None
    assert [seen[:6] for seen in together] == [selector.see(event)[:6] for event in events]  # type: ignore[index]


def test_a_draft_is_seen_as_the_event_that_it_becomes(selector: Selector) -> None:
    event = _event(4)
    draft = Draft(kind=event.kind, entity=event.entity, source="s", position=4, at_ns=1, fields=event.fields)
    assert [seen[:6] for seen in selector.foresee([draft]) or []] == [selector.see(event)[:6]]  # type: ignore[index]


def test_a_choice_is_the_decision_that_would_be_made(selector: Selector) -> None:
    automatic = 0
    for seen, event in zip(selector.foresee([_event(n) for n in range(40)]) or [], map(_event, range(40)), strict=True):
        choice = selector.choose(seen, 0.8, (5, 3))
        decision = selector.decide(event, dict.fromkeys(TREATMENTS, 0.8), (5, 3), 60)
        if choice is None:
            assert decision.mode != "auto"
            continue
        automatic += 1
        assert choice.decision() == decision
        assert decision.candidates[0].treatment == decision.treatment
        assert sum(each.probability for each in decision.candidates) == pytest.approx(1.0, abs=1e-5)
        assert decision.gate.confidence >= decision.gate.threshold
    assert automatic > 10


def test_trust_is_asked_when_the_decision_is_made(selector: Selector) -> None:
    seen = next(each for each in selector.foresee([_event(n) for n in range(9)]) or [] if selector.choose(each, 0.8, ()))
    assert selector.choose(seen, 0.39, ()) is None
    assert selector.choose(seen, 0.4, ()) is not None


def test_without_a_model_nothing_is_foreseen() -> None:
    bare = Selector(SPEC, TREATMENTS, TwoHeads(), SelectionSettings())
    assert bare.foresee([_event(1)]) is None
    assert bare.see(_event(1)) is None
    assert bare.cells([_event(1)]) == [-1]
