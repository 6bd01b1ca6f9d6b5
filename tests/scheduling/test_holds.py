"""An operator's holds and cancels: in every state, across a crash, and on parents with children."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.scheduling.test_scheduler import ALL, diagnosis, moves, parent, short
from tests.scheduling.world import Repertoire, World, say
from wakeful.contracts.treatment import Mind, Refusal
from wakeful.facts.events import Event
from wakeful.facts.inputs import Act
from wakeful.facts.lines import Acted, Concluded, Moved
from wakeful.facts.processes import State, Trigger
from wakeful.facts.results import Result
from wakeful.journal.audit import audit


class Lines:
    """A world's lines as a journal to be audited."""

    def __init__(self, world: World) -> None:
        self._world = world

    def lines(self, after: int = 0) -> object:
        return iter(self._world.lines[after:])


def assert_sound(world: World) -> None:
    """The audit finds nothing; ids are left aside, since these events have names and come from no source."""
    checks = audit(Lines(world)).checks
    assert {name: finding.first_offender for name, finding in checks.items() if not finding.ok and name != "identities"} == {}


@pytest.fixture
def world() -> World:
    return World(ALL)


def act(world: World, what: str, process: int, identity: str = "") -> None:
    world.scheduler.act(Act(who="ana", act=what, process=process, why="a test", id=identity))


def state(world: World, process: int) -> State:
    return world.scheduler.processes[process].state


def test_one_held_while_active_is_preempted_by_the_operator_at_its_steps_end(world: World) -> None:
    slow = world.meet("slow", "short")
    next_in_line = world.meet("next", "short")
    world.until(0.5)
    act(world, "hold", slow)
    assert state(world, slow) is State.ACTIVE
    world.until(1)
    held = world.scheduler.processes[slow]
    assert (held.state, held.steps, held.preempted_by) == (State.SUSPENDED, 1, "ana")
    assert state(world, next_in_line) is State.ACTIVE
    world.until(10)
    assert state(world, slow) is State.SUSPENDED
    assert world.scheduler.processes.runnable == 0
    act(world, "release", slow)
    world.until(11)
    assert world.ends() == [("next", "next done"), ("slow", "slow done")]
    assert moves(world, slow).count(Trigger.DISPATCH) == 2


def test_one_held_while_waiting_is_woken_but_gets_no_slot(world: World) -> None:
    process = world.meet("device", "diagnosis")
    world.until(1)
    act(world, "hold", process)
    world.tell("sensor", "device", 71.5)
    assert state(world, process) is State.SUSPENDED
    world.until(20)
    assert state(world, process) is State.SUSPENDED
    act(world, "release", process)
    world.until(21)
    assert world.ends() == [("device", "['device-hot', 'device-worn'] [71.5]")]


def test_one_released_while_it_waits_goes_on_when_its_evidence_comes(world: World) -> None:
    process = world.meet("device", "diagnosis")
    world.until(1)
    act(world, "hold", process)
    act(world, "release", process)
    world.until(2)
    world.tell("sensor", "device", 1)
    world.until(3)
    assert len(world.ends()) == 1


def test_one_held_before_it_began_stays_created_and_a_second_hold_changes_nothing(world: World) -> None:
    world.meet("first", "short")
    second = world.meet("second", "short")
    act(world, "hold", second)
    act(world, "hold", second)
    world.until(10)
    assert state(world, second) is State.CREATED
    act(world, "release", second)
    world.until(12)
    assert [event for event, _ in world.ends()] == ["first", "second"]


def test_a_hold_survives_a_crash_in_every_state(world: World) -> None:
    active = world.meet("active", "short")
    waiting = world.meet("waiting", "diagnosis", criticality=1)
    world.until(1.5)
    act(world, "hold", active)
    act(world, "hold", waiting)
    world.crash()
    world.tell("sensor", "waiting", 1)
    world.until(20)
    assert (state(world, active), state(world, waiting)) == (State.SUSPENDED, State.SUSPENDED)
    world.crash()
    act(world, "release", active)
    act(world, "release", waiting)
    world.until(30)
    assert sorted(event for event, _ in world.ends()) == ["active", "waiting"]


