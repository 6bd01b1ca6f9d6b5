"""Draws docs/timeline_eq6.svg: the paper's sequence P1(1) → P2 → P3 → P1(2) (Eq. 6) by wakeful's own kernel and treatments.

A device works badly, and its diagnosis waits for a reading; meanwhile a blocked route is planned around and an unstable object's
risk is predicted; then the reading comes, and the diagnosis goes on where it was.

Run it with ``python docs/draw_timeline_eq6.py``.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import msgspec

from wakeful.cli.draw_lanes import draw
from wakeful.contracts.bridge import Item
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.events import Context, Draft
from wakeful.facts.evidence import Evidence
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import to_ns
from wakeful.facts.values import Field
from wakeful.journal import MemoryJournal
from wakeful.journal.lanes import lanes

OUT = Path(__file__).with_name("timeline_eq6.svg")
STEP_S = 0.5
READING_S = 6.0


def items() -> Iterator[Item]:
    """What the robot meets, and the reading that comes later."""
    yield _met("pump-3", 0.0, {"category": "device", "state": "abnormal", "location": "storage", "route": "none", "load": 0.4})
    yield _met(
        "trolley-9", 1.5, {"category": "obstacle", "state": "normal", "location": "route", "route": "blocking"}, task="deliver"
    )
    yield _met("stack-4", 2.0, {"category": "item", "state": "unstable", "location": "edge", "route": "none", "load": 0.6})
    yield Evidence(
        id="reading-1",
        topic="reading",
        key="pump-3",
        at_ns=to_ns(READING_S),
        value=msgspec.Raw(b'{"temperature_c": 82.0, "current_a": 3.1}'),
    )


def _met(entity: str, at_s: float, fields: dict[str, Field], task: str = "") -> Draft:
    context = Context(task=task, fields={"context": "task" if task else "none"})
    return Draft(kind="object", entity=entity, source="eq6", position=0, at_ns=to_ns(at_s), fields=fields, context=context)


def run() -> MemoryJournal:
    """The sequence in virtual time; the journal that it wrote."""
    kernel, learner = assemble("service_robot", MindSettings(step_s=STEP_S))
    journal = MemoryJournal()
    # The guidelines take no time to ask, so that the only wait in the picture is the one for the reading.
    driver = SimulatedDriver(kernel, journal, GuidelineReasoner(kernel.domain.spec, latency_s=0.0), learner)
    for _ in driver.run("eq6", "eq6", lambda after: list(items())[after + 1 :]):
        pass
    driver.close()
    return journal


if __name__ == "__main__":
    draw(lanes(run()), OUT, title="P1(1) → P2 → P3 → P1(2): a diagnosis waits for its reading while others think (Eq. 6)")
    print(f"drawn to {OUT}")
