"""Experiment 2: continuous processing under load (Sec. IV-C, Tables 3 and 4), on the kernel that ships.

Virtual time: one slot, one unit of work a step, a step a second. The kernel, its scheduler, process table, policies and
journal are the product's; this file feeds it the world's events and evidence, and counts in the journal's lines.

    wakeful reproduce exp2

Each event's treatment works all its units but one, waits for its evidence where it needs any, and works the last unit. The
domain has no forecasts and no guidelines: one treatment, chosen for everything, so that only processing is compared.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from wakeful.contracts.detector import DetectorFactory
from wakeful.contracts.policy import Policy
from wakeful.contracts.treatment import Mind
from wakeful.experiments.rows import Row, row
from wakeful.experiments.worlds.service_load import (
    DRAIN_STEPS,
    FIRST,
    LOADS,
    NOMINAL_STEPS,
    SECOND,
    Arrival,
    Load,
    Parameters,
    arrivals,
)
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import CRITICAL, Context, Draft, Event, Observation
from wakeful.facts.evidence import Evidence
from wakeful.facts.inputs import Begin, Input
from wakeful.facts.lines import Admitted, Created, Line, Moved
from wakeful.facts.processes import State, Trigger
from wakeful.facts.results import Result
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import NS_PER_S
from wakeful.facts.values import Fact, Field
from wakeful.journal import MemoryJournal
from wakeful.kernel import Kernel
from wakeful.learning.two_heads import TwoHeads
from wakeful.scheduling.policies.reactive_priority import ReactivePriority
from wakeful.scheduling.policies.sequential import Sequential
from wakeful.scheduling.policies.suspend_resume import SuspendResume
from wakeful.scheduling.policies.task_bounded import TaskBounded
from wakeful.treatments.decorator import treatment
from wakeful.treatments.registry import Registry

STEPS = NOMINAL_STEPS + DRAIN_STEPS
SOURCE = "service_load"

#: Step t lasts from second t + 1 to t + 2. What comes in step t is fed half a step before, so that all of it is known
#: when the step begins.
_ORIGIN_NS = NS_PER_S
_BEFORE_NS = NS_PER_S // 2

#: What the robot's own task gains in a nominal step, by what cognition does in it.
GAIN_IDLE, GAIN_ROUTINE, GAIN_CRITICAL, GAIN_BLOCKED = 1.0, 0.80, 0.10, 0.25


class Method(Fact, frozen=True):
    """A policy under test. ``blocks``: the slot is kept while its process waits, and the robot's task suffers for it."""

    name: str
    policy: Callable[[], Policy]
    blocks: bool = False


METHODS: dict[str, Method] = {
    each.name: each
    for each in (
        Method(name="task_bounded", policy=TaskBounded, blocks=True),
        Method(name="sequential", policy=Sequential, blocks=True),
        Method(name="reactive_priority", policy=ReactivePriority),
        Method(name="suspend_resume", policy=SuspendResume),
    )
}


class Measured(Fact, frozen=True):
    """One run's figures, in percent and steps; None where there was nothing to count (a run without critical events)."""

    events: int
    completion: float | None
    critical_miss: float | None
    critical_deadline: float | None
    latency_steps: float | None
    primary_task: float


# --- the domain: one treatment, no guidelines, no forecasts ---


class Paced(Result, frozen=True, kw_only=True, tag="paced"):
    """The result of a treatment whose only content is its effort."""


@treatment(says="Spends the effort that the event needs, and waits for its evidence before the last unit.")
async def paced(event: Event, mind: Mind) -> Paced:
    """Work all units but one, wait for evidence where the event needs it, work the last unit."""
    fields = event.context.fields
    units = fields["work"]
    await mind.work(int(units if isinstance(units, int) else 1) - 1)
    if fields["awaits"]:
        await mind.evidence("service_load", event.entity, within_s=float(STEPS + 2))
    await mind.work(1)
    return Paced(says="done", confidence=1.0, rests_on=(event.id,))


class ServiceLoadDomain:
    """The experiment's domain: drafts are fed as they are, so it has no detectors and no simulator."""

    spec = DomainSpec(
        name="service_load",
        version=1,
        says="Experiment 2: events that only cost effort.",
        treatments=(paced.name,),
    )

    def detectors(self) -> Mapping[str, DetectorFactory]:
        """None: events come registered."""
        return {}

    def simulate(self, seed: int) -> Iterator[Observation] | None:  # noqa: ARG002
        """None: the world's events come from ``worlds.service_load``."""
        return None


# --- one run ---


