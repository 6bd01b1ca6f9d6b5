"""The paper's Eq. 6, P1(1) → P2 → P3 → P1(2), through the whole kernel with wakeful's own domain and treatments."""

from __future__ import annotations

import runpy
from pathlib import Path
from types import SimpleNamespace

import msgspec
import pytest

from wakeful.facts.lines import Concluded, Moved
from wakeful.facts.processes import State, Trigger
from wakeful.facts.time import to_ns
from wakeful.journal import MemoryJournal
from wakeful.journal.audit import audit
from wakeful.journal.lanes import lanes

DOCS = Path(__file__).parents[1] / "docs"


@pytest.fixture(scope="module")
def drawing() -> SimpleNamespace:
    return SimpleNamespace(**runpy.run_path(str(DOCS / "draw_timeline_eq6.py"), run_name="drawing"))


@pytest.fixture(scope="module")
def journal(drawing: SimpleNamespace) -> MemoryJournal:
    return drawing.run()


def test_the_turns_of_thinking_are_those_of_equation_6(journal: MemoryJournal) -> None:
    told = lanes(journal)
    turns = sorted(
        (stretch.begin_ns, lane.process)
        for lane in told.lanes
        for stretch in lane.stretches
        if stretch.state is State.ACTIVE and stretch.end_ns > stretch.begin_ns
    )
    assert [process for _, process in turns] == [1, 2, 3, 1]
    assert [lane.treatment for lane in told.lanes] == ["diagnosis", "planning", "risk_prediction"]


def test_the_diagnosis_waits_for_its_reading_and_goes_on_where_it_was(journal: MemoryJournal, drawing: SimpleNamespace) -> None:
    moves = [line for line in journal.lines() if isinstance(line.record, Moved) and line.record.process == 1]
    asked = [line for line in moves if line.record.trigger is Trigger.ASK][-1]
    woken = [line for line in moves if line.record.trigger is Trigger.WAKE][-1]
    assert woken.at_ns == to_ns(drawing.READING_S)
    assert woken.record.steps == asked.record.steps == 2
    assert moves[-1].record.steps == 3
    (concluded,) = [line.record for line in journal.lines() if isinstance(line.record, Concluded) and line.record.process == 1]
    assert b"82" in bytes(concluded.result)
    assert msgspec.json.decode(concluded.result)["type"] == "diagnosis"


def test_nothing_was_ignored_lost_or_done_twice(journal: MemoryJournal) -> None:
    assert audit(journal).ok


def test_the_committed_picture_shows_the_sequence() -> None:
    pytest.importorskip("matplotlib")
    picture = (DOCS / "timeline_eq6.svg").read_text()
    assert "<svg" in picture
