"""Chaos, seed by seed: the real kernel, driver and journal in virtual time, under everything that may go wrong at once.

    python -m benchmarks.chaos --seeds 1000 [--driver simulated|live] [--first-seed 0] [--jobs 1] [--json]

Each seed is played as its plan says and a second time: undisturbed where its plan holds nothing but crashes and failing
disks, and then both must end alike to the byte; else by the same plan again, and both must be the same. A seed that fails is
printed with its plan and the command that plays it again; the exit status is 1. ``--driver live`` plays them through asyncio in a
virtual event loop, by the same plan twice (``benchmarks/chaos/live.py``).
"""

from __future__ import annotations

import argparse
import itertools
import json
import subprocess
import sys
import time

from benchmarks.chaos.trial import Totals, trial


def main() -> int:
    """Play the seeds; print what was counted."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--seeds", type=int, default=100, help="how many (default: 100)")
    arguments.add_argument("--driver", choices=("simulated", "live"), default="simulated")
    arguments.add_argument("--first-seed", type=int, default=0)
    arguments.add_argument("--jobs", type=int, default=1, help="so many processes, each with its part of the seeds (default: 1)")
    arguments.add_argument("--json", action="store_true")
    arguments.add_argument("--keep-going", action="store_true", help="play all seeds, whatever fails")
    given = arguments.parse_args()
    began_s = time.process_time()
    if given.jobs > 1:
        totals = in_parts(given.first_seed, given.seeds, given.jobs, given.driver, keep_going=given.keep_going)
    else:
        totals = play_all(range(given.first_seed, given.first_seed + given.seeds), given.driver, keep_going=given.keep_going)
        totals.cpu_s = round(time.process_time() - began_s, 3)
    if given.json:
        print(json.dumps(totals.as_row()))
    else:
        for name, value in totals.as_row().items():
            print(f"{name:24} {value}")
    return 1 if totals.failed else 0


def play_all(seeds: range, driver: str, *, keep_going: bool) -> Totals:
    """Play one after the other, up to the first that fails unless told to go on."""
    totals = Totals()
    for seed in seeds:
        told = trial(seed, driver)
        totals.add(told)
        if told.failed:
            print(told.describe(), file=sys.stderr)
            if not keep_going:
                break
    return totals


def in_parts(first: int, seeds: int, jobs: int, driver: str, *, keep_going: bool) -> Totals:
    """Play in so many processes, and sum up what they counted."""
    cuts = [first + seeds * job // jobs for job in range(jobs + 1)]
    running = []
    for start, end in itertools.pairwise(cuts):
        command = [sys.executable, "-m", "benchmarks.chaos", "--driver", driver, "--json"]
        command += ["--first-seed", str(start), "--seeds", str(end - start)]
        running.append(subprocess.Popen(command + ["--keep-going"] * keep_going, stdout=subprocess.PIPE, text=True))
    totals = Totals()
    for process in running:
        said, _ = process.communicate()
        for name, value in json.loads(said).items():
            if name in Totals.__struct_fields__:
                setattr(totals, name, getattr(totals, name) + value)
    return totals


if __name__ == "__main__":
    sys.exit(main())
