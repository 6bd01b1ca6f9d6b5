"""Exact inference where exactly one of the table's faults is there, or none: a small Bayesian model with one hidden variable.

Given the fault, symptoms are independent: P(symptom | fault) is what the table says, or the leak where it says nothing. Any
number of findings costs the same. Source: Pearl, *Probabilistic Reasoning in Intelligent Systems* (1988), Section 2.3.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from wakeful.facts.domain import DomainSpec, Fault
from wakeful.treatments.noisy_or import Findings, Network

Floats = NDArray[np.float64]

#: No finding is ruled out by a fault, and none is certain: a table is never that sure.
LEAST = 1e-4


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
        self._shows = {
            symptom: np.clip(np.array([*(fault.causes.get(symptom, leak) for fault in faults), leak]), LEAST, 1.0 - LEAST)
            for symptom in self.symptoms
        }

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
            shows = self._shows[symptom]
            chance = float(now @ shows)
            seen, missing = now * shows, now * (1.0 - shows)
            gain = _entropy(now)
            gain -= chance * _entropy(seen / chance) if chance > 0.0 else 0.0
            gain -= (1.0 - chance) * _entropy(missing / (1.0 - chance)) if chance < 1.0 else 0.0
            found[symptom] = (chance, max(gain, 0.0))
        return found

    def _given(self, findings: Findings) -> Floats:
        with np.errstate(divide="ignore"):
            log = np.log(self._weights)
        for symptom, seen in findings.items():
            if symptom in self._shows:
                log = log + np.log(self._shows[symptom] if seen else 1.0 - self._shows[symptom])
        shares: Floats = np.exp(log - log.max())
        return np.asarray(shares / shares.sum())


def network_of(domain: DomainSpec, leak: float) -> Network:
    """The domain's fault model: independent faults (noisy-OR), or exactly one of them where the domain says so."""
    return OneFault(domain.fault, leak) if domain.one_fault else Network(domain.fault, leak)


def _entropy(shares: Floats) -> float:
    some = shares[shares > 0.0]
    return float(-(some * np.log2(some)).sum())
