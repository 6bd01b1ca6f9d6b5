"""Promises of the whole kernel, on random scripts of events, evidence, answers, outcomes, acts, time and crashes."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable

import msgspec
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.domains import load
from wakeful.drivers.assembly import assemble
from wakeful.drivers.live import LiveDriver
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.asking import Reply
from wakeful.facts.events import Draft
from wakeful.facts.evidence import Evidence, Outcome
from wakeful.facts.inputs import Act, Answer, Begin, Call, Input, Mark, Requests
from wakeful.facts.lines import Admitted, Created, Decided, Line, Moved
from wakeful.facts.processes import State, Trigger
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import to_ns
from wakeful.facts.values import Field
from wakeful.journal import MemoryJournal
from wakeful.journal.audit import audit
from wakeful.journal.export import exported
from wakeful.scheduling import SuspendResume

#: What is met, and the treatment that the guidelines choose for it: one waits for evidence, the others think at once.
MET: dict[str, dict[str, Field]] = {
    "diagnosis": {"category": "device", "state": "abnormal", "location": "storage", "route": "none"},
    "risk_prediction": {"category": "item", "state": "unstable", "location": "edge", "route": "none"},
    "description": {"category": "item", "state": "normal", "location": "center", "route": "none"},
}
DOMAIN = load("service_robot")
ENTITIES = ("pump", "stack", "crate")


class Bench:
    """A kernel with its journal, driven by hand; ``crash`` forgets everything that was not committed."""

    def __init__(self, seed: int = 0, keep_waiting: int = 4_096) -> None:
        self.settings = MindSettings(step_s=0.1, reasoner_slots=2, seed=seed, keep_waiting=keep_waiting)
        self.journal = MemoryJournal()
        self.calls: list[Call] = []
        self.position = -1
        self.kernel, _ = assemble(DOMAIN, self.settings, policy=SuspendResume())
        self.feed(Begin(source="bench", digest="bench"))

    def feed(self, *inputs: Input, after_s: float = 0.0) -> None:
        self._take(self.kernel.feed(inputs, self.kernel.now_ns + to_ns(after_s)))

    def _take(self, requests: Requests) -> None:
        self.journal.commit(requests.lines, self.kernel.changed(), requests.blobs)
        self.calls.extend(requests.calls)

    def crash(self) -> None:
        self.kernel, _ = assemble(DOMAIN, self.settings, policy=SuspendResume())
        self.calls = []
        self._take(self.kernel.recover(self.journal.lines(), self.journal.state(), {}))

    def meet(self, what: str, entity: str, criticality: int) -> None:
        self.position += 1
        draft = Draft(
            kind="object",
            entity=entity,
            source="bench",
            position=self.position,
            at_ns=self.kernel.now_ns,
            fields=MET[what],
            criticality=criticality,  # type: ignore[arg-type]
            deadline_s=5.0 if criticality == 3 else None,
        )
        self.feed(draft, Mark(source="bench", position=self.position))

    def answer(self, right: bool) -> None:
        """Answer the oldest call that somebody still waits for: with the first option, or by refusing."""
        waiting = {(each.id, each.pending.seq) for each in self.kernel._scheduler.processes if each.pending is not None}
        self.calls = [call for call in self.calls if (call.process, call.seq) in waiting]
        if not self.calls:
            return
        call = min(self.calls, key=lambda call: (call.asked_ns, call.process, call.seq))
        self.calls.remove(call)
        options = call.question.options if call.question is not None else ("",)
        reply = Reply(choice=options[0], confidence=0.9, because=("a script",))
        value = msgspec.Raw(msgspec.json.encode(reply))
        answer = Answer(process=call.process, seq=call.seq)
        changes = {"value": value} if right else {"error": "refused"}
        self.feed(msgspec.structs.replace(answer, **changes))

    def lines(self) -> list[Line]:
        return list(self.journal.lines())


def text(lines: Iterable[Line]) -> bytes:
    return msgspec.json.encode(list(lines))


class TwoKernels(RuleBasedStateMachine):
    """The same script for a kernel that lives through and for one that crashes at any instant between two commits, and whose
    waiting processes are parked outside memory at once."""

    def __init__(self) -> None:
        super().__init__()
        self.calm, self.crashing = Bench(), Bench(keep_waiting=0)
        self.told = 0

    def both(self) -> tuple[Bench, Bench]:
        return self.calm, self.crashing

    @rule(what=st.sampled_from(sorted(MET)), entity=st.sampled_from(ENTITIES), criticality=st.integers(0, 3))
    def meet(self, what: str, entity: str, criticality: int) -> None:
        for bench in self.both():
            bench.meet(what, entity, criticality)

    @rule(entity=st.sampled_from(ENTITIES), twice=st.booleans())
    def hear(self, entity: str, twice: bool) -> None:
        self.told += 1
        for bench in self.both():
            later = Evidence(
                id=f"e{self.told}",
                topic="reading",
                key=entity,
                at_ns=bench.kernel.now_ns,
                value=msgspec.Raw(b'{"temperature_c": 82.0, "current_a": 3.0}'),
            )
            bench.feed(*([later, later] if twice else [later]))

    @rule(entity=st.sampled_from(ENTITIES), label=st.sampled_from(["none", "intervention"]))
    def see(self, entity: str, label: str) -> None:
        self.told += 1
        for bench in self.both():
            bench.feed(Outcome(id=f"o{self.told}", topic="outcome", entity=entity, label=label, at_ns=bench.kernel.now_ns))

    @rule(right=st.booleans())
    def answer(self, right: bool) -> None:
        for bench in self.both():
            bench.answer(right)

    @rule(act=st.sampled_from(["hold", "release", "cancel"]), process=st.integers(1, 8), identity=st.integers(0, 30))
    def operate(self, act: str, process: int, identity: int) -> None:
        for bench in self.both():
            bench.feed(Act(who="ana", act=act, process=process, why="a script", id=f"a{identity}" if identity else ""))

    @rule(process=st.integers(1, 8))
    def reopen(self, process: int) -> None:
        """A person wants a completed process's event to be thought about again, once or while another process of it is open."""
        for bench in self.both():
            made = {line.record.process: line.record.event for line in bench.lines() if isinstance(line.record, Created)}
            if process in made:
                bench.feed(Act(who="ana", act="reopen", process=process, event=made[process], why="a script"))

    @rule(seconds=st.sampled_from([0.05, 0.1, 0.3, 2.0, 45.0]))
    def wait(self, seconds: float) -> None:
        for bench in self.both():
            bench.feed(after_s=seconds)

    @rule()
    def crash(self) -> None:
        self.crashing.crash()

    @invariant()
    def every_admitted_event_has_a_process_with_a_decision(self) -> None:
        lines = self.crashing.lines()
        admitted = {line.record.event.id for line in lines if isinstance(line.record, Admitted)}
        created = {line.record.event: line.record.process for line in lines if isinstance(line.record, Created)}
        decided = {line.record.process for line in lines if isinstance(line.record, Decided)}
        assert admitted == set(created)
        assert set(created.values()) <= decided

    @invariant()
    def a_crash_changes_nothing(self) -> None:
        assert text(exported(self.crashing.journal, stable=True)) == text(exported(self.calm.journal, stable=True))

    @invariant()
    def no_more_calls_than_slots_are_under_way(self) -> None:
        for bench in self.both():
            open_calls = bench.kernel._scheduler.processes.reasoner_calls.under_way
            assert open_calls <= bench.settings.reasoner_slots

    def teardown(self) -> None:
        """Let everybody go on and everything end; then audit."""
        for bench in self.both():
            for process in [each.id for each in bench.kernel._scheduler.processes if each.held]:
                bench.feed(Act(who="ana", act="release", process=process, why="the end"))
            for _ in range(12):
                bench.feed(after_s=200.0)
            assert len(bench.kernel._scheduler.processes) == 0
            report = audit(bench.journal)
            assert report.ok, report.first_offender
        self.a_crash_changes_nothing()
        no_step_is_lost_or_repeated(self.calm.lines())


