"""Diagnosis on recordings whose fault is known, beside naive Bayes and a random forest trained on the same earlier cases.

Run: `./run python -m benchmarks.diagnosis ../shared/data [--json]` (scikit-learn: the group `bench`). Two recordings:

- `uci_robot_execution_failures`: force/torque traces after a failure of a real assembly robot, five learning problems. A case is
  one trace as numbers (of each of six channels mean, spread, least, most, slope, last minus first). The order of the cases in the
  files goes by class, so "earlier" is a seeded shuffle's first half; 10 shuffles.
- `skab`: a water-pump rig, one fault a file. A case is a minute of sensor values in the labelled anomaly, as its distance from
  the same file's quiet beginning in robust deviations. Earlier: the first half of each fault's files; later: the others. Faults
  with one file only are left out.

The fault table is learned from the earlier cases (`wakeful.treatments.fault_table`), put into a domain, and the treatment
`diagnosis` itself is asked, in auto mode, with an empty memory: its suspects in their order. Top-1 and top-3 are shares of
the later cases whose true fault is the first, or among the first three; the interval is 95 %, over shuffles (t), or for skab by
resampling the later files (2,000 times, seed 0), since the minutes of one file are no cases of their own. Then: by how much
diagnosis is ahead of the method in top-1, paired over the same shuffles or files; `alike`, top-1 where each fault weighs alike;
`log`, the mean logarithm of the probability that the true fault was given (nearer to 0 is better, certain errors cost most).
"""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from math import sqrt
from pathlib import Path
from random import Random
from statistics import mean, median, stdev
from typing import NamedTuple

import numpy as np
from sklearn.ensemble import RandomForestClassifier
from sklearn.naive_bayes import GaussianNB

from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Event
from wakeful.facts.time import Stamp
from wakeful.testing import ScriptedMind
from wakeful.treatments.diagnosis import Diagnosis, diagnosis
from wakeful.treatments.fault_table import learn_faults

SHUFFLES = 10
CHANNELS = ("force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z")
WINDOW, QUIET = 60, 300

#: So little a probability counts as, so that one certain error does not decide a mean of logarithms.
LEAST = 1e-6

#: What each method says of each later case: the probability of each fault.
Said = list[dict[str, float]]


class Case(NamedTuple):
    """What was measured, the fault that it was, and the run that it comes from."""

    values: Mapping[str, float]
    fault: str
    run: str = ""


Method = Callable[[Sequence[Case], Sequence[Case]], Said]


def traces(path: Path) -> Iterator[Case]:
    """The traces of one learning problem."""
    for block in path.read_text().split("\n\n"):
        rows = block.strip().splitlines()
        if len(rows) == 16:
            values = np.array([[float(cell) for cell in row.split()] for row in rows[1:]])
            yield Case(_numbers(values, CHANNELS), rows[0].strip())


def _numbers(values: np.ndarray, names: Sequence[str]) -> dict[str, float]:
    at = np.arange(len(values)) - (len(values) - 1) / 2
    found: dict[str, float] = {}
    for place, name in enumerate(names):
        channel = values[:, place]
        found |= {
            f"{name}_mean": float(channel.mean()),
            f"{name}_spread": float(channel.std()),
            f"{name}_least": float(channel.min()),
            f"{name}_most": float(channel.max()),
            f"{name}_slope": float(at @ channel / (at @ at)),
            f"{name}_change": float(channel[-1] - channel[0]),
        }
    return {name: float(f"{value:.6g}") for name, value in found.items()}


def pump(root: Path) -> tuple[list[Case], list[Case], list[str]]:
    """Minutes of the rig: earlier cases, later cases, and the faults that were left out."""
    files: dict[str, list[Path]] = {
        "inlet valve closes": _numbered(root / "valve1", range(17)),
        "outlet valve closes": _numbered(root / "valve2", range(5)),
        "leak or addition": _numbered(root / "other", range(1, 5)),
        "rotor imbalance": _numbered(root / "other", range(5, 10)),
        "too much water": _numbered(root / "other", range(10, 12)),
        "cavitation": _numbered(root / "other", range(12, 14)),
        "hot water": _numbered(root / "other", range(14, 15)),
    }
    earlier: list[Case] = []
    later: list[Case] = []
    for fault, paths in files.items():
        half = len(paths) // 2
        for place, path in enumerate(paths):
            if len(paths) > 1:
                (earlier if place < half else later).extend(Case(values, fault, str(path)) for values in _minutes(path))
    return earlier, later, [fault for fault, paths in files.items() if len(paths) < 2]


