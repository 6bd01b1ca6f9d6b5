"""What is true of an encounter, checked against the rule as it is written down for Experiment 1."""

from __future__ import annotations

import pytest

from wakeful.domains.service_robot.world import Encounter, needed, right_treatment


def met(**fields: object) -> Encounter:
    plain = {
        "category": "item",
        "location": "center",
        "state": "normal",
        "history": "unchanged",
        "route": "none",
        "load": 0.2,
        "context": "none",
    }
    return Encounter(**{**plain, **fields})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("fields", "treatment"),
    [
        ({}, "description"),
        ({"state": "unstable", "location": "edge"}, "risk_prediction"),
        ({"state": "unstable", "context": "safety", "load": 0.61}, "risk_prediction"),
        ({"state": "unstable", "context": "safety", "load": 0.59}, "description"),
        ({"route": "blocking"}, "description"),
        ({"route": "blocking", "context": "task"}, "planning"),
        ({"route": "outside", "context": "task", "load": 0.7}, "planning"),
        ({"route": "outside", "context": "safety", "load": 0.7}, "description"),
        ({"category": "device", "state": "abnormal", "history": "moved"}, "diagnosis"),
        ({"category": "unknown", "history": "none"}, "analogy"),
        ({"category": "unknown"}, "description"),
        ({"history": "moved"}, "memory"),
        ({"route": "blocking", "context": "task", "state": "unstable", "location": "edge"}, "planning"),
        ({"route": "blocking", "context": "safety", "state": "unstable", "location": "edge"}, "risk_prediction"),
        ({"route": "blocking", "context": "safety", "category": "device", "state": "abnormal"}, "diagnosis"),
    ],
)
def test_the_right_treatment_is_the_first_active_cue_in_the_order_of_the_context(
    fields: dict[str, object], treatment: str
) -> None:
    assert right_treatment(met(**fields)) == treatment


def test_intervention_is_needed_when_the_state_is_not_normal_until_a_signature_turns() -> None:
    device = met(category="device", state="abnormal")
    assert needed(device, frozenset()) == "intervention"
    assert needed(device, frozenset("D")) == "none"
    assert needed(met(), frozenset()) == "none"
    assert needed(met(), frozenset("A")) == "intervention"
    assert needed(met(), frozenset("BCD")) == "none"
