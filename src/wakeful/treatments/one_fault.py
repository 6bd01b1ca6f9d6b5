"""Exact inference where exactly one of the table's faults is there, or none: a small Bayesian model with one hidden variable.

Given the fault, fields are independent: P(symptom | fault) is what the table says, or the leak where it says nothing. Bounds on
one and the same field (``load>0.3``, ``load>0.7``, ``load<0.1``) are read as what they are, its distribution: between two of them
lies a share of its own, so that three bounds passed are one finding and not three. Any number of findings costs the same.
Source: Pearl, *Probabilistic Reasoning in Intelligent Systems* (1988), Section 2.3.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import fmean
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from wakeful.facts.domain import DomainSpec, Fault
from wakeful.treatments.noisy_or import Findings, Network
from wakeful.treatments.symptoms import split

Floats = NDArray[np.float64]

#: No finding is ruled out by a fault, and none is certain: a table is never that sure.
LEAST = 1e-4


class _Bound(NamedTuple):
    """One symptom among those of its field: where it cuts the field, and P(beyond the cut | fault) of each fault and of none."""

    symptom: str
    at: tuple[float, bool]
    """The number, and whether the number itself lies below the cut."""
    below: bool
    """Whether the symptom is that the field is not beyond."""
    beyond: Floats


class OneFault(Network):
    """The same questions as a noisy-OR network answers, over mutually exclusive faults.

    Args:
        faults: n rows of a domain's fault table; their priors sum to 1 at most, what is left is that none of them is there.
        leak: P(symptom | no fault of the table), and of any fault that does not name it.
    """

    def __init__(self, faults: Sequence[Fault], leak: float = 0.02) -> None:
        super().__init__(faults, leak)
        priors = np.array([max(fault.prior, 0.0) for fault in faults])
        total = float(priors.sum())
        priors = priors / total if total > 1.0 else priors
        self._weights = np.append(priors, max(1.0 - float(priors.sum()), 0.0))
        self._leak = leak
        grouped: dict[str, list[_Bound]] = {}
        for symptom in self.symptoms:
            shows = np.array([*(fault.causes.get(symptom, leak) for fault in faults), leak])
            group, at, below = _place(symptom)
            shows = np.clip(shows, LEAST, 1.0 - LEAST)
            grouped.setdefault(group, []).append(_Bound(symptom, at, below, 1.0 - shows if below else shows))
        self._bounds = {group: _distribution(bounds) for group, bounds in grouped.items()}
        self._group = {bound.symptom: group for group, bounds in self._bounds.items() for bound in bounds}

    def suspecting(self, name: str, odds: float) -> OneFault:
        """The same model where the odds of one fault are so many times as high: what it gains the others lose."""
        shares = self._weights[:-1] * [odds if fault.name == name else 1.0 for fault in self.faults]
        whole = float(shares.sum() + self._weights[-1])
        faults = [replace(fault, prior=float(share) / whole) for fault, share in zip(self.faults, shares, strict=True)]
        return OneFault(faults, self._leak)

    def posterior(self, findings: Findings) -> dict[str, float]:
        """P(it is this fault | findings) of each fault."""
        shares = self._given(findings)
        return {fault.name: float(share) for fault, share in zip(self.faults, shares[:-1], strict=True)}

    def unexplained(self, findings: Findings) -> float:
        """P(none of the faults is there | findings)."""
        return float(self._given(findings)[-1])

    def look_for(self, symptoms: Sequence[str], findings: Findings) -> dict[str, tuple[float, float]]:
        """What looking for each unknown symptom is worth: P(it would be seen), and what that tells of the fault in bits."""
        now = self._given(findings)
        found: dict[str, tuple[float, float]] = {}
        for symptom in symptoms:
            group = self._group[symptom]
            # of what is known of its field already, the part in which it is seen, and the part in which it is not
            parts = [self._share(group, {**findings, symptom: there}) for there in (True, False)]
            seen, missing = (now * part / (parts[0] + parts[1]) for part in parts)
            chance = float(seen.sum())
            gain = _entropy(now)
            gain -= chance * _entropy(seen / chance) if chance > 0.0 else 0.0
            gain -= (1.0 - chance) * _entropy(missing / (1.0 - chance)) if chance < 1.0 else 0.0
            found[symptom] = (chance, max(gain, 0.0))
        return found

    def _given(self, findings: Findings) -> Floats:
        with np.errstate(divide="ignore"):
            log = np.log(self._weights)
        for group in dict.fromkeys(self._group[symptom] for symptom in findings if symptom in self._group):
            log = log + np.log(self._share(group, findings))
        shares: Floats = np.exp(log - log.max())
        return np.asarray(shares / shares.sum())

    def _share(self, group: str, findings: Mapping[str, bool]) -> Floats:
        """P(what is known of one field | fault): what lies beyond the last bound that is passed, less what lies beyond the first
        that is not. Bounds that contradict one another leave next to nothing.
        """
        passed = np.ones(len(self._weights))
        not_passed: Floats | None = None
        for bound in self._bounds[group]:
            seen = findings.get(bound.symptom)
            there = None if seen is None else seen != bound.below
            if there and not_passed is not None:
                return np.full(len(self._weights), LEAST)
            if there:
                passed = bound.beyond
            elif there is False and not_passed is None:
                not_passed = bound.beyond
        return np.clip(passed if not_passed is None else passed - not_passed, LEAST, 1.0)


def network_of(domain: DomainSpec, leak: float) -> Network:
    """The domain's fault model: independent faults (noisy-OR), or exactly one of them where the domain says so."""
    return OneFault(domain.fault, leak) if domain.one_fault else Network(domain.fault, leak)


