"""The main job as a user runs it: every source in, coverage proved, and nothing twice when it is read again."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from wakeful.cli.main import main

RECORDED = [
    ("ur3_cobotops/dataset.xlsx", "ur3_cobotops"),
    ("px4_ulog/sample_px4_events.ulg", "px4_ulog"),
    ("px4_ulog/sample.ulg", "px4_ulog"),
    ("rosbag2_turtlebot", "mobile_base"),
    ("rosbag1/test2.bag", "mobile_base"),
    ("rosbag2_samples/rosbag2_py/test/resources/mcap/talker/talker.mcap", "mobile_base"),
]


def run(*arguments: str) -> dict:
    """One command with ``--json``; its one object on standard output."""
    done = CliRunner().invoke(main, [*arguments, "--json"])
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def check_twice(source: str, domain: str, journal: Path, *more: str) -> dict:
    first = run("run", source, "--journal", str(journal), *more)
    assert first["domain"] == domain
    assert first["received"] == first["admitted"] + first["duplicate"] + first["refused"]
    assert first["coverage"] == 1.0
    audit = run("audit", "--journal", str(journal))
    assert audit["ok"], audit
    again = run("run", source, "--journal", str(journal), *more)
    assert again["this_run"]["admitted"] == 0
    assert again["this_run"]["duplicate"] == first["admitted"] + first["duplicate"]
    assert again["this_run"]["refused"] == first["refused"]
    assert run("audit", "--journal", str(journal))["ok"]
    return first


@pytest.mark.parametrize(("source", "domain"), RECORDED)
def test_a_recorded_source_is_covered_and_its_second_reading_is_all_duplicates(
    shared_data: Path, tmp_path: Path, source: str, domain: str
) -> None:
    check_twice(str(shared_data / source), domain, tmp_path / "mind.db")


def test_a_state_stream_of_the_fleet_standard_is_covered_and_its_second_reading_is_all_duplicates(tmp_path: Path) -> None:
    stream = tmp_path / "states.jsonl"
    made = CliRunner().invoke(main, ["simulate", "vda5050", "--messages", "400", "--seed", "3"])
    assert made.exit_code == 0, made.output
    stream.write_text(made.stdout)
    found = check_twice(str(stream), "vda5050", tmp_path / "mind.db")
    assert 0 < found["admitted"] < 200


def test_anybodys_events_are_covered_and_their_second_reading_is_all_duplicates(tmp_path: Path) -> None:
    lines = [{"event": {"kind": "alarm", "entity": f"pump {n % 3}", "at": 1_700_000_000 + n}} for n in range(9)]
    source = tmp_path / "events.jsonl"
    source.write_text("\n".join([*map(json.dumps, lines), "not json", ""]))
    found = check_twice(str(source), "jsonl", tmp_path / "mind.db")
    assert (found["admitted"], found["refused"]) == (9, 1)


def test_the_simulated_robot_goes_on_where_it_stopped(tmp_path: Path) -> None:
    journal = str(tmp_path / "mind.db")
    first = run("run", "service_robot", "--events", "60", "--journal", journal)
    second = run("run", "service_robot", "--events", "60", "--journal", journal)
    assert first["this_run"]["admitted"] >= 60
    assert second["this_run"]["duplicate"] == 0
    assert second["admitted"] == first["admitted"] + second["this_run"]["admitted"]
    assert run("audit", "--journal", journal)["ok"]
