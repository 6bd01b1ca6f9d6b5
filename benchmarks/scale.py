"""What a mind costs as more processes wait: CPU for each further event and wake, memory, pauses.

    ./run python -m benchmarks.scale [--waiting 1000,10000,100000] [--at-hand 100000] [--json] [--svg docs/scale.svg]

Everything runs through the real kernel, with W's model and its stub treatments; waiting processes wait for a reading that comes
a day later. For each number a row with the newest 4,096 at hand and the others parked, as by default, and one with all of them at
hand (``--at-hand`` says up to how many). Bytes are resident memory, after what the mind keeps of all events has filled up. CPU is
that of events that don't wait, and of readings that wake one of those that do, while as many wait; the longest feed is of all,
those too that let them wait. Times are CPU: what others take of the machine does not count.
"""

from __future__ import annotations

import argparse
import json
import resource
import sys
import time
from pathlib import Path
from random import Random
from statistics import quantiles

import msgspec

from benchmarks.peers.drafting import draft
from benchmarks.peers.learned import DOMAIN
from benchmarks.peers.messages import TREATMENTS, Event, decode
from benchmarks.peers.treating import TOPIC, WAITS, conclude, look, weigh
from benchmarks.peers.workload import Workload, make
from wakeful import Event as WakefulEvent
from wakeful import Evidence, MindView, Registry, Result, treatment
from wakeful.drivers import garbage
from wakeful.drivers.assembly import assemble
from wakeful.facts.inputs import Begin, Input, Instant, Mark
from wakeful.facts.lines import Line, Published
from wakeful.facts.overload import UNLIMITED
from wakeful.facts.settings import MindSettings
from wakeful.kernel import Kernel

BATCH = 64
FURTHER = 2_000
REMEMBERED = 500
KEPT_WAITING = MindSettings().keep_waiting
DAY_S = 86_400.0
#: So close that no window closes meanwhile: a forecast that nothing bears out is contradicted, and W is not about that.
SPACING_NS = 10_000


class Treated(Result, frozen=True, kw_only=True, tag="treated"):
    """What the stub concludes."""

    state: int


class Waiting(msgspec.Struct):
    """One row: with so many processes waiting."""

    waiting: int
    at_hand: int
    cpu_us_per_event: float
    cpu_us_per_wake: float
    bytes_per_waiting: float
    p99_batch_ms: float
    longest_ms: float


def registry() -> Registry:
    """W's treatments, with a longer wait."""
    found = Registry(installed=())
    for name in TREATMENTS:

        @treatment(name, says="A stub of three steps.")
        async def treat(event: WakefulEvent, mind: MindView) -> Treated:
            """Three steps; before the second a device's reading is waited for."""
            seen, reading = look(event.entity, event.fields["load"]), None
            await mind.work()
            if event.fields["category"] == WAITS:
                came = await mind.evidence(TOPIC, event.entity, DAY_S)
                reading = msgspec.json.decode(came[0].value) if came else None
            await mind.work()
            forecast = mind.forecast()
            await mind.work()
            return Treated(says="", confidence=0.5, forecast=forecast, state=conclude(weigh(seen, reading), forecast.label))

        found.add(treat, replace=True)
    return found


class World:
    """Events of W, as many as are wanted, of things that wait for a reading or don't."""

    def __init__(self, workload: Workload) -> None:
        met = [each for each in map(decode, workload.messages) if isinstance(each, Event)]
        self._waiting = [each for each in met if each.category == WAITS]
        self._others = [each for each in met if each.category != WAITS]
        self.at_ns = met[0].at_ns
        self.position = -1

    def inputs(self, count: int, waits: bool) -> list[Input]:
        """So many further events, one after the other."""
        found: list[Input] = []
        source = self._waiting if waits else self._others
        for _ in range(count):
            self.position += 1
            self.at_ns += SPACING_NS
            event = source[self.position % len(source)]
            named = msgspec.structs.replace(event, at_ns=self.at_ns, entity=f"{event.category}-{self.position:07d}")
            found += (Instant(self.at_ns), draft(named, "w", self.position), Mark(source="w", position=self.position))
        return found


def new_kernel(keep: int = 10_000, keep_waiting: int = KEPT_WAITING) -> Kernel:
    """One mind that remembers so many events."""
    settings = MindSettings(
        step_s=0.0, overload=UNLIMITED, keep_events=keep, episodes=2 * keep, keep_ids=25 * keep, keep_waiting=keep_waiting
    )
    return assemble(DOMAIN, settings, registry=registry())[0]


def begun(workload: Workload, kernel: Kernel) -> list[Line]:
    """Publish W's model."""
    lines = [Line(1, 1, Published(training=1, card=workload.card))]
    kernel.recover(lines, {}, {workload.card.blob: workload.weights})
    return lines


