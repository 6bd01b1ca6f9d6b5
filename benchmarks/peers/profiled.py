"""Where wakeful's time goes in W, by room, beside the floor: sampled each millisecond of the process's own CPU time.

    python -m benchmarks.peers.profiled SYSTEM VARIANT WORKLOAD STORE LOAD     prints the samples by stage as JSON

Sampling costs next to nothing, unlike cProfile, which makes many small calls look dearer than they are. A sample belongs to the
innermost frame that a stage claims; where the main thread waits, to the thread that works. Garbage collection is timed apart.
"""

from __future__ import annotations

import gc
import json
import signal
import sys
import time
from collections import Counter
from pathlib import Path
from types import FrameType

import msgspec

from benchmarks.peers.kept import lean_of, messages_of
from benchmarks.peers.report import Found
from benchmarks.peers.running import Load, Run
from benchmarks.peers.systems import SYSTEMS

INTERVAL_S = 0.001

#: Which stage a module's frame belongs to, the longest prefix first; a module that is not here leaves it to its caller.
STAGES: dict[str, str] = {
    "benchmarks.peers.drafting": "decode",
    "benchmarks.peers.messages": "decode",
    "benchmarks.peers.of_wakeful": "decode",
    "benchmarks.peers.treating": "treatments",
    "wakeful.registration": "admit",
    "wakeful.admission": "admit",
    "wakeful.selection": "select",
    "wakeful.learning.predictor": "select",
    "wakeful.learning.novelty": "select",
    "wakeful.learning.network": "select",
    "wakeful.scheduling": "steps",
    "wakeful.validation": "validate",
    "wakeful.learning": "learn",
    "wakeful.revision": "learn",
    "wakeful.journal": "journal",
    "wakeful.facts.packs": "journal",
    "wakeful.facts.named": "journal",
    "wakeful.kernel": "kernel",
    "wakeful.drivers": "driver",
    "asyncio": "driver",
    "selectors": "driver",
    "concurrent": "driver",
}

#: Which of these the floor's stages stand beside.
FLOOR = {"decode": "decode", "features": "select", "forward": "select", "append": "journal", "steps": "steps"}

_IDLE = {"select", "poll", "wait", "sleep", "get", "_worker", "_worker_loop", "acquire"}


class Sampler:
    """Counts where the process is, each time that it has used another millisecond of CPU."""

    def __init__(self) -> None:
        self.counts: Counter[str] = Counter()
        self.lines: Counter[str] = Counter()
        self.gc_s = 0.0
        self._gc_began = 0.0

    def __enter__(self) -> Sampler:
        gc.callbacks.append(self._collecting)
        signal.signal(signal.SIGPROF, self._sample)
        signal.setitimer(signal.ITIMER_PROF, INTERVAL_S, INTERVAL_S)
        return self

    def __exit__(self, *_: object) -> None:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        gc.callbacks.remove(self._collecting)

    def _collecting(self, phase: str, _about: dict[str, int]) -> None:
        if phase == "start":
            self._gc_began = time.process_time()
        else:
            self.gc_s += time.process_time() - self._gc_began

    def _sample(self, _number: int, frame: FrameType | None) -> None:
        if frame is not None and frame.f_code.co_name in _IDLE:
            others = [each for each in sys._current_frames().values() if each.f_code.co_name not in (*_IDLE, "_sample")]
            frame = next(iter(others), frame)
        if frame is not None:
            self.lines[f"{frame.f_globals.get('__name__', '')}.{frame.f_code.co_qualname}"] += 1
        while frame is not None:
            stage = stage_of(str(frame.f_globals.get("__name__", "")))
            if stage:
                self.counts[stage] += 1
                return
            frame = frame.f_back
        self.counts["other"] += 1


def stage_of(module: str) -> str:
    """The stage that a module's frames belong to, or nothing."""
    parts = module.split(".")
    return next((found for end in range(len(parts), 0, -1) if (found := STAGES.get(".".join(parts[:end])))), "")


def main(system: str, variant: str, workload: Path, store: Path, load: Load) -> Found:
    """Run it once under the sampler."""
    store.mkdir(parents=True, exist_ok=True)
    messages = messages_of(workload)
    run = Run(messages, lean_of(workload), workload, store, load)
    made = SYSTEMS[system].make(variant, run)
    gc.collect()
    with Sampler() as sampler:
        cpu = time.process_time()
        made.run()
        cpu_s = time.process_time() - cpu
    events = len(run.times.came)
    total = sum(sampler.counts.values())
    us = cpu_s * 1e6 / events
    collecting_us = sampler.gc_s * 1e6 / events
    share = (us - collecting_us) / total
    return {
        "cpu_us_per_event": round(us, 2),
        "stages_us": {**{name: round(count * share, 2) for name, count in sampler.counts.items()}, "gc": round(collecting_us, 2)},
        "hottest": [(name, round(count * share, 2)) for name, count in sampler.lines.most_common(25)],
    }


def draw(found: Found, floor: Found, title: str, path: Path) -> None:
    """Two bars for each stage: wakeful's, and the floor's where it has that stage. Needs matplotlib (the extra ``plots``)."""
    from wakeful.experiments.plotting import new_figure  # noqa: PLC0415 - peers' children must not carry it

    ours: dict[str, float] = found["stages_us"]  # type: ignore[assignment]
    beneath = floor_stages(floor)
    names = sorted(ours, key=lambda name: ours[name])
    figure, axes = new_figure(7.0, 0.4 * len(names) + 1.4)
    places = range(len(names))
    axes.barh([place + 0.2 for place in places], [ours[name] for name in names], 0.4, label="wakeful", color="#3b6ea5")
    axes.barh([place - 0.2 for place in places], [beneath.get(name, 0.0) for name in names], 0.4, label="floor", color="#c9822b")
    for place, name in zip(places, names, strict=True):
        axes.text(ours[name], place + 0.2, f" {ours[name]:.1f}", va="center", fontsize=8)
        if name in beneath:
            axes.text(beneath[name], place - 0.2, f" {beneath[name]:.1f}", va="center", fontsize=8)
    axes.set_yticks(list(places), names)
    axes.set_xlabel("µs of CPU for each event")
    axes.set_title(title, fontsize=10)
    axes.legend(loc="lower right", fontsize=8)
    figure.savefig(path, metadata={"Date": None})


def floor_stages(floor: Found) -> dict[str, float]:
    """The floor's faster implementations under wakeful's names."""
    sums: Counter[str] = Counter()
    for stage, kinds in floor["stages_us"].items():  # type: ignore[attr-defined]
        if stage in FLOOR:
            sums[FLOOR[stage]] += min(kinds.values())
    return dict(sums)


if __name__ == "__main__":
    name, kind, folder, own, given = sys.argv[1:]
    print(json.dumps(main(name, kind, Path(folder), Path(own), msgspec.json.decode(given, type=Load))))
