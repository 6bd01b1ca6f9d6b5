"""Experiment 3's four published methods (Sec. IV-B). Where the paper leaves room, its tables decided (`docs/experiments.md`)."""

from __future__ import annotations

from typing import Literal, Protocol

import numpy as np
import numpy.typing as npt

from wakeful.experiments.exp3_reasoner import DriftReasoner
from wakeful.experiments.worlds.service_drift import INPUTS, OUTCOMES, DriftWorld, Met, features
from wakeful.experiments.worlds.service_events import TREATMENTS
from wakeful.facts.values import Fact
from wakeful.learning.material import Material
from wakeful.learning.network import Fit, Shape, logits, softmax, start, train

TREATMENT_CONFIDENCE = 0.99
OUTCOME_CONFIDENCE = 0.55
"""What the heads need for automatic processing."""
CORRECTIVE_WEIGHT = 2.3
"""What an experience weighs that corrected what had been concluded."""
BATCH = 64
PRETRAINING_EPOCHS, UPDATE_EPOCHS = 140, 35
"""Section IV-A."""
ONE_TREATMENT = {"item": "description", "obstacle": "planning", "device": "description", "unknown": "analogy"}
"""Outcome-Only's treatments: the object's category decides, whatever happens to it."""


class Said(Fact, frozen=True):
    """What a method concluded of one event, as indices, and how."""

    treatment: int
    outcome: int
    mode: Literal["auto", "delib", "fallback"]
    trust: float | None = None
    """How far the outcome that was said is trusted, where the method has such a figure."""


class Method(Protocol):
    """One method on one world: decides event by event, and is told each validation when it is there."""

    def decide(self, place: int, met: Met) -> Said:
        """What it concludes of event ``place`` of the stream."""

    def learn(self, place: int, met: Met, said: Said) -> None:
        """The validation of event ``place``, and what had been concluded of it."""


class AlwaysLLM:
    """Deliberates on every event."""

    def __init__(self, world: DriftWorld) -> None:
        self._reasoner = DriftReasoner(world)

    def decide(self, place: int, met: Met) -> Said:
        """What the reasoner says."""
        treatment, outcome = self._reasoner.answer(place, met)
        return Said(treatment=treatment, outcome=outcome, mode="delib")

    def learn(self, place: int, met: Met, said: Said) -> None:  # noqa: ARG002
        """History for the next prompts."""
        self._reasoner.hear(met)


class TwoHeaded:
    """The paper's network with its threshold rule: Proposed, and with fewer abilities Offline MultiHead and Outcome-Only.

    Args:
        world: its materials are what is learned from before the stream.
        updates: whether it goes on learning from validations.
        treats: whether it learns treatments; else the object's category decides.
    """

    def __init__(self, world: DriftWorld, *, updates: bool = True, treats: bool = True) -> None:
        self._reasoner = DriftReasoner(world)
        self._seed, self._updates, self._treats = world.seed, updates, treats
        self._shape = Shape(INPUTS, 64, len(TREATMENTS), len(OUTCOMES))
        self._rows = [features(met) for met in world.pretraining]
        self._treatments = [met.treatment for met in world.pretraining]
        self._outcomes = [met.outcome for met in world.pretraining]
        self._weights = [1.0] * len(self._rows)
        self._types: set[int] = {0}
        self._theta = start(self._shape, self._seed)
        self._trainings = 0
        self._train(PRETRAINING_EPOCHS)

    def estimate(self, row: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Probabilities over treatments and outcomes for rows (n, INPUTS)."""
        z, w = logits(self._theta, self._shape, row)
        return softmax(z), softmax(w)

    def decide(self, place: int, met: Met) -> Said:
        """The network where it is sure and the type has been validated; else the reasoner."""
        (p,), (q,) = self.estimate(features(met)[None])
        sure = q.max() >= OUTCOME_CONFIDENCE and (not self._treats or p.max() >= TREATMENT_CONFIDENCE)
        if met.novel not in self._types or not sure:
            treatment, outcome = self._reasoner.answer(place, met)
            said = Said(treatment=treatment, outcome=outcome, mode="fallback" if met.novel not in self._types else "delib")
        else:
            said = Said(treatment=int(p.argmax()), outcome=int(q.argmax()), mode="auto", trust=float(q.max()))
        if self._treats:
            return said
        return Said(treatment=TREATMENTS.index(ONE_TREATMENT[met.case.category]), outcome=said.outcome, mode=said.mode)

    def learn(self, place: int, met: Met, said: Said) -> None:  # noqa: ARG002
        """35 further epochs on all material."""
        self._reasoner.hear(met)
        if not self._updates:
            return
        wrong = said.outcome != met.told or (self._treats and said.treatment != met.treatment)
        self._types.add(met.novel)
        self._rows.append(features(met))
        self._treatments.append(met.treatment)
        self._outcomes.append(met.told)
        self._weights.append(CORRECTIVE_WEIGHT if wrong else 1.0)
        self._train(UPDATE_EPOCHS)

    def _train(self, epochs: int) -> None:
        weight = np.array(self._weights)
        material = Material(
            x=np.array(self._rows),
            treatment=np.array(self._treatments),
            result=np.array(self._outcomes),
            refuted=np.full(len(weight), -1),
            weight=weight,
            result_weight=weight,
        )
        self._trainings += 1
        fit = Fit(epochs=epochs, seed=self._seed * 1000 + self._trainings, treatment_loss=float(self._treats), batch=BATCH)
        for theta in train(self._theta, self._shape, material, fit):
            self._last = theta
        self._theta = self._last.copy()
