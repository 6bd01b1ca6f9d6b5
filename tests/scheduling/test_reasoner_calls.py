"""Slots for the reasoner: so many calls under way, the others by criticality, the same after a crash."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.scheduling.test_scheduler import deliberate, short
from tests.scheduling.world import Repertoire, World
from wakeful.facts.asking import Reply
from wakeful.facts.inputs import Act
from wakeful.scheduling.reasoner_calls import ReasonerCalls

ANSWER = Reply(choice="a", confidence=1.0)


def world_of(slots: int) -> World:
    return World(Repertoire(deliberate=deliberate, short=short), reasoner_slots=slots)


def asking(world: World, *criticalities: int) -> list[int]:
    # Chosen already, so that only the treatment's own question is put.
    found = [world.meet(f"e{index}", "short", each, mode="delib") for index, each in enumerate(criticalities)]
    world.until(world.now_ns / 1e9 + 0.1)
    return found


def test_no_more_calls_are_under_way_than_slots_and_the_critical_is_next() -> None:
    world = world_of(2)
    first, second, third, critical = asking(world, 0, 0, 0, 3)
    assert [call.process for call in world.calls] == [first, second]
    assert world.scheduler.processes.reasoner_calls.queued == 2
    world.answer(error="refused")
    assert [call.process for call in world.calls] == [second, critical]
    world.answer(error="refused")
    assert [call.process for call in world.calls] == [critical, third]


def test_a_call_that_is_under_way_is_not_interrupted_by_a_critical_one() -> None:
    world = world_of(1)
    (slow,) = asking(world, 0)
    world.meet("critical", "short", 3, mode="delib")
    world.until(1)
    assert [call.process for call in world.calls] == [slow]


def test_a_cancelled_process_gives_its_place_to_the_next() -> None:
    world = world_of(1)
    first, second = asking(world, 0, 0)
    world.scheduler.act(Act(who="ana", act="cancel", process=first, why=""))
    assert [call.process for call in world.calls] == [first, second]


def test_a_held_process_is_passed_over_in_the_queue_and_takes_its_turn_when_it_is_let_go() -> None:
    world = world_of(1)
    _, second, third = asking(world, 0, 3, 0)
    world.scheduler.act(Act(who="ana", act="hold", process=second, why=""))
    world.answer(error="refused")
    assert [call.process for call in world.calls] == [third]
    world.scheduler.act(Act(who="ana", act="release", process=second, why=""))
    world.answer(error="refused")
    assert [call.process for call in world.calls] == [second]


def test_one_whose_limit_passes_in_the_queue_goes_on_without_the_reasoner() -> None:
    world = world_of(1)
    asking(world, 0, 0)
    world.until(120)
    assert sorted(event for event, _ in world.ends()) == ["e0", "e1"]
    assert len(world.calls) == 1


def test_after_a_crash_the_same_calls_are_under_way_since_the_same_instants() -> None:
    world = world_of(2)
    asking(world, 0, 1, 0, 3)
    world.until(5)
    world.answer(error="refused")
    before = sorted((call.process, call.seq, call.asked_ns) for call in world.calls)
    world.crash()
    assert sorted((call.process, call.seq, call.asked_ns) for call in world.calls) == before
    world.answer(error="refused")
    assert len(world.calls) == 2


@settings(max_examples=100)
@given(
    st.integers(0, 3),
    st.lists(st.tuples(st.sampled_from(["ask", "leave", "hold", "let go"]), st.integers(1, 6), st.integers(0, 3))),
)
def test_in_any_order_the_slots_are_full_or_nobody_queues_and_the_first_in_line_is_taken(
    slots: int, script: list[tuple[str, int, int]]
) -> None:
    calls = ReasonerCalls(slots)
    queued: dict[int, tuple[int, int, int, int]] = {}
    under_way: set[int] = set()
    held: set[int] = set()
    for now_ns, (what, process, criticality) in enumerate(script):
        if what == "ask" and process not in under_way | set(queued):
            key = (-criticality, 0, now_ns)
            queued[process] = (*key, process)
            calls.ask(process, key, now_ns, held=process in held)
        elif what == "leave":
            queued.pop(process, None)
            under_way.discard(process)
            calls.leave(process, now_ns)
        elif what == "hold":
            held.add(process)
            calls.hold(process)
        elif what == "let go":
            held.discard(process)
            calls.let_go(process, now_ns)
        ready = sorted(place for each, place in queued.items() if each not in held)
        for place in ready[: len(ready) if not slots else max(0, slots - len(under_way))]:
            under_way.add(place[3])
            del queued[place[3]]
        assert calls.under_way == len(under_way)
        assert calls.queued == len(queued)
