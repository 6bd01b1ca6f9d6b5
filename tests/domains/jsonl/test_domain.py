"""The domain for anybody's JSON lines: what it takes, what it registers of plain observations, and how seldom it is chosen."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

import pytest

from wakeful.bridges.jsonl import JsonlBridge
from wakeful.contracts.bridge import Peek
from wakeful.contracts.domain import Registered
from wakeful.domains import load, recognise
from wakeful.facts.domain import matches
from wakeful.facts.events import Observation
from wakeful.facts.time import NS_PER_S
from wakeful.facts.values import Field, Value
from wakeful.registration import SpecRegistrar

DOMAIN = load("jsonl")
SPEC = DOMAIN.spec


def registered(many: Iterable[tuple[str, dict[str, Value]]]) -> list[Registered]:
    registrar = SpecRegistrar(DOMAIN, "d")
    return [
        registrar.observe(Observation(source="s", position=i, topic=topic, at_ns=i * NS_PER_S, values=values))
        for i, (topic, values) in enumerate(many)
    ]


def kinds(many: Iterable[tuple[str, dict[str, Value]]]) -> list[str]:
    return [event.kind for each in registered(many) for event in each.events]


def advised(**has: Field) -> str:
    """The treatment of the weightiest guideline that holds."""
    return max((rule for rule in SPEC.guideline if matches(rule.when, has)), key=lambda rule: rule.weight).treat


def test_it_is_recognised_for_json_lines_and_only_where_nothing_better_is(tmp_path: Path) -> None:
    path = tmp_path / "anything.jsonl"
    assert recognise(Peek("jsonl", ("base/speed",)), path) == "jsonl"
    state = ("state/headerId", "state/serialNumber", "state/errors", "state/operatingMode")
    assert recognise(Peek("jsonl", state), path) == "vda5050"
    assert recognise(Peek("xlsx", ("row/speed",)), tmp_path / "rows.xlsx") != "jsonl"


def test_quiet_observations_are_no_events() -> None:
    assert kinds(("base", {"speed": 0.5 + 0.01 * (i % 7), "battery": 0.9, "mode": "auto"}) for i in range(500)) == []


def test_a_value_far_out_of_its_band_is_one_event() -> None:
    calm: list[tuple[str, dict[str, Value]]] = [("base", {"speed": 0.5 + 0.01 * (i % 7)}) for i in range(300)]
    assert kinds([*calm, ("base", {"speed": 9.0}), ("base", {"speed": 9.0}), *calm[:20]]) == ["unusual"]


@pytest.mark.parametrize(
    ("values", "kind"),
    [
        ({"emergency_stop": True}, "stopped"),
        ({"fault": 1}, "flag"),
        ({"errors": [{"type": "overheating", "level": "FATAL"}]}, "error"),
        ({"level": "error", "text": "motor 3 does not answer"}, "message"),
    ],
)
def test_what_lasts_is_one_event_however_often_it_is_sent(values: dict[str, Value], kind: str) -> None:
    assert kinds(("base", values) for _ in range(40)) == [kind]


def test_a_change_of_state_is_an_event() -> None:
    assert kinds([("base", {"status": "ok"})] * 5 + [("base", {"status": "degraded"})] * 5) == ["state"]


def test_a_failure_that_is_flagged_is_an_outcome() -> None:
    outcomes = [outcome for each in registered([("base", {"failure": i > 3}) for i in range(8)]) for outcome in each.outcomes]
    assert [(outcome.label, outcome.entity) for outcome in outcomes] == [("failure", "*")]


def test_guidelines_go_by_what_is_pressing_by_memory_and_by_words() -> None:
    plain: dict[str, Field] = {"kind": "whatever", "relation": "new", "criticality": 0, "safety": False}
    assert advised(**plain) == "description"
    assert advised(**{**plain, "kind": "blocked"}) == "planning"
    assert advised(**{**plain, "kind": "overheating", "criticality": 2}) == "diagnosis"
    assert advised(**{**plain, "criticality": 3}) == "risk_prediction"
    assert advised(**{**plain, "relation": "moved"}) == "memory"
    assert advised(**{**plain, "criticality": 1}) == "analogy"
    assert advised(**{**plain, "recent_entity": 7}) == "causal_analysis"


def test_an_event_of_any_kind_and_fields_can_be_piped_in(tmp_path: Path) -> None:
    path = tmp_path / "events.jsonl"
    event = {"kind": "found_a_cat", "entity": "cat-1", "fields": {"fur": "striped", "weight_kg": 4.2}, "criticality": 1}
    path.write_text(json.dumps({"event": event}) + "\n" + json.dumps({"outcome": {"label": "none", "entity": "cat-1"}}) + "\n")
    items = list(JsonlBridge().read(path))
    assert [type(item).__name__ for item in items] == ["Draft", "Outcome"]
