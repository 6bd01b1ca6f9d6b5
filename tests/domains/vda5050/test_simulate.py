"""The fleet's stream: valid against the standard's schema, repeatable, and eventful in the way that errors are."""

from __future__ import annotations

import json
from collections import Counter
from itertools import islice, pairwise
from pathlib import Path

import jsonschema
import pytest

from tests.domains.vda5050.fleet import DOMAIN
from wakeful.domains.vda5050.simulate import FLEET, messages, simulate, write_jsonl
from wakeful.domains.vda5050.vehicle import Body
from wakeful.registration import SpecRegistrar

LENGTH = 10_000


@pytest.fixture(scope="module")
def stream() -> list[Body]:
    return list(islice(messages(5), LENGTH))


def test_every_message_is_valid_against_the_recorded_schema(shared_data: Path, stream: list[Body]) -> None:
    schema = json.loads((shared_data / "vda5050" / "json_schemas_2.1.0" / "state.schema").read_text())
    validator = jsonschema.Draft202012Validator(schema, format_checker=jsonschema.FormatChecker())
    with_errors = [body for body in stream if body["errors"]]
    for body in [*stream[::40], *with_errors[::20]]:
        validator.validate(json.loads(json.dumps(body)))


def test_the_same_seed_gives_the_same_stream_and_another_seed_another(stream: list[Body]) -> None:
    assert list(islice(messages(5), 2_000)) == stream[:2_000]
    assert list(islice(messages(6), 2_000)) != stream[:2_000]


def test_time_never_runs_back_and_every_vehicle_counts_up(stream: list[Body]) -> None:
    times = [str(body["timestamp"]) for body in stream]
    assert all(a <= b for a, b in pairwise(times))
    for serial in FLEET:
        headers = [int(str(body["headerId"])) for body in stream if body["serialNumber"] == serial]
        assert all(a < b for a, b in pairwise(headers))


def test_errors_appear_repeat_change_and_clear_and_are_few_events(stream: list[Body]) -> None:
    registrar = SpecRegistrar(DOMAIN, "d")
    registered = [registrar.observe(one) for one in islice(simulate(5), LENGTH)]
    phases = Counter(str(event.condition.phase) for each in registered for event in each.events if event.condition)
    labels = Counter(outcome.label for each in registered for outcome in each.outcomes)
    topics = Counter(evidence.topic for each in registered for evidence in each.evidence)
    sent = sum(len(body["errors"]) for body in stream)  # type: ignore[arg-type]
    assert phases["raised"] > 10
    assert phases["changed"] > 0
    assert set(labels) == {"cleared", "escalated", "stopped"}
    assert topics["condition.repeated"] > 20 * phases["raised"]
    assert sum(phases.values()) < sent / 20


def test_the_stream_can_be_written_as_json_lines(tmp_path: Path, stream: list[Body]) -> None:
    path = tmp_path / "fleet.jsonl"
    write_jsonl(5, 100, path)
    assert [json.loads(line) for line in path.read_text().splitlines()] == stream[:100]
