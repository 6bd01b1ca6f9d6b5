"""An automatic decision follows from its numbers alone."""

from __future__ import annotations

import msgspec

from tests.facts.test_packs import CHOICE


def test_a_choice_gives_the_decision_with_its_words() -> None:
    decision = CHOICE.decision()
    assert (decision.treatment, decision.mode, decision.confidence) == ("memory", "auto", 0.9)
    assert [each.treatment for each in decision.candidates] == ["memory", "description"]
    assert decision.prior == {"none": 0.8, "intervention": 0.2}
    assert decision.rests_on == (4, 2)
    assert decision.reasons == (
        "Model version 3, learned from 120 experiences, gives memory 0.900, before description with 0.100.",
        "Automatic: confidence 0.900 (at least 0.50), forecast 'none' with 0.800 (at least 0.55), "
        "novelty 0.100 (at most 0.99), trust 0.80 (at least 0.4), 12 validated experiences.",
    )
    assert CHOICE.confidence == 0.9


def test_equal_shares_stand_in_the_order_of_the_treatments() -> None:
    basis = msgspec.structs.replace(CHOICE.basis, treatment="description")
    even = msgspec.structs.replace(CHOICE, basis=basis, shares=(0.5, 0.5))
    assert [each.treatment for each in even.decision().candidates] == ["description", "memory"]
