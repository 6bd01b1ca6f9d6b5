"""How a mind learns on one recording: accuracy of the predicted outcome and automatic share over time, against baselines.

    ./run python -m benchmarks.ur3_learning SOURCE [--journal FILE] [--stretches 10] [--picture FILE.svg]

Reads the journal of a `wakeful run` (of --journal, or of one that it makes for SOURCE first). Nothing is predicted again for
wakeful: what counts is the forecast that each event's first process recorded, against the outcome that the recording showed
later. The baselines predict every event when it is admitted, from the encoder's features of that event, and know just the
outcomes that were known by then; they are fitted anew to all of them whenever the mind asked for a training.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import msgspec
import numpy as np

from benchmarks.baselines import Baseline, BaseRate, LogisticRegression
from wakeful.contracts.learner import Vector
from wakeful.domains import load
from wakeful.facts.decisions import Decision
from wakeful.facts.domain import DomainSpec
from wakeful.facts.experience import Verdict
from wakeful.facts.lines import Admitted, AnyRecord, Concluded, Created, Decided, Gained, Judged, Opened, TrainingAsked
from wakeful.journal import open_journal
from wakeful.selection.features import Encoder

HEAD = "the result head alone"
NAMES = ("wakeful", HEAD, "logistic regression", "most frequent so far", "most frequent of the last 50")


class Told(msgspec.Struct):
    """One event: the mode its first process ended up in, what everybody predicted, and what came of it."""

    mode: str = ""
    predicted: dict[str, str] = msgspec.field(default_factory=dict)
    outcome: str = ""


class Reading:
    """Folds a journal's records into what was predicted and what came, the baselines fitted on the way."""

    def __init__(self, spec: DomainSpec) -> None:
        labels = len(spec.outcome.labels)
        self.labels = spec.outcome.labels
        self.told: dict[str, Told] = {}
        self._encoder = Encoder(spec, spec.treatments)
        self._baselines: dict[str, Baseline] = {
            "logistic regression": LogisticRegression(labels),
            "most frequent so far": BaseRate(labels),
            "most frequent of the last 50": BaseRate(labels, last=50),
        }
        self._features: dict[str, Vector] = {}
        self._roots: dict[str, int] = {}
        self._concluded: set[int] = set()
        self._known: dict[int, tuple[str, int]] = {}

    def apply(self, record: AnyRecord) -> None:
        """Take up one record, in the journal's order."""
        if isinstance(record, Admitted):
            features = self._encoder.encode(record.event)
            self._features[record.event.id] = features
            said = {name: self.labels[baseline.predict(features)] for name, baseline in self._baselines.items()}
            self.told[record.event.id] = Told(predicted=said)
        elif isinstance(record, Created):
            if not record.parent and not record.reopens:
                self._roots.setdefault(record.event, record.process)
        elif isinstance(record, Decided):
            if self._roots.get(record.event) == record.process and record.process not in self._concluded:
                self._decided(self.told[record.event], record.decision)
        elif isinstance(record, Concluded):
            self._concluded.add(record.process)
        elif isinstance(record, Judged):
            told = self.told[record.event]
            if self._roots.get(record.event) == record.process and not told.outcome and record.verdict is not Verdict.UNDECIDED:
                told.outcome = record.label
                told.predicted["wakeful"] = record.predicted
        elif isinstance(record, Gained):
            gained = record.experience
            self._known.pop(gained.process, None)
            self._known[gained.process] = (gained.event, self.labels.index(gained.outcome))
        elif isinstance(record, TrainingAsked):
            rows = np.stack([self._features[event] for event, _ in self._known.values()])
            outcome = np.array([label for _, label in self._known.values()])
            for baseline in self._baselines.values():
                baseline.fit(rows, outcome)

    def _decided(self, told: Told, decision: Decision) -> None:
        told.mode = decision.mode
        if decision.model and HEAD not in told.predicted:
            told.predicted[HEAD] = max(self.labels, key=lambda label: round(decision.prior.get(label, 0.0), 9))


def accuracy(told: Iterable[Told], name: str) -> float:
    """The share of right predictions; NaN where there are none."""
    right = [each.predicted[name] == each.outcome for each in told if name in each.predicted]
    return sum(right) / len(right) if right else math.nan


def interval(share: float, rows: int) -> tuple[float, float]:
    """The 95 % interval of a share (Wilson). Neighbouring events are not independent: take it as the least there is."""
    if not rows:
        return math.nan, math.nan
    z = 1.96
    middle = (share + z * z / (2 * rows)) / (1 + z * z / rows)
    half = z * math.sqrt(share * (1 - share) / rows + z * z / (4 * rows * rows)) / (1 + z * z / rows)
    return middle - half, middle + half


def difference(told: Sequence[Told], name: str, block: int = 20, draws: int = 2000) -> tuple[float, float, float]:
    """wakeful's accuracy less another's, with a 95 % interval by resampling blocks of neighbouring events (seed 0)."""
    gap = np.array(
        [float(e.predicted["wakeful"] == e.outcome) - float(e.predicted[name] == e.outcome) for e in told if name in e.predicted]
    )
    random = np.random.default_rng(0)
    starts = random.integers(0, max(1, len(gap) - block + 1), (draws, math.ceil(len(gap) / block)))
    means = gap[(starts[:, :, None] + np.arange(block)).reshape(draws, -1) % len(gap)].mean(axis=1)
    low, high = np.percentile(means, [2.5, 97.5])
    return float(gap.mean()), float(low), float(high)