def no_step_is_lost_or_repeated(lines: list[Line]) -> None:
    """A process's steps are exactly those of its stays in a slot: a whole step each 0.1 s, none beyond."""
    since: dict[int, tuple[int, int]] = {}
    for line in lines:
        record = line.record
        if not isinstance(record, Moved):
            continue
        if record.trigger is Trigger.DISPATCH:
            since[record.process] = (line.at_ns, record.steps)
        elif record.before is State.ACTIVE:
            began_ns, steps = since.pop(record.process)
            assert record.steps - steps == (line.at_ns - began_ns) // to_ns(0.1), line
        else:
            assert record.process not in since


TwoKernels.TestCase.settings = settings(
    max_examples=15,
    stateful_step_count=20,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
test_a_kernel_keeps_its_promises_in_any_order_and_a_crash_anywhere_changes_nothing = TwoKernels.TestCase


SCRIPT = st.lists(
    st.one_of(
        st.tuples(st.just("meet"), st.sampled_from(sorted(MET)), st.sampled_from(ENTITIES), st.integers(0, 3)),
        st.tuples(st.just("hear"), st.sampled_from(ENTITIES)),
        st.tuples(st.just("act"), st.sampled_from(["hold", "release", "cancel"]), st.integers(1, 5)),
    ),
    max_size=14,
)
NOW_NS = 1_700_000_000_000_000_000


def inputs(script: list[tuple]) -> list[Draft | Evidence | Act]:
    """The script as inputs, all at one instant of source time."""
    found: list[Draft | Evidence | Act] = []
    for index, (what, *rest) in enumerate(script):
        if what == "meet":
            kind, entity, criticality = rest
            found.append(
                Draft(
                    kind="object",
                    entity=entity,
                    source="live",
                    position=index,
                    at_ns=NOW_NS,
                    fields=MET[kind],
                    criticality=criticality,
                )
            )
        elif what == "hear":
            value = msgspec.Raw(b'{"temperature_c": 82.0, "current_a": 3.0}')
            found.append(Evidence(id=f"e{index}", topic="reading", key=rest[0], at_ns=NOW_NS, value=value))
        else:
            found.append(Act(who="ana", act=rest[0], process=rest[1], why="a script"))
    return found


def decisions(journal: MemoryJournal) -> list[tuple]:
    """In order: what was decided for whom and how, and every transition."""
    found: list[tuple] = []
    for line in journal.lines():
        record = line.record
        if isinstance(record, Decided):
            found.append((record.process, record.decision.treatment, record.decision.mode, record.decision.confidence))
        elif isinstance(record, Moved):
            found.append((record.process, record.trigger, record.steps, record.by))
    return found


def virtual(script: list[tuple]) -> MemoryJournal:
    journal = MemoryJournal()
    kernel, learner = assemble(DOMAIN, MindSettings(step_s=0.0), policy=SuspendResume())
    driver = SimulatedDriver(kernel, journal, GuidelineReasoner(kernel.domain.spec, latency_s=0.0), learner)
    driver.begin("live", "live")
    for each in inputs(script):
        driver.put([each], NOW_NS)
    driver.close()
    return journal


def lived(script: list[tuple]) -> MemoryJournal:
    journal = MemoryJournal()
    kernel, learner = assemble(DOMAIN, MindSettings(step_s=0.0), policy=SuspendResume())
    reasoner = GuidelineReasoner(kernel.domain.spec, latency_s=0.0)

    async def main() -> None:
        async with LiveDriver(kernel, journal, reasoner, learner, clock_ns=lambda: NOW_NS) as mind:
            for each in inputs(script):
                await (mind.admit(each) if isinstance(each, Draft) else mind.tell(each))
                while kernel.runnable or mind.busy:
                    await asyncio.sleep(0)

    asyncio.run(main())
    return journal


@settings(max_examples=15, deadline=None)
@given(SCRIPT)
def test_the_live_and_the_virtual_driver_give_the_same_order_of_decisions_on_the_same_inputs(script: list[tuple]) -> None:
    assert decisions(lived(script)) == decisions(virtual(script))


@settings(max_examples=10, deadline=None)
@given(SCRIPT)
def test_the_same_inputs_give_the_same_journal_to_the_byte(script: list[tuple]) -> None:
    assert text(virtual(script).lines()) == text(virtual(script).lines())
