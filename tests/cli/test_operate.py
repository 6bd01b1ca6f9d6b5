"""`wakeful suspend`, `resume`, `cancel`, `debt`: on a journal at rest, and under a mind that is writing it."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.cli.conftest import Wakeful
from wakeful.drivers.inline import open_live
from wakeful.drivers.live import LiveDriver
from wakeful.facts.asking import Question, Reply
from wakeful.facts.events import Draft
from wakeful.facts.inputs import Act
from wakeful.facts.lines import Acted, Line, Moved
from wakeful.facts.processes import Trigger
from wakeful.journal.acts import ActSpool
from wakeful.journal.audit import audit
from wakeful.journal.sqlite import open_journal

WHO = ("--who", "ana", "--why", "she looks herself")


class Silent:
    """A reasoner that never answers: what asks it waits."""

    name = "silent"
    latency_s = 0.0

    async def answer(self, question: Question) -> Reply:
        await asyncio.Event().wait()
        raise AssertionError("nobody wakes it")


def box(name: str) -> Draft:
    fields = {"category": "obstacle", "location": "edge", "state": "unstable", "route": "none"}
    return Draft(kind="object", entity=name, source="", position=0, at_ns=1_700_000_000_000_000_000, fields=dict(fields))


async def admit(mind: LiveDriver, count: int) -> None:
    for index in range(count):
        await mind.admit(box(f"box {index}"))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A journal at rest: two processes wait for a reasoner that never answered."""
    journal = tmp_path / "mind.db"

    async def main() -> None:
        async with open_live("service_robot", journal, reasoner=Silent()) as mind:
            await admit(mind, 2)

    asyncio.run(main())
    return journal


@contextmanager
def running(journal: Path) -> Iterator[None]:
    """A live mind that holds the journal in another thread while the test's commands run."""
    begun, ended = threading.Event(), threading.Event()

    async def main() -> None:
        async with open_live("service_robot", journal, reasoner=Silent()) as mind:
            await admit(mind, 1)
            begun.set()
            await asyncio.get_running_loop().run_in_executor(None, ended.wait)

    thread = threading.Thread(target=asyncio.run, args=(main(),))
    thread.start()
    assert begun.wait(30)
    try:
        yield
    finally:
        ended.set()
        thread.join(30)


def lines(journal: Path) -> list[Line]:
    with open_journal(journal, read_only=True) as opened:
        assert audit(opened).ok
        return list(opened.lines())


def acted(journal: Path) -> list[tuple[str, str, int, str]]:
    return [
        (record.who, record.act, record.process, record.why)
        for record in (line.record for line in lines(journal))
        if isinstance(record, Acted)
    ]


def test_acts_on_a_journal_at_rest_are_applied_at_once_and_move_nobody_else(path: Path, wakeful: Wakeful) -> None:
    before = len(lines(path))
    held = wakeful("suspend", "P1", *WHO, "--journal", path)
    assert held.exit_code == 0, held.output
    assert "process 1 is held" in held.output
    assert "applied at once" in held.output
    assert "held by ana (she looks herself)" in wakeful("processes", "--journal", path).output
    assert "may go on" in wakeful("resume", "1", *WHO, "--journal", path).output
    assert len(lines(path)) == before + 2
    assert acted(path) == [("ana", "hold", 1, "she looks herself"), ("ana", "release", 1, "she looks herself")]


def test_a_cancelled_process_is_debt_and_the_mind_starts_again_without_it(path: Path, wakeful: Wakeful) -> None:
    done = json.loads(wakeful("cancel", 2, *WHO, "--journal", path, "--json").stdout)
    assert (done["act"], done["process"], done["recorded"], done["by"]) == ("cancel", 2, True, "this command")
    assert json.loads(wakeful("status", "--journal", path, "--json").stdout)["summary"]["debt"] == 1
    (row,) = json.loads(wakeful("debt", "--journal", path, "--json").stdout)
    assert (row["because"], row["who"], row["process"], row["entity"]) == ("cancelled", "ana", 2, "box 1")
    assert "cancelled by ana" in wakeful("debt", "--journal", path).output

    async def main() -> None:
        async with open_live("service_robot", path, reasoner=Silent()) as mind:
            await mind.admit(box("another"))

    asyncio.run(main())
    assert [row["id"] for row in json.loads(wakeful("processes", "--journal", path, "--json").stdout)] == [1, 3]
    assert lines(path)


