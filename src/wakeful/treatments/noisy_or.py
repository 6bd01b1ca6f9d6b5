"""Exact inference in a two-layer noisy-OR network: independent faults above, symptoms below.

Source: Quickscore, Heckerman 1989: the cost is exponential in the number of positive findings only, never in the number of
faults. Findings: symptom -> seen (True) or looked for and not there (False); a symptom that is not in it is unknown.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from math import log2, prod

import msgspec

from wakeful.facts.domain import Fault

#: More positive findings than this are not worth the doubling of cost that each brings; the most telling are kept.
POSITIVES = 10

Findings = Mapping[str, bool]


class Network(msgspec.Struct, frozen=True):
    """Faults with their priors, and the probability that each causes each symptom. ``leak``: a symptom without any fault."""

    faults: tuple[Fault, ...]
    leak: float = 0.02

    @property
    def symptoms(self) -> tuple[str, ...]:
        """All symptoms, in the order of the fault table."""
        return tuple(dict.fromkeys(symptom for fault in self.faults for symptom in fault.causes))

    def likelihood(self, findings: Findings, given: Mapping[str, bool] | None = None) -> float:
        """P(findings, given faults), the faults in ``given`` being held on or off.

        The sum over subsets of the positive findings turns "at least one cause fired" into products over independent faults.
        """
        known = given or {}
        absent = [symptom for symptom, seen in findings.items() if not seen]
        present = self._telling([symptom for symptom, seen in findings.items() if seen])
        total = 0.0
        for size in range(len(present) + 1):
            for chosen in combinations(present, size):
                none_of = (*absent, *chosen)
                term = (1.0 - self.leak) ** len(none_of)
                for fault in self.faults:
                    silent = prod(1.0 - _chance(fault.causes.get(symptom, 0.0)) for symptom in none_of)
                    prior = _chance(fault.prior)
                    held = known.get(fault.name)
                    term *= prior * silent * (held is not False) + (1.0 - prior) * (held is not True)
                total += term if size % 2 == 0 else -term
        return max(total, 0.0)

    def posterior(self, findings: Findings) -> dict[str, float]:
        """P(fault present | findings) of each fault; the priors where the findings are impossible."""
        whole = self.likelihood(findings)
        if whole <= 0.0:
            return {fault.name: _chance(fault.prior) for fault in self.faults}
        return {fault.name: min(self.likelihood(findings, {fault.name: True}) / whole, 1.0) for fault in self.faults}

    def unexplained(self, findings: Findings) -> float:
        """P(none of the faults is present | findings): what the table does not know, or a leak."""
        whole = self.likelihood(findings)
        if whole <= 0.0:
            return 1.0
        return min(self.likelihood(findings, {fault.name: False for fault in self.faults}) / whole, 1.0)

    def chance(self, symptom: str, findings: Findings) -> float:
        """P(symptom would be seen | findings)."""
        whole = self.likelihood(findings)
        return min(self.likelihood({**findings, symptom: True}) / whole, 1.0) if whole > 0.0 else 0.0

    def gain(self, symptom: str, findings: Findings) -> float:
        """Expected information gain of looking for a symptom, in bits: the sum over faults of I(fault; symptom | findings)."""
        seen = self.chance(symptom, findings)
        left = seen * self._entropy({**findings, symptom: True}) + (1.0 - seen) * self._entropy({**findings, symptom: False})
        return max(self._entropy(findings) - left, 0.0)

    def _entropy(self, findings: Findings) -> float:
        return sum(_bits(share) for share in self.posterior(findings).values())

    def _telling(self, present: Sequence[str]) -> list[str]:
        if len(present) <= POSITIVES:
            return list(present)
        strongest = {s: max(_chance(fault.causes.get(s, 0.0)) for fault in self.faults) for s in present}
        return sorted(sorted(present, key=lambda s: -strongest[s])[:POSITIVES])


def _chance(probability: float) -> float:
    return min(max(probability, 0.0), 1.0)


def _bits(share: float) -> float:
    return 0.0 if share <= 0.0 or share >= 1.0 else -share * log2(share) - (1.0 - share) * log2(1.0 - share)
