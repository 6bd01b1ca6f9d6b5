"""Tables fit a terminal and are plain where they are piped."""

from __future__ import annotations

from pathlib import Path

import pytest

from wakeful.cli import terminal
from wakeful.cli.main import main
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


@pytest.mark.usefixtures("narrow")
def test_other_columns_are_left_out_before_the_last_is_cut(capsys: pytest.CaptureFixture[str]) -> None:
    columns = ["event", "mode", "kind", "says"]
    says = "The gripper lost its part over the third crate today"
    table(columns, [["a1b2", "auto", "grip", says]], drop=["mode", "kind"])
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == ["event", "says"]
    assert lines[1] == f"a1b2   {says}"
    table(columns, [["a1b2", "auto", "grip", says[:44]]], drop=["mode", "kind"])
    assert capsys.readouterr().out.splitlines()[0].split() == ["event", "kind", "says"]


@pytest.mark.usefixtures("narrow")
def test_events_on_a_narrow_terminal_keep_what_they_say(journal: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["events", "--journal", str(journal)], standalone_mode=False)
    lines = capsys.readouterr().out.splitlines()
    assert max(len(line) for line in lines) <= 60
    assert all("current left its band" in line for line in lines[1:])


@pytest.mark.usefixtures("narrow")
def test_what_is_short_enough_keeps_every_column(capsys: pytest.CaptureFixture[str]) -> None:
    table(["event", "mode", "says"], [["a1b2", "auto", "short"]], drop=["mode"])
    assert capsys.readouterr().out.splitlines()[0].split() == ["event", "mode", "says"]
