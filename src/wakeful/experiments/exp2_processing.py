"""Experiment 2: continuous processing under load (Sec. IV-C, Tables 3 and 4), on the kernel that ships.

Virtual time: one slot, one unit of work a step, a step a second. The kernel, its scheduler, process table, policies and
journal are the product's; this file feeds it the world's events and evidence, and counts in the journal's lines.

    wakeful reproduce exp2

Each event's treatment works all its units but one, waits for its evidence where it needs any, and works the last unit. The
domain has no forecasts and no guidelines: one treatment, chosen for everything, so that only processing is compared.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from statistics import fmean, stdev
from typing import Literal

from wakeful.contracts.detector import DetectorFactory
from wakeful.contracts.policy import Policy
from wakeful.contracts.treatment import Mind
from wakeful.experiments.bounds import clairvoyant
from wakeful.experiments.rows import Progress, Reproduced, Row, row
from wakeful.experiments.worlds.service_load import (
    DRAIN_STEPS,
    FIRST,
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
from wakeful.facts.overload import UNLIMITED
from wakeful.facts.packs import expanded
from wakeful.facts.processes import State, Trigger
from wakeful.facts.results import Result
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import NS_PER_S
from wakeful.facts.values import Fact, Field
from wakeful.journal import MemoryJournal
from wakeful.kernel import Kernel
from wakeful.learning.two_heads import TwoHeads
from wakeful.scheduling.policies.deadline_aware import DeadlineAware
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


Told = Literal["effort", "kind", "nothing"]
"""What a policy is told of an event's effort beforehand: how many steps and whether it waits; its kind alone; nothing."""


class Method(Fact, frozen=True):
    """A policy under test. ``blocks``: the slot is kept while its process waits, and the robot's task suffers for it."""

    name: str
    policy: Callable[[], Policy]
    blocks: bool = False
    told: Told = "effort"


METHODS = (
    Method(name="task_bounded", policy=TaskBounded, blocks=True),
    Method(name="sequential", policy=Sequential, blocks=True),
    Method(name="reactive_priority", policy=ReactivePriority),
    Method(name="suspend_resume", policy=SuspendResume),
    Method(name="deadline_aware", policy=DeadlineAware),
)

CLAIRVOYANT = "clairvoyant"
"""The name under which the limit stands beside the methods."""


class Measured(Fact, frozen=True):
    """One run's figures, in percent and steps; None where there was nothing to count (a run without critical events)."""

    events: int
    completion: float | None
    critical_miss: float | None
    critical_deadline: float | None
    latency_steps: float | None = None
    primary_task: float | None = None


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


def new_kernel(policy: Policy) -> Kernel:
    """The product's kernel for this experiment: one slot, a step a second, steps begin on whole seconds."""
    settings = MindSettings(slots=1, step_s=1.0, slotted=True, keep_evidence_s=float(2 * STEPS), overload=UNLIMITED)
    return Kernel(ServiceLoadDomain(), Registry(own=(paced,), installed=()), TwoHeads(), policy, settings)


def run(world: tuple[Arrival, ...], policy: Policy, *, told: Told = "effort") -> MemoryJournal:
    """One run of the kernel over the world's events; returns its journal.

    Args:
        world: the events, in the order of their arrival.
        policy: fresh.
        told: what the events say of their effort; a live robot's say nothing but their kind.
    """
    kernel = new_kernel(policy)
    journal = MemoryJournal()
    coming: dict[int, list[Input]] = {0: [Begin(source=SOURCE, digest=SOURCE)]}
    for position, arrival in enumerate(world):
        coming.setdefault(arrival.step, []).append(_draft(arrival, position, told))
    begun: set[int] = set()
    for step in range(STEPS + 1):
        lines: list[Line] = []
        now_ns = _ORIGIN_NS + step * NS_PER_S
        # First what came while the last step lasted; then the step's beginning, so that its first units are seen.
        for at_ns, inputs in ((now_ns - _BEFORE_NS, coming.get(step, [])), (now_ns, [])):
            requests = kernel.feed(inputs, at_ns)
            journal.commit(requests.lines, kernel.changed(), requests.blobs)
            lines.extend(expanded(requests.lines))
        for number in _first_steps(lines, begun):
            evidence_steps = world[number - 1].evidence_steps
            if evidence_steps is not None:
                due = step + evidence_steps
                coming.setdefault(due, []).append(_evidence(number, due))
    return journal


