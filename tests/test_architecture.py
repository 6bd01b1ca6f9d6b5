"""The import rules of docs/architecture.md, which stand in pyproject.toml under [tool.importlinter]."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from importlinter import cli

ROOT = Path(__file__).parents[1]


def test_every_import_rule_is_kept(capsys: pytest.CaptureFixture[str]) -> None:
    status = cli.lint_imports(config_filename=str(ROOT / "pyproject.toml"), no_cache=True, no_logo=True)
    assert status == cli.EXIT_STATUS_SUCCESS, capsys.readouterr().out


@pytest.mark.parametrize(
    ("where", "imports"),
    [
        ("selection", "wakeful.scheduling"),
        ("facts", "wakeful.contracts"),
        ("bridges", "wakeful.kernel"),
        ("domains", "wakeful.bridges"),
        ("kernel.py", "wakeful.journal"),
        ("kernel.py", "time"),
        ("treatments", "asyncio"),
        ("drivers", "wakeful.cli"),
        ("unheard_of", "wakeful.facts"),
    ],
)
def test_an_import_against_the_rules_is_found(where: str, imports: str, tmp_path: Path) -> None:
    package = tmp_path / "src" / "wakeful"
    shutil.copytree(ROOT / "src" / "wakeful", package, ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copyfile(ROOT / "pyproject.toml", tmp_path / "pyproject.toml")
    target = package / where
    if target.suffix != ".py":
        target.mkdir(exist_ok=True)
        (target / "__init__.py").touch()
        target /= "offender.py"
    target.write_text(f"{target.read_text() if target.exists() else ''}\nimport {imports}\n")
    found = subprocess.run(
        [sys.executable, "-c", "from importlinter.cli import lint_imports; raise SystemExit(lint_imports(no_cache=True))"],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(tmp_path / "src")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert found.returncode == 1, found.stdout
    assert imports.removeprefix("wakeful.") in found.stdout or where in found.stdout
