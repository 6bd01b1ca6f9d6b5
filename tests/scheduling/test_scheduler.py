"""The scheduler: slots, waiting, preemption, failure, and recovery at any instant."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

import msgspec
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.scheduling.world import Repertoire, Said, World, say
from wakeful.contracts.treatment import Mind, Refusal
from wakeful.facts.asking import Query, Question, Reply
from wakeful.facts.events import Event
from wakeful.facts.lines import Answered, Asked, Concluded, Created, Decided, Moved, Noted
from wakeful.facts.processes import TRANSITIONS, State, Trigger
from wakeful.facts.results import Result

Thinks = Callable[[Event, Mind], Awaitable[Result]]


async def short(event: Event, mind: Mind) -> Result:
    await mind.work(2)
    return say(f"{event.id} done")


async def diagnosis(event: Event, mind: Mind) -> Result:
    await mind.work(1)
    hypotheses = [f"{event.id}-hot", f"{event.id}-worn"]
    readings = await mind.evidence("sensor", event.id, within_s=50)
    await mind.work(1)
    heard = [msgspec.json.decode(each.value) for each in readings]
    return say(f"{hypotheses} {heard}")


async def remembering(event: Event, mind: Mind) -> Result:
    first = await mind.recall(Query(event=event.id))
    await mind.work(1)
    second = await mind.recall(Query(event=event.id))
    return say(f"{first[0].at_ns} {second[0].at_ns}")


async def failing(event: Event, mind: Mind) -> Result:
    await mind.work(1)
    if mind.mode != "fallback":
        raise ValueError("no such thing")
    return say("provisional")


async def hopeless(event: Event, mind: Mind) -> Result:
    raise RuntimeError("never")


async def parent(event: Event, mind: Mind) -> Result:
    await mind.work(1)
    found = await mind.treat("short", event)
    return say(f"child said: {found.says}")


async def caller(event: Event, mind: Mind) -> Result:
    try:
        answer = await mind.call(lambda: None, key="look", within_s=20)
    except Refusal as refusal:
        answer = f"refused: {refusal}"
    return say(str(answer))


async def effective(event: Event, mind: Mind) -> Result:
    try:
        answer = await mind.call(lambda: None, key="move", within_s=20, safety="effect")
    except Refusal as refusal:
        answer = f"refused: {refusal}"
    return say(str(answer))


async def deliberate(event: Event, mind: Mind) -> Result:
    question = Question(about="what", event=event.id, asks="?", options=("a",))
    reply = await mind.deliberate(question)
    return say(reply.choice)


async def sleeper(event: Event, mind: Mind) -> Result:
    await mind.sleep_s(7)
    return say(f"awake at {mind.now_s:g}")


async def two_of_three(event: Event, mind: Mind) -> Result:
    heard = await mind.evidence("vote", event.id, within_s=10, count=2)
    more = await mind.evidence("vote", event.id, within_s=10)
    return say(",".join(each.id for each in (*heard, *more)))


ALL = Repertoire(
    short=short,
    diagnosis=diagnosis,
    remembering=remembering,
    failing=failing,
    hopeless=hopeless,
    parent=parent,
    caller=caller,
    effective=effective,
    deliberate=deliberate,
    sleeper=sleeper,
    two_of_three=two_of_three,
)


@pytest.fixture
def world() -> World:
    return World(ALL)


def moves(world: World, process: int) -> list[Trigger]:
    return [line.record.trigger for line in world.lines if isinstance(line.record, Moved) and line.record.process == process]


def test_the_sequence_of_equation_6_p1_p2_p3_p1(world: World) -> None:
    first = world.meet("device", "diagnosis")
    world.until(1)
    assert world.scheduler.processes[first].state is State.WAITING
    world.meet("route", "short")
    world.until(2)
    world.meet("box", "short")
    world.until(6)
    world.tell("sensor", "device", 71.5)
    world.until(8)
    assert world.ends() == [
        ("route", "route done"),
        ("box", "box done"),
        ("device", "['device-hot', 'device-worn'] [71.5]"),
    ]


def test_a_critical_event_preempts_and_the_preempted_goes_on_where_it_was(world: World) -> None:
    slow = world.meet("slow", "short")
    world.until(0.5)
    world.meet("urgent", "short", criticality=3)
    world.until(1.5)
    suspended = world.scheduler.processes[slow]
    assert (suspended.state, suspended.steps, suspended.preempted_by) == (State.SUSPENDED, 1, "P2")
    world.until(4)
    assert [event for event, _ in world.ends()] == ["urgent", "slow"]
    assert world.now_ns == 4_000_000_000
    done = [line.at_ns for line in world.lines if isinstance(line.record, Concluded)]
    assert done == [3_000_000_000, 4_000_000_000]  # no step lost, none repeated: 2 + 2 steps


def test_a_suspended_process_keeps_its_hypotheses_across_a_crash(world: World) -> None:
    world.meet("device", "diagnosis")
    world.until(1)
    world.crash()
    world.tell("sensor", "device", 3)
    world.crash()
    world.until(3)
    assert world.ends() == [("device", "['device-hot', 'device-worn'] [3]")]


def test_what_was_recalled_is_not_recalled_again_after_a_crash(world: World) -> None:
    world.meet("thing", "remembering")
    before = [line.record for line in world.lines if isinstance(line.record, Answered)]
    world.crash()
    world.until(2)
    answers = [line.record for line in world.lines if isinstance(line.record, Answered)]
    assert answers[:1] == before
    assert len(answers) == 2


def test_evidence_that_comes_early_is_kept_and_delivered(world: World) -> None:
    world.tell("sensor", "device", "early")
    world.meet("device", "diagnosis")
    world.until(2)
    assert world.ends() == [("device", "['device-hot', 'device-worn'] ['early']")]


def test_evidence_that_never_comes_ends_the_wait_at_its_limit(world: World) -> None:
    process = world.meet("device", "diagnosis")
    world.until(60)
    assert world.ends() == [("device", "['device-hot', 'device-worn'] []")]
    assert Trigger.EXPIRE in moves(world, process)


def test_the_same_evidence_twice_counts_once_and_none_is_delivered_twice(world: World) -> None:
    world.meet("door", "two_of_three")
    for identity in ("a", "a", "b"):
        world.tell("vote", "door", 1, identity)
    world.tell("vote", "door", 1, "c")
    world.until(1)
    assert world.ends() == [("door", "a,b,c")]


def test_a_treatment_that_raises_goes_on_in_fallback_mode(world: World) -> None:
    process = world.meet("odd", "failing")
    world.until(3)
    assert world.ends() == [("odd", "provisional")]
    assert moves(world, process) == [Trigger.DISPATCH, Trigger.RESTART, Trigger.DISPATCH, Trigger.RESOLVE]
    modes = [line.record.decision.mode for line in world.lines if isinstance(line.record, Decided)]
    assert modes == ["auto", "fallback"]


def test_a_treatment_that_fails_in_fallback_too_is_unresolved_and_never_lost(world: World) -> None:
    process = world.meet("odd", "hopeless")
    assert moves(world, process)[-1] is Trigger.FAIL
    assert "RuntimeError: never" in world.ends()[0][1]
    assert sum(isinstance(line.record, Noted) for line in world.lines) == 2


def test_a_treatment_that_is_gone_is_stood_in_for_in_fallback_mode_and_named(world: World) -> None:
    process = world.meet("odd", "removed")
    world.until(60)
    assert moves(world, process)[-1] is Trigger.RESOLVE
    decided = [line.record.decision for line in world.lines if isinstance(line.record, Decided)]
    assert [each.mode for each in decided] == ["auto", "fallback"]
    assert decided[1].treatment in world.repertoire.of
    assert [line.record.what for line in world.lines if isinstance(line.record, Noted)] == ["treatment removed"]


def test_a_treatment_that_is_gone_with_nothing_to_stand_in_is_unresolved_and_not_stranded() -> None:
    world = World(Repertoire())
    process = world.meet("odd", "removed")
    assert moves(world, process)[-1] is Trigger.FAIL


def test_a_child_process_gives_its_result_to_its_parent(world: World) -> None:
    world.meet("both", "parent")
    world.until(5)
    assert [says for _, says in world.ends()] == ["both done", "child said: both done"]
    created = [line.record for line in world.lines if isinstance(line.record, Created)]
    assert [each.parent for each in created] == [0, 1]


def test_an_answered_call_is_never_made_again(world: World) -> None:
    world.meet("it", "caller")
    assert len(world.calls) == 1
    world.answer("seen")
    world.crash()
    world.until(1)
    assert world.calls == []
    assert world.ends() == [("it", "seen")]


def test_a_call_in_doubt_is_made_again_when_it_only_reads(world: World) -> None:
    world.meet("it", "caller")
    key = world.calls[0].key
    world.crash()
    assert [call.key for call in world.calls] == [key]


def test_a_call_with_effect_in_doubt_is_never_made_again(world: World) -> None:
    world.meet("it", "effective")
    world.crash()
    assert world.calls == []
    world.until(1)
    assert "in doubt" in world.ends()[0][1]


def test_a_refused_deliberation_ends_in_fallback_mode(world: World) -> None:
    world.meet("it", "short", mode="delib")
    world.answer(error="rate limit")
    world.until(4)
    assert world.ends() == [("it", "it done")]
    last = [line.record.decision for line in world.lines if isinstance(line.record, Decided)][-1]
    assert last.mode == "fallback"
    assert "rate limit" in last.reasons[-1]


def test_deliberation_may_choose_another_treatment(world: World) -> None:
    world.meet("it", "short", mode="delib")
    world.answer(Reply(choice="sleeper", confidence=0.9, because=("it is late",), reasoner="test"))
    world.crash()
    world.until(10)
    assert world.ends() == [("it", "awake at 7")]
    last = [line.record.decision for line in world.lines if isinstance(line.record, Decided)][-1]
    assert (last.treatment, last.mode, last.reasons[-1]) == ("sleeper", "delib", "test: it is late")


def test_what_waits_about_a_cleared_condition_becomes_moot(world: World) -> None:
    process = world.meet("blocked", "diagnosis", condition="robot|zone|blocked")
    world.until(1)
    world.scheduler.moot("robot|zone|blocked")
    assert moves(world, process)[-1] is Trigger.MOOT
    assert process not in world.scheduler.processes


def test_code_that_no_longer_matches_its_record_is_restarted_and_named(world: World) -> None:
    process = world.meet("device", "diagnosis")
    world.until(1)
    world.repertoire = Repertoire(diagnosis=sleeper)
    world.crash()
    world.tell("sensor", "device", 1)
    world.until(20)
    assert Trigger.RESTART in moves(world, process)
    assert world.ends()[0][1].startswith("awake at")
    assert any("no longer matches" in line.record.what for line in world.lines if isinstance(line.record, Noted))


async def timekeeper(event: Event, mind: Mind) -> Result:
    told = [mind.now_s]
    for _ in range(3):
        await mind.work(2)
        told.append(mind.now_s)
        await mind.evidence("sensor", event.id, within_s=3)
        told.append(mind.now_s)
    return say(str(told))


def test_a_rebuilt_process_is_told_the_same_times() -> None:
    def told(crash_at: int | None) -> str:
        world = World(Repertoire(timekeeper=timekeeper))
        world.meet("clock", "timekeeper")
        for second in range(40):
            world.until(second)
            if second == crash_at:
                world.crash()
        return world.ends()[0][1]

    assert told(None) == "[0.0, 0.0, 5.0, 5.0, 10.0, 10.0, 15.0]"
    assert {told(second) for second in range(20)} == {told(None)}


def _run(plan: list[tuple[int, str, int]], crashes: set[int]) -> World:
    """Meet each event at its second; crash at the seconds in ``crashes``."""
    world = World(ALL, slots=2)
    for second in range(40):
        for at, treatment, criticality in plan:
            if at == second:
                world.meet(f"e{second}-{treatment}-{criticality}-{len(world.lines)}", treatment, criticality)
        if second % 5 == 4:
            for process in list(world.scheduler.processes):
                world.tell("sensor", process.event.id, second)
                world.tell("vote", process.event.id, second, f"{second}{process.event.id}")
        world.until(second + 0.7)
        if second in crashes:
            world.crash()
        world.until(second + 1)
    world.until(2000)
    return world


_TREATMENTS = st.sampled_from(["short", "diagnosis", "remembering", "failing", "hopeless", "parent", "sleeper", "two_of_three"])


@settings(max_examples=60, deadline=None)
@example(plan=[(5, "two_of_three", 0), (18, "short", 0), (18, "short", 0)], crashes={19})
@given(
    st.lists(st.tuples(st.integers(0, 30), _TREATMENTS, st.integers(0, 3)), max_size=12),
    st.sets(st.integers(0, 39), max_size=12),
)
def test_a_run_with_crashes_leaves_the_same_lines_as_one_without(plan: list[tuple[int, str, int]], crashes: set[int]) -> None:
    assert _run(plan, crashes).lines == _run(plan, set()).lines


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 30), _TREATMENTS, st.integers(0, 3)), max_size=15))
def test_every_process_ends_by_legal_moves_and_every_answer_has_its_request(plan: list[tuple[int, str, int]]) -> None:
    world = _run(plan, set())
    assert len(world.scheduler.processes) == 0
    states: dict[int, State] = {}
    asked: set[tuple[int, int]] = set()
    for line in world.lines:
        record = line.record
        if isinstance(record, Created):
            states[record.process] = State.CREATED
        elif isinstance(record, Moved):
            assert states[record.process] is record.before
            assert TRANSITIONS[record.before, record.trigger] is record.after
            states[record.process] = record.after
        elif isinstance(record, Asked):
            asked.add((record.process, record.seq))
        elif isinstance(record, Answered):
            asked.remove((record.process, record.seq))
    assert all(state is State.COMPLETED for state in states.values())


def test_in_slotted_time_all_that_came_within_a_step_is_known_before_the_next_one_begins() -> None:
    world = World(ALL)
    world.settings = msgspec.structs.replace(world.settings, slotted=True)
    world.now_ns = 500_000_000
    world.meet("first", "short")
    world.meet("urgent", "short", criticality=3)
    assert world.scheduler.processes.active == []
    world.until(0.9)
    world.crash()
    world.until(1.5)
    assert world.scheduler.processes.active == [2]
    world.until(9)
    done = [(line.at_ns, line.record.event) for line in world.lines if isinstance(line.record, Concluded)]
    assert done == [(3_000_000_000, "urgent"), (5_000_000_000, "first")]


async def waits_for_ever(event: Event, mind: Mind) -> Result:
    await mind.evidence("sensor", event.id, within_s=float("inf"))
    return say("never")


async def asks_for_ever(event: Event, mind: Mind) -> Result:
    while True:
        await mind.evidence("sensor", event.id, within_s=0)


async def works_for_ever(event: Event, mind: Mind) -> Result:
    while True:
        await mind.work()


async def works_very_long(event: Event, mind: Mind) -> Result:
    await mind.work(10**12)
    return say("never")


async def treats_itself(event: Event, mind: Mind) -> Result:
    return say((await mind.treat("bad", event)).says)


async def leaves(event: Event, mind: Mind) -> Result:
    raise SystemExit(3)


async def unsure_of_all(event: Event, mind: Mind) -> Result:
    return say("x") if mind.mode == "none" else Said(says="x", confidence=float("nan"))


@pytest.mark.parametrize(
    ("think", "why"),
    [
        (waits_for_ever, "every wait needs a limit"),
        (asks_for_ever, "more than 256 requests"),
        (works_for_ever, "at most 10000 are given"),
        (works_very_long, "at most 10000 are given"),
        (treats_itself, "nested deeper than 8"),
        (leaves, "SystemExit"),
        (unsure_of_all, "confidence nan"),
    ],
)
def test_a_treatment_that_asks_for_too_much_has_failed_and_others_go_on(think: Thinks, why: str) -> None:
    world = World(Repertoire(bad=think, short=short))
    bad = world.meet("bad", "bad")
    world.meet("good", "short")
    world.until(40_000)
    assert len(world.scheduler.processes) == 0
    assert "good done" in [says for _, says in world.ends()]
    assert moves(world, bad)[-1] in (Trigger.FAIL, Trigger.RESOLVE)
    assert any(why in line.record.detail for line in world.lines if isinstance(line.record, Noted))