def run(world: tuple[Arrival, ...], policy: Policy, *, steps_known: bool = True) -> MemoryJournal:
    """One run of the kernel over the world's events; returns its journal.

    Args:
        world: the events, in the order of their arrival.
        policy: fresh.
        steps_known: whether an event says how many units it will need, and whether it will wait; a live robot's do not.
    """
    settings = MindSettings(slots=1, step_s=1.0, slotted=True, keep_evidence_s=float(2 * STEPS))
    kernel = Kernel(ServiceLoadDomain(), Registry(own=(paced,), installed=()), TwoHeads(), policy, settings)
    journal = MemoryJournal()
    coming: dict[int, list[Input]] = {0: [Begin(source=SOURCE, digest=SOURCE)]}
    for position, arrival in enumerate(world):
        coming.setdefault(arrival.step, []).append(_draft(arrival, position, steps_known))
    begun: set[int] = set()
    for step in range(STEPS + 1):
        lines: list[Line] = []
        now_ns = _ORIGIN_NS + step * NS_PER_S
        # First what came while the last step lasted; then the step's beginning, so that its first units are seen.
        for at_ns, inputs in ((now_ns - _BEFORE_NS, coming.get(step, [])), (now_ns, [])):
            requests = kernel.feed(inputs, at_ns)
            journal.commit(requests.lines, kernel.changed(), requests.blobs)
            lines.extend(requests.lines)
        for number in _first_steps(lines, begun):
            evidence_steps = world[number - 1].evidence_steps
            if evidence_steps is not None:
                due = step + evidence_steps
                coming.setdefault(due, []).append(_evidence(number, due))
    return journal


def _draft(arrival: Arrival, position: int, steps_known: bool) -> Draft:
    awaits = arrival.evidence_steps is not None
    fields: dict[str, Field] = {"work": arrival.work, "awaits": awaits, "priority": arrival.priority}
    if steps_known:
        fields |= {"steps_needed": arrival.work, "needs_evidence": awaits}
    # The deadline's step is the last in which the event may be worked on: it ends one step later.
    deadline_s = None if arrival.deadline_steps is None else arrival.deadline_steps + 1 + _BEFORE_NS / NS_PER_S
    return Draft(
        kind=arrival.kind,
        entity=f"E{position + 1}",
        source=SOURCE,
        position=position,
        at_ns=_ORIGIN_NS + arrival.step * NS_PER_S - _BEFORE_NS,
        context=Context(task="service" if arrival.task_relevant else "", fields=fields),
        criticality=CRITICAL if arrival.critical else 0,
        deadline_s=deadline_s,
    )


def _evidence(number: int, step: int) -> Evidence:
    name = f"E{number}"
    return Evidence(id=name, topic="service_load", key=name, at_ns=_ORIGIN_NS + step * NS_PER_S - _BEFORE_NS)


def _first_steps(lines: list[Line], begun: set[int]) -> list[int]:
    """The processes that get their first step in these lines. Process n is the world's event n: they come in one order."""
    first: list[int] = []
    for line in lines:
        record = line.record
        if isinstance(record, Moved) and record.trigger is Trigger.DISPATCH and record.process not in begun:
            begun.add(record.process)
            first.append(record.process)
    return first


# --- what the journal says of it ---


class Life(Fact, frozen=True):
    """One process as the journal shows it; steps are the run's."""

    criticality: int
    arrived: int
    deadline_ns: int | None
    first: int | None = None
    ended_ns: int | None = None
    """When it was resolved; None where it never was."""


