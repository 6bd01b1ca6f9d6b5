"""JSON lines, files of one message, directories, standard input."""

from __future__ import annotations

import json
import tracemalloc
from pathlib import Path

import pytest

from tests.bridges.recordings import in_memory, json_lines
from wakeful.bridges.jsonl import STDIN, JsonlBridge
from wakeful.contracts.bridge import SourceError
from wakeful.facts.events import Observation, Undecodable


def topics(*items: object) -> list[str]:
    return [item.topic for item in items if isinstance(item, Observation)]


def test_standard_input_is_read_line_by_line_and_taken_up_again() -> None:
    lines = b'{"topic": "a"}\n\n{"topic": "b"}\nbroken\n{"topic": "c"}'
    whole = list(JsonlBridge(stdin=in_memory(lines)).read(STDIN))
    assert topics(*whole) == ["a", "b", "c"]
    assert isinstance(whole[2], Undecodable)
    assert whole[2].position == 2
    assert list(JsonlBridge(stdin=in_memory(lines)).read(STDIN, after=1)) == whole[2:]


def test_standard_input_has_a_fresh_identity_unless_one_is_given() -> None:
    assert JsonlBridge().digest(STDIN) != JsonlBridge().digest(STDIN)
    assert JsonlBridge("shift").digest(STDIN) == JsonlBridge("shift").digest(STDIN)


def test_looking_at_standard_input_takes_nothing_from_it() -> None:
    stdin = in_memory(b'{"topic": "a"}\n')
    bridge = JsonlBridge(stdin=stdin)
    assert bridge.peek(STDIN).channels == ()
    assert topics(*bridge.read(STDIN)) == ["a"]


def test_a_line_of_ten_megabytes_is_refused_within_bounded_memory(tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    path.write_text(f'{{"topic": "a"}}\n{{"topic": "{"x" * 10_000_000}"}}\n{{"topic": "b"}}\n')
    tracemalloc.start()
    items = list(JsonlBridge().read(path))
    _, peak_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert topics(*items) == ["a", "b"]
    assert isinstance(items[1], Undecodable)
    assert items[1].reason == "a line of 10,000,014 bytes; the limit is 1,000,000"
    assert peak_bytes < 4_000_000


def test_a_truncated_file_loses_only_its_tail(tmp_path: Path) -> None:
    path = json_lines(tmp_path / "a.jsonl")
    whole = list(JsonlBridge().read(path))
    path.write_bytes(path.read_bytes()[:-10])
    cut = list(JsonlBridge().read(path))
    assert cut[:-1] == whole[:-1]
    assert isinstance(cut[-1], Undecodable)


def test_a_json_file_is_one_message_or_an_array_or_lines_by_another_name(tmp_path: Path) -> None:
    for text, expected in (
        ('{\n "topic": "a"\n}', ["a"]),
        ('[{"topic": "a"}, {"topic": "b"}]', ["a", "b"]),
        ('{"topic": "a"}\n{"topic": "b"}\n', ["a", "b"]),
    ):
        (tmp_path / "a.json").write_text(text)
        assert topics(*JsonlBridge().read(tmp_path / "a.json")) == expected


def test_a_directory_is_read_by_the_names_in_it_and_a_bad_file_is_one_refusal(tmp_path: Path) -> None:
    (tmp_path / "2.json").write_text('{"topic": "b"}')
    (tmp_path / "1.json").write_text('{"topic": "a"}')
    (tmp_path / "3.json").write_text("{")
    (tmp_path / "notes.txt").write_text("not mine")
    items = list(JsonlBridge().read(tmp_path))
    assert topics(*items) == ["a", "b"]
    assert [item.position for item in items if isinstance(item, Undecodable)] == [2]


def test_binary_data_called_jsonl_is_one_error(tmp_path: Path) -> None:
    (tmp_path / "a.jsonl").write_bytes(bytes(100))
    with pytest.raises(SourceError, match=r"a\.jsonl holds binary data"):
        list(JsonlBridge().read(tmp_path / "a.jsonl"))


def test_the_recorded_vda5050_examples_are_told_apart(shared_data: Path) -> None:
    for version in ("v1_1", "v2_0"):
        folder = shared_data / "vda5050" / "examples_openTCS" / version
        for item in JsonlBridge().read(folder):
            assert isinstance(item, Observation)
            keys = set(item.values)
            bare = keys <= {"headerId", "timestamp", "version", "manufacturer", "serialNumber"}
            assert item.topic == ("message" if bare else item.topic)
            assert item.topic in ("state", "order", "connection", "instantActions", "visualization", "message")
        states = [path for path in folder.glob("*.json") if "operatingMode" in json.loads(path.read_text())]
        assert topics(*JsonlBridge().read(folder)).count("state") == len(states)


@pytest.mark.parametrize("content", ["", "\n \n"])
def test_a_file_without_any_line_is_an_error_and_empty_standard_input_is_none(tmp_path: Path, content: str) -> None:
    path = tmp_path / "a.jsonl"
    path.write_text(content)
    with pytest.raises(SourceError, match="is empty"):
        JsonlBridge().peek(path)
    with pytest.raises(SourceError, match="is empty"):
        list(JsonlBridge().read(path))
    assert list(JsonlBridge(stdin=in_memory(content.encode())).read(STDIN)) == []


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ('{"event": 5}', "`event` must hold an object, not 5"),
        ('{"outcome": null}', "`outcome` must hold an object"),
        ('{"evnt": {"kind": "a", "entity": "b"}}', "did you mean `event`"),
        ('{"Events": {"kind": "a", "entity": "b"}}', "did you mean `event`"),
        ('{"obervation": {"topic": "a", "values": {}}}', "did you mean `observation`"),
    ],
)
def test_a_misspelt_or_misused_word_of_the_schema_is_refused(line: str, says: str) -> None:
    (item,) = JsonlBridge(stdin=in_memory(line.encode())).read(STDIN)
    assert isinstance(item, Undecodable)
    assert says in item.reason


@pytest.mark.parametrize(
    "line", ['{"evnt": 5}', '{"state": {"a": 1}}', '{"event": 5, "b": 1}', '{"evnt": {"a": 1}, "b": 2}', "{}"]
)
def test_any_other_object_is_still_an_observation(line: str) -> None:
    (item,) = JsonlBridge(stdin=in_memory(line.encode())).read(STDIN)
    assert isinstance(item, Observation)