def test_a_running_mind_takes_acts_up_and_the_command_says_so(path: Path, wakeful: Wakeful) -> None:
    with running(path):
        held = wakeful("suspend", 1, *WHO, "--journal", path, "--wait", 30)
        assert held.exit_code == 0, held.output
        assert "taken up by the running mind, process " in held.output
        assert wakeful("cancel", 2, *WHO, "--journal", path, "--wait", 30).exit_code == 0
        rows = json.loads(wakeful("processes", "--journal", path, "--json").stdout)
        assert [row["id"] for row in rows] == [1, 3]
    assert [act for _, act, _, _ in acted(path)] == ["hold", "cancel"]
    assert list(ActSpool(path).folder.iterdir()) == []


def test_an_act_that_the_running_mind_has_not_recorded_in_time_is_said_to_be_handed_over(path: Path, wakeful: Wakeful) -> None:
    with open_journal(path):  # a writer that takes nothing up
        told = wakeful("suspend", 1, *WHO, "--journal", path, "--wait", 0)
    assert told.exit_code == 0
    assert "which has not recorded it within" in told.output
    assert acted(path) == []
    wakeful("cancel", 2, *WHO, "--journal", path)
    assert [act for _, act, _, _ in acted(path)] == ["hold", "cancel"]


def test_acts_left_in_the_folder_are_taken_up_by_the_next_mind_once(path: Path) -> None:
    handed = ActSpool(path).put(Act(who="ana", act="cancel", process=1, why="left"))

    async def main() -> None:
        async with open_live("service_robot", path, reasoner=Silent()):
            pass

    asyncio.run(main())
    ActSpool(path).put(handed)  # as after a crash between the commit and taking the file out
    asyncio.run(main())
    assert acted(path) == [("ana", "cancel", 1, "left")]
    assert [
        line.record.by for line in lines(path) if isinstance(line.record, Moved) and line.record.trigger is Trigger.CANCEL
    ] == ["ana"]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("suspend", "99"), "there is no process 99"),
        (("suspend", "2"), "process 2 has completed (cancelled)"),
        (("cancel", "2"), "nothing left to cancel"),
        (("resume", "1"), "nobody holds process 1"),
    ],
)
def test_what_cannot_be_is_one_clear_error_and_records_nothing(
    path: Path, wakeful: Wakeful, arguments: tuple[str, str], says: str
) -> None:
    wakeful("cancel", 2, *WHO, "--journal", path)
    before = acted(path)
    told = wakeful(*arguments, *WHO, "--journal", path)
    assert told.exit_code == 1
    assert says in told.output
    assert told.output.count("\n") == 1
    assert acted(path) == before


def test_a_process_that_is_no_number_and_an_act_without_who_are_wrong_usage(path: Path, wakeful: Wakeful) -> None:
    assert wakeful("suspend", "box", *WHO, "--journal", path).exit_code == 2
    assert wakeful("suspend", "1", "--journal", path).exit_code == 2


def test_a_run_takes_acts_up_between_its_items(tmp_path: Path, wakeful: Wakeful) -> None:
    journal = tmp_path / "run.db"
    wakeful("run", "service_robot", "--events", 3, "--journal", journal)
    ActSpool(journal).put(Act(who="ana", act="cancel", process=99, why="none such"))
    wakeful("run", "service_robot", "--events", 3, "--journal", journal)
    (record,) = [line.record for line in lines(journal) if isinstance(line.record, Acted)]
    assert record.refused == "process 99 is not open"
