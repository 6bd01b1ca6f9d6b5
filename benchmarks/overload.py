"""Ten times the rate that the machine sustains, for a minute: what is admitted, shed and refused, who waits, and how it drains.

    ./run python -m benchmarks.overload [--times 10] [--seconds 60] [--live-seconds 60] [--json]

First in virtual time: one mind, a step of 20 ms, three steps an event, everything deliberated by a reasoner that takes 0.2 s and
answers four at once; what it sustains follows from that and is offered ``--times`` over. Then in real time: a live mind on this
machine whose treatment computes for about a millisecond a step; what it sustains is measured first, by offering it all it takes.
One event in twenty is critical. Nothing that was admitted may be lost: every one has an end when it has drained.
"""

from __future__ import annotations

import argparse
import asyncio
import hashlib
import json
import resource
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import msgspec

from wakeful import Event, MindView, Registry, Result, treatment
from wakeful.contracts.domain import Domain
from wakeful.domains import load
from wakeful.drivers.assembly import assemble
from wakeful.drivers.live import LiveDriver
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.asking import Question, Reply
from wakeful.facts.domain import DomainSpec, Guideline
from wakeful.facts.events import CRITICAL, Draft
from wakeful.facts.lines import Admitted
from wakeful.facts.overload import OverloadSettings
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import NS_PER_S, to_s
from wakeful.journal import open_journal
from wakeful.journal.audit import audit
from wakeful.journal.overload import backlog
from wakeful.journal.views import History, history

STEPS, STEP_S = 3, 0.02
LATENCY_S, REASONER_SLOTS = 0.2, 4
ONE_IN = 20
DEFAULT = OverloadSettings()
EPOCH_NS = 1_700_000_000 * NS_PER_S


class Attended(Result, frozen=True, kw_only=True, tag="attended"):
    """What the treatment concludes."""


class Answering:
    """A reasoner that always agrees; in real time it takes as long as in virtual time."""

    name = "answering"
    latency_s = LATENCY_S

    def __init__(self, waits: bool) -> None:
        self._waits = waits

    async def answer(self, question: Question) -> Reply:  # noqa: ARG002
        """Always the same, after its latency."""
        if self._waits:
            await asyncio.sleep(self.latency_s)
        return Reply(choice="attend", confidence=0.9, because=("asked",), reasoner=self.name)


class OneTreatment:
    """The plain domain with one treatment; each event is deliberated, since nothing has been learned."""

    def __init__(self, domain: Domain) -> None:
        self._domain = domain
        rule = Guideline(treat="attend", because="every event is attended to", when={"kind": "alarm"})
        self.spec: DomainSpec = msgspec.structs.replace(domain.spec, treatments=("attend",), guideline=(rule,))

    def detectors(self) -> object:
        """The domain's own."""
        return self._domain.detectors()

    def simulate(self, seed: int) -> None:
        """Nothing: the events are made here."""


def registry(rounds: int) -> Registry:
    """One treatment of three steps that computes so many rounds of a digest in each."""

    @treatment(name="attend", result=Attended, says="Attends to it in three steps.")
    async def attend(event: Event, mind: MindView) -> Attended:
        digest = b""
        for _ in range(STEPS):
            for _ in range(rounds):
                digest = hashlib.blake2b(digest).digest()
            await mind.work()
        return Attended(says=f"attended to {event.entity}", confidence=1.0)

    return Registry(own=(attend,), installed=())


def draft(index: int, at_ns: int) -> Draft:
    """One event; one in so many is critical."""
    critical = index % ONE_IN == 0
    return Draft(
        kind="alarm",
        entity=f"pump {index}",
        source="alarms",
        position=index,
        at_ns=at_ns,
        criticality=CRITICAL if critical else 0,
    )


