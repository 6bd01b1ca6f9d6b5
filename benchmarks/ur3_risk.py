"""How good the risks that are foretold are: Brier scores and reliability on the UR3, beside base rate and logistic regression.

Run: `./run python -m benchmarks.ur3_risk SOURCE [--json] [--picture FILE.svg]`. The whole recording is read once, in order, by a
mind that may only treat by `risk_prediction`; each event's probabilities were recorded before its outcome came. Scored is the
second half. The base rate is the share of each outcome among those known when the event was admitted; the logistic regression
knows the same outcomes, on the encoder's features of the event, and is fitted anew every 25 of them. The recent rate knows of
them the last 24 of the event's own kind, each weighing half as much for every 40 outcome windows that it is older, and one case
spread evenly: recency as risk prediction has it, and nothing else. Intervals: 95 %, by resampling blocks of 20 neighbouring
events (seed 0), of the difference to the logistic regression, to the recent rate and to the base rate (below zero is better).
In the picture bins of fewer than five events are left out.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import msgspec
import numpy as np

from benchmarks.baselines import LogisticRegression
from wakeful.bridges import bridge_for
from wakeful.contracts.detector import DetectorFactory
from wakeful.contracts.domain import Domain
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.domains import load
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Event, Observation
from wakeful.facts.experience import Verdict
from wakeful.facts.lines import Admitted, AnyRecord, Concluded, Gained, Judged
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import to_s
from wakeful.journal import MemoryJournal
from wakeful.selection.features import Encoder

REFIT, BLOCK, DRAWS, BINS = 25, 20, 2000, 10
LATELY, HALF_LIFE_WINDOWS = 24, 40.0
NAMES = ("risk_prediction", "logistic_regression", "recent_rate", "base_rate")


class OnlyRisk:
    """A domain in which nothing but risk prediction may be chosen."""

    def __init__(self, domain: Domain) -> None:
        self._domain = domain
        self.spec: DomainSpec = msgspec.structs.replace(domain.spec, treatments=("risk_prediction",))

    def detectors(self) -> Mapping[str, DetectorFactory]:
        """The domain's own."""
        return self._domain.detectors()

    def simulate(self, seed: int) -> Iterator[Observation] | None:
        """The domain's own."""
        return self._domain.simulate(seed)


class Foretold(msgspec.Struct):
    """One event: everybody's probabilities over the labels, and what came."""

    shares: dict[str, np.ndarray]
    outcome: str = ""


class Reading:
    """Folds a journal's records into who foretold what and what came."""

    def __init__(self, spec: DomainSpec) -> None:
        self.labels = spec.outcome.labels
        self.told: dict[str, Foretold] = {}
        self._encoder = Encoder(spec, spec.treatments)
        self._logistic = LogisticRegression(len(self.labels))
        self._rows: dict[str, np.ndarray] = {}
        self._known: dict[int, tuple[str, int]] = {}
        self._events: dict[str, Event] = {}
        self._half_life_s = HALF_LIFE_WINDOWS * spec.outcome.within_s
        self._fitted = 0

    def apply(self, record: AnyRecord) -> None:
        """Take up one record, in the journal's order."""
        if isinstance(record, Admitted):
            row = self._rows[record.event.id] = self._encoder.encode(record.event).copy()
            self._events[record.event.id] = record.event
            counts = np.ones(len(self.labels))
            for _, label in self._known.values():
                counts[label] += 1
            self.told[record.event.id] = Foretold(
                {
                    "base_rate": counts / counts.sum(),
                    "recent_rate": self._lately(record.event),
                    "logistic_regression": self._by_logistic(row),
                }
            )
        elif isinstance(record, Concluded) and record.forecast is not None:
            told = self.told[record.event].shares
            told.setdefault("risk_prediction", np.array([record.forecast.probabilities[label] for label in self.labels]))
        elif isinstance(record, Judged) and record.verdict is not Verdict.UNDECIDED:
            self.told[record.event].outcome = self.told[record.event].outcome or record.label
        elif isinstance(record, Gained):
            self._known[record.experience.process] = (record.experience.event, self.labels.index(record.experience.outcome))
            if len(self._known) >= self._fitted + REFIT:
                self._fitted = len(self._known)
                rows = np.stack([self._rows[event] for event, _ in self._known.values()])
                self._logistic.fit(rows, np.array([label for _, label in self._known.values()]))

    def _lately(self, event: Event) -> np.ndarray:
        counts = np.full(len(self.labels), 1.0 / len(self.labels))
        alike = [(self._events[each], label) for each, label in self._known.values() if self._events[each].kind == event.kind]
        for earlier, label in sorted(alike, key=lambda pair: -pair[0].stamp.source_ns)[:LATELY]:
            age_s = max(to_s(event.stamp.source_ns - earlier.stamp.source_ns), 0.0)
            counts[label] += 0.5 ** (age_s / self._half_life_s)
        return counts / counts.sum()

    def _by_logistic(self, row: np.ndarray) -> np.ndarray:
        return self._logistic.shares(row) if self._fitted else np.full(len(self.labels), 1.0 / len(self.labels))


