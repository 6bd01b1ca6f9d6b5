"""Experiment 3's stand-in for the language model, with validated history in its prompt. Its error rates are stated, not hidden.

Treatment: right with probability .70 on familiar events, else a uniform wrong one; on the signatures right but for D; on the new
types right but for one. Outcome: right with probability .80 on familiar events; on a signature or a new type the latest validated
one of it, D's always the one before the change; where nothing was validated yet, what was learned from last before deployment on
signatures, and on new types right but for two.
"""

from __future__ import annotations

import numpy as np

from wakeful.experiments.worlds.service_drift import FAMILIAR, NOVEL, DriftWorld, Met
from wakeful.experiments.worlds.service_events import TREATMENTS

FAMILIAR_TREATMENT = 0.70
FAMILIAR_OUTCOME = 0.80
BLIND_TO = "D"
"""The signature that it always judges as before, and by the wrong treatment."""
NOVEL_TREATMENT_WRONG = NOVEL
NOVEL_OUTCOME_WRONG = (1, 2)
"""Numbers of new types."""


class DriftReasoner:
    """Says what treatment and outcome an event has. The same event gets the same luck, whichever method asks."""

    def __init__(self, world: DriftWorld) -> None:
        luck = np.random.default_rng((world.seed, 3, 8))
        self._luck = luck.random((FAMILIAR, 2))
        self._wrong = luck.integers(1, len(TREATMENTS), size=len(world.stream))
        self._latest: dict[str, int] = {}
        for met in world.pretraining:
            if met.signature:
                self._latest[met.signature] = met.outcome

    def hear(self, met: Met) -> None:
        """A validation: it stands in the prompts from now on."""
        if met.same_as and met.signature != BLIND_TO:
            self._latest[met.same_as] = met.told

    def answer(self, place: int, met: Met) -> tuple[int, int]:
        """Indices of treatment and outcome for event ``place`` of the stream."""
        other = (met.treatment + int(self._wrong[place])) % len(TREATMENTS)
        if met.stage == "familiar":
            right, as_usual = self._luck[place] < (FAMILIAR_TREATMENT, FAMILIAR_OUTCOME)
            return met.treatment if right else other, met.outcome if as_usual else 1 - met.outcome
        wrong = met.signature == BLIND_TO or met.novel == NOVEL_TREATMENT_WRONG
        guess = 1 - met.outcome if met.novel in NOVEL_OUTCOME_WRONG else met.outcome
        return other if wrong else met.treatment, self._latest.get(met.same_as, guess)
