"""W through wakeful: a domain of 25 lines, six treatments, and the driver."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import msgspec

from benchmarks.peers.drafting import draft, evidence, outcome
from benchmarks.peers.learned import DOMAIN
from benchmarks.peers.messages import TREATMENTS, Event, Tick, decode
from benchmarks.peers.messages import Evidence as Reading
from benchmarks.peers.running import Run, now_ns, size_of
from benchmarks.peers.treating import LIMIT_S, TOPIC, WAITS, conclude, final, look, weigh
from wakeful import Event as WakefulEvent
from wakeful import MindView, Registry, Result, treatment
from wakeful.contracts.bridge import Item
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.asking import Kind
from wakeful.facts.experience import ModelCard
from wakeful.facts.lines import Admitted, Answered, Concluded, Judged, Line, Published
from wakeful.facts.settings import MindSettings
from wakeful.journal import open_journal
from wakeful.journal.sqlite import SqliteJournal

SOURCE = "w"


class Treated(Result, frozen=True, kw_only=True, tag="treated"):
    """What the stub treatment concludes."""

    state: int
    reading: float | None = None


class Wakeful:
    """In virtual time: the workload's own clock drives limits, as fast as the machine goes."""

    def __init__(self, run: Run, variant: str) -> None:
        self._run = run
        self._path = run.store / "mind.db"
        full_sync = run.load.full_sync or variant.endswith("full")
        if not self._path.exists():
            prepare(self._path, run.workload, full_sync)
        self._before = size_of(run.store, "mind.db")
        kernel, learner = assemble(DOMAIN, MindSettings(step_s=0.0, trains=False), registry=registry(run))
        self._kernel = kernel
        self._journal = Stamping(self._path, full_sync=full_sync)
        self._driver = SimulatedDriver(kernel, self._journal, GuidelineReasoner(kernel.domain.spec), learner)

    def run(self) -> None:
        """Read the messages as one source, many at once; each commit acknowledges what was admitted by then."""
        self._handed: list[str] = []
        self._told = 0
        before = self._kernel.counts.admitted

        def committed() -> None:
            durable = self._kernel.counts.admitted - before
            self._run.acknowledge(self._handed[self._told : durable])
            self._told = durable

        self._journal.committed = committed
        for _ in self._driver.run(SOURCE, "w", self._items, at_once=self._run.load.window):
            pass

    def _items(self, after: int) -> Iterator[Item]:
        times, position = self._run.times, -1
        for text in self._run.messages:
            came_ns = now_ns()
            message = decode(text)
            if isinstance(message, Tick):
                continue
            position += 1
            if position <= after:
                continue
            if isinstance(message, Event):
                times.came[message.entity] = came_ns
                self._handed.append(message.entity)
                yield draft(message, SOURCE, position)
            elif isinstance(message, Reading):
                times.read.setdefault(message.entity, came_ns)
                yield evidence(message)
            else:
                yield outcome(message)

    def finals(self) -> list[str]:
        """From the journal."""
        self._driver.close()
        self._journal.close()
        return finals_of(self._path)

    def stored_bytes(self) -> int:
        """The journal's growth."""
        return size_of(self._run.store, "mind.db") - self._before


class Stamping(SqliteJournal):
    """The journal, which says that it has committed."""

    committed: Callable[[], None] | None = None

    def commit(self, lines: Sequence[Line], state: Mapping[str, bytes | None], blobs: Mapping[str, bytes]) -> None:
        """Append, in one transaction."""
        super().commit(lines, state, blobs)
        if self.committed is not None:
            self.committed()


def registry(run: Run) -> Registry:
    """The six stub treatments, in the places of wakeful's own."""
    found = Registry(installed=())
    for name in TREATMENTS:
        found.add(stub(name, run), replace=True)
    return found


def stub(name: str, run: Run) -> object:
    """Three steps, and a reading where one is needed."""
    times, load = run.times, run.load

    @treatment(name, says="The stub treatment of W.")
    async def treat(event: WakefulEvent, mind: MindView) -> Treated:
        entity, reading = event.entity, 0.0
        await mind.work()
        times.stepped[entity] = now_ns()
        seen = look(entity, event.fields["load"])
        if event.fields["category"] == WAITS:
            came = await mind.evidence(TOPIC, entity, LIMIT_S)
            times.resumed[entity] = now_ns()
            reading = msgspec.json.decode(came[0].value) if came else None
        await mind.work()
        state = weigh(seen, reading)
        if load.calls:
            await mind.call(lambda: run.call(entity), entity, 60.0)
        await mind.work()
        forecast = mind.forecast()
        state = conclude(state, forecast.label)
        times.treated += 1
        waited = reading if event.fields["category"] == WAITS else None
        return Treated(says="", confidence=forecast.probability, forecast=forecast, state=state, reading=waited)

    return treat


def prepare(path: Path, workload: Path, full_sync: bool) -> None:
    """A journal in which the model was published, as a robot's that has learned before."""
    card = msgspec.json.decode((workload / "card.json").read_bytes(), type=ModelCard)
    with open_journal(path, full_sync=full_sync) as journal:
        line = Line(1, 1, Published(training=card.version, card=card))
        journal.commit((line,), {}, {card.blob: (workload / "weights.bin").read_bytes()})


def finals_of(path: Path) -> list[str]:
    """Each judged event's final state."""
    entities: dict[str, str] = {}
    results: dict[str, tuple[str, Treated, str]] = {}
    finals = []
    with open_journal(path, read_only=True) as journal:
        for line in journal.lines():
            record = line.record
            if isinstance(record, Admitted):
                entities[record.event.id] = record.event.entity
            elif isinstance(record, Concluded):
                result = msgspec.json.decode(record.result, type=Treated)
                results[record.event] = record.treatment, result, record.forecast.label if record.forecast else ""
            elif isinstance(record, Judged):
                name, result, label = results[record.event]
                finals.append(
                    final(entities[record.event], name, label, result.reading, result.state, record.label, record.verdict.value)
                )
    return finals


def answered(store: Path, _variant: str) -> set[str]:
    """Whose outside call's answer is committed."""
    path = store / "mind.db"
    if not path.exists():
        return set()
    with open_journal(path, read_only=True) as journal:
        records = [line.record for line in journal.lines()]
    return {each.key for each in records if isinstance(each, Answered) and each.kind is Kind.CALL and not each.error}
