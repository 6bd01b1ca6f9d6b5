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
the later cases whose true fault is the first, or among the first three; the interval is 95 % over shuffles (t) or Wilson's.
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

Case = tuple[Mapping[str, float], str]
Ranks = Callable[[Sequence[Case], Sequence[Case]], list[list[str]]]


def traces(path: Path) -> Iterator[Case]:
    """The traces of one learning problem."""
    for block in path.read_text().split("\n\n"):
        rows = block.strip().splitlines()
        if len(rows) == 16:
            values = np.array([[float(cell) for cell in row.split()] for row in rows[1:]])
            yield _numbers(values, CHANNELS), rows[0].strip()


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
                (earlier if place < half else later).extend((case, fault) for case in _minutes(path))
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


def by_diagnosis(earlier: Sequence[Case], later: Sequence[Case]) -> list[list[str]]:
    """The treatment's suspects, in its order."""
    domain = DomainSpec(
        name="recorded", version=1, says="learned from earlier cases", fault=learn_faults(earlier), one_fault=True
    )
    ranked = []
    for number, (values, _) in enumerate(later):
        event = Event(
            id=str(number),
            kind="failure",
            entity="arm",
            source="s",
            position=number,
            stamp=Stamp(source_ns=0),
            fields=dict(values),
        )
        result = ScriptedMind(domain, "auto").run(diagnosis, event)
        assert isinstance(result, Diagnosis)
        by_share = sorted(result.suspects, key=lambda each: -each.posterior)
        ranked.append([each.fault for each in by_share])
    return ranked


def by_model(model: object) -> Ranks:
    """A scikit-learn classifier's classes by probability."""

    def rank(earlier: Sequence[Case], later: Sequence[Case]) -> list[list[str]]:
        names = sorted(earlier[0][0])
        x, z = (np.array([[values[name] for name in names] for values, _ in part]) for part in (earlier, later))
        model.fit(x, [fault for _, fault in earlier])  # type: ignore[attr-defined]
        shares = model.predict_proba(z)  # type: ignore[attr-defined]
        return [[model.classes_[place] for place in np.argsort(-row, kind="stable")] for row in shares]  # type: ignore[attr-defined]

    return rank


def by_share(earlier: Sequence[Case], later: Sequence[Case]) -> list[list[str]]:
    """The most frequent faults, whatever is seen."""
    names = [fault for _, fault in earlier]
    ranked = sorted(sorted(set(names)), key=lambda name: -names.count(name))
    return [ranked] * len(later)


def methods() -> dict[str, Ranks]:
    """Who is asked."""
    return {
        "diagnosis": by_diagnosis,
        "naive_bayes": by_model(GaussianNB()),
        "random_forest": by_model(RandomForestClassifier(n_estimators=200, random_state=0, n_jobs=1)),
        "most_frequent": by_share,
    }


def top(ranked: Sequence[Sequence[str]], later: Sequence[Case], count: int) -> float:
    """The share of the cases whose fault is among the first ``count``."""
    return mean(fault in ranks[:count] for ranks, (_, fault) in zip(ranked, later, strict=True))


def rows(root: Path) -> Iterator[dict[str, object]]:
    """Every figure of both recordings."""
    for problem in ("lp1", "lp2", "lp3", "lp4", "lp5"):
        cases = list(traces(root / "uci_robot_execution_failures" / f"{problem}.data"))
        found: dict[str, list[tuple[float, float]]] = {}
        for seed in range(SHUFFLES):
            shuffled = Random(seed).sample(cases, len(cases))
            earlier, later = shuffled[: len(cases) // 2], shuffled[len(cases) // 2 :]
            for name, rank in methods().items():
                ranked = rank(earlier, later)
                found.setdefault(name, []).append((top(ranked, later, 1), top(ranked, later, 3)))
        for name, shares in found.items():
            yield {
                "recording": f"uci {problem}",
                "method": name,
                "faults": len({fault for _, fault in cases}),
                "earlier": len(cases) // 2,
                "later": len(cases) - len(cases) // 2,
                **_interval("top1", [one for one, _ in shares]),
                **_interval("top3", [three for _, three in shares]),
            }
    earlier, later, left = pump(root / "skab")
    for name, rank in methods().items():
        ranked = rank(earlier, later)
        yield {
            "recording": "skab",
            "method": name,
            "faults": len({fault for _, fault in earlier}),
            "left_out": left,
            "earlier": len(earlier),
            "later": len(later),
            **_wilson("top1", top(ranked, later, 1), len(later)),
            **_wilson("top3", top(ranked, later, 3), len(later)),
        }


def _interval(name: str, shares: Sequence[float]) -> dict[str, float]:
    half = 2.262 * stdev(shares) / sqrt(len(shares))  # t with 9 degrees of freedom
    return {name: mean(shares), f"{name}_low": mean(shares) - half, f"{name}_high": mean(shares) + half}


def _wilson(name: str, share: float, of: int) -> dict[str, float]:
    z = 1.959964
    middle, spread = share + z * z / (2 * of), z * sqrt(share * (1 - share) / of + z * z / (4 * of * of))
    scale = 1 + z * z / of
    return {name: share, f"{name}_low": (middle - spread) / scale, f"{name}_high": (middle + spread) / scale}


def main() -> None:
    """Print the table."""
    paths = [argument for argument in sys.argv[1:] if not argument.startswith("-")]
    found = list(rows(Path(paths[0] if paths else "../shared/data")))
    if "--json" in sys.argv:
        print(json.dumps(found, indent=2))
        return
    print(f"{'recording':10} {'method':14} {'faults':>6} {'earlier':>7} {'later':>5}  {'top-1 (95 %)':>20} {'top-3 (95 %)':>20}")
    for row in found:
        cells = [f"{100 * row[n]:5.1f} ({100 * row[f'{n}_low']:.1f}–{100 * row[f'{n}_high']:.1f})" for n in ("top1", "top3")]
        print(
            f"{row['recording']:10} {row['method']:14} {row['faults']:>6} {row['earlier']:>7} {row['later']:>5}  "
            f"{cells[0]:>20} {cells[1]:>20}"
        )
    out = next((row["left_out"] for row in found if row.get("left_out")), [])
    print(
        f"left out of skab, one file only: {', '.join(out) or 'none'}; median files a fault: {median([17, 5, 4, 5, 2, 2, 1]):g}"
    )


if __name__ == "__main__":
    main()
