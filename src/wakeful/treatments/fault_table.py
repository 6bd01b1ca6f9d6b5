"""A fault table from labelled cases: which bounds on which fields tell the faults apart, and how often each fault passes them.

What it writes is an ordinary table of a domain, for a person to read and correct: ``force_z_mean>42.5``, not weights.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import log2
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from wakeful.facts.domain import Fault

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]


#: By how much of what a field tells a learned table may go by; the share that held-back cases are likeliest under is taken.
SHARES = (1.0, 0.7, 0.5, 0.35, 0.25, 0.18, 0.12, 0.06, 0.03)
FOLDS = 5
#: What a fault that was given less than this share is taken to have been given: one surprise must not outweigh all else.
LEAST = 1e-6


class _Field(NamedTuple):
    """One field's bounds, the share of all cases in each interval between them, and of each fault's own."""

    bounds: tuple[float, ...]
    everybody: Floats
    own: Floats

    def drawn(self, share: float) -> Floats:
        """Each fault's own shares, drawn towards everybody's; shape (faults, intervals)."""
        mixed = self.own**share * self.everybody ** (1.0 - share)
        return np.asarray(mixed / mixed.sum(axis=1, keepdims=True))


def learn_faults(
    cases: Sequence[tuple[Mapping[str, float], str]], runs: Sequence[str] = (), smoothing: float = 1.0
) -> tuple[Fault, ...]:
    """A table for exactly one fault at a time (``one_fault = true``).

    Each field is cut where that shortens the description of the cases' faults, and again on either side while it does; a field
    that is worth no cut stands in no row. Where none is, as with few cases, each field's best single cut stands. Fields are
    read as if each were news, though many come of one another: so all rows are drawn towards what all cases show, by as much
    as makes held-back cases likeliest, and the posterior is about as sure as it has reason to be.
    Source: minimum description length, Fayyad and Irani 1993; tempered likelihoods, Grünwald 2012 (safe Bayes).

    Args:
        cases: the numeric fields of each case, and which fault it was.
        runs: the run that each case comes from, where several come from one: they are held back together.
        smoothing: how many cases each interval of a field is given beforehand, by its share of all cases: what a fault was not
            seen to do in few cases is unlikely, not impossible.

    Returns:
        one row for each fault that was seen, in the order of their names, with its share as the prior and the share of its cases
        beyond each bound.

    Raises:
        ValueError: there is no case.
    """
    if not cases:
        raise ValueError("a fault table is learned from labelled cases; there are none")
    names = sorted({name for _, name in cases})
    label = np.array([names.index(name) for _, name in cases])
    seen = {
        field: np.array([values.get(field, np.nan) for values, _ in cases]) for field in sorted({f for v, _ in cases for f in v})
    }
    share = _share(seen, label, list(runs) or [str(place) for place in range(len(cases))], smoothing)
    prior = np.bincount(label, minlength=len(names)) / len(cases)
    causes: list[dict[str, float]] = [{} for _ in names]
    for name, field in _learned(seen, label, len(names), smoothing).items():
        beyond = np.cumsum(field.drawn(share)[:, ::-1], axis=1)[:, ::-1][:, 1:]
        for row, shares in zip(causes, beyond, strict=True):
            row |= {f"{name}>{bound:g}": round(float(each), 4) for bound, each in zip(field.bounds, shares, strict=True)}
    return tuple(Fault(name=n, prior=round(float(p), 6), causes=row) for n, p, row in zip(names, prior, causes, strict=True))


def _learned(seen: Mapping[str, Floats], label: Counts, faults: int, smoothing: float) -> dict[str, _Field]:
    """The fields that are worth a cut; where there is none, each with its best one."""
    cuts = {name: _cuts(values, label) for name, values in seen.items()}
    if not any(cuts.values()):
        cuts = {name: _cuts(values, label, deep=False) for name, values in seen.items()}
    return {name: _counted(seen[name], bounds, label, faults, smoothing) for name, bounds in cuts.items() if bounds}


def _counted(values: Floats, bounds: tuple[float, ...], label: Counts, faults: int, smoothing: float) -> _Field:
    known = ~np.isnan(values)
    place, of = np.searchsorted(bounds, values[known]), label[known]
    many = len(bounds) + 1
    everybody = np.bincount(place, minlength=many) / len(place)
    own = np.array([np.bincount(place[of == fault], minlength=many) for fault in range(faults)]) + smoothing * many * everybody
    return _Field(bounds, everybody, np.asarray(own / own.sum(axis=1, keepdims=True)))


def _share(seen: Mapping[str, Floats], label: Counts, runs: Sequence[str], smoothing: float) -> float:
    """Under which of SHARES cases that were held back, run by run, are likeliest; 1 where nothing can be held back."""
    by_fault = dict(
        sorted({run: (int(fault), run) for run, fault in zip(runs, label, strict=True)}.items(), key=lambda each: each[1])
    )
    fold_of = {run: place % FOLDS for place, run in enumerate(by_fault)}
    fold = np.array([fold_of[run] for run in runs])
    told = np.zeros(len(SHARES))
    for held in range(FOLDS):
        kept, back = fold != held, fold == held
        back &= np.isin(label, label[kept])
        if not back.any():
            continue
        names = np.unique(label[kept])
        own = np.searchsorted(names, label[kept])
        fields = _learned({name: values[kept] for name, values in seen.items()}, own, len(names), smoothing)
        right = np.searchsorted(names, label[back])
        for place, share in enumerate(SHARES):
            logs = np.tile(np.log(np.bincount(own) / len(own)), (int(back.sum()), 1))
            for name, field in fields.items():
                at = seen[name][back]
                logs += np.where(
                    np.isnan(at), 0.0, np.log(field.drawn(share))[:, np.searchsorted(field.bounds, at) % len(field.everybody)]
                ).T
            shares = np.exp(logs - logs.max(axis=1, keepdims=True))
            shares /= shares.sum(axis=1, keepdims=True)
            told[place] += np.log(np.maximum(shares[np.arange(len(right)), right], LEAST)).sum()
    return SHARES[int(np.argmax(np.round(told, 9)))]


def _cuts(values: Floats, label: Counts, deep: bool = True) -> tuple[float, ...]:
    """The bounds of one field, rising and to six digits."""
    known = ~np.isnan(values)
    order = np.argsort(values[known], kind="stable")
    found = _split(values[known][order], label[known][order], deep)
    return tuple(sorted({float(f"{bound:.6g}") for bound in found}))


def _split(values: Floats, label: Counts, deep: bool) -> list[float]:
    """Where to cut these sorted values, if a cut pays for itself; ``deep`` False: the best one, whether it pays or not."""
    count = len(values)
    apart = np.flatnonzero(values[1:] > values[:-1]) + 1
    if not len(apart):
        return []
    before = np.cumsum(label[:, None] == np.unique(label)[None, :], axis=0)
    whole, left = before[-1], before[apart - 1]
    right = whole - left
    inside = (apart * _entropy(left) + (count - apart) * _entropy(right)) / count
    best = int(np.argmin(inside))
    place = int(apart[best])
    bound = float((values[place - 1] + values[place]) / 2.0)
    if not deep:
        return [bound]
    entropy = float(_entropy(whole[None, :])[0])
    kinds = [int((part > 0).sum()) for part in (whole, left[best], right[best])]
    parts = [float(_entropy(part[None, :])[0]) for part in (left[best], right[best])]
    price = log2(3.0 ** kinds[0] - 2.0) - (kinds[0] * entropy - kinds[1] * parts[0] - kinds[2] * parts[1])
    if entropy - float(inside[best]) <= (log2(count - 1.0) + price) / count:
        return []
    return [*_split(values[:place], label[:place], deep), bound, *_split(values[place:], label[place:], deep)]


def _entropy(counts: Counts) -> Floats:
    """The entropy in bits of each row of counts."""
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    return -np.asarray((shares * np.log2(np.where(shares > 0.0, shares, 1.0))).sum(axis=1))