def _draft(arrival: Arrival, position: int, told: Told) -> Draft:
    awaits = arrival.evidence_steps is not None
    fields: dict[str, Field] = {"work": arrival.work, "awaits": awaits, "priority": arrival.priority}
    if told == "effort":
        fields |= {"steps_needed": arrival.work, "needs_evidence": awaits}
    # The deadline's step is the last in which the event may be worked on: it ends one step later.
    deadline_s = None if arrival.deadline_steps is None else arrival.deadline_steps + 1 + _BEFORE_NS / NS_PER_S
    return Draft(
        kind="event" if told == "nothing" else arrival.kind,
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


def measure(journal: MemoryJournal, parameters: Parameters, *, blocks: bool) -> Measured:
    """The paper's metrics, from the journal's records alone (Sec. IV-B, Eq. 12).

    Args:
        journal: of one run.
        parameters: say what the primary task gains in a step.
        blocks: whether the slot counts as kept while a process waits and nobody works.
    """
    admitted = sum(isinstance(line.record, Admitted) for line in journal.lines())
    processes = lives(journal)
    done = [life for life in processes.values() if life.ended_ns is not None]
    critical = [life for life in processes.values() if life.criticality == CRITICAL]
    missed = [life for life in critical if life.ended_ns is None]
    in_time = [life for life in critical if life.ended_ns is not None and life.ended_ns <= (life.deadline_ns or 0)]
    gained = 0.0
    for holder, waited in list(zip(holders(journal), waiting(journal), strict=True))[:NOMINAL_STEPS]:
        if holder is not None:
            urgent = processes[holder].criticality == CRITICAL
            gained += parameters.gain_critical if urgent else parameters.gain_routine
        else:
            gained += parameters.gain_blocked if blocks and waited else 1.0
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


def one(method: Method, load: Load, parameters: Parameters, seed: int) -> Measured:
    """One method on one world."""
    journal = run(arrivals(load, parameters, seed), method.policy(), told=method.told)
    return measure(journal, parameters, blocks=method.blocks)


def limit(load: Load, parameters: Parameters, seed: int) -> Measured:
    """What nobody could beat on that world; it says nothing of latency and of the primary task."""
    bound = clairvoyant(arrivals(load, parameters, seed))
    return Measured(
        events=bound.events,
        completion=_percent(bound.completions, bound.events),
        critical_miss=_percent(bound.critical - bound.criticals, bound.critical),
        critical_deadline=_percent(bound.deadlines, bound.critical),
    )


# --- all runs ---

#: The project's ten seeds: of the first 200, those whose worlds together are the most typical in what they contain (events,
#: critical, delayed and task-relevant ones, work, deadlines that can be met at all). No policy had run on any of them then.
SEEDS = (54, 59, 81, 108, 135, 137, 177, 179, 191, 196)

PARAMETER_SETS = (FIRST, SECOND)

METRICS: dict[str, str] = {
    "completion": "3",
    "critical_miss": "4",
    "critical_deadline": "4",
    "latency_steps": "4",
    "primary_task": "4",
}
"""Metric → the paper's table that it stands in."""

Results = dict[tuple[str, str], list[Measured]]
"""(method, workload) → one run per seed, in the order of the seeds."""


def measure_all(
    seeds: Sequence[int],
    progress: Progress,
    methods: Sequence[Method] = METHODS,
    parameter_sets: Sequence[Parameters] = PARAMETER_SETS,
) -> Results:
    """Every method, and the limit, on every workload of the parameter sets.

    Args:
        seeds: of the worlds; each method meets the same ones.
        progress: told after each run how many runs are done, and how many events they had.
        methods: what is compared.
        parameter_sets: a set's suffix stands in its workloads' names.
    """
    results: Results = {}
    runs = events = 0
    for parameters in parameter_sets:
        for load in parameters.loads:
            workload = parameters.named(load)
            for method in methods:
                runs_of_method = results.setdefault((method.name, workload), [])
                for seed in seeds:
                    runs_of_method.append(one(method, load, parameters, seed))
                    runs, events = runs + 1, events + runs_of_method[-1].events
                    progress(runs, events)
            results[CLAIRVOYANT, workload] = [limit(load, parameters, seed) for seed in seeds]
    return results


def rows(results: Results) -> list[Row]:
    """Means and sample standard deviations over the seeds, the paper's cell of the workload beside them."""
    published = {parameters.named(load): load.name for parameters in PARAMETER_SETS for load in parameters.loads}
    found = (
        row(table, method, workload, metric, [getattr(each, metric) for each in measured], beside=published[workload])
        for (method, workload), measured in results.items()
        for metric, table in METRICS.items()
    )
    return [each for each in found if each is not None]


def reproduce(seeds: Sequence[int], progress: Progress) -> Reproduced:
    """Tables 3 and 4 with ours and the limit beside them, under both parameter sets."""
    results = measure_all(seeds, progress)
    return Reproduced(
        rows(results), against_limit(results, "deadline_aware") + gains(results, "deadline_aware", "suspend_resume")
    )


# --- what the runs say of ours ---


def against_limit(results: Results, method: str) -> list[str]:
    """How much of what nobody could beat a method reaches: ratios of means over the seeds."""
    said: list[str] = []
    for workload in dict.fromkeys(workload for name, workload in results if name == method):
        parts: list[str] = []
        for metric in ("critical_deadline", "completion"):
            ours, best = _mean(results[method, workload], metric), _mean(results[CLAIRVOYANT, workload], metric)
            parts.append(f"{metric} {100.0 * ours / best:.1f} %" if best else f"{metric} –")
        missed = _mean(results[method, workload], "critical_miss")
        said.append(f"{method} on {workload}, of the clairvoyant's: {', '.join(parts)}; critical misses {missed:.2f} %.")
    return said


def gains(results: Results, method: str, other: str) -> list[str]:
    """By how much a method is above another on the same worlds: mean of the differences and its standard error."""
    said: list[str] = []
    for workload in dict.fromkeys(workload for name, workload in results if name == method):
        parts: list[str] = []
        for metric in ("completion", "critical_deadline", "primary_task"):
            pairs = zip(results[method, workload], results[other, workload], strict=True)
            found = [(getattr(one, metric), getattr(two, metric)) for one, two in pairs]
            steps = [ours - theirs for ours, theirs in found if ours is not None and theirs is not None]
            error = f"{stdev(steps) / len(steps) ** 0.5:.2f}" if len(steps) > 1 else "–"
            parts.append(f"{metric} {fmean(steps):+.2f} ± {error}" if steps else f"{metric} –")
        said.append(f"{method} above {other} on {workload} (± standard error): {', '.join(parts)}.")
    return said


def _mean(measured: Sequence[Measured], metric: str) -> float:
    return fmean([value for each in measured if (value := getattr(each, metric)) is not None] or [0.0])
