"""Exemplar memory: one validated experience suffices, one contradiction turns it, and what is unlike is left alone."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from tests.learning.worlds import LABELS, TREATMENTS, event
from wakeful.contracts.learner import Estimate, Vector
from wakeful.facts.decisions import Decision, Gate
from wakeful.facts.events import Event
from wakeful.facts.experience import Experience, Verdict
from wakeful.facts.lines import Decided, Gained
from wakeful.learning.alike import LIKE_ENOUGH
from wakeful.learning.exemplars import Exemplars

A, B = np.array([1.0, 0.0, 0.3, 0.9]), np.array([0.0, 1.0, 0.3, 0.9])


class Flat:
    """A model that looks at one number alone."""

    treatments, labels = TREATMENTS, LABELS
    typical = np.zeros(4)

    def __init__(self, column: int = 2, steep: float = 1.0) -> None:
        self.column, self.steep = column, steep

    def estimate(self, features: Vector) -> Estimate:
        share = min(1.0, self.steep * float(features[self.column]))
        return Estimate(treatments=np.array([share, 1.0 - share, 0.0]), labels=np.array([share, 1.0 - share]), novelty=0.0)

    def estimate_many(self, features: Vector) -> list[Estimate]:
        return [self.estimate(row) for row in features]


def encode(each: Event) -> Vector:
    return np.array([float(each.kind == "a"), float(each.kind == "b"), float(each.fields["load"] or 0.0), 0.9])  # type: ignore[arg-type]


def experience(number: int, outcome: str = "stop", treatment: str = "planning", **more: object) -> Experience:
    given = {"event": f"e{number}", "process": number, "predicted": "none", "verdict": Verdict.SUPPORTED, "mode": "auto", **more}
    return Experience(id=number, treatment=treatment, treatment_label=treatment, outcome=outcome, **given)  # type: ignore[arg-type]


def new(limit: int = 100) -> Exemplars:
    return Exemplars(encode, TREATMENTS, LABELS, limit)


def test_nothing_is_remembered_before_the_first_experience() -> None:
    assert new().recall(A, None) is None


def test_one_validated_experience_suffices() -> None:
    memory = new()
    memory.learn(experience(1), A)
    found = memory.recall(A, None)
    assert found is not None
    assert (found.treatment, found.label, found.experiences, found.likeness) == ("planning", "stop", (1,), 1.0)
    assert found.share > 0.85


def test_another_category_is_another_event() -> None:
    memory = new()
    memory.learn(experience(1), A)
    assert memory.recall(B, Flat()) is None


def test_numbers_that_make_no_difference_to_the_model_make_none_to_memory() -> None:
    memory = new()
    memory.learn(experience(1), A)
    other = A + np.array([0.0, 0.0, 0.0, 5.0])
    assert memory.recall(other, None) is None
    found = memory.recall(other, Flat())
    assert found is not None
    assert found.likeness == 1.0


def test_numbers_that_matter_to_the_model_tell_events_apart() -> None:
    memory = new()
    memory.learn(experience(1), A)
    far = A + np.array([0.0, 0.0, LIKE_ENOUGH + 0.1, 0.0])
    near = A + np.array([0.0, 0.0, 0.1, 0.0])
    assert memory.recall(far, Flat()) is None
    found = memory.recall(near, Flat())
    assert found is not None
    assert found.likeness == pytest.approx(0.9)


def test_the_likest_exemplar_speaks() -> None:
    memory = new()
    memory.learn(experience(1, "stop"), A)
    memory.learn(experience(2, "none"), A + np.array([0.0, 0.0, 0.4, 0.0]))
    at = A + np.array([0.0, 0.0, 0.3, 0.0])
    found = memory.recall(at, Flat())
    assert found is not None
    assert found.label == "none"
    assert len(memory) == 2


def test_one_contradiction_turns_what_is_said_where_outcomes_proved_reliable() -> None:
    memory = new()
    for number in range(1, 40):
        memory.learn(experience(number), A if number % 2 else B)
    memory.learn(experience(150, "none"), A)
    found = memory.recall(A, None)
    assert found is not None
    assert found.label == "none"
    assert found.treatment == "planning"
    untouched = memory.recall(B, None)
    assert untouched is not None
    assert untouched.label == "stop"


def test_noise_of_one_kind_of_event_does_not_make_another_doubtful() -> None:
    memory = new()
    for number in range(1, 60):
        memory.learn(experience(number, "stop" if number % 3 else "none"), A)
        memory.learn(experience(100 + number), B)
    noisy, steady = memory.recall(A, None), memory.recall(B, None)
    assert noisy is not None
    assert steady is not None
    assert noisy.noise > 0.2 > steady.noise
    assert steady.share > noisy.share


def test_a_refuted_treatment_is_no_treatment_to_reuse() -> None:
    memory = new()
    memory.learn(msgspec.structs.replace(experience(1), treatment_label="", verdict=Verdict.CONTRADICTED), A)
    found = memory.recall(A, None)
    assert found is not None
    assert (found.treatment, found.label) == ("", "stop")


def test_an_undecided_experience_of_no_treatment_teaches_nothing() -> None:
    memory = new()
    memory.learn(msgspec.structs.replace(experience(1), treatment_label="", verdict=Verdict.UNDECIDED), A)
    assert memory.recall(A, None) is None


def test_an_outcome_that_is_told_again_of_the_same_process_takes_the_place_of_the_earlier_one() -> None:
    memory, once = new(), new()
    memory.learn(experience(1, "none"), A)
    memory.learn(msgspec.structs.replace(experience(2, "stop"), process=1), A)
    once.learn(msgspec.structs.replace(experience(2, "stop"), process=1), A)
    found, only = memory.recall(A, None), once.recall(A, None)
    assert found is not None
    assert only is not None
    assert found.label == only.label == "stop"
    assert found.experiences == (2,)


def test_a_decision_that_rested_on_an_exemplar_teaches_that_exemplar() -> None:
    memory = new()
    memory.learn(experience(1), A)
    other = A + np.array([0.0, 0.0, 0.1, 3.0])
    memory.learn(experience(2, "none"), other, recalled=1)
    assert len(memory) == 1
    found = memory.recall(other, None)
    assert found is not None
    assert found.exemplar == 1


def test_what_was_validated_least_recently_is_forgotten() -> None:
    memory = new(limit=2)
    rows = [np.array([1.0, 0.0, load, 0.9]) for load in (0.1, 0.2, 0.3)]
    memory.learn(experience(1), rows[0])
    memory.learn(experience(2), rows[1])
    memory.learn(experience(3), rows[0])
    memory.learn(experience(4), rows[2])
    assert len(memory) == 2
    assert memory.recall(rows[1], None) is None
    assert memory.recall(rows[0], None) is not None


def test_a_column_that_turns_out_to_be_a_number_is_no_category_any_more() -> None:
    memory = new()
    memory.learn(experience(1), np.array([1.0, 0.0, 1.0, 0.9]))
    assert memory.recall(np.array([1.0, 0.0, 0.0, 0.9]), Flat(3)) is None
    memory.learn(experience(2), np.array([0.0, 1.0, 0.5, 0.9]))
    assert memory.recall(np.array([1.0, 0.0, 0.0, 0.9]), Flat(3)) is not None


def test_the_records_alone_give_the_same_memory() -> None:
    gate = Gate(confidence=0.9, threshold=0.5, novelty=0.0, novelty_limit=0.99, trust=1.0, trust_limit=0.4)
    live, again = new(), new()
    recorded: list[tuple[Decided | Gained, Event | None]] = []
    for number in range(1, 30):
        each = event(number, "ab"[number % 2], load=(number % 7) / 7)
        found = live.recall(encode(each), Flat())
        decision = Decision(
            treatment="planning",
            mode="auto",
            confidence=0.9,
            candidates=(),
            reasons=(),
            gate=gate,
            prior={"none": 0.7, "stop": 0.3},
            model=1,
            recalled=found.exemplar if found is not None else 0,
        )
        told = Gained(experience=experience(number, LABELS[number % 3 == 0], event=each.id))
        for record, of in ((Decided(process=number, event=each.id, decision=decision), None), (told, each)):
            live.apply(record, of)
            recorded.append((record, of))
    for record, of in recorded:
        again.apply(record, of)
    for kind in "ab":
        for load in range(7):
            features = encode(event(0, kind, load=load / 7))
            assert live.recall(features, Flat()) == again.recall(features, Flat())
    assert live.noise == again.noise