def peak_mb() -> float:
    """This process's largest memory so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def quantile(values: list[float], share: float) -> float:
    """The value below which that share lies."""
    ranked = sorted(values)
    return ranked[min(len(ranked) - 1, int(share * len(ranked)))] if ranked else 0.0


def row(name: str, read: History, sustained: float, rate: float, over_ns: int, before_mb: float) -> dict[str, object]:
    """What a journal says of an overload that was over at ``over_ns``."""
    waited = backlog(read)
    roots = read.roots()
    first: dict[bool, list[float]] = {True: [], False: []}
    for past, process in roots:
        if process.first_treated_ns is not None:
            first[past.event.criticality >= CRITICAL].append(to_s(process.first_treated_ns - process.created_ns))
    modes = Counter(process.decision.mode for _, process in roots if process.decision)
    criticals = [process for past, process in roots if past.event.criticality >= CRITICAL]
    return {
        "run": name,
        "sustained_per_s": round(sustained, 1),
        "offered_per_s": round(rate, 1),
        "offered": len(read.events) + sum(read.refused.values()),
        "admitted": len(read.events),
        "refused": dict(read.refused),
        "lost": sum(1 for _, process in roots if process.end is None),
        "critical_admitted": len(criticals),
        "critical_deliberated": sum(1 for each in criticals if each.decision and each.decision.mode == "delib"),
        "deliberated": modes["delib"],
        "shed": waited.shed,
        "most_backlog": waited.most,
        "oldest_s": round(waited.worst_s, 3),
        "critical_first_p50_s": round(quantile(first[True], 0.5), 3),
        "critical_first_max_s": round(max(first[True], default=0.0), 3),
        "other_first_p50_s": round(quantile(first[False], 0.5), 3),
        "other_first_max_s": round(max(first[False], default=0.0), 3),
        "drained_s": round(max(0.0, to_s(max((process.since_ns for _, process in roots), default=0) - over_ns)), 1),
        "memory_mb": round(peak_mb() - before_mb, 1),
    }


def virtual(times: float, seconds: float, folder: Path, overload: OverloadSettings = DEFAULT) -> dict[str, object]:
    """The overload in virtual time, through the simulated driver and a journal on disk."""
    sustained = min(1.0 / (STEPS * STEP_S), REASONER_SLOTS / LATENCY_S)
    rate = times * sustained
    count = int(rate * seconds)
    domain: Domain = OneTreatment(load("jsonl"))  # type: ignore[assignment]
    settings = MindSettings(step_s=STEP_S, reasoner_slots=REASONER_SLOTS, overload=overload)
    kernel, learner = assemble(domain, settings, registry=registry(1))

    def offered(after: int) -> Iterator[Draft]:
        for index in range(after + 1, count):
            yield draft(index, EPOCH_NS + int(index / rate * NS_PER_S))

    before_mb = peak_mb()
    with open_journal(folder / "virtual.db") as journal:
        driver = SimulatedDriver(kernel, journal, Answering(waits=False), learner)
        for _ in driver.run("alarms", "digest", offered):
            pass
        driver.close()
        found = row("virtual", history(journal), sustained, rate, EPOCH_NS + int(seconds * NS_PER_S), before_mb)
        return {**found, "audit": audit(journal).ok}


async def real(times: float, seconds: float, folder: Path) -> dict[str, object]:
    """The overload in real time. What is not critical is offered with patience for a tenth of a second, as a robot would."""
    rounds = 1_000
    domain: Domain = OneTreatment(load("jsonl"))  # type: ignore[assignment]

    def mind(path: Path) -> LiveDriver:
        settings = MindSettings(step_s=0.0, reasoner_slots=REASONER_SLOTS)
        kernel, learner = assemble(domain, settings, registry=registry(rounds))
        return LiveDriver(kernel, open_journal(path), Answering(waits=True), learner, closes_journal=True)

    # What is sustained: treated provisionally, since the reasoner's own rate is a matter of its settings.
    calm = folder / "calm.db"
    began_s = time.monotonic()
    async with mind(calm) as calibrating:
        await asyncio.gather(*(calibrating.admit(draft(index * ONE_IN + 1, time.time_ns())) for index in range(2_000)))
        while calibrating.kernel.backlog > OverloadSettings().shed_backlog + 300:
            await asyncio.sleep(0.01)
        sustained = (2_000 - calibrating.kernel.backlog) / (time.monotonic() - began_s)
    rate = times * sustained
    before_mb = peak_mb()
    path = folder / "live.db"
    tasks: set[asyncio.Task[object]] = set()
    dropped = Counter[str]()
    async with mind(path) as overloaded:

        async def offer(index: int) -> None:
            receipt = await overloaded.admit(draft(index, time.time_ns()), patience_s=0.1 if index % ONE_IN else None)
            dropped[receipt.status] += 1

        began_s = time.monotonic()
        index = 0
        while (elapsed_s := time.monotonic() - began_s) < seconds:
            while index < elapsed_s * rate:
                task: asyncio.Task[object] = asyncio.create_task(offer(index))
                tasks.add(task)
                task.add_done_callback(tasks.discard)
                index += 1
            await asyncio.sleep(0.01)
        over_ns = overloaded.kernel.now_ns
        while tasks or len(overloaded.kernel._scheduler.processes):
            await asyncio.sleep(0.05)
    with open_journal(path, read_only=True) as journal:
        found = row("live", history(journal), sustained, rate, over_ns, before_mb)
        admitted = sum(1 for line in journal.lines() if isinstance(line.record, Admitted))
        report = audit(journal)
        return {**found, "audit": report.ok, "acknowledged": dropped["admitted"], "journaled": admitted}


def main() -> int:
    """Print a table of both runs; exit 1 where something that was admitted has no end, or an audit fails."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--times", type=float, default=10.0)
    arguments.add_argument("--seconds", type=float, default=60.0)
    arguments.add_argument("--live-seconds", type=float, default=60.0)
    arguments.add_argument("--json", action="store_true")
    given = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rows = [virtual(given.times, given.seconds, Path(folder))]
        if given.live_seconds:
            rows.append(asyncio.run(real(given.times, given.live_seconds, Path(folder))))
    if given.json:
        print(json.dumps(rows))
    else:
        for name in rows[-1]:
            print(f"{name:22}" + "".join(f"{each.get(name, '')!s:>22}" for each in rows if not isinstance(each.get(name), dict)))
            for found in rows:
                for reason, number in dict(found[name]).items() if isinstance(found.get(name), dict) else ():  # type: ignore[call-overload]
                    print(f"  {found['run']}: {number:,} {reason}")
    return 0 if all(each["audit"] and not each["lost"] for each in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
