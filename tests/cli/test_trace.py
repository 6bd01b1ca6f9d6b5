"""`wakeful trace` and `wakeful timeline` as a user calls them."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.cli.conftest import Wakeful


def test_a_trace_is_written_to_a_file_or_to_standard_output(journal: Path, tmp_path: Path, wakeful: Wakeful) -> None:
    out = tmp_path / "trace.json"
    told = wakeful("trace", "--journal", journal, "--out", out)
    assert told.exit_code == 0, told.output
    assert json.loads(out.read_text()) == json.loads(wakeful("trace", "--journal", journal).stdout)


def test_a_trace_of_one_event_or_of_the_last_processes_is_smaller(journal: Path, wakeful: Wakeful) -> None:
    def lanes(*arguments: object) -> int:
        events = json.loads(wakeful("trace", "--journal", journal, *arguments).stdout)["traceEvents"]
        return sum(1 for each in events if each["name"] == "thread_name" and each["pid"] == 1)

    event = json.loads(wakeful("events", "--journal", journal, "--json").stdout)[0]["id"]
    assert 0 < lanes("--event", event[:8]) < lanes()
    assert lanes("--last", 2) == 2


def test_an_unknown_event_and_another_format_are_clear_mistakes(journal: Path, tmp_path: Path, wakeful: Wakeful) -> None:
    assert "'wakeful events' lists them" in wakeful("trace", "--journal", journal, "--event", "ffff").output
    assert wakeful("timeline", "--journal", journal, "--out", tmp_path / "a.gif").exit_code == 2
    nowhere = tmp_path / "none" / "a.json"
    assert "cannot be written" in wakeful("trace", "--journal", journal, "--out", nowhere).output


def test_a_timeline_is_drawn_as_svg_and_png_and_twice_the_same(journal: Path, tmp_path: Path, wakeful: Wakeful) -> None:
    pytest.importorskip("matplotlib")
    for name in ("a.svg", "b.svg", "c.png"):
        told = wakeful("timeline", "--journal", journal, "--out", tmp_path / name)
        assert told.exit_code == 0, told.output
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    assert ElementTree.parse(tmp_path / "a.svg").getroot().tag.endswith("svg")
    assert (tmp_path / "c.png").read_bytes().startswith(b"\x89PNG")
