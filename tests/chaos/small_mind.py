"""A small mind in a process of its own, to be killed: a service robot's morning and afternoon, calls outside, acts, a training.

    python small_mind.py JOURNAL CALLS [--count] [--compact]

Every call outside is a line that the callee appends to CALLS. ``--count``: print how often each crash point was reached.
``--compact``: at noon and in the evening all but the last few events are given up.
"""

from __future__ import annotations

import json
import os
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing, nullcontext
from itertools import islice
from pathlib import Path

import wakeful
from wakeful.contracts.bridge import Item
from wakeful.contracts.treatment import Mind
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.domains import load
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.crash_points import armed
from wakeful.facts.events import Event
from wakeful.facts.inputs import Act
from wakeful.facts.results import Result
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import to_ns
from wakeful.journal.acts import ActSpool
from wakeful.journal.compaction import ages, compactor
from wakeful.journal.retention import KEEP_ALL, Retention
from wakeful.journal.sqlite import open_journal
from wakeful.treatments.registry import Registry

DOMAIN = load("service_robot")

#: Observations of each half of the day: enough for a training, few enough for a second.
HALVES = {"morning": (0, 621), "afternoon": (621, 720)}

#: An operator holds a process between the two halves, and lets it go again.
ACTS = (
    Act(who="ana", act="hold", process=24, why="let me look", id="hold 24"),
    Act(who="ana", act="release", process=24, why="all is well", id="release 24"),
)


class Noted(Result, frozen=True, kw_only=True, tag="noted"):
    """What the calling treatments conclude."""

    heard: tuple[str, ...] = ()


def registry(calls: Path) -> Registry:
    """wakeful's treatments, description and planning replaced by ones that call outside, work long and wait."""

    def callee(event: Event, what: str) -> str:
        file = os.open(calls, os.O_CREAT | os.O_APPEND | os.O_WRONLY, 0o600)
        os.write(file, f"{event.id} {what}\n".encode())
        os.close(file)
        return f"{what} done"

    @wakeful.treatment(says="Looks it up outside, and notes it there.")
    async def description(event: Event, mind: Mind) -> Noted:
        await mind.work(2)
        seen = await mind.call(lambda: callee(event, "look"), key="look", within_s=20.0)
        await mind.work(2)
        noted = await mind.call(lambda: callee(event, "note"), key="note", within_s=20.0, safety="idempotent")
        return Noted(says=f"noted {event.entity}", confidence=0.9, forecast=mind.forecast(), heard=(seen, noted))

    @wakeful.treatment(says="Thinks long and waits for what may never come.")
    async def planning(event: Event, mind: Mind) -> Noted:
        await mind.work(12)
        came = await mind.evidence("reading", event.entity, within_s=15.0)
        await mind.work(6)
        return Noted(says=f"planned {event.entity}", confidence=0.7, forecast=mind.forecast(), heard=tuple(e.id for e in came))

    found = Registry(installed=())
    found.add(description, replace=True)
    found.add(planning, replace=True)
    return found


def half(name: str) -> Callable[[int], Iterator[Item]]:
    """The observations of a half of the day."""
    start, end = HALVES[name]
    stream = list(islice(DOMAIN.simulate(6) or (), start, end))
    return lambda after: iter(stream[after + 1 :])


def live(journal: Path, calls: Path, compact: bool = False) -> None:
    """Live through the day, or through what is left of it."""
    if compact:  # in pieces as small as the day
        ages._EVENTS, compactor._ROWS_PER_STEP, compactor._LINES_PER_STEP = 2, 3, 60
    retention = Retention(days=0.0, events=4, megabytes=0, least=2) if compact else KEEP_ALL
    spool = ActSpool(journal)
    for name in HALVES:
        with open_journal(journal, retention=retention) as opened:
            kernel, learner = assemble(DOMAIN, MindSettings(step_s=0.4, seed=5), registry=registry(calls))
            driver = SimulatedDriver(kernel, opened, GuidelineReasoner(DOMAIN.spec), learner, acts=spool)
            known = kernel.source(name)
            if known is None or not known.finished:
                with closing(driver.run(name, name, half(name))) as positions:
                    for _ in positions:
                        pass
            if name == "morning":
                for act in ACTS:
                    spool.put(act)
            else:
                driver.put([], kernel.now_ns + to_ns(300.0))
            driver.close()
            while compact and opened.tidy(1):
                pass


def main() -> None:
    """Live, and say what was reached."""
    reached: Counter[str] = Counter()

    def count(name: str) -> None:
        reached[name] += 1

    with armed(count) if "--count" in sys.argv else nullcontext():
        live(Path(sys.argv[1]), Path(sys.argv[2]), "--compact" in sys.argv)
    if "--count" in sys.argv:
        print(json.dumps(reached))


if __name__ == "__main__":
    main()
