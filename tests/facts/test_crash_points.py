"""Crash points: every name stands in the code, every place in the code has a name, and nothing happens unarmed."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

import wakeful
from wakeful.facts.crash_points import CRASH_AT, CRASH_POINTS, UnknownCrashPoint, armed, killing, reach

SOURCES = Path(wakeful.__file__).parent


def test_every_name_stands_in_the_code_and_every_place_has_a_name() -> None:
    placed = Counter(
        name for path in SOURCES.rglob("*.py") for name in re.findall(r'^\s+reach\("([^"]+)"\)', path.read_text(), re.MULTILINE)
    )
    assert set(placed) == set(CRASH_POINTS)


def test_unarmed_a_crash_point_does_nothing() -> None:
    reach("commit: done")


def test_an_armed_action_hears_each_place_and_only_while_it_is_armed() -> None:
    heard: list[str] = []
    with armed(heard.append):
        reach("commit: begun")
        reach("commit: done")
    reach("commit: begun")
    assert heard == ["commit: begun", "commit: done"]


def test_a_name_that_is_none_is_refused_at_the_start() -> None:
    with pytest.raises(UnknownCrashPoint, match=r"'commit: begun'"):
        killing("commit: began")


def test_the_process_kills_itself_at_the_nth_time() -> None:
    script = (
        "from wakeful.facts.crash_points import reach\n"
        "reach('commit: done'); reach('commit: begun'); print('once', flush=True); reach('commit: done'); print('twice')"
    )
    environment = os.environ | {CRASH_AT: "commit: done@2", "PYTHONPATH": str(SOURCES.parent)}
    run = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == -signal.SIGKILL
    assert run.stdout == "once\n"
    assert "commit: done@2" in run.stderr
