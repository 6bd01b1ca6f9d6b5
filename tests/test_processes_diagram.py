"""The drawing in docs/processes.md is that of the process table."""

from __future__ import annotations

import runpy
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest

from wakeful.facts.processes import TRANSITIONS, State, Trigger

DOCS = Path(__file__).parents[1] / "docs"
REDRAW = "the process table has changed: ./run python docs/draw_processes.py"


@pytest.fixture(scope="module")
def drawing() -> SimpleNamespace:
    return SimpleNamespace(**runpy.run_path(str(DOCS / "draw_processes.py"), run_name="drawing"))


def test_the_committed_picture_is_drawn_from_the_table(drawing: SimpleNamespace) -> None:
    assert (DOCS / "processes.svg").read_text() == drawing.picture(), REDRAW


def test_the_committed_page_lists_the_table(drawing: SimpleNamespace) -> None:
    text = (DOCS / "processes.md").read_text()
    assert text == drawing.page(text), REDRAW
    assert all(f"| {before} | {trigger} | {after} |" in text for (before, trigger), after in TRANSITIONS.items()), REDRAW


def test_the_picture_shows_every_state_and_every_trigger(drawing: SimpleNamespace) -> None:
    shown = {element.text for element in ElementTree.fromstring(drawing.picture()).iter("{http://www.w3.org/2000/svg}text")}
    assert shown >= set(State) | set(Trigger)
