"""`wakeful web` refuses what it should in one line, before it listens."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest

from tests.cli.conftest import Wakeful
from wakeful.cli import web


def test_a_missing_journal_is_one_line(wakeful: Wakeful, tmp_path: Path) -> None:
    result = wakeful("web", "--journal", tmp_path / "none.db", "--port", 0)
    assert result.exit_code == 1
    assert len(result.stderr.splitlines()) == 1
    assert "there is no journal at" in result.stderr


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.0.1"])
def test_other_machines_are_let_in_only_when_that_is_said(wakeful: Wakeful, journal: Path, host: str) -> None:
    result = wakeful("web", "--journal", journal, "--host", host, "--port", 0)
    assert result.exit_code == 1
    assert len(result.stderr.splitlines()) == 1
    assert "--allow-remote" in result.stderr


def test_letting_other_machines_in_warns(wakeful: Wakeful, journal: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    served: list[tuple[str, bool]] = []

    def serve(followed: object, host: str, listening: socket.socket, weighing: object, ready: object, remote: bool) -> None:
        listening.close()
        served.append((host, remote))

    monkeypatch.setattr(web, "serve", serve)
    result = wakeful("web", "--journal", journal, "--host", "0.0.0.0", "--port", 0, "--allow-remote")
    assert served == [("0.0.0.0", True)]
    assert "neither login nor encryption" in result.stderr


def test_a_taken_port_is_one_line(wakeful: Wakeful, journal: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        result = wakeful("web", "--journal", journal, "--port", taken.getsockname()[1])
    assert result.exit_code == 1
    assert len(result.stderr.splitlines()) == 1
    assert "another --port" in result.stderr