def stretches(told: list[Told], count: int) -> list[list[Told]]:
    """The events cut into parts of equal number, in order of admission."""
    cuts = [round(len(told) * part / count) for part in range(count + 1)]
    return [told[first:last] for first, last in pairwise(cuts) if last > first]


def table(parts: list[list[Told]]) -> list[str]:
    """The Markdown table: a row a stretch, and rows for the second half and for all."""
    everything = [each for part in parts for each in part]
    half = everything[len(everything) // 2 :]
    rows = [(f"{index}", part) for index, part in enumerate(parts, 1)] + [("second half", half), ("all", everything)]
    lines = [
        f"| stretch | events | automatic | {' | '.join(NAMES)} |",
        f"|---|--:|--:|{'--:|' * len(NAMES)}",
    ]
    for title, part in rows:
        automatic = sum(each.mode == "auto" for each in part) / len(part)
        shares = " | ".join(percent(accuracy(part, name)) for name in NAMES)
        lines.append(f"| {title} | {len(part)} | {percent(automatic)} | {shares} |")
    return lines


def by_mode(told: list[Told]) -> list[str]:
    """One line a mode: how many, and how often wakeful and logistic regression were right on these very events."""
    lines = []
    for mode in ("auto", "delib", "fallback"):
        part = [each for each in told if each.mode == mode]
        if part:
            own, other = accuracy(part, "wakeful"), accuracy(part, "logistic regression")
            lines.append(
                f"- {mode}: {len(part)} events, wakeful right in {percent(own)} %, logistic regression in {percent(other)} %"
            )
    return lines


def percent(share: float) -> str:
    """A share as a number out of 100, `–` where there is none."""
    return "–" if math.isnan(share) else f"{100 * share:.1f}"


def picture(parts: list[list[Told]], path: Path) -> None:
    """Accuracy of each, and the automatic share, over the stretches."""
    try:
        from matplotlib import pyplot  # noqa: PLC0415  (an extra, wanted here alone)
    except ImportError:
        raise SystemExit("the picture needs matplotlib: pip install 'wakeful[plots]'") from None
    pyplot.rcParams["svg.hashsalt"] = "wakeful"
    figure, (above, below) = pyplot.subplots(2, 1, sharex=True, figsize=(8, 5.5), height_ratios=(3, 1), layout="constrained")
    x = range(1, len(parts) + 1)
    for name, style in zip(NAMES, ("-o", ":", "-s", "--", "-."), strict=True):
        wide = 2.2 if name == "wakeful" else 1.2
        above.plot(x, [100 * accuracy(part, name) for part in parts], style, label=name, linewidth=wide, markersize=4)
    above.set_ylabel("outcome predicted rightly, %")
    above.set_ylim(0, 100)
    above.legend(loc="upper left", fontsize="small", ncols=2)
    below.bar(list(x), [100 * sum(each.mode == "auto" for each in part) / len(part) for part in parts], color="0.6")
    below.set_ylabel("automatic, %")
    below.set_ylim(0, 100)
    below.set_xlabel(f"stretch of about {len(parts[0])} events, in time order")
    figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)


def main() -> None:
    """Run where there is no journal yet, read it, print the table, draw the picture."""
    arguments = argparse.ArgumentParser(description="How a mind learns on one recording, against baselines.")
    arguments.add_argument("source", nargs="?", help="a recording; may be left out where --journal has been written before")
    arguments.add_argument("--journal", type=Path)
    arguments.add_argument("--stretches", type=int, default=10)
    arguments.add_argument("--picture", type=Path)
    asked = arguments.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        journal = asked.journal or Path(scratch) / "run.db"
        if not journal.exists():
            if asked.source is None:
                arguments.error("name a SOURCE, or a --journal that is there")
            command = [sys.executable, "-m", "wakeful", "run", asked.source, "--journal", str(journal), "--json"]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        told = read(journal)
    if not told:
        raise SystemExit("no forecast was ever judged in this journal: there is nothing to compare")
    parts = stretches(told, asked.stretches)
    print("\n".join(table(parts)))
    own = accuracy(told, "wakeful")
    low, high = interval(own, len(told))
    print(f"\nwakeful over all: {percent(own)} % (95 %: {percent(low)} to {percent(high)})")
    for name in NAMES[1:]:
        gap, low, high = difference(told, name)
        print(f"- less {name}: {100 * gap:+.1f} points (95 %, by blocks of 20 events: {100 * low:+.1f} to {100 * high:+.1f})")
    print("\n".join(by_mode(told)))
    if asked.picture:
        picture(parts, asked.picture)


def read(journal: Path) -> list[Told]:
    """The events of a journal that were judged, in order of admission."""
    reader = open_journal(journal, read_only=True)
    try:
        reading: Reading | None = None
        for line in reader.lines():
            if isinstance(line.record, Opened) and reading is None:
                reading = Reading(load(line.record.domain).spec)
            if reading is not None:
                reading.apply(line.record)
    finally:
        reader.close()
    return [each for each in reading.told.values() if each.outcome] if reading is not None else []


if __name__ == "__main__":
    main()
