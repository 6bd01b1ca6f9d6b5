"""Tables fit a terminal and are plain where they are piped."""

from __future__ import annotations

import pytest

from wakeful.cli import terminal
from wakeful.cli.terminal import paragraph, say, table


@pytest.fixture
def narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(terminal, "on_terminal", lambda: True)
    monkeypatch.setenv("COLUMNS", "60")
    monkeypatch.setenv("LINES", "24")


ROWS = [["a1b2", "The gripper lost its part while it was lifting the third crate of the day", "12"], ["c3d4", "short", "7"]]


@pytest.mark.usefixtures("narrow")
def test_a_table_is_cut_to_the_terminal_and_its_numbers_are_whole(capsys: pytest.CaptureFixture[str]) -> None:
    table(["event", "says", "count"], ROWS, ["count"])
    lines = capsys.readouterr().out.splitlines()
    assert max(len(line) for line in lines) <= 60
    assert lines[1].endswith("…     12")


def test_a_piped_table_has_tabs_and_nothing_is_cut(capsys: pytest.CaptureFixture[str]) -> None:
    table(["event", "says", "count"], ROWS, ["count"])
    assert capsys.readouterr().out.splitlines()[1].split("\t") == ROWS[0]


def test_piped_text_has_no_colour(capsys: pytest.CaptureFixture[str]) -> None:
    say("all is lost", fg="red", bold=True)
    assert capsys.readouterr().out == "all is lost\n"


@pytest.mark.usefixtures("narrow")
def test_a_paragraph_hangs_under_its_label(capsys: pytest.CaptureFixture[str]) -> None:
    paragraph(ROWS[0][1], 2, 8, "says    ")
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("  says    The gripper")
    assert lines[1].startswith(" " * 10)
