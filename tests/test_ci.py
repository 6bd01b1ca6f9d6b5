"""What continuous integration runs beside the tests says plainly what it could not do, and finds what it looks for."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

CI = Path(__file__).parents[1] / ".ci"


def script(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, CI / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # where msgspec looks up the types that annotations name
    spec.loader.exec_module(module)
    return module


def audit_that_says(advisories: ModuleType, monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setattr(advisories, "locked", lambda folder: folder)
    done = subprocess.CompletedProcess([], 0, text, "")
    monkeypatch.setattr(advisories.subprocess, "run", lambda *_, **__: done)


@pytest.mark.parametrize(
    "text",
    ["", "no network", json.dumps({"dependencies": [{"name": "click", "skip_reason": "Dependency not found on PyPI"}]})],
)
def test_an_advisory_service_that_cannot_be_asked_is_never_a_silent_pass(
    text: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    advisories = script("advisories")
    audit_that_says(advisories, monkeypatch, text)
    assert advisories.main() == 0
    assert "SKIPPED" in capsys.readouterr().out
    monkeypatch.setenv("WAKEFUL_CI_STRICT", "1")
    assert advisories.main() == 1


@pytest.mark.parametrize(("weaknesses", "code"), [([], 0), ([{"id": "PYSEC-1", "fix_versions": ["9"]}], 1)])
def test_a_known_weakness_is_an_error(
    weaknesses: list[object], code: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    advisories = script("advisories")
    told = {"dependencies": [{"name": "click", "version": "8.1", "vulns": weaknesses}]}
    audit_that_says(advisories, monkeypatch, json.dumps(told))
    assert advisories.main() == code
    assert ("PYSEC-1" in capsys.readouterr().out) == bool(code)


@pytest.mark.parametrize(
    ("named", "permissive"),
    [
        ("MIT", True),
        ("BSD-3-Clause", True),
        ("BSD License", True),
        ("Apache-2.0 OR BSD-2-Clause", True),
        ("GPL-3.0-only", False),
        ("MIT AND AGPL-3.0", False),
        ("", False),
        ("Free for non-commercial use", False),
    ],
)
def test_a_licence_is_permissive_or_a_persons_business(named: str, permissive: bool) -> None:
    licences = script("licences")
    found = bool(licences.PERMISSIVE.search(named)) and not licences.RESTRICTIVE.search(named)
    assert found == permissive


def test_a_secret_in_the_tree_is_found_and_one_that_was_looked_at_is_not(tmp_path: Path) -> None:
    pytest.importorskip("detect_secrets", reason="detect-secrets is in the dependency group audit: ./run audit")
    (tmp_path / ".ci").mkdir()
    (tmp_path / "src").mkdir()
    (tmp_path / ".ci" / "secret_scan.py").write_text((CI / "secret_scan.py").read_text())
    (tmp_path / "src" / "settings.py").write_text("aws = 'AKIA" + "IOSFODNN7EXAMPLQ'\n")
    (tmp_path / ".secrets.baseline").write_text("[]")
    environment = {**os.environ, "GIT_DIR": str(tmp_path / "none")}

    def scan(*options: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, str(tmp_path / ".ci" / "secret_scan.py"), *options]
        return subprocess.run(command, capture_output=True, text=True, check=False, env=environment)

    found = scan()
    assert found.returncode == 1, found.stderr
    assert "src/settings.py:1: AWS Access Key" in found.stdout
    assert scan("--accept").returncode == 0
    assert scan().returncode == 0
