"""Chaos, seed by seed: the real kernel, driver and journal in virtual time, under everything that may go wrong at once.

    python -m benchmarks.chaos --seeds 1000 [--first-seed 0] [--json]

Each seed is played as its plan says and a second time: undisturbed where its plan holds nothing but crashes and failing
disks, and then both must end alike to the byte; else by the same plan again, and both must be the same. A seed that fails is
printed with its plan and the command that plays it again; the exit status is 1.
"""

from __future__ import annotations

import argparse
import json
import sys
import time

from benchmarks.chaos.trial import Totals, trial


def main() -> int:
    """Play the seeds; print what was counted."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--seeds", type=int, default=100, help="how many (default: 100)")
    arguments.add_argument("--first-seed", type=int, default=0)
    arguments.add_argument("--json", action="store_true")
    arguments.add_argument("--keep-going", action="store_true", help="play all seeds, whatever fails")
    given = arguments.parse_args()
    totals = Totals()
    began_s = time.process_time()
    for seed in range(given.first_seed, given.first_seed + given.seeds):
        told = trial(seed)
        totals.add(told)
        if told.failed:
            print(told.describe(), file=sys.stderr)
            if not given.keep_going:
                break
    totals.cpu_s_per_seed = round((time.process_time() - began_s) / max(1, totals.seeds), 4)
    if given.json:
        print(json.dumps(totals.as_row()))
    else:
        for name, value in totals.as_row().items():
            print(f"{name:24} {value}")
    return 1 if totals.failed else 0


if __name__ == "__main__":
    sys.exit(main())
