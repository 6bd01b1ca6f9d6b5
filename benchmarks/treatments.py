"""How long each treatment of this machine holds the kernel for one event, and how much it recalls into the journal.

Run: `./run python benchmarks/treatments.py [--rounds 200]`: the built-in treatments, and those of installed packages. A scripted
mind answers at once from forty remembered cases of the simulated service robot, so that what is measured is the thinking and the
trampoline, not the search. Prints medians and the range from the 10th to the 90th percentile in microseconds, steps of work, and
the bytes of answers and result as JSON.
"""

from __future__ import annotations

import argparse
import os
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import msgspec
import numpy as np

from wakeful.domains import load
from wakeful.facts.asking import Episode
from wakeful.facts.decisions import Mode
from wakeful.facts.events import Context, Event
from wakeful.facts.time import Stamp, to_ns
from wakeful.testing import Script, ScriptedMind
from wakeful.treatments.registry import Registry

NOW_S = 10_000.0
MODES: tuple[Mode, ...] = ("auto", "delib")


def event() -> Event:
    """A device in the way that does not work as it should."""
    return Event(
        id="now",
        kind="object",
        entity="device-7",
        source="bench",
        position=1,
        stamp=Stamp(source_ns=to_ns(NOW_S), received_ns=to_ns(NOW_S)),
        fields={
            "category": "device",
            "location": "route",
            "state": "abnormal",
            "route": "blocking",
            "load": 0.7,
            "context": "task",
        },
        context=Context(zone="hall", task="deliver a tray"),
    )


def cases() -> tuple[Episode, ...]:
    """Forty remembered cases, half of the event's own entity."""
    states = ("normal", "unstable", "abnormal")
    return tuple(
        Episode(
            event=f"e{at:02}",
            kind="object",
            entity="device-7" if at % 2 else f"device-{at}",
            at_ns=to_ns(NOW_S - 60.0 * (at + 1)),
            likeness=1.0 / (1.0 + 0.05 * at),
            treatment="diagnosis",
            outcome=("none", "intervention")[at % 2],
            verdict="supported",
            fields={"category": "device", "location": "route", "state": states[at % 3], "route": "none", "load": 0.02 * at},
        )
        for at in range(40)
    )


def main() -> None:
    """Print one row for each treatment and mode."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--rounds", type=int, default=200)
    rounds = arguments.parse_args().rounds
    domain = load("service_robot").spec
    met, script = event(), Script(episodes=cases(), prior={"none": 0.6, "intervention": 0.4}, now_s=NOW_S)
    print(f"{'treatment':16} {'mode':6} {'median':>8} {'10 %':>8} {'90 %':>8} {'steps':>6} {'recalled':>9} {'result':>7}")
    registry = Registry()
    for treatment in map(registry.get, registry.names()):
        for mode in MODES:
            took = []
            for _ in range(rounds):
                mind = ScriptedMind(domain, mode, script)
                start = time.perf_counter()
                result = mind.run(treatment, met)
                took.append(1e6 * (time.perf_counter() - start))
            low, middle, high = np.percentile(took, (10, 50, 90))
            steps = sum(int(each.request.key) for each in mind.exchanges if each.request.kind == "work")
            recalled = sum(len(msgspec.json.encode(each.answer)) for each in mind.exchanges if each.request.kind == "recall")
            said = len(msgspec.json.encode(result))
            print(f"{treatment.name:16} {mode:6} {middle:8.0f} {low:8.0f} {high:8.0f} {steps:6} {recalled:9} {said:7}")


if __name__ == "__main__":
    main()