def lives(journal: MemoryJournal) -> dict[int, Life]:
    """Every process's life, by process."""
    found: dict[int, dict[str, int | None]] = {}
    for line in journal.lines():
        record = line.record
        if isinstance(record, Created):
            found[record.process] = {
                "criticality": record.criticality,
                "arrived": (line.at_ns + _BEFORE_NS - _ORIGIN_NS) // NS_PER_S,
                "deadline_ns": record.deadline_ns,
            }
        elif isinstance(record, Moved):
            life = found[record.process]
            if record.trigger is Trigger.DISPATCH:
                life.setdefault("first", (line.at_ns - _ORIGIN_NS) // NS_PER_S)
            elif record.trigger is Trigger.RESOLVE:
                life["ended_ns"] = line.at_ns
    return {process: Life(**life) for process, life in found.items()}  # type: ignore[arg-type]


def holders(journal: MemoryJournal) -> list[int | None]:
    """Who held the slot in each step of the run; None where nobody did."""
    held: list[int | None] = [None] * STEPS
    for process, begun_ns, ended_ns in _stretches(journal, State.ACTIVE):
        for step in range((begun_ns - _ORIGIN_NS) // NS_PER_S, min(STEPS, (ended_ns - _ORIGIN_NS) // NS_PER_S)):
            held[step] = process
    return held


def waiting(journal: MemoryJournal) -> list[bool]:
    """Whether any process waited for evidence throughout each step of the run."""
    waited = [False] * STEPS
    for _, begun_ns, ended_ns in _stretches(journal, State.WAITING):
        first = -((_ORIGIN_NS - begun_ns) // NS_PER_S)
        for step in range(first, min(STEPS, (ended_ns + _BEFORE_NS - _ORIGIN_NS) // NS_PER_S)):
            waited[step] = True
    return waited


def _stretches(journal: MemoryJournal, state: State) -> Iterator[tuple[int, int, int]]:
    """(process, from, to) of every stay in a state; to the run's end where it was not left."""
    since: dict[int, int] = {}
    for line in journal.lines():
        record = line.record
        if isinstance(record, Moved):
            if record.before is state:
                yield record.process, since.pop(record.process), line.at_ns
            if record.after is state:
                since[record.process] = line.at_ns
    for process, begun_ns in since.items():
        yield process, begun_ns, _ORIGIN_NS + STEPS * NS_PER_S


def measure(journal: MemoryJournal, *, blocks: bool) -> Measured:
    """The paper's metrics, from the journal's records alone (Sec. IV-B, Eq. 12)."""
    admitted = sum(isinstance(line.record, Admitted) for line in journal.lines())
    processes = lives(journal)
    done = [life for life in processes.values() if life.ended_ns is not None]
    critical = [life for life in processes.values() if life.criticality == CRITICAL]
    missed = [life for life in critical if life.ended_ns is None]
    in_time = [life for life in critical if life.ended_ns is not None and life.ended_ns <= (life.deadline_ns or 0)]
    gained = 0.0
    for holder, waited in list(zip(holders(journal), waiting(journal), strict=True))[:NOMINAL_STEPS]:
        if holder is not None:
            gained += GAIN_CRITICAL if processes[holder].criticality == CRITICAL else GAIN_ROUTINE
        else:
            gained += GAIN_BLOCKED if blocks and waited else GAIN_IDLE
    return Measured(
        events=admitted,
        completion=_percent(len(done), admitted),
        critical_miss=_percent(len(missed), len(critical)),
        critical_deadline=_percent(len(in_time), len(critical)),
        latency_steps=sum((life.first or 0) - life.arrived for life in done) / len(done) if done else None,
        primary_task=100.0 * gained / NOMINAL_STEPS,
    )


def _percent(part: int, whole: int) -> float | None:
    return 100.0 * part / whole if whole else None


def one(method: Method, load: Load, parameters: Parameters, seed: int, *, steps_known: bool = True) -> Measured:
    """One method on one world."""
    return measure(run(arrivals(load, parameters, seed), method.policy(), steps_known=steps_known), blocks=method.blocks)


# --- all runs ---

#: The project's ten seeds. They were not picked: the means of their event counts lie within 3 % of the paper's as they are.
SEEDS = tuple(range(10))

RUNS_PER_SEED = 2 * len(LOADS) * len(METHODS)

METRICS: dict[str, str] = {
    "completion": "3",
    "critical_miss": "4",
    "critical_deadline": "4",
    "latency_steps": "4",
    "primary_task": "4",
}
"""Metric → the paper's table that it stands in."""


def rows(
    seeds: Sequence[int],
    methods: Sequence[Method] = tuple(METHODS.values()),
    parameter_sets: Sequence[Parameters] = (FIRST, SECOND),
    progress: Callable[[int, int], None] | None = None,
) -> list[Row]:
    """Every method on every workload of both parameter sets.

    Args:
        seeds: of the worlds; each method meets the same ones.
        methods: what is compared.
        parameter_sets: a set's suffix stands in its workloads' names.
        progress: told after each run how many runs are done, and how many events they had.
    """
    found: list[Row] = []
    runs = events = 0
    for parameters in parameter_sets:
        for load in LOADS.values():
            for method in methods:
                measured: list[Measured] = []
                for seed in seeds:
                    measured.append(one(method, load, parameters, seed))
                    runs, events = runs + 1, events + measured[-1].events
                    if progress is not None:
                        progress(runs, events)
                for metric, table in METRICS.items():
                    values = [getattr(each, metric) for each in measured]
                    made = row(table, method.name, parameters.named(load), metric, values, beside=load.name)
                    if made is not None:
                        found.append(made)
    return found