def _numbered(folder: Path, numbers: range) -> list[Path]:
    return [folder / f"{number}.csv" for number in numbers if (folder / f"{number}.csv").is_file()]


def _minutes(path: Path) -> Iterator[dict[str, float]]:
    with path.open() as file:
        rows = list(csv.DictReader(file, delimiter=";"))
    names = [name for name in rows[0] if name not in ("datetime", "anomaly", "changepoint")]
    values = np.array([[float(row[name]) for name in names] for row in rows])
    odd = np.array([float(row["anomaly"]) for row in rows]) > 0
    quiet = values[:QUIET][~odd[:QUIET]]
    middle = np.median(quiet, axis=0)
    spread = 1.4826 * np.median(np.abs(quiet - middle), axis=0) + 1e-3 * (1.0 + np.abs(middle))
    short = [name.lower().replace(" ", "_") for name in names]
    for start in range(0, len(values) - WINDOW + 1, WINDOW):
        if odd[start : start + WINDOW].mean() > 0.9:
            yield _numbers((values[start : start + WINDOW] - middle) / spread, short)


def by_diagnosis(earlier: Sequence[Case], later: Sequence[Case]) -> Said:
    """The treatment's suspects with their posteriors."""
    runs = [case.run for case in earlier] if earlier[0].run else ()
    table = learn_faults([(case.values, case.fault) for case in earlier], runs)
    domain = DomainSpec(name="recorded", version=1, says="learned from earlier cases", fault=table, one_fault=True)
    said = []
    for number, case in enumerate(later):
        event = Event(
            id=str(number),
            kind="failure",
            entity="arm",
            source="s",
            position=number,
            stamp=Stamp(source_ns=0),
            fields=dict(case.values),
        )
        result = ScriptedMind(domain, "auto").run(diagnosis, event)
        assert isinstance(result, Diagnosis)
        said.append({each.fault: each.posterior for each in result.suspects})
    return said


def by_model(model: object) -> Method:
    """A scikit-learn classifier's probabilities."""

    def say(earlier: Sequence[Case], later: Sequence[Case]) -> Said:
        """Fit it to the earlier cases; what it says of the later ones."""
        names = sorted(earlier[0].values)
        x, z = (np.array([[case.values[name] for name in names] for case in part]) for part in (earlier, later))
        model.fit(x, [case.fault for case in earlier])  # type: ignore[attr-defined]
        return [dict(zip(model.classes_, row, strict=True)) for row in model.predict_proba(z)]  # type: ignore[attr-defined]

    return say


def by_share(earlier: Sequence[Case], later: Sequence[Case]) -> Said:
    """How frequent each fault was, whatever is seen."""
    names = [case.fault for case in earlier]
    return [{name: names.count(name) / len(names) for name in sorted(set(names))}] * len(later)


def methods() -> dict[str, Method]:
    """Who is asked."""
    return {
        "diagnosis": by_diagnosis,
        "naive_bayes": by_model(GaussianNB()),
        "random_forest": by_model(RandomForestClassifier(n_estimators=200, random_state=0, n_jobs=1)),
        "most_frequent": by_share,
    }


class Scored(NamedTuple):
    """Of each later case whether its fault was the first, whether among the first three, and how likely it was said to be."""

    first: np.ndarray
    three: np.ndarray
    log: np.ndarray


def scored(said: Said, later: Sequence[Case]) -> Scored:
    """What was said, against what it was."""
    ranked = [sorted(shares, key=lambda fault: (-shares[fault], fault)) for shares in said]
    pairs = list(zip(ranked, later, strict=True))
    chances = [shares.get(case.fault, 0.0) for shares, case in zip(said, later, strict=True)]
    return Scored(
        np.array([case.fault in ranks[:1] for ranks, case in pairs], dtype=float),
        np.array([case.fault in ranks[:3] for ranks, case in pairs], dtype=float),
        np.log(np.maximum(chances, LEAST)),
    )


def alike(first: np.ndarray, later: Sequence[Case]) -> float:
    """Top-1 where each fault weighs the same, however many of the cases are of it."""
    faults = sorted({case.fault for case in later})
    return mean(float(first[[case.fault == fault for case in later]].mean()) for fault in faults)


