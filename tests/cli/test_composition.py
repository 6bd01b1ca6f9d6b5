"""A treatment starts another as a child process: diagnosis of what stands in the way has planning look for a way round."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.conftest import Wakeful, written
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.asking import Question, Reply
from wakeful.facts.events import Context, Draft
from wakeful.facts.inputs import Mark
from wakeful.facts.lines import Concluded, Created, Line
from wakeful.facts.settings import MindSettings
from wakeful.facts.values import Field
from wakeful.journal import MemoryJournal
from wakeful.journal.audit import audit
from wakeful.journal.results import result_fields

NOON_NS = 1_767_600_000 * 10**9
JAMMED: dict[str, Field] = {"category": "device", "state": "abnormal", "location": "route", "route": "blocking", "load": 0.3}


class Diagnoses:
    """A reasoner that has everything diagnosed."""

    name = "diagnoses"
    latency_s = 0.5

    async def answer(self, question: Question) -> Reply:
        return Reply(choice="diagnosis", confidence=0.9, reasoner=self.name)


def lines(fields: dict[str, Field]) -> list[Line]:
    kernel, learner = assemble("service_robot", MindSettings())
    journal = MemoryJournal()
    driver = SimulatedDriver(kernel, journal, Diagnoses(), learner)
    driver.begin("s", "d")
    where = Context(zone="corridor_a")
    jammed = Draft(kind="object", entity="lift 3", source="s", position=0, at_ns=NOON_NS, fields=fields, context=where)
    driver.put([jammed, Mark(source="s", position=0)], NOON_NS)
    driver.put([], NOON_NS + 300 * 10**9)
    driver.close()
    assert audit(journal).ok
    return list(journal.lines())


@pytest.fixture(scope="module")
def blocked() -> list[Line]:
    return lines(JAMMED)


def test_a_faulty_device_in_the_way_is_diagnosed_and_a_way_round_is_planned_by_a_child(blocked: list[Line]) -> None:
    created = [line.record for line in blocked if isinstance(line.record, Created)]
    concluded = {line.record.treatment: line for line in blocked if isinstance(line.record, Concluded)}
    root, child = created
    assert (child.treatment, child.parent) == ("planning", root.process)
    assert concluded["planning"].position < concluded["diagnosis"].position
    diagnosis, plan = (result_fields(concluded[name].record.result) for name in ("diagnosis", "planning"))  # type: ignore[union-attr]
    assert diagnosis["way_round"] == plan["says"]
    assert "corridor_a blocked" in str(plan["says"])
    assert any("take " in each["effect"] for each in diagnosis["proposes"])  # type: ignore[union-attr, index, call-overload]


def test_what_blocks_nothing_is_only_diagnosed() -> None:
    created = [line.record for line in lines({**JAMMED, "route": "none"}) if isinstance(line.record, Created)]
    assert len(created) == 1


def test_why_and_the_timeline_show_the_tree(blocked: list[Line], tmp_path: Path, wakeful: Wakeful) -> None:
    path = written(blocked, tmp_path / "lift.db")
    event = next(line.record.event for line in blocked if isinstance(line.record, Created))
    told = wakeful("why", event, "--journal", path).output
    assert "child" in told
    assert "planning" in told
    assert wakeful("timeline", "--journal", path, "--out", tmp_path / "lift.svg").exit_code == 0
    picture = (tmp_path / "lift.svg").read_text()
    assert "planning" in picture
    assert "P2" in picture
