"""`wakeful new domain` drafts a domain that runs as it is."""

from __future__ import annotations

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
