"""One run of W by one system in a process of its own: prints one JSON object.

python -m benchmarks.peers.child SYSTEM VARIANT WORKLOAD STORE LOAD
"""

from __future__ import annotations

import gc
import json
import resource
import sys
import threading
import time
from pathlib import Path
from statistics import median, quantiles

import msgspec

from benchmarks.peers.kept import facts_of, lean_of, messages_of
from benchmarks.peers.running import Load, Run
from benchmarks.peers.systems import SYSTEMS
from benchmarks.peers.treating import checksum


def main(system: str, variant: str, workload: Path, store: Path, load: Load) -> dict[str, object]:
    """Run it and say what it took."""
    store.mkdir(parents=True, exist_ok=True)
    facts = facts_of(workload)
    run = Run(messages_of(workload), lean_of(workload), workload, store, load)
    made = SYSTEMS[system].make(variant, run)
    gc.collect()
    before_mb = _peak_mb()
    cpu, began = time.process_time(), time.perf_counter()
    made.run()
    seconds, cpu_s = time.perf_counter() - began, time.process_time() - cpu
    threads = _threads()
    peak_mb = _peak_mb()
    finals = made.finals()
    times = run.times
    return {
        "system": system,
        "variant": variant,
        "events": facts.events,
        "events_per_second": facts.events / seconds,
        "cpu_us_per_event": (cpu_s + getattr(made, "other_cpu_s", 0.0)) * 1e6 / facts.events,
        "admit": _spread(times.came, times.durable),
        "step": _spread(times.came, times.stepped),
        "resume": _spread(_both(times.read, times.came), times.resumed),
        "bytes_per_event": made.stored_bytes() / facts.events,
        "peak_mb": peak_mb,
        "base_mb": before_mb,
        "threads": threads,
        "finals": len(finals),
        "checksum": checksum(finals),
        "right": checksum(finals) == facts.checksum,
        **({"entities": [each.split(" ", 1)[0] for each in finals]} if load.calls else {}),
        **getattr(made, "extra", {}),
    }


def _both(read: dict[str, int], came: dict[str, int]) -> dict[str, int]:
    """From when on a waiting event could have gone on: a reading may be there before it."""
    return {name: max(at, came[name]) for name, at in read.items() if name in came}


def _spread(since: dict[str, int], until: dict[str, int]) -> list[float] | None:
    """p50, p99 and the longest, in milliseconds, of what has both ends in that order."""
    took = [(until[name] - since[name]) / 1e6 for name in since if name in until and until[name] >= since[name]]
    if len(took) < 2:
        return None
    return [round(each, 4) for each in (median(took), quantiles(took, n=100)[-1], max(took))]


def _peak_mb() -> float:
    """The most that this process has held; ``ru_maxrss`` would tell of the parent that it was forked from too."""
    found = _status("VmHWM:")
    return found / 1024 if found is not None else resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _threads() -> int:
    return _status("Threads:") or threading.active_count()


def _status(name: str) -> int | None:
    try:
        lines = Path("/proc/self/status").read_text().splitlines()
    except OSError:
        return None
    return next((int(line.split()[1]) for line in lines if line.startswith(name)), None)


if __name__ == "__main__":
    name, kind, folder, own, given = sys.argv[1:]
    print(json.dumps(main(name, kind, Path(folder), Path(own), msgspec.json.decode(given, type=Load))))
