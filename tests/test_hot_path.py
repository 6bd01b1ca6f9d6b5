"""The hot path is a faster way to the same: packs do what their lines do, and batching changes nothing."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from random import Random

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.peers.drafting import draft
from benchmarks.peers.learned import DOMAIN
from benchmarks.peers.messages import TREATMENTS, Event, Tick, decode
from benchmarks.peers.messages import Evidence as Reading
from benchmarks.peers.treating import LIMIT_S, TOPIC, WAITS, conclude, look, weigh
from benchmarks.peers.workload import Workload, make
from wakeful import Event as WakefulEvent
from wakeful import Evidence, MindView, Outcome, Registry, Result, treatment
from wakeful.drivers.assembly import assemble
from wakeful.facts.asking import Query
from wakeful.facts.inputs import Begin, Input, Instant, Mark
from wakeful.facts.lines import Line, Published
from wakeful.facts.packs import AnyBurst, Covered, Entry, Inquired, Ran, Validated, Woken, expanded
from wakeful.facts.settings import MindSettings
from wakeful.journal import MemoryJournal
from wakeful.journal.export import exported
from wakeful.kernel import Kernel

EVENTS = 240


class Treated(Result, frozen=True, kw_only=True, tag="treated"):
    state: int


def stub(name: str) -> object:
    @treatment(name, says="A stub of three steps.")
    async def treat(event: WakefulEvent, mind: MindView) -> Treated:
        await mind.work()
        seen, reading = look(event.entity, event.fields["load"]), None  # type: ignore[arg-type]
        if event.fields["category"] == WAITS:
            came = await mind.evidence(TOPIC, event.entity, LIMIT_S)
            reading = msgspec.json.decode(came[0].value) if came else None
        elif event.position % 29 == 7:
            await mind.recall(Query(event=event.id, limit=2))
        elif event.position % 31 == 9:
            raise RuntimeError("a treatment may fail")
        elif event.position % 37 == 11:
            await mind.sleep_s(0.5)
        await mind.work(2)
        forecast = mind.forecast()
        state = conclude(weigh(seen, reading), forecast.label if forecast is not None else "")
        return Treated(says=f"seen at {mind.now_s:.3f}", confidence=0.5, forecast=forecast, state=state)

    return treat


@pytest.fixture(scope="module")
def workload() -> Workload:
    return make(3, EVENTS)


def new_kernel() -> Kernel:
    registry = Registry(installed=())
    for name in TREATMENTS:
        registry.add(stub(name), replace=True)  # type: ignore[arg-type]
    return assemble(DOMAIN, MindSettings(step_s=0.0), registry=registry)[0]


def begun(workload: Workload, kernel: Kernel) -> MemoryJournal:
    """A journal in which the model was published, and a kernel that has taken it up."""
    journal = MemoryJournal()
    line = Line(1, 1, Published(training=1, card=workload.card))
    journal.commit((line,), {}, {workload.card.blob: workload.weights})
    kernel.recover(journal.entries(), journal.state(), {workload.card.blob: workload.weights})
    requests = kernel.feed([Begin(source="w", digest="w")], 1)
    journal.commit(requests.lines, kernel.changed(), requests.blobs)
    return journal


def inputs_of(workload: Workload, odd: int = 0) -> Iterator[list[Input]]:
    """What each message is fed as. A tenth of the outcomes contradict, so that trust falls and decisions are reopened."""
    random, position = Random(odd), -1
    for text in workload.messages:
        message = decode(text)
        found: list[Input] = [Instant(message.at_ns)]
        if isinstance(message, Tick):
            yield found
            continue
        if isinstance(message, Event):
            position += 1
            found += [draft(message, "w", position), Mark(source="w", position=position)]
        elif isinstance(message, Reading):
            value = msgspec.Raw(msgspec.json.encode(message.value))
            found.append(Evidence(id=message.id, topic=TOPIC, key=message.entity, at_ns=message.at_ns, value=value))
        else:
            label = ("none" if message.label == "intervention" else "intervention") if random.random() < 0.1 else message.label
            found.append(Outcome(id=message.id, topic="outcome", entity=message.entity, label=label, at_ns=message.at_ns))
        yield found


def run(workload: Workload, kernel: Kernel, sizes: Iterable[int] = (64,), odd: int = 0) -> MemoryJournal:
    """W in batches of these sizes, by turns."""
    journal = begun(workload, kernel)
    turns, waiting = list(sizes), []
    turn = 0
    for place, found in enumerate(inputs_of(workload, odd)):
        waiting.extend(found)
        if place % turns[turn % len(turns)] == 0:
            turn += 1
            feed(kernel, journal, waiting)
            waiting = []
    feed(kernel, journal, waiting)
    return journal


def feed(kernel: Kernel, journal: MemoryJournal, inputs: list[Input]) -> None:
    requests = kernel.feed(inputs, kernel.now_ns)
    journal.commit(requests.lines, kernel.changed(), requests.blobs)


class Unpacked(Kernel):
    """Writes each record of a pack as a line of its own, and takes every outcome the long way."""

    def pack(self, burst: AnyBurst) -> None:
        for record in burst.records():
            self.write(record)


def unpacked() -> Kernel:
    kernel = new_kernel()
    kernel.__class__ = Unpacked
    kernel._validation.sole = lambda outcome, now_ns: None  # type: ignore[method-assign]
    kernel._scheduler._straight.run = lambda process: False  # type: ignore[method-assign]
    return kernel


def told(kernel: Kernel) -> object:
    """What the rooms know, as far as it can be asked for."""
    rooms = kernel
    return (
        rooms.now_ns,
        rooms.counts,
        rooms._validation.counts(),
        rooms._revision.levels((1, 2, 3)),
        rooms._revision.reliability,
        [(row.id, row.label, row.result, row.held_back) for row in rooms._learning.rows],
        [rooms._cells.newest(cell, 4) for cell in range(40)],
        [(each.id, each.state, each.steps, each.decision) for each in rooms._scheduler.processes],
        [each.event for each in rooms._episodes.search(Query(limit=50), rooms.now_ns)],
        rooms._exemplars.noise,
        (rooms._recent.weights, rooms._recent.heard, rooms._recent.outdoes_memory),
    )


def test_all_kinds_of_packs_are_written(workload: Workload) -> None:
    journal = run(workload, new_kernel())
    kinds = {type(entry.burst) for entry in journal.entries() if not isinstance(entry, Line)}
    assert kinds == {Covered, Inquired, Woken, Ran, Validated}


def test_a_run_with_packs_exports_the_same_as_one_without(workload: Workload) -> None:
    packed, plain = new_kernel(), unpacked()
    one, other = run(workload, packed, odd=1), run(workload, plain, odd=1)
    assert all(isinstance(entry, Line) for entry in other.entries())
    assert list(exported(one)) == list(exported(other))
    assert told(packed) == told(plain)


@pytest.mark.parametrize("odd", [0, 1])
def test_taking_up_packs_does_what_taking_up_their_lines_does(workload: Workload, odd: int) -> None:
    live = new_kernel()
    journal = run(workload, live, odd=odd)
    blobs = {workload.card.blob: workload.weights}
    by_packs, by_lines = new_kernel(), new_kernel()
    entries: list[Entry] = list(journal.entries())
    assert by_packs.recover(entries, journal.state(), blobs).lines == ()
    assert by_lines.recover(expanded(entries), journal.state(), blobs).lines == ()
    assert told(by_packs) == told(by_lines) == told(live)


@settings(max_examples=8, deadline=None)
@given(sizes=st.lists(st.integers(1, 200), min_size=1, max_size=5))
def test_batching_changes_nothing(workload: Workload, sizes: list[int]) -> None:
    assert list(exported(run(workload, new_kernel(), sizes))) == list(exported(run(workload, new_kernel(), (64,))))
