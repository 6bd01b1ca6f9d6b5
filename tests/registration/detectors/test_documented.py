"""Every detector and every setting of it stands in docs/domains.md, with its default."""

from __future__ import annotations

import importlib
from pathlib import Path

import pytest

from wakeful.registration.detectors import BUILT_IN
from wakeful.registration.detectors.base import Settings

DOCS = Path(__file__).parents[3] / "docs" / "domains.md"


@pytest.mark.parametrize("name", sorted(BUILT_IN))
def test_a_detector_stands_in_the_documentation_with_all_its_settings(name: str) -> None:
    (row,) = (line for line in DOCS.read_text().splitlines() if line.startswith(f"| `{name}` |"))
    module = importlib.import_module(f"wakeful.registration.detectors.{name}")
    kinds = [
        kind for kind in vars(module).values() if isinstance(kind, type) and issubclass(kind, Settings) and kind is not Settings
    ]
    (kind,) = kinds
    missing = [setting for setting in kind.__struct_fields__ if f"`{setting}`" not in row]
    assert missing == []
    defaults = dict(zip(kind.__struct_fields__, kind.__struct_defaults__, strict=True))
    for setting, default in defaults.items():
        if isinstance(default, float | int) and not isinstance(default, bool):
            assert f"`{setting}` ({default:g}" in row, setting
