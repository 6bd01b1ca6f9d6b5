"""Experiment 2 on the kernel: nothing lost, nothing repeated, the baselines' structure, the metrics by hand, bytes."""

from __future__ import annotations

from functools import cache

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wakeful.experiments.exp2_processing import (
    METHODS,
    SEEDS,
    SOURCE,
    STEPS,
    Method,
    Told,
    against_limit,
    gains,
    holders,
    limit,
    lives,
    measure,
    measure_all,
    new_kernel,
    one,
    rows,
    run,
    waiting,
)
from wakeful.experiments.worlds.service_load import FIRST, NOMINAL_STEPS, SECOND, Arrival, Load, arrivals
from wakeful.facts.events import Draft
from wakeful.facts.evidence import Evidence
from wakeful.facts.inputs import Begin, Input
from wakeful.facts.lines import Admitted, Answered, Asked, Concluded, Created, Decided, Line, Moved
from wakeful.facts.processes import ProcessView, State, Trigger
from wakeful.facts.time import NS_PER_S
from wakeful.journal import MemoryJournal
from wakeful.scheduling.policies.deadline_aware import DeadlineAware
from wakeful.scheduling.policies.reactive_priority import ReactivePriority
from wakeful.scheduling.policies.sequential import Sequential
from wakeful.scheduling.policies.suspend_resume import SuspendResume
from wakeful.scheduling.policies.task_bounded import TaskBounded

BY_NAME = {method.name: method for method in METHODS}
HIGH, BURSTY = FIRST.loads[2], FIRST.loads[3]
SEED = 1000

each_method = pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
each_load = pytest.mark.parametrize("load", [HIGH, BURSTY], ids=lambda load: load.name)


@cache
def played(name: str, load: str, seed: int = SEED) -> MemoryJournal:
    return run(world_of(load, seed), BY_NAME[name].policy())


def world_of(load: str, seed: int = SEED) -> tuple[Arrival, ...]:
    return arrivals(next(each for each in FIRST.loads if each.name == load), FIRST, seed)


def moves(journal: MemoryJournal) -> list[tuple[int, Moved]]:
    return [(line.at_ns, line.record) for line in journal.lines() if isinstance(line.record, Moved)]


# --- what holds for every policy ---


@each_method
@each_load
def test_every_admitted_event_has_its_process_with_a_decision_in_the_very_next_lines(method: Method, load: Load) -> None:
    lines = list(played(method.name, load.name).lines())
    admitted = 0
    for line, following, last in zip(lines, lines[1:], lines[2:], strict=False):
        if isinstance(line.record, Admitted):
            admitted += 1
            assert isinstance(following.record, Created)
            assert following.record.event == line.record.event.id
            assert isinstance(last.record, Decided)
            assert last.record.process == following.record.process
            assert line.at_ns == following.at_ns == last.at_ns
    assert admitted == len(world_of(load.name))


@each_method
@each_load
def test_no_step_is_lost_or_repeated_by_suspension(method: Method, load: Load) -> None:
    journal, world = played(method.name, load.name), world_of(load.name)
    held = holders(journal)
    for process, life in lives(journal).items():
        spent = sum(holder == process for holder in held)
        if life.ended_ns is not None:
            assert spent == world[process - 1].work
        else:
            assert spent < world[process - 1].work


@each_method
def test_the_last_unit_waits_for_the_evidence_and_nothing_else_does(method: Method) -> None:
    journal, world = played(method.name, "bursty_delayed"), world_of("bursty_delayed")
    held = holders(journal)
    for process, life in lives(journal).items():
        needs = world[process - 1].evidence_steps
        steps = [step for step, holder in enumerate(held) if holder == process]
        if life.ended_ns is not None and needs is not None:
            assert steps[-1] >= steps[0] + needs
        if needs is None:
            assert not any(isinstance(line.record, Asked) and line.record.process == process for line in journal.lines())


