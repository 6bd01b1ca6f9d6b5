"""A fault table from labelled cases: which bounds on which fields tell the faults apart, and how often each fault shows them.

What it writes is an ordinary table of a domain, for a person to read and correct: ``force_z_mean>42.5``, not weights.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from wakeful.facts.domain import Fault

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

#: Bounds that are tried of each field: these quantiles of what was seen.
QUANTILES = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95)


def learn_faults(cases: Sequence[tuple[Mapping[str, float], str]], symptoms: int = 40, bounds: int = 3) -> tuple[Fault, ...]:
    """A table for exactly one fault at a time (``one_fault = true``).

    Args:
        cases: the numeric fields of each case, and which fault it was.
        symptoms: at most so many, those with the most mutual information with the fault.
        bounds: at most so many bounds of one field.

    Returns:
        one row for each fault that was seen, in the order of their names, with its share as the prior and the share of its cases
        that show each symptom, each with one case added to both sides (Laplace).

    Raises:
        ValueError: there is no case.
    """
    if not cases:
        raise ValueError("a fault table is learned from labelled cases; there are none")
    names = sorted({name for _, name in cases})
    label = np.array([names.index(name) for _, name in cases])
    shown: dict[str, Flags] = {}
    ranked: list[tuple[float, str]] = []
    for field in sorted({field for values, _ in cases for field in values}):
        tried = _bounds(field, np.array([values.get(field, np.nan) for values, _ in cases]))
        best = sorted((-round(_information(shows, label, len(names)), 9), symptom) for symptom, shows in tried.items())[:bounds]
        shown |= {symptom: tried[symptom] for _, symptom in best}
        ranked += best
    chosen = [symptom for _, symptom in sorted(ranked)[:symptoms]]
    count = np.bincount(label, minlength=len(names))
    rows = []
    for place, name in enumerate(names):
        own = label == place
        causes = {symptom: round((float(shown[symptom][own].sum()) + 1.0) / (float(count[place]) + 2.0), 4) for symptom in chosen}
        rows.append(Fault(name=name, prior=round(float(count[place]) / len(cases), 6), causes=causes))
    return tuple(rows)


def _bounds(field: str, values: Floats) -> dict[str, Flags]:
    """Which cases show ``field>bound``, for each bound that some cases pass and others don't."""
    known = ~np.isnan(values)
    if known.sum() < 2:
        return {}
    bounds = dict.fromkeys(float(f"{each:.6g}") for each in np.quantile(values[known], QUANTILES))
    found = {f"{field}>{bound:g}": known & (values > bound) for bound in bounds}
    return {symptom: shows for symptom, shows in found.items() if 0 < shows.sum() < len(values)}


def _information(shown: Flags, label: NDArray[np.int64], faults: int) -> float:
    whole = _entropy(np.bincount(label, minlength=faults))
    parts = ((shown, float(shown.mean())), (~shown, 1.0 - float(shown.mean())))
    return whole - sum(share * _entropy(np.bincount(label[part], minlength=faults)) for part, share in parts)


def _entropy(counts: NDArray[np.int64]) -> float:
    shares = counts[counts > 0] / counts.sum()
    return float(-(shares * np.log2(shares)).sum())
