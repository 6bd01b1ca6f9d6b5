"""Lanes of time, and the trace in the Trace Event Format: structure as the format's description wants it."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterator
from io import BytesIO
from itertools import pairwise

import pytest

from tests.journal.builder import full_book
from tests.scheduling.test_holds import act
from tests.scheduling.test_scheduler import ALL
from tests.scheduling.world import World
from wakeful.facts.lines import Line
from wakeful.facts.processes import State
from wakeful.journal.lanes import Lanes, lanes
from wakeful.journal.trace import write_trace


class Lines:
    def __init__(self, world: World) -> None:
        self._world = world

    def lines(self, after: int = 0) -> Iterator[Line]:
        return iter(self._world.lines[after:])


@pytest.fixture
def told() -> Lanes:
    """A diagnosis that waits, a process that is preempted and held, another that is preempted, a parent with its child."""
    world = World(ALL)
    world.meet("device", "diagnosis")
    world.until(1)
    slow = world.meet("slow", "short")
    world.until(1.5)
    world.meet("urgent", "short", criticality=3)
    world.until(3)
    act(world, "hold", slow)
    world.meet("next", "short")
    world.until(4.5)
    world.meet("again", "short", criticality=3)
    world.until(8)
    world.tell("sensor", "device", 71.5)
    world.meet("box", "parent")
    world.until(20)
    return lanes(Lines(world))


def trace(told: Lanes) -> dict:
    file = BytesIO()
    written = write_trace(told, file)
    found = json.loads(file.getvalue())
    assert written == len(found["traceEvents"])
    return found


def check(found: dict) -> None:
    """What the Trace Event Format requires, and what Perfetto drops or misdraws where it is broken."""
    events = found["traceEvents"]
    assert found["displayTimeUnit"] in ("ms", "ns")
    threads = {(each["pid"], each["tid"]) for each in events if each["ph"] == "M" and each["name"] == "thread_name"}
    slices: dict[tuple[int, int], list[tuple[float, float]]] = defaultdict(list)
    flows: dict[int, list[tuple[str, float, tuple[int, int]]]] = defaultdict(list)
    before = 0.0
    for each in events:
        assert {"name", "ph", "pid", "tid", "ts"} <= set(each)
        assert each["ph"] in "XMisf", each
        assert isinstance(each["name"], str)
        assert each["name"]
        assert each["ts"] >= before, "timestamps run back"
        before = each["ts"] if each["ph"] != "M" else before
        if each["ph"] == "M":
            assert each["args"].get("name") or each["name"] == "thread_sort_index"
            continue
        where = (each["pid"], each["tid"])
        assert where in threads, f"{each} is on a thread without a name"
        if each["ph"] == "X":
            assert each["dur"] >= 0
            slices[where].append((each["ts"], each["ts"] + each["dur"]))
        elif each["ph"] == "i":
            assert each["s"] in "gpt"
        else:
            assert each["ph"] == "s" or each["bp"] == "e"
            flows[each["id"]].append((each["ph"], each["ts"], where))
    for found_slices in slices.values():
        for (_, end), (begin, _) in pairwise(found_slices):
            assert begin >= end - 1e-6, "slices of one thread overlap without being nested"
    for (start, start_us, start_on), (end, end_us, end_on) in flows.values():
        assert (start, end) == ("s", "f")
        assert start_us <= end_us
        assert start_on != end_on
        for at_us, on in ((start_us, start_on), (end_us, end_on)):
            assert any(begin <= at_us <= until for begin, until in slices[on]), "a flow that binds to no slice"


def test_the_trace_is_valid_and_complete(told: Lanes) -> None:
    found = trace(told)
    check(found)
    names = [each["args"]["name"] for each in found["traceEvents"] if each["name"] == "thread_name" and each["pid"] == 1]
    assert [name.split(":")[0] for name in names] == [f"P{lane.process} {lane.treatment}" for lane in told.lanes]
    marks = {each["cat"] for each in found["traceEvents"] if each["ph"] == "i"}
    assert marks >= {"evidence", "answer", "act", "result"}


def test_every_preemption_is_an_arrow_between_the_slices_that_it_ended_and_began(told: Lanes) -> None:
    assert [(each.preempted, each.preempting) for each in told.preemptions] == [(2, 3), (4, 5)]
    events = trace(told)["traceEvents"]
    arrows = [each for each in events if each["ph"] in "sf"]
    assert [(each["ph"], each["tid"]) for each in arrows] == [("s", 2), ("f", 3), ("s", 4), ("f", 5)]
    for each in (each for each in arrows if each["ph"] == "f"):
        on = [
            one["name"]
            for one in events
            if one["ph"] == "X"
            and one["tid"] == each["tid"]
            and one["pid"] == 1
            and one["ts"] < each["ts"] < one["ts"] + one["dur"]
        ]
        assert on == ["active"]


def test_the_stretches_of_a_lane_follow_one_another_from_its_creation_to_its_end(told: Lanes) -> None:
    for lane in told.lanes:
        for before, following in pairwise(lane.stretches):
            assert before.end_ns == following.begin_ns
        assert all(each.begin_ns <= each.end_ns <= told.end_ns for each in lane.stretches)
    held = told.lanes[1]
    assert (held.stretches[-1].state, held.end) == (State.SUSPENDED, "")
    assert held.stretches[-1].end_ns == told.end_ns


def test_one_events_lanes_bring_those_that_preempted_it() -> None:
    world = World(ALL)
    world.meet("slow", "short")
    world.until(0.5)
    world.meet("urgent", "short", criticality=3)
    world.meet("other", "short")
    world.until(20)
    assert [lane.process for lane in lanes(Lines(world), event="slow").lanes] == [1, 2]
    assert [lane.process for lane in lanes(Lines(world), last=1).lanes] == [3]


def test_a_journal_with_something_of_everything_gives_a_valid_trace() -> None:
    check(trace(lanes(full_book())))


def test_an_empty_journal_gives_an_empty_trace() -> None:
    world = World(ALL)
    check(trace(lanes(Lines(world))))