@each_method
def test_nobody_works_before_arriving_and_one_slot_holds_one_process(method: Method) -> None:
    journal, world = played(method.name, "high"), world_of("high")
    active: set[int] = set()
    for _, moved in moves(journal):
        if moved.after is State.ACTIVE:
            active.add(moved.process)
        else:
            active.discard(moved.process)
        assert len(active) <= 1
    for step, holder in enumerate(holders(journal)):
        assert holder is None or world[holder - 1].step <= step


@each_method
def test_the_same_seed_gives_the_same_journal_to_the_byte(method: Method) -> None:
    def encoded() -> bytes:
        return msgspec.json.encode(list(run(world_of("bursty_delayed"), method.policy()).lines()))

    assert encoded() == encoded()


@pytest.mark.parametrize("told", ["effort", "kind"])
@pytest.mark.parametrize("load", [HIGH, BURSTY], ids=lambda load: load.name)
def test_a_mind_that_is_killed_again_and_again_decides_on_as_if_it_had_not_been(load: Load, told: Told) -> None:
    world = arrivals(load, FIRST, SEED)
    undisturbed = run(world, DeadlineAware(), told=told)
    first = {process: life.first for process, life in lives(undisturbed).items()}
    coming: dict[int, list[Input]] = {0: [Begin(source=SOURCE, digest=SOURCE)]}
    for line in undisturbed.lines():
        if isinstance(line.record, Admitted):
            event = line.record.event
            draft = Draft(
                **{name: getattr(event, name) for name in Draft.__struct_fields__ if hasattr(event, name)},
                at_ns=event.stamp.source_ns,
            )
            coming.setdefault(world[event.position].step, []).append(draft)
    begun = sorted((began, number) for number, began in first.items() if began is not None)
    for began, number in begun:
        delay = world[number - 1].evidence_steps
        if delay is not None:
            due = began + delay
            at_ns = (2 * due + 1) * NS_PER_S // 2
            evidence = Evidence(id=f"E{number}", topic="service_load", key=f"E{number}", at_ns=at_ns)
            coming.setdefault(due, []).append(evidence)
    journal = MemoryJournal()
    kernel = new_kernel(DeadlineAware())
    for step in range(STEPS + 1):
        if step % 7 == 3:
            kernel = new_kernel(DeadlineAware())
            assert kernel.recover(journal.lines(), journal.state(), {}).lines == ()
        for at_ns, inputs in (((2 * step + 1) * NS_PER_S // 2, coming.get(step, [])), ((step + 1) * NS_PER_S, [])):
            requests = kernel.feed(inputs, at_ns)
            journal.commit(requests.lines, kernel.changed(), requests.blobs)
    assert list(journal.lines()) == list(undisturbed.lines())


ARRIVALS = st.builds(
    Arrival,
    step=st.integers(0, 30),
    kind=st.sampled_from(["a", "b"]),
    critical=st.booleans(),
    task_relevant=st.booleans(),
    work=st.integers(2, 6),
    priority=st.integers(0, 5),
    deadline_steps=st.none() | st.integers(1, 15),
    evidence_steps=st.none() | st.integers(1, 20),
)


@settings(max_examples=25, deadline=None)
@given(
    st.lists(ARRIVALS, min_size=1, max_size=25).map(lambda events: tuple(sorted(events, key=lambda each: each.step))),
    st.sampled_from(METHODS),
    st.sampled_from(["effort", "kind", "nothing"]),
)
def test_on_any_world_every_event_is_covered_at_every_position_and_no_step_is_lost(
    world: tuple[Arrival, ...], method: Method, told: Told
) -> None:
    journal = run(world, method.policy(), told=told)
    states: dict[int, State] = {}
    limited: set[int] = set()
    owed: list[str] = []
    done = 0
    for line in journal.lines():
        record = line.record
        if isinstance(record, Admitted):
            owed.append(record.event.id)
        elif isinstance(record, Created):
            assert record.event == owed[-1]
            states[record.process] = State.CREATED
        elif isinstance(record, Asked):
            assert record.expires_ns is not None
            limited.add(record.process)
        elif isinstance(record, Moved):
            assert states[record.process] is record.before
            assert record.after is not State.WAITING or record.process in limited
            states[record.process] = record.after
            done += record.after is State.COMPLETED
        if not isinstance(record, Admitted):
            assert len(states) == len(owed)
    assert len(owed) == len(world)
    held = holders(journal)
    for process, life in lives(journal).items():
        spent = sum(holder == process for holder in held)
        assert spent == world[process - 1].work if life.ended_ns is not None else spent < world[process - 1].work
    if method.name in ("suspend_resume", "deadline_aware"):
        assert done == len(world)  # 25 × 6 steps and 20 of waiting fit into the run: nobody is left over


def test_evidence_is_answered_once_for_each_process_that_asked_and_lived() -> None:
    lines = list(played("suspend_resume", "bursty_delayed").lines())
    asked = [line.record.process for line in lines if isinstance(line.record, Asked)]
    answered = [line.record.process for line in lines if isinstance(line.record, Answered)]
    assert len(set(asked)) == len(asked)
    assert len(set(answered)) == len(answered)
    assert set(answered) <= set(asked)


# --- the baselines' structure ---


def test_task_bounded_gives_no_step_to_what_is_outside_the_task() -> None:
    journal, world = played("task_bounded", "high"), world_of("high")
    assert all(world[holder - 1].task_relevant for holder in holders(journal) if holder is not None)


@pytest.mark.parametrize("name", ["sequential", "task_bounded"])
def test_a_sequential_policy_finishes_one_before_it_begins_the_next(name: str) -> None:
    found = moves(played(name, "high"))
    begun: list[int] = []
    for _, moved in found:
        if moved.trigger is Trigger.DISPATCH and moved.process not in begun:
            begun.append(moved.process)
    assert begun == sorted(begun)
    open_now: set[int] = set()
    for _, moved in found:
        open_now.add(moved.process)
        if moved.after is State.COMPLETED:
            open_now.discard(moved.process)
        assert len(open_now) <= 1
    assert not any(moved.trigger is Trigger.PREEMPT for _, moved in found)


def test_reactive_priority_drops_what_it_interrupts_for_a_strictly_higher_priority() -> None:
    journal, world = played("reactive_priority", "high"), world_of("high")
    dropped = {moved.process: at_ns for at_ns, moved in moves(journal) if moved.trigger is Trigger.ABANDON}
    assert dropped
    assert not any(moved.trigger is Trigger.PREEMPT for _, moved in moves(journal))
    begins = [(at_ns, moved.process) for at_ns, moved in moves(journal) if moved.trigger is Trigger.DISPATCH]
    states = {moved.process: moved.before for _, moved in moves(journal) if moved.trigger is Trigger.ABANDON}
    for process, at_ns in dropped.items():
        successor = next(other for when_ns, other in begins if when_ns >= at_ns)
        if states[process] is State.ACTIVE:
            assert world[successor - 1].priority > world[process - 1].priority
        else:
            assert states[process] is State.WAITING


@pytest.mark.parametrize("name", ["suspend_resume", "deadline_aware"])
@each_load
def test_a_policy_that_keeps_state_drops_nothing_and_misses_no_critical_event(name: str, load: Load) -> None:
    for seed in (1000, 1001, 1002):
        journal = played(name, load.name, seed)
        assert not any(moved.trigger is Trigger.ABANDON for _, moved in moves(journal))
        assert measure(journal, FIRST, blocks=False).critical_miss == 0.0


def test_suspend_resume_always_runs_the_highest_priority_that_is_ready() -> None:
    journal, world = played("suspend_resume", "high"), world_of("high")
    ready: set[int] = set()
    by_instant: dict[int, list[Line]] = {}
    for line in journal.lines():
        by_instant.setdefault(line.at_ns, []).append(line)
    for at_ns, lines in sorted(by_instant.items()):
        holder = None
        for line in lines:
            if isinstance(line.record, Created):
                ready.add(line.record.process)
            elif isinstance(line.record, Moved):
                if line.record.after in (State.WAITING, State.COMPLETED):
                    ready.discard(line.record.process)
                else:
                    ready.add(line.record.process)
                holder = line.record.process if line.record.after is State.ACTIVE else None
        if holder is not None and at_ns % 1_000_000_000 == 0:
            best = max(ready, key=lambda process: (world[process - 1].priority, -process))
            assert holder == best


def test_deadline_aware_comes_close_to_the_clairvoyant_and_is_above_the_papers_policy() -> None:
    results = measure_all(range(1000, 1004), lambda done, events: None, METHODS[3:], (FIRST,))
    for workload in ("high", "bursty_delayed"):
        for metric, share in (("critical_deadline", 0.96), ("completion", 0.97)):
            ours, best, theirs = (
                sum(getattr(each, metric) for each in results[method, workload])
                for method in ("deadline_aware", "clairvoyant", "suspend_resume")
            )
            assert best * share <= ours
            assert theirs <= ours
    assert len(against_limit(results, "deadline_aware")) == len(FIRST.loads)
    assert "completion +" in gains(results, "deadline_aware", "suspend_resume")[2]


# --- metrics, by hand ---


def arrival(step: int, work: int, *, critical: bool = False, evidence: int | None = None, deadline: int | None = None) -> Arrival:
    return Arrival(
        step=step,
        kind="k",
        critical=critical,
        task_relevant=True,
        work=work,
        priority=2 if critical else 0,
        deadline_steps=deadline,
        evidence_steps=evidence,
    )


def test_a_run_measured_by_hand() -> None:
    # step 0: routine A begins; 1, 2: critical B (3 units, deadline 1 step after arrival: too late) preempts; 1 to 3; A ends in 5.
    world = (arrival(0, 3), arrival(1, 3, critical=True, deadline=1))
    journal = run(world, SuspendResume())
    assert holders(journal)[:8] == [1, 2, 2, 2, 1, 1, None, None]
    found = measure(journal, FIRST, blocks=False)
    assert (found.events, found.completion, found.critical_miss, found.critical_deadline) == (2, 100.0, 0.0, 0.0)
    assert found.latency_steps == 0.0
    assert found.primary_task == pytest.approx(100 * (NOMINAL_STEPS - 6 + 3 * 0.8 + 3 * 0.1) / NOMINAL_STEPS)


@pytest.mark.parametrize(("deadline", "met"), [(2, 100.0), (1, 0.0)])
def test_a_deadline_is_met_in_its_own_step_and_not_after_it(deadline: int, met: float) -> None:
    found = measure(run((arrival(4, 3, critical=True, deadline=deadline),), SuspendResume()), FIRST, blocks=False)
    assert found.critical_deadline == met


def test_a_blocked_step_costs_the_primary_task_only_where_the_policy_keeps_its_slot() -> None:
    journal = run((arrival(0, 3, evidence=8),), Sequential())
    assert holders(journal)[:10] == [1, 1, *[None] * 6, 1, None]
    assert waiting(journal)[:10] == [False, False, *[True] * 6, False, False]
    kept, free = (measure(journal, FIRST, blocks=blocks).primary_task for blocks in (True, False))
    assert kept == pytest.approx(100 * (NOMINAL_STEPS - 9 + 3 * 0.8 + 6 * 0.25) / NOMINAL_STEPS)
    assert free == pytest.approx(100 * (NOMINAL_STEPS - 3 + 3 * 0.8) / NOMINAL_STEPS)


def test_evidence_that_comes_while_a_process_still_works_costs_it_no_wait() -> None:
    world = (arrival(0, 4, evidence=8), *(arrival(step, 3) for step in (1, 1, 1)))
    journal = run(world, Sequential())
    assert holders(journal)[:9] == [1, 1, 1, None, None, None, None, None, 1]
    preempted = run((arrival(0, 4, evidence=8), arrival(2, 6, critical=True, deadline=12)), SuspendResume())
    assert holders(preempted)[:10] == [1, 1, 2, 2, 2, 2, 2, 2, 1, 1]
    assert not any(isinstance(line.record, Asked) and line.record.expires_ns == line.at_ns for line in preempted.lines())
    assert not any(waiting(preempted))


def test_what_is_left_at_the_end_is_not_completed_and_the_drain_counts_for_completion_alone() -> None:
    late = run((arrival(NOMINAL_STEPS - 1, 3),), SuspendResume())
    assert measure(late, FIRST, blocks=False).completion == 100.0
    assert measure(late, FIRST, blocks=False).primary_task == pytest.approx(100 * (NOMINAL_STEPS - 1 + 0.8) / NOMINAL_STEPS)
    many = run(tuple(arrival(NOMINAL_STEPS - 1, 6) for _ in range(20)), SuspendResume())
    assert measure(many, FIRST, blocks=False).completion == 100 * 10 / 20
    assert sum(holder is not None for holder in holders(many)) == STEPS - NOMINAL_STEPS + 1


def test_a_world_without_critical_events_says_nothing_of_them() -> None:
    found = measure(run((arrival(3, 3),), DeadlineAware()), FIRST, blocks=False)
    assert (found.critical_miss, found.critical_deadline) == (None, None)


def test_an_untold_policy_sees_neither_steps_nor_waits() -> None:
    class Watching(DeadlineAware):
        def runnable(self, view: ProcessView, now_ns: int) -> None:
            assert view.steps_needed is None
            assert view.needs_evidence is None
            kinds.add(view.kind)
            super().runnable(view, now_ns)

    kinds: set[str] = set()
    run(world_of("bursty_delayed"), Watching(), told="kind")
    assert len(kinds) > 3
    kinds.clear()
    run(world_of("bursty_delayed"), Watching(), told="nothing")
    assert kinds == {"event"}


# --- rows ---


def test_rows_have_every_method_workload_and_metric_with_the_papers_cell_beside_both_sets() -> None:
    results = {
        (method, parameters.named(load)): [limit(load, parameters, seed) if method == "clairvoyant" else _any(method)]
        for parameters in (FIRST, SECOND)
        for load in parameters.loads
        for method in (*BY_NAME, "clairvoyant")
        for seed in (SEEDS[0],)
    }
    found = rows(results)
    assert {each.method for each in found} == {
        "task_bounded", "sequential", "reactive_priority", "suspend_resume", "deadline_aware", "clairvoyant",
    }  # fmt: skip
    names = ["low", "medium", "high", "bursty_delayed"]
    assert {each.workload for each in found} == {*names, *(f"{name}_2" for name in names)}
    assert {each.metric for each in found} == {
        "completion", "critical_miss", "critical_deadline", "latency_steps", "primary_task",
    }  # fmt: skip
    compared = [each for each in found if each.paper_mean is not None]
    assert len(compared) == 2 * 48
    assert {each.table for each in compared if each.metric == "completion"} == {"3"}


@cache
def _any(method: str) -> object:
    return one(BY_NAME[method], FIRST.loads[1], FIRST, SEEDS[0])


def test_a_process_is_concluded_once() -> None:
    concluded = [line.record.process for line in played("deadline_aware", "high").lines() if isinstance(line.record, Concluded)]
    assert len(concluded) == len(set(concluded)) > 0


def test_the_policies_under_test_are_the_products() -> None:
    policies = (TaskBounded, Sequential, ReactivePriority, SuspendResume, DeadlineAware)
    assert [method.policy for method in METHODS] == list(policies)