def test_a_cancel_of_a_parent_completes_its_child_too(world: World) -> None:
    process = world.meet("box", "parent")
    world.until(1.5)
    assert state(world, process) is State.WAITING
    act(world, "cancel", process)
    assert len(world.scheduler.processes) == 0
    assert moves(world, process)[-1] is Trigger.CANCEL
    assert moves(world, process + 1)[-1] is Trigger.CANCEL
    world.until(10)
    assert world.ends() == []
    assert_sound(world)


def test_a_cancel_of_a_child_is_told_its_parent_at_once() -> None:
    async def careful(event: Event, mind: Mind) -> Result:
        try:
            await mind.treat("short", event)
        except Refusal as refusal:
            return say(f"without the child: {refusal}")
        return say("with the child")

    world = World(Repertoire(careful=careful, short=short))
    process = world.meet("box", "careful")
    world.until(0.5)
    act(world, "cancel", process + 1)
    world.until(2)
    assert world.ends() == [("box", "without the child: cancelled by ana")]


@pytest.mark.parametrize("what", ["hold", "release", "cancel"])
def test_an_act_on_a_process_that_is_gone_is_recorded_as_refused(world: World, what: str) -> None:
    process = world.meet("box", "short")
    world.until(5)
    act(world, what, process)
    record = world.lines[-1].record
    assert isinstance(record, Acted)
    assert record.refused == "process 1 is not open"


def test_an_act_handed_in_twice_acts_once_also_after_a_crash(world: World) -> None:
    process = world.meet("box", "short")
    act(world, "hold", process, "a1")
    act(world, "release", process, "a2")
    act(world, "hold", process, "a1")
    world.crash()
    act(world, "hold", process, "a1")
    assert [line.record.id for line in world.lines if isinstance(line.record, Acted)] == ["a1", "a2"]
    world.until(3)
    assert len(world.ends()) == 1


STEPS: dict[str, Callable[[World, int], None]] = {
    "hold": lambda world, process: act(world, "hold", process),
    "release": lambda world, process: act(world, "release", process),
    "cancel": lambda world, process: act(world, "cancel", process),
    "tell": lambda world, process: world.tell("sensor", f"e{process}", 1),
    "pass": lambda world, process: world.until(world.now_ns / 1e9 + 0.7),
    "meet diagnosis": lambda world, process: _meet(world, "diagnosis"),
    "meet parent": lambda world, process: _meet(world, "parent"),
    "meet short": lambda world, process: _meet(world, "short", 3),
}


def _meet(world: World, treatment: str, criticality: int = 0) -> None:
    world.meet(f"e{world.scheduler.processes.next_id}", treatment, criticality)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(sorted(STEPS)), st.integers(1, 8)), max_size=30), st.integers(1, 2), st.data())
def test_acts_and_evidence_in_any_order_keep_every_promise_and_a_crash_changes_nothing(
    script: list[tuple[str, int]], slots: int, data: st.DataObject
) -> None:
    crashes = data.draw(st.sets(st.integers(0, 30), max_size=3))
    repertoire = Repertoire(short=short, diagnosis=diagnosis, parent=parent)
    calm, crashing = World(repertoire, slots), World(repertoire, slots)
    for index, (step, process) in enumerate(script):
        for world in (calm, crashing):
            STEPS[step](world, process)
        if index in crashes:
            crashing.crash()
        held = [each for each in calm.scheduler.processes if each.held and each.state is State.ACTIVE and not each.stepping]
        assert not held
    for world in (calm, crashing):
        for process in [each.id for each in world.scheduler.processes if each.held]:
            act(world, "release", process)
        world.until(world.now_ns / 1e9 + 200)
    assert len(calm.scheduler.processes) == 0
    assert [line.record for line in crashing.lines] == [line.record for line in calm.lines]
    assert_sound(calm)
    for line in calm.lines:
        if isinstance(line.record, Moved) and line.record.trigger is Trigger.RESOLVE:
            concluded = {each.record.process for each in calm.lines if isinstance(each.record, Concluded)}
            assert line.record.process in concluded
