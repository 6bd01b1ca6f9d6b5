"""Workload W, made from one seed: events, later evidence and outcomes of the service robot, as JSON messages in order of time.

A fifth of the events wait for a reading. Of these 3 % are read before they come, 2 % twice, 5 % never: the limit passes, in
workload time. There are as many readings as a fifth of the events; the remainder are of things that nobody asked about. Every
event has an outcome, which bears out what the model forecast or, for a tenth of those that forecast an intervention, shows none
because somebody had acted. So nothing that was learned is refuted: what W measures is not learning anew.
"""

from __future__ import annotations

from pathlib import Path
from random import Random

import msgspec

from benchmarks.peers.kept import Facts
from benchmarks.peers.lean import Lean
from benchmarks.peers.learned import clear, train
from benchmarks.peers.messages import (
    CONTEXTS,
    LOCATIONS,
    ROUTES,
    STATES,
    AnyMessage,
    Event,
    Evidence,
    Outcome,
    Tick,
    encode,
)
from benchmarks.peers.running import SPACING_NS
from benchmarks.peers.treating import LIMIT_NS, WAITS, checksum, conclude, final, look, verdict, weigh
from wakeful.facts.experience import ModelCard

START_NS = 1_767_596_400_000_000_000
READING_NS = (100_000_000, 1_000_000_000)
EARLY_NS = (50_000_000, 500_000_000)
OUTCOME_NS = (3_000_000_000, 5_000_000_000)
TICK_NS = 1_000_000_000

EARLY, TWICE, NEVER = 0.03, 0.02, 0.05
ACTED_ON = 0.1


class Workload(msgspec.Struct, frozen=True):
    """W in memory: each message as the bytes that arrive."""

    facts: Facts
    messages: list[bytes]
    lean: Lean
    card: ModelCard
    weights: bytes


def make(seed: int, events: int) -> Workload:
    """W of so many events."""
    random = Random(f"workload W {seed}")
    met = [_event(random, number) for number in range(events)]
    # The model learns from other events than W's own, of the same kind.
    card, weights, lean = train([_event(random, number) for number in range(1000)], seed)
    if not clear(lean, met):
        raise ValueError(f"seed {seed}: an event's choice hangs on the last digits; take another seed")
    chosen = lean.choose(met)
    timed: list[tuple[int, AnyMessage]] = [(event.at_ns, event) for event in met]
    readings, waiting = _readings(random, met)
    timed += [(reading.at_ns, reading) for reading in readings]
    outcomes = [_outcome(random, event, label) for event, (_, label) in zip(met, chosen, strict=True)]
    timed += [(outcome.at_ns, outcome) for outcome in outcomes]
    last_ns = max(at_ns for at_ns, _ in timed) + LIMIT_NS + TICK_NS
    timed += [(at_ns, Tick(at_ns=at_ns)) for at_ns in range(START_NS, last_ns + TICK_NS, TICK_NS)]
    timed.sort(key=lambda pair: pair[0])
    facts = Facts(
        seed=seed,
        events=events,
        evidence=len(readings),
        outcomes=len(outcomes),
        messages=len(timed),
        waiting=waiting,
        checksum=checksum(_finals(met, chosen, readings, outcomes)),
    )
    return Workload(facts, [encode(message) for _, message in timed], lean, card, weights)


def save(workload: Workload, folder: Path) -> None:
    """Write it down for the children."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "messages.jsonl").write_bytes(b"\n".join(workload.messages))
    (folder / "facts.json").write_bytes(encode(workload.facts))
    (folder / "card.json").write_bytes(encode(workload.card))
    (folder / "weights.bin").write_bytes(workload.weights)
    workload.lean.save(folder / "lean.npz")


def _event(random: Random, number: int) -> Event:
    category = WAITS if number % 5 == 0 else random.choice(("item", "obstacle", "unknown"))
    return Event(
        at_ns=START_NS + LIMIT_NS + number * SPACING_NS,
        entity=f"{category}-{number:05d}",
        category=category,  # type: ignore[arg-type]
        location=random.choice(LOCATIONS),  # type: ignore[arg-type]
        state=random.choice(STATES),  # type: ignore[arg-type]
        route=random.choice(ROUTES),  # type: ignore[arg-type]
        load=round(random.random(), 3),
        x=round(random.uniform(-2.5, 2.5), 2),
        y=round(random.uniform(-2.5, 2.5), 2),
        context=random.choice(CONTEXTS),  # type: ignore[arg-type]
    )


def _readings(random: Random, met: list[Event]) -> tuple[list[Evidence], int]:
    """The readings, and how many events wait for one."""
    waiting = [event for event in met if event.category == WAITS]
    shuffled = random.sample(waiting, len(waiting))
    never, early, twice = (round(len(waiting) * share) for share in (NEVER, EARLY, TWICE))
    readings: list[Evidence] = []
    for place, event in enumerate(shuffled[never:]):
        reading = _reading(random, event)
        if place < early:
            reading = msgspec.structs.replace(reading, at_ns=event.at_ns - random.randint(*EARLY_NS))
        readings.append(reading)
        if early <= place < early + twice:
            readings.append(msgspec.structs.replace(reading, at_ns=reading.at_ns + random.randint(*EARLY_NS)))
    others = [event for event in met if event.category != WAITS]
    while len(readings) < len(met) // 5:
        readings.append(_reading(random, random.choice(others)))
    return readings, len(waiting)


def _reading(random: Random, event: Event) -> Evidence:
    after_ns = random.randint(*READING_NS)
    number = random.getrandbits(40)
    return Evidence(at_ns=event.at_ns + after_ns, id=f"r{number:010x}", entity=event.entity, value=round(random.gauss(40, 9), 2))


def _outcome(random: Random, event: Event, forecast: str) -> Outcome:
    prevented = forecast == "intervention" and random.random() < ACTED_ON
    return Outcome(
        at_ns=event.at_ns + random.randint(*OUTCOME_NS),
        id=f"o-{event.entity}",
        entity=event.entity,
        label="none" if prevented else forecast,  # type: ignore[arg-type]
        acted_on=prevented,
    )


def _finals(met: list[Event], chosen: list[tuple[str, str]], readings: list[Evidence], outcomes: list[Outcome]) -> list[str]:
    """What every system must come to, worked out without any of them."""
    read = {reading.entity: reading.value for reading in readings}
    finals = []
    for event, (treatment, label), outcome in zip(met, chosen, outcomes, strict=True):
        reading = read.get(event.entity) if event.category == WAITS else None
        seen = look(event.entity, event.load)
        seen = weigh(seen, reading if event.category == WAITS else 0.0)
        concluded = conclude(seen, label)
        judged = verdict(label, outcome.label, outcome.acted_on)
        finals.append(final(event.entity, treatment, label, reading, concluded, outcome.label, judged))
    return finals
