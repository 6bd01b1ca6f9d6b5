"""What memory changes about a decision."""

from __future__ import annotations

import msgspec

from wakeful.facts.decisions import Audit, Candidate, Decision, Gate
from wakeful.facts.recollection import Recollection
from wakeful.selection.recalled import NOISY, RELIABLE, SURE, with_memory

GATE = Gate(confidence=0.6, threshold=0.9, novelty=0.2, novelty_limit=0.99, trust=0.3, trust_limit=0.4)
MADE = Decision(
    treatment="memory",
    mode="delib",
    confidence=0.6,
    candidates=(
        Candidate(treatment="memory", probability=0.6),
        Candidate(treatment="planning", probability=0.3),
        Candidate(treatment="diagnosis", probability=0.1),
    ),
    reasons=("The model said so.",),
    gate=GATE,
    prior={"none": 0.8, "stop": 0.2},
    model=3,
    rests_on=(1, 2),
)
FOUND = Recollection(
    exemplar=7,
    experiences=(9, 8, 7),
    likeness=1.0,
    treatment="planning",
    treatment_share=0.95,
    labels={"none": 0.1, "stop": 0.9},
    noise=0.02,
)


def found(**changes: object) -> Recollection:
    return msgspec.structs.replace(FOUND, **changes)


def test_without_a_recollection_the_decision_is_the_same() -> None:
    assert with_memory(MADE, None) == MADE


def test_what_is_believed_and_confirmed_is_automatic() -> None:
    made = with_memory(MADE, FOUND)
    assert (made.treatment, made.mode, made.prior, made.recalled, made.rests_on) == (
        "planning",
        "auto",
        FOUND.labels,
        7,
        FOUND.experiences,
    )
    assert [each.treatment for each in made.candidates] == ["planning", "memory", "diagnosis"]
    assert abs(sum(each.probability for each in made.candidates) - 1.0) < 1e-6
    assert made.gate.trust == 0.9


def test_what_was_contradicted_and_not_confirmed_since_is_deliberated() -> None:
    sure = msgspec.structs.replace(MADE, mode="auto")
    made = with_memory(sure, found(confirmed=False))
    assert made.mode == "delib"
    assert "confirmed" in made.reasons[1]


def test_without_a_told_treatment_the_models_is_deliberated() -> None:
    made = with_memory(MADE, found(treatment=""))
    assert (made.treatment, made.mode) == ("memory", "delib")


def test_what_is_hardly_believed_is_deliberated() -> None:
    assert with_memory(MADE, found(treatment_share=SURE - 0.01)).mode == "delib"


def test_a_last_word_against_it_counts_where_validations_are_reliable_and_else_not() -> None:
    assert with_memory(MADE, found(contradicted=True)).mode == "delib"
    assert with_memory(MADE, found(contradicted=True, noise=RELIABLE + 0.01)).mode == "auto"


def test_an_event_whose_validations_are_mostly_noise_is_left_to_the_model() -> None:
    made = with_memory(MADE, found(noise=NOISY + 0.01))
    assert made == msgspec.structs.replace(MADE, recalled=7)


def test_agreement_with_an_automatic_decision_changes_nothing_but_what_learns_from_it() -> None:
    sure = msgspec.structs.replace(MADE, mode="auto", treatment="planning", prior={"none": 0.2, "stop": 0.8})
    assert with_memory(sure, FOUND) == msgspec.structs.replace(sure, recalled=7)


def test_memory_never_allows_what_the_guarantee_gate_did_not() -> None:
    audit = Audit(treatment="memory", predicted="none", score=0.5, level=0.9, probability=0.2, drawn=False, alpha=0.05)
    assert with_memory(msgspec.structs.replace(MADE, audit=audit), FOUND).mode == "delib"
