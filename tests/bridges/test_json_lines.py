"""What a line of JSON says."""

from __future__ import annotations

import json
from pathlib import Path
from runpy import run_path
from typing import Any

import jsonschema
import pytest

from tests.bridges.recordings import json_lines
from wakeful.bridges.json_lines import Refused, item_of
from wakeful.contracts.bridge import Item
from wakeful.facts.events import Condition, Context, Draft, Observation, Phase
from wakeful.facts.evidence import Evidence, Outcome

DOCS = Path(__file__).parents[2] / "docs"
S = 1_000_000_000


def item(said: object, before_ns: int = 0) -> Item:
    text = said if isinstance(said, bytes) else json.dumps(said).encode()
    return item_of(text, "pipe", 3, before_ns)[0]


def test_the_committed_schema_is_that_of_the_types() -> None:
    drawn = run_path(str(DOCS / "draw_jsonl_schema.py"), run_name="drawing")["schema"]()
    assert (DOCS / "jsonl.schema.json").read_text() == drawn, "run: ./run python docs/draw_jsonl_schema.py"


def test_the_documented_lines_are_in_the_schema_and_are_read() -> None:
    schema: dict[str, Any] = json.loads((DOCS / "jsonl.schema.json").read_text())
    examples = [line for line in (DOCS / "jsonl.md").read_text().splitlines() if line.startswith("{")]
    assert len(examples) == 4
    kinds = set()
    for example in examples:
        jsonschema.validate(json.loads(example), schema)
        kinds.add(type(item(example.encode())))
    assert kinds == {Observation, Draft, Evidence, Outcome}


def test_the_schema_refuses_what_the_bridge_refuses(tmp_path: Path) -> None:
    schema: dict[str, Any] = json.loads((DOCS / "jsonl.schema.json").read_text())
    for line in json_lines(tmp_path / "a.jsonl").read_text().splitlines():
        said = json.loads(line)
        if len(said) == 1:
            (fields,) = said.values()
            fields["unheard_of"] = 1
            with pytest.raises(jsonschema.ValidationError):
                jsonschema.validate(said, schema)
            with pytest.raises(Refused, match="unheard_of"):
                item(said)


def test_an_event_carries_its_context_and_condition() -> None:
    found = item(
        {
            "event": {
                "at": "1970-01-01T00:00:05Z",
                "kind": "blocked",
                "entity": "aisle",
                "context": {"task": "deliver", "safety": True},
                "condition": {"key": "r|aisle|blocked|", "phase": "raised"},
                "criticality": 3,
                "deadline_s": 4.5,
            }
        }
    )
    assert isinstance(found, Draft)
    assert found.context == Context(task="deliver", safety=True)
    assert found.condition == Condition(key="r|aisle|blocked|", phase=Phase.RAISED)
    assert (found.at_ns, found.position, found.criticality, found.deadline_s) == (5 * S, 3, 3, 4.5)


def test_evidence_without_an_id_gets_one_from_its_text_and_place() -> None:
    said = {"evidence": {"topic": "t", "key": "k", "value": {"a": [1, None]}}}
    first, again = item(said), item(said)
    other = item({"evidence": {"topic": "t", "key": "k", "value": 2}})
    assert isinstance(first, Evidence)
    assert isinstance(other, Evidence)
    assert first == again
    assert first.id != other.id
    assert json.loads(bytes(first.value)) == {"a": [1, None]}


def test_a_line_without_time_is_a_second_after_the_one_before() -> None:
    found = item({"topic": "pump", "pressure": 2}, before_ns=7 * S)
    assert isinstance(found, Observation)
    assert (found.at_ns, found.clock, found.topic) == (8 * S, "line", "pump")


@pytest.mark.parametrize("at", ["1970-01-01T00:00:09Z", "1970-01-01T01:00:09+01:00", 9, 9.0])
def test_times_are_iso_or_seconds(at: object) -> None:
    found = item({"observation": {"topic": "t", "values": {}, "at": at}})
    assert isinstance(found, Observation)
    assert found.at_ns == 9 * S


@pytest.mark.parametrize("at", [1_700_000_000, 1_700_000_000_000, 1_700_000_000_000_000, 1_700_000_000_000_000_000])
def test_large_numbers_are_read_by_their_size(at: int) -> None:
    found = item({"time": at, "x": 1})
    assert isinstance(found, Observation)
    assert found.at_ns == 1_700_000_000 * S


def test_a_vda5050_state_has_its_topic_its_robot_and_the_whole_message() -> None:
    said = {"headerId": 1, "timestamp": "1970-01-01T00:00:01Z", "version": "2.0.0", "manufacturer": "m", "serialNumber": "agv-7"}
    found = item({**said, "operatingMode": "AUTOMATIC", "errors": [{"errorType": "x"}]})
    assert isinstance(found, Observation)
    assert (found.topic, found.robot, found.at_ns) == ("state", "agv-7", S)
    assert found.values["errors"] == [{"errorType": "x"}]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (b"nonsense", "not JSON"),
        (b"[1]", "a JSON list, not an object"),
        (b'{"a": "\xff"}', "not UTF-8"),
        (b'{"a":' * 100 + b"1" + b"}" * 100, "deeper than 32"),
        (b'{"a":' * 100_000, "nested too deep|not JSON"),
        (b'{"event": {"kind": "k"}}', "missing required field `entity`"),
        (b'{"event": {"kind": "k", "entity": "e", "criticality": 9}}', "criticality"),
        (b'{"observation": {"topic": "t", "values": {}, "at": "soon"}}', "`at` is no instant: 'soon'"),
        (b'{"event": {"kind": "k", "entity": "e", "unheard_of": 1}}', "unheard_of"),
    ],
)
def test_what_cannot_be_read_is_refused_with_the_reason(text: bytes, reason: str) -> None:
    with pytest.raises(Refused, match=reason):
        item(text)


def test_nan_and_infinity_are_null() -> None:
    found = item(b'{"topic": "t", "a": NaN, "b": [Infinity, -Infinity, 1e999], "c": 2}')
    assert isinstance(found, Observation)
    assert found.values == {"topic": "t", "a": None, "b": [None, None, None], "c": 2}
