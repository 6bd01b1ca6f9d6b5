"""The kernel alone on workload W: CPU for an event with the journal in memory, and selection's two stages by batch size.

    ./run python -m benchmarks.hot_path [--events 10000] [--batch 512] [--calls]

``--calls`` counts function calls for an event instead (which the load of the machine does not change).
"""

from __future__ import annotations

import argparse
import cProfile
import gc
import pstats
import time
from collections.abc import Callable, Iterator

from benchmarks.peers.drafting import draft, evidence, outcome
from benchmarks.peers.messages import Event, Tick, decode
from benchmarks.peers.messages import Evidence as Reading
from benchmarks.peers.workload import Workload, make
from benchmarks.scale import begun, new_kernel
from wakeful.facts.inputs import Begin, Input, Instant, Mark
from wakeful.kernel import Kernel
from wakeful.learning.two_heads import TwoHeads
from wakeful.selection.batch import BatchEncoder
from wakeful.selection.features import Encoder

SIZES = (1, 4, 16, 64, 256)


def batches(workload: Workload, size: int) -> Iterator[list[Input]]:
    """W's messages as inputs, so many messages at a time."""
    position = -1
    for begin in range(0, len(workload.messages), size):
        inputs: list[Input] = []
        for message in map(decode, workload.messages[begin : begin + size]):
            inputs.append(Instant(message.at_ns))
            if isinstance(message, Event):
                position += 1
                inputs += (draft(message, "w", position), Mark(source="w", position=position))
            elif isinstance(message, Reading):
                inputs.append(evidence(message))
            elif not isinstance(message, Tick):
                inputs.append(outcome(message))
        yield inputs


def ready(workload: Workload) -> Kernel:
    """A mind with W's model."""
    kernel = new_kernel()
    begun(workload, kernel)
    kernel.feed([Begin(source="w", digest="w")], 1)
    gc.collect()
    gc.freeze()
    return kernel


def run(workload: Workload, kernel: Kernel, size: int) -> None:
    """All of W; what would be committed is let go."""
    for inputs in batches(workload, size):
        kernel.feed(inputs, kernel.now_ns)
        kernel.changed()


def calls(workload: Workload, events: int, size: int) -> tuple[float, float]:
    """Calls for an event: of Python functions, and of all."""
    kernel, profile = ready(workload), cProfile.Profile()
    profile.runcall(run, workload, kernel, size)
    counted = pstats.Stats(profile).stats  # type: ignore[attr-defined]  # typeshed does not know it
    python = sum(count[1] for (file, _, _), count in counted.items() if file != "~")
    return python / events, sum(count[1] for count in counted.values()) / events


def least(work: Callable[[], object], events: int) -> float:
    """The least CPU of nine passes, in µs an event."""
    times = max(1, 1_000 // events)
    found = []
    for _ in range(9):
        began = time.process_time()
        for _ in range(times):
            work()
        found.append((time.process_time() - began) / times / events * 1e6)
    return min(found)


def stages(workload: Workload) -> str:
    """Encoding and the model, by batch size."""
    met = [draft(each) for each in map(decode, workload.messages) if isinstance(each, Event)]
    kernel = ready(workload)
    encoder = Encoder(kernel.domain.spec, kernel.domain.spec.treatments)
    predictor = TwoHeads().load(workload.weights)
    batch = BatchEncoder(encoder)
    lines = ["| events at a time | encode, µs | model and novelty, µs |", "|---|---|---|"]
    for size in SIZES:
        some = met[:size]
        rows = batch.encode(some)
        encode = least(lambda some=some: batch.encode(some), size)  # type: ignore[misc]
        estimate = least(lambda rows=rows: predictor.estimate_rows(rows), size)  # type: ignore[misc]
        lines.append(f"| {size} | {encode:.2f} | {estimate:.2f} |")
    return "\n".join(lines)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--events", type=int, default=10_000)
    parser.add_argument("--batch", type=int, default=512)
    parser.add_argument("--calls", action="store_true")
    given = parser.parse_args()
    workload = make(1, given.events)
    if given.calls:
        python, every = calls(workload, given.events, given.batch)
        print(f"{python:.0f} Python functions are called for an event, {every:.0f} calls in all")
        return
    kernel = ready(workload)
    began = time.process_time()
    run(workload, kernel, given.batch)
    print(f"{(time.process_time() - began) / given.events * 1e6:.0f} µs of CPU an event, {given.batch} messages at a time\n")
    print(stages(workload))


if __name__ == "__main__":
    main()
