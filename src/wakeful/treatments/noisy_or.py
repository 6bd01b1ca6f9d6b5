"""Exact inference in a two-layer noisy-OR network: independent faults above, symptoms below.

Source: Quickscore, Heckerman 1989: the cost is exponential in the number of positive findings only, never in the number of
faults. Findings: symptom -> seen (True) or looked for and not there (False); a symptom that is not in it is unknown.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from wakeful.facts.domain import Fault

#: More positive findings than this are not worth the doubling of cost that each brings; the most telling are kept.
POSITIVES = 10

Findings = Mapping[str, bool]
Floats = NDArray[np.float64]


class Weighed(NamedTuple):
    """P(findings), P(findings, no fault), and P(findings, fault) of each fault, shape (n,)."""

    whole: float
    none: float
    on: Floats


class Network:
    """Faults with their priors, and the probability that each causes each symptom.

    Args:
        faults: n rows of a domain's fault table.
        leak: the probability that a symptom appears without any of the faults.
    """

    def __init__(self, faults: Sequence[Fault], leak: float = 0.02) -> None:
        self.faults = tuple(faults)
        self.symptoms = tuple(dict.fromkeys(symptom for fault in faults for symptom in fault.causes))
        self._leak = _chance(leak)
        self._prior = np.array([_chance(fault.prior) for fault in faults], dtype=np.float64)
        #: of each symptom, the probability that each fault does not bring it about
        self._silent = {
            symptom: np.array([1.0 - _chance(fault.causes.get(symptom, 0.0)) for fault in faults]) for symptom in self.symptoms
        }

    def suspecting(self, name: str, odds: float) -> Network:
        """The same network where the odds of one fault are so many times as high beforehand, and so after any findings too."""
        return Network([_raised(fault, odds) if fault.name == name else fault for fault in self.faults], self._leak)

    def posterior(self, findings: Findings) -> dict[str, float]:
        """P(fault present | findings) of each fault; the priors where the findings are impossible."""
        weighed = self._weigh(findings)
        shares = self._prior if weighed.whole <= 0.0 else np.minimum(weighed.on / weighed.whole, 1.0)
        return {fault.name: float(share) for fault, share in zip(self.faults, shares, strict=True)}

    def unexplained(self, findings: Findings) -> float:
        """P(none of the faults is present | findings): what the table does not know, or a leak."""
        weighed = self._weigh(findings)
        return min(weighed.none / weighed.whole, 1.0) if weighed.whole > 0.0 else 1.0

    def chance(self, symptom: str, findings: Findings) -> float:
        """P(symptom would be seen | findings)."""
        return self.look_for((symptom,), findings)[symptom][0]

    def look_for(self, symptoms: Sequence[str], findings: Findings) -> dict[str, tuple[float, float]]:
        """What looking for each of these unknown symptoms is worth.

        Returns:
            Of each symptom P(it would be seen | findings), and the expected information gain of looking, in bits: the sum over
            faults of I(fault; symptom | findings).
        """
        terms, signs = self._terms(findings)
        now = self._sum(terms, signs)
        found: dict[str, tuple[float, float]] = {}
        for symptom in symptoms:
            if now.whole <= 0.0:
                found[symptom] = (0.0, 0.0)
                continue
            # seen and not seen sum to what is known now, so only one of the two has to be worked out
            missing = self._sum(terms * self._silent[symptom], signs * (1.0 - self._leak))
            absent = min(max(missing.whole / now.whole, 0.0), 1.0)
            gain = _bits(now.on / now.whole)
            if absent > 0.0:
                gain -= absent * _bits(missing.on / missing.whole)
            if absent < 1.0:
                gain -= (1.0 - absent) * _bits((now.on - missing.on) / (now.whole - missing.whole))
            found[symptom] = (1.0 - absent, max(gain, 0.0))
        return found

    def _weigh(self, findings: Findings) -> Weighed:
        return self._sum(*self._terms(findings))

    def _terms(self, findings: Findings) -> tuple[Floats, Floats]:
        """One row for each subset of the positive findings, shape (2^k, n): P(fault i present, and silent on the subset and on
        all negative findings); and each row's sign, with what the leak adds, shape (2^k,).

        The alternating sum over subsets turns "at least one cause fired" into products over independent faults.
        """
        known = {symptom: seen for symptom, seen in findings.items() if symptom in self._silent}
        rows = self._prior[np.newaxis, :]
        signs = np.ones(1)
        for symptom in (symptom for symptom, seen in known.items() if not seen):
            rows, signs = rows * self._silent[symptom], signs * (1.0 - self._leak)
        for symptom in self._telling([symptom for symptom, seen in known.items() if seen]):
            rows = np.concatenate((rows, rows * self._silent[symptom]))
            signs = np.concatenate((signs, -signs * (1.0 - self._leak)))
        return rows, signs

    def _sum(self, rows: Floats, signs: Floats) -> Weighed:
        either = rows + (1.0 - self._prior)
        # products of all but one, without dividing: a certain fault that would show makes a factor zero
        ones = np.ones((len(rows), 1))
        before = np.cumprod(np.concatenate((ones, either), axis=1), axis=1)
        after = np.cumprod(np.concatenate((ones, either[:, ::-1]), axis=1), axis=1)[:, ::-1]
        on = signs @ (rows * before[:, :-1] * after[:, 1:])
        none = float(signs.sum() * np.prod(1.0 - self._prior))
        return Weighed(max(float(signs @ before[:, -1]), 0.0), max(none, 0.0), np.maximum(on, 0.0))

    def _telling(self, present: Sequence[str]) -> list[str]:
        if len(present) <= POSITIVES:
            return list(present)
        return sorted(sorted(present, key=lambda s: float(self._silent[s].min()))[:POSITIVES])


def _raised(fault: Fault, odds: float) -> Fault:
    prior = _chance(fault.prior)
    return replace(fault, prior=odds * prior / (odds * prior + 1.0 - prior))


def _chance(probability: float) -> float:
    return min(max(probability, 0.0), 1.0)


def _bits(shares: Floats) -> float:
    """The summed entropies of these probabilities."""
    inside = shares[(shares > 0.0) & (shares < 1.0)]
    return float(-(inside * np.log2(inside) + (1.0 - inside) * np.log2(1.0 - inside)).sum())
