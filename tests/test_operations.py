"""The unit file in docs/operations.md says what the code needs, and systemd takes it where it is there."""

from __future__ import annotations

import configparser
import re
import shutil
import subprocess
from pathlib import Path

import click
import pytest

from wakeful.cli.main import main

PAGE = Path(__file__).parents[1] / "docs" / "operations.md"


def unit() -> str:
    found = re.search(r"^```ini\n(.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL)
    assert found is not None
    return found[1]


def test_the_unit_speaks_the_notify_protocol_and_restarts_what_stalls() -> None:
    parsed = configparser.ConfigParser(strict=False, interpolation=None)
    parsed.optionxform = str  # type: ignore[assignment, method-assign]
    parsed.read_string(unit())
    service = parsed["Service"]
    assert service["Type"] == "notify"
    assert service["NotifyAccess"] in ("main", "exec")
    assert int(service["WatchdogSec"].removesuffix("s")) > 0
    assert service["Restart"] in ("on-failure", "on-abnormal", "always")
    assert service["RestartPreventExitStatus"] == "2"
    assert service["UMask"] == "0077"


def test_the_command_that_the_unit_runs_is_one_with_options_that_exist() -> None:
    line = next(line for line in unit().splitlines() if line.startswith("ExecStart="))
    program, name, *arguments = line.removeprefix("ExecStart=").split()
    assert program.endswith("/wakeful")
    command = main.commands[name]
    options = {option for each in command.params if isinstance(each, click.Option) for option in each.opts}
    assert {each for each in arguments if each.startswith("--")} <= options


def test_systemd_takes_the_unit(tmp_path: Path) -> None:
    analyze = shutil.which("systemd-analyze")
    if analyze is None:
        pytest.skip("systemd-analyze is not on this machine")
    text = re.sub(r"ExecStart=\S+", "ExecStart=/bin/true", unit())
    file = tmp_path / "wakeful.service"
    file.write_text(text)
    done = subprocess.run([analyze, "verify", "--man=no", str(file)], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr
