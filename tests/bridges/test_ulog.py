"""Flight logs."""

from __future__ import annotations

import json
import lzma
import struct
from collections import Counter
from itertools import pairwise
from pathlib import Path

import pytest

from tests.bridges.recordings import Ulog, ulog
from wakeful.bridges.ulog import UlogBridge
from wakeful.contracts.bridge import SourceError
from wakeful.facts.events import Observation, Undecodable

MS = 1_000_000


def observations(path: Path, max_hz: float = 10.0) -> list[Observation]:
    items = list(UlogBridge(max_hz).read(path))
    assert all(isinstance(item, Observation) for item in items)
    return [item for item in items if isinstance(item, Observation)]


def test_rows_come_in_time_order_over_all_topics(tmp_path: Path) -> None:
    rows = observations(ulog(tmp_path / "a.ulg"))
    assert all(earlier.at_ns <= later.at_ns for earlier, later in pairwise(rows))
    assert Counter(row.topic for row in rows if not row.topic.startswith("sensor")) == {
        "vehicle_status": 3,
        "battery_status": 3,
        "battery_status.1": 3,
        "log": 2,
        "dropout": 1,
    }
    assert {row.clock for row in rows} == {"boot"}


def test_a_quick_stream_is_thinned_and_a_row_whose_flag_changes_is_kept(tmp_path: Path) -> None:
    path = ulog(tmp_path / "a.ulg")
    stream = [row for row in observations(path) if row.topic == "sensor_combined"]
    assert len(stream) == 31
    changed = next(row for row in stream if row.values["clipping"])
    assert changed.at_ns == (1000 + 153 * 10) * MS
    assert len([row for row in observations(path, max_hz=0) if row.topic == "sensor_combined"]) == 300


def test_a_status_is_never_thinned(tmp_path: Path) -> None:
    log = Ulog()
    log.format("estimator_status", "uint64_t timestamp;float drift")
    log.subscribe("estimator_status")
    for number in range(500):
        log.row("estimator_status", struct.pack("<Qf", number * 1_000, number))
    (tmp_path / "a.ulg").write_bytes(log.content)
    assert len(observations(tmp_path / "a.ulg")) == 500


def test_values_are_plain_arrays_are_lists_and_nan_is_none(tmp_path: Path) -> None:
    rows = observations(ulog(tmp_path / "a.ulg"))
    first = next(row for row in rows if row.topic == "sensor_combined")
    assert first.values == {"gyro": [pytest.approx(0.1), None, 0.0], "clipping": False}
    status = [row.values for row in rows if row.topic == "vehicle_status"]
    assert status[1] == {"nav_state": 1, "mode": "MISSION"}


def test_a_log_message_has_its_level_its_module_and_no_colours(tmp_path: Path) -> None:
    said = [row.values for row in observations(ulog(tmp_path / "a.ulg")) if row.topic == "log"]
    assert said[0] == {"level": "info", "severity": 1, "text": "Ready for takeoff!", "module": "commander"}
    assert said[1] == {"level": "critical", "severity": 4, "text": "Failsafe activated", "module": ""}


def test_an_event_is_put_into_words_by_the_logs_own_definitions(tmp_path: Path) -> None:
    definitions = {
        "version": 1,
        "components": {
            "1": {
                "namespace": "px4",
                "event_groups": {
                    "default": {
                        "events": {
                            "7": {
                                "name": "low",
                                "message": "Battery at {1:.1}%",
                                "arguments": [{"type": "float", "name": "left"}],
                            }
                        }
                    }
                },
            }
        },
    }
    log = Ulog()
    key = b"uint8_t[9] metadata_events"
    log.add(b"M", bytes([0, len(key)]) + key + lzma.compress(json.dumps(definitions).encode()))
    log.format("event", "uint64_t timestamp;uint32_t id;uint8_t log_levels;uint8_t[25] arguments")
    log.subscribe("event")
    for number, levels in ((7, 0x44), (8, 0x88)):
        log.row("event", struct.pack("<QIB25s", number, number | 1 << 24, levels, struct.pack("<f", 12.5)))
    (tmp_path / "a.ulg").write_bytes(log.content)
    known, unknown = (row.values for row in observations(tmp_path / "a.ulg"))
    assert {name: known[name] for name in ("level", "severity", "name", "text", "group")} == {
        "level": "warning",
        "severity": 2,
        "name": "low",
        "text": "Battery at 12.5%",
        "group": "default",
    }
    assert unknown["level"] == "protocol"
    assert "text" not in unknown


def test_a_truncated_log_loses_only_its_tail_and_says_so(tmp_path: Path) -> None:
    path = ulog(tmp_path / "a.ulg")
    whole = [item for item in observations(path) if item.topic != "dropout"]
    path.write_bytes(path.read_bytes()[:-2000])
    *rest, last = UlogBridge().read(path)
    assert len(rest) > len(whole) // 2
    assert [(item.at_ns, item.topic, item.values) for item in rest if isinstance(item, Observation)] == [
        (item.at_ns, item.topic, item.values) for item in whole[: len(rest)]
    ]
    assert isinstance(last, Undecodable)
    assert "ends in the middle" in last.reason


def test_a_row_with_an_impossible_time_is_refused_and_the_others_are_kept(tmp_path: Path) -> None:
    log = Ulog()
    log.format("cpuload", "uint64_t timestamp;float load")
    log.subscribe("cpuload")
    for at_us in (1, 2**63, 3):
        log.row("cpuload", struct.pack("<Qf", at_us, 0.5))
    (tmp_path / "a.ulg").write_bytes(log.content)
    items = list(UlogBridge(max_hz=0).read(tmp_path / "a.ulg"))
    assert [type(item) for item in items] == [Observation, Observation, Undecodable]


def test_the_library_prints_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = ulog(tmp_path / "a.ulg")
    damaged = bytearray(path.read_bytes())
    damaged[400:440] = bytes(40)
    path.write_bytes(damaged)
    list(UlogBridge().read(path))
    assert capsys.readouterr().out == ""


def test_another_thinning_is_another_digest(tmp_path: Path) -> None:
    path = ulog(tmp_path / "a.ulg")
    assert UlogBridge().digest(path) == UlogBridge(10).digest(path) != UlogBridge(0).digest(path)


def test_a_file_that_is_no_log_is_one_error(tmp_path: Path) -> None:
    (tmp_path / "a.ulg").write_bytes(b"PK\x03\x04" + bytes(100))
    with pytest.raises(SourceError, match=r"a\.ulg is no ULog file: it begins with 'PK"):
        list(UlogBridge().read(tmp_path / "a.ulg"))


def test_the_recorded_flights_are_read_whole(shared_data: Path) -> None:
    for path in sorted((shared_data / "px4_ulog").glob("*.ulg")):
        rows = observations(path)
        assert UlogBridge().peek(path).items == len(rows) > 1000
        assert all(earlier.at_ns <= later.at_ns for earlier, later in pairwise(rows))


def test_the_recorded_simulated_flight_says_in_words_what_happened(shared_data: Path) -> None:
    rows = observations(shared_data / "px4_ulog" / "sample_px4_events.ulg")
    said = [row.values["text"] for row in rows if row.topic == "event" and row.values.get("group") == "default"]
    for words in ("Armed by internal command", "Takeoff detected", "Landing detected", "Disarmed by landing"):
        assert words in said