def read(source: Path) -> tuple[list[Foretold], tuple[str, ...]]:
    """Let a mind read the recording; returns what was foretold of each event that the world decided, and the labels."""
    domain = OnlyRisk(load("ur3_cobotops"))
    kernel, learner = assemble(domain, MindSettings())
    journal = MemoryJournal()
    driver = SimulatedDriver(kernel, journal, GuidelineReasoner(domain.spec), learner)
    bridge = bridge_for(source)
    for _ in driver.run(source.name, bridge.digest(source), lambda after: bridge.read(source, after)):
        pass
    driver.close()
    reading = Reading(domain.spec)
    for line in journal.lines():
        reading.apply(line.record)
    return [each for each in reading.told.values() if each.outcome and "risk_prediction" in each.shares], reading.labels


def scores(told: list[Foretold], labels: tuple[str, ...]) -> Iterator[dict[str, object]]:
    """The Brier score of each outcome but the quiet one, by each method, with its difference to the base rate."""
    random = np.random.default_rng(0)
    starts = random.integers(0, max(1, len(told) - BLOCK + 1), (DRAWS, -(-len(told) // BLOCK)))
    drawn = ((starts[:, :, None] + np.arange(BLOCK)).reshape(DRAWS, -1)) % len(told)
    for place, label in enumerate(labels[1:], 1):
        came = np.array([each.outcome == label for each in told], dtype=float)
        errors = {name: (np.array([each.shares[name][place] for each in told]) - came) ** 2 for name in NAMES}
        for name in NAMES:
            against = {
                other: [float(each) for each in ((errors[name] - errors[other]).mean(), *np.percentile(gap, [2.5, 97.5]))]
                for other in NAMES[1:]
                for gap in [(errors[name] - errors[other])[drawn].mean(axis=1)]
            }
            yield {
                "outcome": label,
                "method": name,
                "events": len(told),
                "came": float(came.mean()),
                "brier": float(errors[name].mean()),
                "against": against,
                "reliability": bins(np.array([each.shares[name][place] for each in told]), came),
            }


def bins(shares: np.ndarray, came: np.ndarray) -> list[dict[str, float]]:
    """The reliability diagram: of the events with a like probability, how many, the mean probability, and how many came true."""
    place = np.minimum((shares * BINS).astype(int), BINS - 1)
    return [
        {"events": int((place == b).sum()), "foretold": float(shares[place == b].mean()), "came": float(came[place == b].mean())}
        for b in range(BINS)
        if (place == b).any()
    ]


def draw(rows: list[dict[str, object]], picture: Path) -> None:
    """One reliability diagram an outcome."""
    from wakeful.experiments.plotting import new_figure, save  # noqa: PLC0415  # only where a picture is wanted

    labels = list(dict.fromkeys(str(row["outcome"]) for row in rows))
    figure, first = new_figure(4.0 * len(labels), 4.0)
    first.remove()
    for place, label in enumerate(labels, 1):
        axes = figure.add_subplot(1, len(labels), place)
        axes.plot([0, 1], [0, 1], color="0.7", linestyle="--", linewidth=1)
        for row in rows:
            if row["outcome"] == label:
                found = [each for each in row["reliability"] if each["events"] >= 5]  # type: ignore[attr-defined]
                name = f"{row['method']}: Brier {row['brier']:.3f}"
                axes.plot([each["foretold"] for each in found], [each["came"] for each in found], marker="o", label=name)
        axes.set(title=label, xlabel="foretold probability", ylabel="share that came", xlim=(0, 1), ylim=(0, 1))
        axes.legend(fontsize=7)
    for path in save(figure, picture.with_suffix("")):
        if path.suffix != picture.suffix:  # only the kind that was asked for is kept
            path.unlink()


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("source", type=Path)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--picture", type=Path)
    asked = parser.parse_args()
    told, labels = read(asked.source)
    later = told[len(told) // 2 :]
    rows = list(scores(later, labels))
    if asked.picture is not None:
        draw(rows, asked.picture)
    if asked.json:
        print(json.dumps(rows, indent=2))
        return
    print(f"{len(told)} events decided by the world, the later {len(later)} scored")
    print(
        f"{'outcome':15} {'method':19} {'came':>6} {'Brier':>7} {'against logistic (95 %)':>29} "
        f"{'against recent rate (95 %)':>29} {'against base rate (95 %)':>29}"
    )
    for row in rows:
        gaps = [
            f"{gap:+.4f} ({low:+.4f} to {high:+.4f})" if row["method"] != other else ""
            for other, (gap, low, high) in row["against"].items()  # type: ignore[attr-defined]
        ]
        print(
            f"{row['outcome']:15} {row['method']:19} {100 * row['came']:5.1f}% {row['brier']:7.4f} "  # type: ignore[operator]
            f"{' '.join(f'{gap:>29}' for gap in gaps)}".rstrip()
        )


if __name__ == "__main__":
    main()