def rows(root: Path) -> Iterator[dict[str, object]]:
    """Every figure of both recordings."""
    for problem in ("lp1", "lp2", "lp3", "lp4", "lp5"):
        cases = list(traces(root / "uci_robot_execution_failures" / f"{problem}.data"))
        found: dict[str, list[Scored]] = {}
        even: dict[str, list[float]] = {}
        for seed in range(SHUFFLES):
            shuffled = Random(seed).sample(cases, len(cases))
            earlier, later = shuffled[: len(cases) // 2], shuffled[len(cases) // 2 :]
            for name, method in methods().items():
                score = scored(method(earlier, later), later)
                found.setdefault(name, []).append(score)
                even.setdefault(name, []).append(alike(score.first, later))
        for name, scores in found.items():
            firsts = [float(each.first.mean()) for each in scores]
            yield {
                "recording": f"uci {problem}",
                "method": name,
                "faults": len({case.fault for case in cases}),
                "earlier": len(cases) // 2,
                "later": len(cases) - len(cases) // 2,
                **_interval("top1", firsts),
                **_interval("top3", [float(each.three.mean()) for each in scores]),
                **_interval("ahead", [float(o.first.mean()) - f for o, f in zip(found["diagnosis"], firsts, strict=True)]),
                "alike": mean(even[name]),
                "log": mean(float(each.log.mean()) for each in scores),
            }
    earlier, later, left = pump(root / "skab")
    told = {name: scored(method(earlier, later), later) for name, method in methods().items()}
    files = [case.run for case in later]
    for name, score in told.items():
        yield {
            "recording": "skab",
            "method": name,
            "faults": len({case.fault for case in earlier}),
            "left_out": left,
            "earlier": len(earlier),
            "later": len(later),
            **_resampled("top1", score.first, files),
            **_resampled("top3", score.three, files),
            **_resampled("ahead", told["diagnosis"].first - score.first, files),
            "alike": alike(score.first, later),
            "log": float(score.log.mean()),
        }


def _interval(name: str, shares: Sequence[float]) -> dict[str, float]:
    half = 2.262 * stdev(shares) / sqrt(len(shares))  # t with 9 degrees of freedom
    return {name: mean(shares), f"{name}_low": mean(shares) - half, f"{name}_high": mean(shares) + half}


def _resampled(name: str, hits: np.ndarray, of_file: Sequence[str]) -> dict[str, float]:
    files = sorted(set(of_file))
    sums = np.array([sum(hit for hit, file in zip(hits, of_file, strict=True) if file == each) for each in files])
    counts = np.array([of_file.count(each) for each in files])
    drawn = np.random.default_rng(0).integers(0, len(files), (2000, len(files)))
    low, high = np.percentile(sums[drawn].sum(axis=1) / counts[drawn].sum(axis=1), [2.5, 97.5])
    return {name: float(hits.mean()), f"{name}_low": float(low), f"{name}_high": float(high)}


def main() -> None:
    """Print the table."""
    paths = [argument for argument in sys.argv[1:] if not argument.startswith("-")]
    found = list(rows(Path(paths[0] if paths else "../shared/data")))
    if "--json" in sys.argv:
        print(json.dumps(found, indent=2))
        return
    titles = f"{'top-1 (95 %)':>19} {'top-3 (95 %)':>20} {'diagnosis ahead':>23} {'alike':>6} {'log':>6}"
    print(f"{'recording':9} {'method':14} {'earlier':>7} {'later':>5} {titles}")
    for row in found:
        first, three, ahead = ([100 * row[f"{name}{end}"] for end in ("", "_low", "_high")] for name in ("top1", "top3", "ahead"))  # type: ignore[operator]
        cells = [f"{at:5.1f} ({low:.1f}–{min(high, 100.0):.1f})" for at, low, high in (first, three)]
        cells += [f"{ahead[0]:+.1f} ({ahead[1]:+.1f} to {ahead[2]:+.1f})" if row["method"] != "diagnosis" else ""]
        print(
            f"{row['recording']:9} {row['method']:14} {row['earlier']:>7} {row['later']:>5} "
            f"{cells[0]:>19} {cells[1]:>20} {cells[2]:>23} {100 * row['alike']:6.1f} {row['log']:6.2f}"  # type: ignore[operator]
        )
    out = next((row["left_out"] for row in found if row.get("left_out")), [])
    print(
        f"left out of skab, one file only: {', '.join(out) or 'none'}; median files a fault: {median([17, 5, 4, 5, 2, 2, 1]):g}"
    )


if __name__ == "__main__":
    main()
