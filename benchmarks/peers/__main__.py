"""Workload W through every system that is installed, by turns, each run in a process of its own.

    ./run python -m benchmarks.peers [--systems wakeful,floor] [--events 10000] [--rounds 5] [--rate 2000] [--json]

Prints the median of each column over the rounds, with its range. The checksum of the final states must be the same for all.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

import msgspec

from benchmarks.peers.running import Load
from benchmarks.peers.systems import SYSTEMS
from benchmarks.peers.workload import make, save

Found = dict[str, object]


def child(system: str, variant: str, workload: Path, store: Path, load: Load) -> Found:
    """One run in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.peers.child", system, variant, str(workload), str(store)]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    ended = subprocess.run(
        [*command, msgspec.json.encode(load).decode()], capture_output=True, text=True, check=False, env=environment
    )
    if ended.returncode:
        raise SystemExit(f"{system} {variant} failed:\n{ended.stderr}")
    return dict(json.loads(ended.stdout.splitlines()[-1]))


def row_of(system: str, variant: str, runs: list[Found]) -> Found:
    """The medians of one system's runs, with the range of the two figures that matter most."""
    entry = SYSTEMS[system]

    def middle(name: str, place: int | None = None) -> float | None:
        values = [run[name] if place is None else run[name][place] for run in runs if run[name] is not None]  # type: ignore[index]
        return round(median(values), 4) if values else None

    def spread(name: str) -> list[float]:
        values = [float(run[name]) for run in runs]  # type: ignore[arg-type]
        return [round(min(values), 2), round(max(values), 2)]

    row: Found = {
        "system": system,
        "variant": variant,
        "durable": entry.durable,
        "events": runs[0]["events"],
        "runs": len(runs),
        "events_per_second": middle("events_per_second"),
        "cpu_us_per_event": middle("cpu_us_per_event"),
        "p50_ms": middle("admit", 0),
        "p99_ms": middle("admit", 1),
        "step_p50_ms": middle("step", 0),
        "step_p99_ms": middle("step", 1),
        "resume_p50_ms": middle("resume", 0),
        "resume_p99_ms": middle("resume", 1),
        "bytes_per_event": middle("bytes_per_event"),
        "peak_mb": middle("peak_mb"),
        "threads": middle("threads"),
        "lost": None,
        "repeated": None,
        "user_lines": entry.user_lines,
        "right": all(run["right"] for run in runs),
        "cpu_us_range": spread("cpu_us_per_event"),
        "events_per_second_range": spread("events_per_second"),
    }
    if "floor_us" in runs[0]:
        row["assembled_cpu_us"] = row["cpu_us_per_event"]
        row["cpu_us_per_event"] = middle("floor_us")
        row["cpu_us_range"] = spread("floor_us")
        row["stages_us"] = runs[len(runs) // 2]["stages_us"]
    return row


def table(rows: list[Found]) -> str:
    """The rows for people."""
    names = ("events_per_second", "cpu_us_per_event", "p50_ms", "p99_ms", "step_p99_ms", "resume_p99_ms")
    names += ("bytes_per_event", "peak_mb", "threads", "lost", "repeated", "user_lines", "events", "right")
    head = ["system", "durable", *names]
    lines = [head]
    for row in rows:
        name = f"{row['system']} {row['variant']}".strip()
        lines.append([name, "yes" if row["durable"] else "no", *(_shown(row[each]) for each in names)])
    widths = [max(len(line[place]) for line in lines) for place in range(len(head))]
    return "\n".join("  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True)) for line in lines)


def _shown(value: object) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "NO"
    if isinstance(value, float):
        return f"{value:,.0f}" if value >= 100 else f"{value:.2f}"
    return str(value)


def main(words: list[str] | None = None) -> int:
    """Run what was asked for; 1 where a system came to other final states than the workload's."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--systems", default=",".join(SYSTEMS), help="names, each optionally with :variant")
    parser.add_argument("--events", type=int, default=10_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rate", type=float, default=0.0, help="events a second, open loop; 0: as fast as they are taken")
    parser.add_argument("--group-ms", type=float, default=2.0, help="for how long an open-loop system may gather a commit")
    parser.add_argument("--full-sync", action="store_true", help="every acknowledgement survives power loss too")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args(words)
    chosen: list[tuple[str, str]] = []
    for name in given.systems.split(","):
        system, _, variant = name.partition(":")
        entry = SYSTEMS[system]
        if entry.missing:
            print(f"{system}: left out, not installed: {entry.missing}", file=sys.stderr)
            continue
        chosen += [(system, each) for each in entry.variants if variant in ("", each)]
    load = Load(rate=given.rate, group_s=given.group_ms / 1000, full_sync=given.full_sync)
    runs: dict[tuple[str, str], list[Found]] = {each: [] for each in chosen}
    with tempfile.TemporaryDirectory() as folder:
        workloads: dict[int, Path] = {}
        for system, _ in chosen:
            count = max(1, round(given.events * SYSTEMS[system].share))
            if count not in workloads:
                workloads[count] = Path(folder, f"w{count}")
                save(make(given.seed, count), workloads[count])
        for turn in range(given.rounds):
            for place, (system, variant) in enumerate(chosen):
                store = Path(folder, f"store-{turn}-{place}")
                workload = workloads[max(1, round(given.events * SYSTEMS[system].share))]
                offered = msgspec.structs.replace(load, window=SYSTEMS[system].window)
                runs[system, variant].append(child(system, variant, workload, store, offered))
    rows = [row_of(system, variant, found) for (system, variant), found in runs.items()]
    print(json.dumps(rows) if given.json else table(rows))
    return 0 if all(row["right"] for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
