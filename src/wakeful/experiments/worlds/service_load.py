"""Experiment 2's world: a service robot's events by the step, with what only the world knows about each (Sec. IV-C).

The paper states the sizes (220 nominal steps; 13.2, 43.7, 84.8 and 54.0 events in the mean) and what an event may have:
several processing steps, criticality, a deadline, relevance to the task, delayed evidence. Its numbers are not published.
These were looked for with the paper's three baselines alone (`docs/experiments.md` has each choice and why).
"""

from __future__ import annotations

from random import Random

from wakeful.facts.values import Fact

#: Steps with arrivals and with a primary task, and the steps after them in which open processes may still complete.
NOMINAL_STEPS = 220
DRAIN_STEPS = 60


class Arrival(Fact, frozen=True):
    """One event as the world knows it. A policy never sees ``evidence_steps``.

    ``step``: when it arrives, known before that step's work. ``work``: units of cognition, one a step. ``deadline_steps``:
    a critical event's last unit must be done within so many steps after the arrival. ``evidence_steps``: its last unit needs
    evidence that comes so many steps after its first unit; None where it needs none. ``kind`` is all that a robot could know of
    its effort beforehand: events of one kind take one of two adjacent amounts of work, and all or none of them need evidence,
    as it is with the product's own treatments.
    """

    step: int
    kind: str
    critical: bool
    task_relevant: bool
    work: int
    priority: int
    deadline_steps: int | None = None
    evidence_steps: int | None = None


class Load(Fact, frozen=True):
    """One workload: how events arrive, and how many of them are critical or delayed.

    ``rate``: the chance of an event in each step. ``bursts``: one in each of so many equal segments of the run, of
    ``burst_events`` (least, most) events spread over ``burst_steps`` steps.
    """

    name: str
    rate: float
    critical: float
    delayed: float
    bursts: int = 0
    burst_events: tuple[int, int] = (2, 6)
    burst_steps: int = 10


class Parameters(Fact, frozen=True):
    """One declared set: its workloads, and what holds for all of them. Ranges are uniform over whole numbers, ends included."""

    name: str
    loads: tuple[Load, ...]
    suffix: str = ""
    """After a workload's name where results of several sets stand in one table."""
    work: tuple[int, int] = (3, 6)
    deadline_steps: tuple[int, int] = (5, 12)
    evidence_steps: tuple[int, int] = (8, 20)
    task_relevant: float = 0.39
    delayed_if_relevant: float = 0.05
    delayed_if_critical: float = 0.70
    """Factors on a load's ``delayed``: what the task itself is about is seldom delayed."""
    routine_priority: tuple[int, int] = (0, 1)
    critical_priority: tuple[int, int] = (2, 5)
    gain_routine: float = 0.80
    gain_critical: float = 0.10
    gain_blocked: float = 0.25
    """What the robot's own task gains in a nominal step in which cognition does so; 1 where it does nothing."""

    def named(self, load: Load) -> str:
        """The workload's name in tables."""
        return load.name + self.suffix


def _loads(critical: float, delayed: float, bursty: Load) -> tuple[Load, ...]:
    rates = {"low": 0.06, "medium": 0.1986, "high": 0.3855}
    return (*(Load(name=name, rate=rate, critical=critical, delayed=delayed) for name, rate in rates.items()), bursty)


_BURSTY_RATE = 30 / NOMINAL_STEPS

FIRST = Parameters(
    name="first",
    loads=_loads(0.28, 0.55, Load(name="bursty_delayed", rate=_BURSTY_RATE, critical=0.32, delayed=0.90, bursts=6)),
)
SECOND = Parameters(
    name="second",
    loads=_loads(
        0.26, 0.47, Load(name="bursty_delayed", rate=_BURSTY_RATE, critical=0.30, delayed=0.94, bursts=6, burst_steps=20)
    ),
    suffix="_2",
    work=(3, 7),
    deadline_steps=(6, 13),
    task_relevant=0.38,
    delayed_if_relevant=0.10,
    delayed_if_critical=0.65,
    critical_priority=(2, 3),
    gain_routine=0.78,
)


def arrivals(load: Load, parameters: Parameters, seed: int) -> tuple[Arrival, ...]:
    """The events of one run, in the order of their arrival. The same arguments give the same events.

    When events come, what they are like, and their kinds are drawn from streams of their own: both parameter sets meet the same
    instants.
    """
    when = Random(f"service_load/{load.name}/{seed}/when")
    what = Random(f"service_load/{load.name}/{seed}/what")
    kind = Random(f"service_load/{load.name}/{seed}/kind")
    return tuple(_event(step, load, parameters, what, kind) for step in _steps(load, when))


def _steps(load: Load, random: Random) -> list[int]:
    steps = [step for step in range(NOMINAL_STEPS) if random.random() < load.rate]
    for burst in range(load.bursts):
        events, place = random.randint(*load.burst_events), random.random()
        spread = [random.random() for _ in range(events)]
        first = burst * NOMINAL_STEPS // load.bursts
        last = (burst + 1) * NOMINAL_STEPS // load.bursts - load.burst_steps
        begins = first + int(place * (last - first + 1))
        steps += [begins + int(each * load.burst_steps) for each in spread]
    return sorted(steps)


def _event(step: int, load: Load, parameters: Parameters, random: Random, kinds: Random) -> Arrival:
    critical = random.random() < load.critical
    relevant = random.random() < parameters.task_relevant
    chance = load.delayed
    chance *= parameters.delayed_if_relevant if relevant else 1.0
    chance *= parameters.delayed_if_critical if critical else 1.0
    delayed = random.random() < chance
    work = random.randint(*parameters.work)
    evidence = random.randint(*parameters.evidence_steps)
    deadline = random.randint(*parameters.deadline_steps)
    routine, urgent = random.randint(*parameters.routine_priority), random.randint(*parameters.critical_priority)
    least, most = parameters.work
    about = min(most - 1, max(least, work - kinds.randrange(2)))
    return Arrival(
        step=step,
        kind=f"{'awaited' if delayed else 'ready'}_{about}_{about + 1}",
        critical=critical,
        task_relevant=relevant,
        work=work,
        priority=urgent if critical else routine,
        deadline_steps=deadline if critical else None,
        evidence_steps=evidence if delayed else None,
    )
