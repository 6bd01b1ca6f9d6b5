"""`wakeful new domain` drafts a domain that runs as it is."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from tests.cli.conftest import Wakeful


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """Five minutes of a pump that stops now and then."""
    rows = ["timestamp,pressure_bar,emergency_stop"]
    rows += [f"{1_700_000_000 + second},{3.0 + 0.01 * (second % 7)},{int(second % 90 == 60)}" for second in range(300)]
    path = tmp_path / "pump.csv"
    path.write_text("\n".join(rows) + "\n")
    return path


def test_a_drafted_domain_runs_on_the_recording_that_it_was_made_from(wakeful: Wakeful, recording: Path, tmp_path: Path) -> None:
    out = tmp_path / "pump.toml"
    drafted = wakeful("new", "domain", "--from", recording, "--name", "pump", "--out", out)
    assert drafted.exit_code == 0, drafted.output
    assert 'name = "pump"' in out.read_text()
    result = wakeful("run", recording, "--domain", out, "--journal", tmp_path / "pump.db")
    assert result.exit_code == 0, result.output
    assert "(pump)" in result.stdout


def test_a_draft_goes_to_standard_output_and_never_over_a_file(wakeful: Wakeful, recording: Path, tmp_path: Path) -> None:
    assert 'name = "pump"' in wakeful("new", "domain", "--from", recording).stdout
    taken = tmp_path / "taken.toml"
    taken.write_text("mine")
    result = wakeful("new", "domain", "--from", recording, "--out", taken)
    assert result.exit_code == 1
    assert "is there already" in result.stderr
    assert taken.read_text() == "mine"


def test_a_recording_that_is_not_there(wakeful: Wakeful, tmp_path: Path) -> None:
    result = wakeful("new", "domain", "--from", tmp_path / "absent.csv")
    assert result.exit_code == 1
    assert len(result.stderr.splitlines()) == 1


def test_a_new_treatment_is_a_package_whose_own_test_passes(wakeful: Wakeful, tmp_path: Path) -> None:
    folder = tmp_path / "made"
    done = wakeful("new", "treatment", "shelf_inspection", "--out", folder)
    assert done.exit_code == 0, done.output
    project = tomllib.loads((folder / "pyproject.toml").read_text())
    points = project["project"]["entry-points"]["wakeful.treatments"]
    assert points == {"shelf_inspection": "wakeful_shelf_inspection:shelf_inspection"}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-n", "0", str(folder)]
    tested = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert tested.returncode == 0, tested.stdout + tested.stderr
    assert "2 passed" in tested.stdout


@pytest.mark.parametrize("name", ["Inspection", "9lives", "a-b", "class", "", "../x", "diagnosis"])
def test_a_name_that_no_treatment_can_have_is_refused_and_nothing_is_written(wakeful: Wakeful, tmp_path: Path, name: str) -> None:
    folder = tmp_path / "made"
    refused = wakeful("new", "treatment", name, "--out", folder)
    assert refused.exit_code == 1
    assert not folder.exists()


def test_a_new_treatment_never_goes_over_a_folder(wakeful: Wakeful, tmp_path: Path) -> None:
    refused = wakeful("new", "treatment", "inspection", "--out", tmp_path)
    assert refused.exit_code == 1
    assert "is there already" in refused.output
