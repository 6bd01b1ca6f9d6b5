"""How memory's two constants were chosen: on seeds of their own, of which no result is reported elsewhere.

    python -m wakeful.experiments.exp3_choice

For each pair of means (noise, change) it prints joint accuracy on ``clean``, ``noisy`` and ``jitter`` over seeds 1000 to 1019.
"""

from __future__ import annotations

import sys
from statistics import fmean

from wakeful.contracts.learner import Learner
from wakeful.experiments.exp3_learning import figures, run
from wakeful.experiments.exp3_wakeful import Once, Wakeful
from wakeful.experiments.worlds.service_drift import CLEAN, JITTER, NOISY, Variant, world
from wakeful.learning.belief import Expected
from wakeful.learning.pooled import Pooled

SEEDS = range(1000, 1020)
PAIRS = tuple(Expected(noise, change) for noise in (0.15, 1.0) for change in (0.004, 0.01, 0.03, 1.0))


def joint(variant: Variant, expected: Expected, learner: Learner) -> float:
    """Mean joint accuracy over the seeds, in percent."""
    found = []
    for seed in SEEDS:
        of = world(variant, seed)
        found.append(figures(of, list(run(Wakeful(of, learner, expected), of)))["joint"] or 0.0)
    return fmean(found)


def main() -> None:
    """Print a line per pair."""
    learner = Once(Pooled())
    for expected in PAIRS:
        parts = [f"{variant.name} {joint(variant, expected, learner):.2f}" for variant in (CLEAN, NOISY, JITTER)]
        sys.stdout.write(f"noise {expected.noise:g}, change {expected.change:g}: {', '.join(parts)}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
