"""One recording of each kind, written once."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bridges.recordings import made


@pytest.fixture(scope="session")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Suffix → a small recording. Tests read them and never write to them."""
    return made(tmp_path_factory.mktemp("recordings"))
