"""The import rules of docs/architecture.md, which stand in pyproject.toml under [tool.importlinter]."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


#: In a process of its own: import-linter sets up logging anew, and would silence every other logger of this one.
LINT = [sys.executable, "-c", "from importlinter.cli import lint_imports; raise SystemExit(lint_imports(no_cache=True))"]


def test_every_import_rule_is_kept() -> None:
    found = subprocess.run(LINT, cwd=ROOT, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout + found.stderr


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
        LINT,
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(tmp_path / "src")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert found.returncode == 1, found.stdout
    assert imports.removeprefix("wakeful.") in found.stdout or where in found.stdout