def _place(symptom: str) -> tuple[str, tuple[float, bool], bool]:
    """Whose distribution a symptom belongs to, where it cuts it, whether it is what lies below. No bound: a group of its own."""
    name, sign, value = split(symptom) or (symptom, "=", "")
    try:
        at = float(value)
    except ValueError:
        return symptom, (0.0, False), False
    if sign not in (">", ">=", "<", "<="):
        return symptom, (0.0, False), False
    # the number itself lies below the cut of "> 5" and "<= 5", and beyond that of ">= 5" and "< 5"
    return f"{name}<>", (at, sign in (">", "<=")), sign in ("<", "<=")


def _distribution(bounds: Sequence[_Bound]) -> tuple[_Bound, ...]:
    """A field's bounds in rising order, none less likely to be passed than one beyond it.

    Where bounds from above and from below contradict each other (``x>3`` and ``x<5``, both of them rare, though every number is
    one of the two), the nearest distribution is taken.
    """
    upward = _falling([bound for bound in bounds if not bound.below])
    downward = _falling([bound for bound in bounds if bound.below])
    ordered = sorted((*upward, *downward), key=lambda bound: (bound.at, bound.symptom))
    if not upward or not downward:
        return tuple(ordered)
    shares = np.stack([bound.beyond for bound in ordered])
    nearest = np.stack([_nearest_falling(column) for column in shares.T], axis=1)
    return tuple(bound._replace(beyond=beyond) for bound, beyond in zip(ordered, nearest, strict=True))


def _falling(bounds: Sequence[_Bound]) -> list[_Bound]:
    """Bounds of one direction: who is past the second is past the first, whatever the table says of the first."""
    found: list[_Bound] = []
    rising = sorted(bounds, key=lambda each: (each.at, each.symptom))
    # the rarest first: of bounds from above the lowest, of the others the highest
    for bound in rising if bounds and bounds[0].below else reversed(rising):
        reached = found[-1].beyond if found else bound.beyond
        beyond = np.minimum(bound.beyond, reached) if bound.below else np.maximum(bound.beyond, reached)
        found.append(bound._replace(beyond=beyond))
    return found


def _nearest_falling(shares: Floats) -> Floats:
    """The falling sequence at the least squared distance: neighbours that rise get their mean (pool adjacent violators).

    Source: Ayer et al., *An empirical distribution function for sampling with incomplete information* (1955).
    """
    pools: list[list[float]] = []
    for share in shares:
        pools.append([float(share)])
        while len(pools) > 1 and fmean(pools[-2]) < fmean(pools[-1]):
            pools[-2:] = [pools[-2] + pools[-1]]
    return np.array([fmean(pool) for pool in pools for _ in pool])


def _entropy(shares: Floats) -> float:
    some = shares[shares > 0.0]
    return float(-(some * np.log2(some)).sum())
