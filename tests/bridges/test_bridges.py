"""Every bridge keeps the contract, and the right one is found for a path."""

from __future__ import annotations

import sys
from pathlib import Path

import msgspec
import pytest

from wakeful.bridges import bridge_for, bridges
from wakeful.bridges.jsonl import JsonlBridge
from wakeful.contracts.bridge import SourceError
from wakeful.facts.events import Observation
from wakeful.testing.bridge_checks import check_bridge

KINDS = {".csv": "xlsx", ".xlsx": "xlsx", ".ulg": "ulog", ".bag": "rosbag", ".db3": "rosbag", ".mcap": "mcap", ".jsonl": "jsonl"}


@pytest.mark.parametrize("suffix", KINDS)
def test_a_bridge_keeps_its_contract(recordings: dict[str, Path], suffix: str) -> None:
    bridge = bridge_for(recordings[suffix])
    assert bridge.name == KINDS[suffix]
    items = check_bridge(bridge, recordings[suffix])
    assert len(items) >= 20


@pytest.mark.parametrize("suffix", KINDS)
def test_what_a_bridge_delivers_can_be_written_as_json_without_nan(recordings: dict[str, Path], suffix: str) -> None:
    for item in bridge_for(recordings[suffix]).read(recordings[suffix]):
        if isinstance(item, Observation):
            assert msgspec.json.decode(msgspec.json.encode(item.values)) == item.values


@pytest.mark.parametrize("suffix", [".ulg", ".bag", ".db3", ".mcap"])
def test_a_recording_is_recognised_by_its_first_bytes_under_any_name(
    recordings: dict[str, Path], suffix: str, tmp_path: Path
) -> None:
    nameless = tmp_path / "flight"
    nameless.write_bytes(recordings[suffix].read_bytes())
    assert bridge_for(nameless).name == KINDS[suffix]


def test_a_path_that_is_not_there_is_one_clear_error(tmp_path: Path) -> None:
    with pytest.raises(SourceError, match=r"there is no file or directory .*gone\.bag"):
        bridge_for(tmp_path / "gone.bag")


def test_a_file_that_nothing_reads_is_answered_with_what_could_be_read(tmp_path: Path) -> None:
    (tmp_path / "picture.png").write_bytes(b"\x89PNG\r\n")
    with pytest.raises(SourceError, match=r"nothing reads .*picture\.png.*jsonl, mcap, rosbag, ulog, xlsx"):
        bridge_for(tmp_path / "picture.png")


@pytest.mark.parametrize("suffix", KINDS)
def test_an_empty_file_is_one_error(suffix: str, tmp_path: Path) -> None:
    empty = tmp_path / f"empty{suffix}"
    empty.touch()
    with pytest.raises(SourceError, match=f"empty{suffix}"):
        list(bridge_for(empty).read(empty))


@pytest.mark.parametrize("suffix", KINDS)
def test_a_directory_in_a_files_place_is_one_error(suffix: str, tmp_path: Path) -> None:
    folder = tmp_path / f"folder{suffix}"
    folder.mkdir()
    with pytest.raises(SourceError, match="folder"):
        list(next(each for each in bridges() if each.name == KINDS[suffix]).read(folder))


@pytest.mark.parametrize("suffix", KINDS)
def test_the_extra_that_a_bridge_needs_is_named_where_it_is_missing(
    recordings: dict[str, Path], suffix: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    extra = {".xlsx": "xlsx", ".ulg": "ulog", ".bag": "ros", ".db3": "ros", ".mcap": "ros"}.get(suffix)
    for module in [name for name in sys.modules if name.split(".")[0] in ("python_calamine", "pyulog", "rosbags", "mcap")]:
        monkeypatch.setitem(sys.modules, module, None)
    for module in ("ros_types", "mcap_records"):
        monkeypatch.delitem(sys.modules, f"wakeful.bridges.{module}", raising=False)
    reading = bridge_for(recordings[suffix])
    if extra is None:
        assert list(reading.read(recordings[suffix]))
        return
    with pytest.raises(SourceError, match=rf"pip install 'wakeful\[{extra}\]'"):
        list(reading.read(recordings[suffix]))


def test_standard_input_is_read_by_jsonl() -> None:
    assert isinstance(bridge_for(Path("-")), JsonlBridge)
    assert bridge_for(Path("-"), incarnation="shift 1").digest(Path("-")) == "shift 1"
