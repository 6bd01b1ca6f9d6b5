"""When a training is due, and that its job is the fold of the records."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.learning.worlds import TREATMENTS, event, experience
from wakeful.contracts.learner import Vector
from wakeful.facts.domain import DomainSpec, OutcomeSpec
from wakeful.facts.events import Event
from wakeful.facts.experience import ModelCard
from wakeful.facts.inputs import TrainingJob
from wakeful.facts.lines import Gained, Published, TrainingAsked
from wakeful.facts.settings import MindSettings
from wakeful.learning.plan import Learning, LearningSettings
from wakeful.learning.two_heads import TwoHeads

SPEC = DomainSpec(name="d", version=1, says="", outcome=OutcomeSpec(labels=("none", "stop")))
FEW = LearningSettings(min_experiences=3, every=4, latency_s=2.0, seed=5, held_back=0.25)


def encode(of: Event) -> Vector:
    load = of.fields["load"]
    assert isinstance(load, float)
    return np.array([load, 1.0])


def learning(chosen: LearningSettings = FEW) -> Learning:
    return Learning(SPEC, TREATMENTS, TwoHeads(), encode, chosen)


def gain(into: Learning, number: int, **more: object) -> None:
    of = event(number, load=(number % 7) / 7)
    into.apply(Gained(experience=experience(number, of, **more)), of)  # type: ignore[arg-type]


def card(training: int, accepted: bool = True) -> ModelCard:
    return ModelCard(version=training, base=0, watermark=0, seed=0, epochs=1, blob="", accepted=accepted)


def same(one: TrainingJob, other: TrainingJob) -> bool:
    return all(
        np.array_equal(np.asarray(getattr(one, name)), np.asarray(getattr(other, name))) for name in TrainingJob.__struct_fields__
    )


def test_the_first_training_waits_for_enough_experiences_and_the_next_for_more() -> None:
    one = learning()
    for number in (1, 2):
        gain(one, number)
        assert one.due(0) is None
    gain(one, 3)
    asked = one.due(10**9)
    assert asked == TrainingAsked(training=1, base=0, watermark=3, seed=6, epochs=140, publish_ns=3 * 10**9)
    assert one.due(10**9) == asked
    one.apply(asked)
    gain(one, 4)
    assert one.due(0) is None
    one.apply(Published(training=1, card=card(1)))
    for number in (5, 6):
        gain(one, number)
        assert one.due(0) is None
    gain(one, 7)
    second = one.due(0)
    assert second is not None
    assert (second.training, second.base, second.epochs, second.watermark) == (2, 1, 35, 7)


def test_a_mind_that_does_not_train_keeps_its_version_however_much_it_experiences() -> None:
    trains, stays = (learning(LearningSettings.under(MindSettings(trains=each))) for each in (True, False))
    for number in range(1, 41):
        gain(trains, number)
        gain(stays, number)
    assert trains.due(0) is not None
    assert stays.due(0) is None


def test_a_rejected_challenger_is_not_what_the_next_training_comes_from() -> None:
    one = learning()
    for number in range(1, 4):
        gain(one, number)
    asked = one.due(0)
    assert asked is not None
    one.apply(asked)
    one.apply(Published(training=1, card=card(1, accepted=False)))
    for number in range(4, 8):
        gain(one, number)
    again = one.due(0)
    assert again is not None
    assert (again.base, again.epochs, again.training) == (0, 140, 2)


def test_contradicted_automatic_decisions_bring_a_training_sooner() -> None:
    one = learning(LearningSettings(min_experiences=3, every=10, contradiction_counts=5))
    for number in range(1, 4):
        gain(one, number)
    asked = one.due(0)
    assert asked is not None
    one.apply(asked)
    one.apply(Published(training=1, card=card(1)))
    gain(one, 4, outcome="stop", mode="delib")
    gain(one, 5, outcome="stop", mode="auto")
    assert one.due(0) is None
    gain(one, 6, outcome="stop", mode="auto")
    assert one.due(0) is not None


def test_the_interval_grows_with_experience() -> None:
    one = learning(LearningSettings(min_experiences=3, every=4, growth=1.0))
    for number in range(1, 7):
        gain(one, number)
    asked = one.due(0)
    assert asked is not None
    one.apply(asked)
    one.apply(Published(training=1, card=card(1)))
    for number in range(7, 11):
        gain(one, number)
    assert one.due(0) is None
    for number in range(11, 20):
        gain(one, number)
    assert one.due(0) is not None


def test_labels_follow_the_verdict_and_what_was_told() -> None:
    one = learning(LearningSettings(min_experiences=1, held_back=0.0, corrective_weight=2.3))
    gain(one, 1)
    gain(one, 2, outcome="stop")
    gain(one, 3, outcome="stop", label="planning")
    gain(one, 4, treatment="unheard_of", outcome="stop")
    asked = one.due(0)
    assert asked is not None
    job = one.job(asked, b"")
    assert np.asarray(job.treatment).tolist() == [0, -1, 2, -1]
    assert np.asarray(job.result).tolist() == [0, 1, 1, 1]
    assert np.asarray(job.weight).tolist() == [1.0, 2.3, 2.3, 2.3]
    assert (job.treatments, job.labels) == (TREATMENTS, ("none", "stop"))


def test_a_later_experience_of_a_process_takes_the_place_of_its_earlier_one() -> None:
    one = learning()
    gain(one, 1, process=9)
    of = event(1)
    one.apply(Gained(experience=experience(2, of, outcome="stop", process=9)), of)
    assert [(row.id, row.result) for row in one.rows] == [(2, 1)]


def test_a_job_is_the_same_after_recovery_even_when_more_came_meanwhile() -> None:
    live = learning()
    for number in range(1, 30):
        gain(live, number, outcome="stop" if number % 3 else "none")
    asked = live.due(0)
    assert asked is not None
    live.apply(asked)
    job = live.job(asked, b"")
    recovered = learning()
    for number in range(1, 30):
        gain(recovered, number, outcome="stop" if number % 3 else "none")
    recovered.apply(asked)
    for number in range(30, 60):
        gain(recovered, number)
    of = event(3)
    recovered.apply(Gained(experience=experience(60, of, process=3)), of)
    assert same(recovered.job(asked, b""), job)
    assert recovered.due(0) is None


@settings(max_examples=30, deadline=None)
@given(
    st.lists(st.tuples(st.sampled_from(TREATMENTS), st.sampled_from(("none", "stop"))), min_size=3, max_size=80),
    st.integers(4, 40),
)
def test_a_job_is_bounded_and_leaves_something_to_learn_from(kinds: list[tuple[str, str]], limit: int) -> None:
    chosen = LearningSettings(min_experiences=3, replay=limit, remembered=limit * 2, held_back=0.3)
    one = learning(chosen)
    for number, (treatment, outcome) in enumerate(kinds, 1):
        gain(one, number, treatment=treatment, outcome=outcome)
    asked = one.due(0)
    assert asked is not None
    job = one.job(asked, b"")
    held_back = np.asarray(job.held_back)
    assert 0 < (~held_back).sum() <= limit
    assert held_back.sum() <= limit
    assert len(one.rows) <= limit * 2 + limit // 4
    known = {(row.label if row.label >= 0 else row.applied) for row in one.rows}
    rows = zip(np.asarray(job.treatment)[~held_back].tolist(), strict=True)
    assert {label for (label,) in rows if label >= 0} <= known


def test_an_experience_without_its_event_is_refused_and_changes_nothing() -> None:
    one = learning()
    with pytest.raises(ValueError, match="needs its event"):
        one.apply(Gained(experience=experience(1, event(1))))
    with pytest.raises(ValueError, match="needs its event"):
        one.apply(Gained(experience=experience(1, event(1))), event(2))
    assert one.watermark == 0


def test_a_whole_round_from_records_to_a_published_version() -> None:
    one = learning(LearningSettings(min_experiences=40))
    for number in range(1, 61):
        risky = (number % 7) / 7 > 0.5
        gain(one, number, treatment="planning" if risky else "description", predicted="stop", outcome="stop" if risky else "none")
    asked = one.due(0)
    assert asked is not None
    one.apply(asked)
    made, weights = one.learner.train(one.job(asked, b""))
    one.apply(Published(training=asked.training, card=made))
    assert one.pending is None
    predictor = one.learner.load(weights)
    assert predictor.estimate(np.array([0.9, 1.0])).labels.argmax() == 1
    assert predictor.estimate(np.array([0.0, 1.0])).labels.argmax() == 0
