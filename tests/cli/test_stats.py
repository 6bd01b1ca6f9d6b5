"""`wakeful stats` says what registration made of a source."""

from __future__ import annotations

import json
from pathlib import Path

from tests.cli.conftest import Wakeful


def test_observations_per_event_and_incidents_beside_chance(wakeful: Wakeful, journal: Path) -> None:
    told = wakeful("stats", "--journal", journal).stdout
    assert "500 observations became 7 events." in told
    assert "One event stands for 71.4 observations." in told
    assert "protective_stop" in told
    assert "by chance" in told


def test_json_has_kinds_and_incidents(wakeful: Wakeful, journal: Path) -> None:
    told = json.loads(wakeful("stats", "--journal", journal, "--within", 20, "--json").stdout)
    assert told["within_s"] == 20
    assert {row["kind"] for row in told["kinds"]} == {"joint_current", "grip_lost", "temperature"}
    assert told["incidents"][0]["incidents"] == 1
