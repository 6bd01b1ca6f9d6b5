"""What training and one estimate of a treatment cost, the network alone beside the pool."""

from __future__ import annotations

import time

import numpy as np

from wakeful.contracts.learner import RowPredictor
from wakeful.facts.inputs import TrainingJob
from wakeful.learning.material import Floats
from wakeful.learning.pooled import Pooled
from wakeful.learning.two_heads import TwoHeads


def print_cost(job: TrainingJob, new: Floats) -> None:
    """Print medians of single calls, the learners taken in turn, with the 10th and the 90th percentile.

    Args:
        job: what they learn from.
        new: events to estimate, (n, d), n at least 64.
    """
    readers: list[tuple[str, RowPredictor]] = []
    for learner in (TwoHeads(), Pooled()):
        began = time.process_time()
        _, weights = learner.train(job)
        print(f"{learner.name:12} trained in {time.process_time() - began:.2f} s of processor time, {len(weights):,} bytes")
        reader = learner.load(weights)
        assert isinstance(reader, RowPredictor)
        readers.append((learner.name, reader))
    spent: dict[str, list[float]] = {}
    for turn in range(3000):
        row = new[turn % len(new)]
        for name, reader in readers:
            began = time.perf_counter()
            reader.estimate(row)
            spent.setdefault(f"{name}, one event", []).append(time.perf_counter() - began)
        if turn % 20 == 0:
            for name, reader in readers:
                began = time.perf_counter()
                reader.estimate_rows(new[:64])
                spent.setdefault(f"{name}, one of 64", []).append((time.perf_counter() - began) / 64)
    for name, seconds in spent.items():
        low, middle, high = np.percentile(np.array(seconds) * 1e6, [10, 50, 90])
        print(f"{name:24}{middle:8.1f} µs{low:10.1f} .. {high:.1f}")