def fed(kernel: Kernel, world: World, count: int, waits: bool) -> list[float]:
    """Feed so many further events; CPU of each feed, in ms."""
    took = []
    for _ in range(0, count, BATCH):
        inputs = world.inputs(BATCH, waits=waits)
        began = time.process_time()
        kernel.feed(inputs, kernel.now_ns)
        kernel.changed()
        took.append((time.process_time() - began) * 1e3)
    return took


def waiting(workload: Workload, count: int, keep_waiting: int) -> Waiting:
    """Let so many processes wait, then measure."""
    kernel, world = new_kernel(REMEMBERED, keep_waiting), World(workload)
    begun(workload, kernel)
    kernel.feed([Begin(source="w", digest="w")], 1)
    fed(kernel, world, 30 * REMEMBERED, waits=False)
    garbage.settle()
    before, first = _resident(), world.position + 1
    took = fed(kernel, world, count, waits=True)
    garbage.settle()
    grown_bytes, at_hand = _resident() - before, count - kernel.parked
    further = fed(kernel, world, FURTHER, waits=False)
    cpu_event = sum(further) / 1e3 / (len(further) * BATCH)
    took += further
    random = Random(count)
    woken = random.sample(range(first, first + count), min(count // 2, FURTHER))
    cpu = time.process_time()
    for begin in range(0, len(woken), BATCH):
        readings: list[Input] = []
        for number in woken[begin : begin + BATCH]:
            world.at_ns += SPACING_NS
            reading = Evidence(
                id=f"r{number}", topic=TOPIC, key=f"{WAITS}-{number:07d}", at_ns=world.at_ns, value=msgspec.Raw(b"1.5")
            )
            readings += (Instant(world.at_ns), reading)
        began = time.process_time()
        kernel.feed(readings, kernel.now_ns)
        kernel.changed()
        took.append((time.process_time() - began) * 1e3)
    cpu_wake = (time.process_time() - cpu) / len(woken)
    return Waiting(
        waiting=count,
        at_hand=at_hand,
        cpu_us_per_event=cpu_event * 1e6,
        cpu_us_per_wake=cpu_wake * 1e6,
        bytes_per_waiting=grown_bytes / count,
        p99_batch_ms=quantiles(took, n=100)[-1],
        longest_ms=max(took),
    )


def _resident() -> int:
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
        return pages * resource.getpagesize()
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def table(rows: list[Waiting]) -> str:
    """Rows as a Markdown table."""
    names = Waiting.__struct_fields__
    lines = ["| " + " | ".join(name.replace("_", " ") for name in names) + " |", "|---" * len(names) + "|"]
    for row in rows:
        cells = [getattr(row, name) for name in names]
        lines.append("| " + " | ".join(f"{each:,}" if isinstance(each, int) else f"{each:,.1f}" for each in cells) + " |")
    return "\n".join(lines)


def draw(path: Path, waits: list[Waiting]) -> None:
    """The curves, as one picture."""
    from matplotlib import pyplot  # noqa: PLC0415  # only where a picture is asked for

    figure, axes = pyplot.subplots(1, 3, figsize=(13, 3.6))
    sides = {
        "all at hand": [row for row in waits if row.at_hand >= row.waiting],
        "as by default": [row for row in waits if row.at_hand < row.waiting],
    }
    for axis, name, label in (
        (axes[0], ("cpu_us_per_event", "cpu_us_per_wake"), "CPU, µs"),
        (axes[1], ("bytes_per_waiting",), "bytes for each waiting process"),
        (axes[2], ("p99_batch_ms", "longest_ms"), f"a feed of {BATCH}, ms"),
    ):
        for (side, rows), style in zip(sides.items(), ("--", "-"), strict=True):
            for each in name:
                said = f"{each.replace('_', ' ')}, {side}"
                axis.plot([row.waiting for row in rows], [getattr(row, each) for row in rows], style, marker="o", label=said)
        axis.set(xscale="log", xlabel="waiting processes", ylabel=label, ylim=(0, None))
        axis.legend(fontsize=6)
    figure.tight_layout()
    figure.savefig(path)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--waiting", default="1000,10000,100000")
    parser.add_argument("--at-hand", type=int, default=100_000)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--svg", type=Path)
    given = parser.parse_args()
    workload = make(1, 500)
    counts = [int(each) for each in given.waiting.split(",") if each]
    waits = [waiting(workload, each, KEPT_WAITING) for each in counts if each > KEPT_WAITING]
    waits += [waiting(workload, each, 2 * max(counts)) for each in counts if each <= given.at_hand]
    if given.json:
        json.dump(msgspec.to_builtins(waits), sys.stdout, indent=1)
    else:
        print(table(waits))
    if given.svg:
        draw(given.svg, waits)


if __name__ == "__main__":
    main()
