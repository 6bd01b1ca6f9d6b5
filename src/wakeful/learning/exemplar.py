"""One exemplar: an event as it was met again and again, and what its validations have told, as beliefs."""

from __future__ import annotations

from typing import Final

import msgspec
import numpy as np

from wakeful.contracts.learner import Vector
from wakeful.learning.belief import Belief, Expected, Repeatability

AT_MOST: Final = 0.95
"""No forecast is held to be surer than this: a model that is wrong must not look like an outcome that was told wrongly."""

#: So many validations of one exemplar are remembered one by one.
TOLD: Final = 16


class Foretold(msgspec.Struct, frozen=True):
    """What a model forecast, over the labels, and the last experience that it had learned from; empty where none had a say."""

    shares: tuple[float, ...] = ()
    since: int = 0


class Told(msgspec.Struct, frozen=True):
    """One validation: the right treatment and the outcome, -1 where not known, and what had been foretold."""

    id: int
    process: int
    treatment: int
    label: int
    foretold: Foretold


class Exemplar(msgspec.Struct):
    """Named by its first validation; ``told`` are its last ones."""

    id: int
    features: Vector
    told: list[Told]
    treatment: Belief
    label: Belief
    estimate: tuple[object, Vector] | None = None
    """A model version, and what its two heads say of it."""
    newest: tuple[int, int] = (-1, -1)
    """The treatment and the outcome that were told last, -1 where not."""


class Teacher:
    """Founds exemplars and teaches them what was told.

    Args:
        treatments: how many there are.
        labels: how many outcome labels there are.
        expected: how noisy and how changing the world is held to be at first.
    """

    def __init__(self, treatments: int, labels: int, expected: Expected | None) -> None:
        self._treatments, self._labels = treatments, labels
        self._expected = expected
        self.treatment_repeats, self.label_repeats = Repeatability(expected), Repeatability(expected)

    def found(self, told: Told, features: Vector) -> Exemplar:
        """An exemplar that nothing was told of yet; ``told`` is what will be."""
        exemplar = Exemplar(told.id, features.copy(), [], Belief(np.ones(1), 0), Belief(np.ones(1), 0))
        self._begin(exemplar, told)
        return exemplar

    def teach(self, exemplar: Exemplar, told: Told) -> None:
        """One more validation."""
        self._teach(exemplar, told, self.treatment_repeats, self.label_repeats)
        exemplar.told.append(told)

    def again(self, exemplar: Exemplar, told: Told) -> None:
        """The world was heard late: what this process taught before is taken back."""
        exemplar.told = [told if one.process == told.process else one for one in exemplar.told]
        self._replay(exemplar)

    def together(self, alike: list[Exemplar]) -> Exemplar:
        """What was told of all of these, in the order in which it was, as one exemplar."""
        told = sorted((one for each in alike for one in each.told), key=lambda one: one.id)[-TOLD:]
        whole = Exemplar(told[0].id, alike[0].features, told, Belief(np.ones(1), 0), Belief(np.ones(1), 0))
        self._replay(whole)
        return whole

    def _replay(self, exemplar: Exemplar) -> None:
        self._begin(exemplar, exemplar.told[0])
        aside = Repeatability(self._expected), Repeatability(self._expected)
        for one in exemplar.told:
            self._teach(exemplar, one, *aside)

    def _teach(self, exemplar: Exemplar, told: Told, treatments: Repeatability, labels: Repeatability) -> None:
        if told.treatment >= 0:
            exemplar.treatment.learn(told.treatment, told.id, treatments)
        if told.label >= 0:
            exemplar.label.learn(told.label, told.id, labels)
        exemplar.newest = (told.treatment, told.label)

    def _begin(self, exemplar: Exemplar, told: Told) -> None:
        exemplar.treatment = Belief(np.full(self._treatments, 1.0 / self._treatments), told.id)
        shares = told.foretold.shares
        if shares:
            first = np.clip(shares, 1.0 - AT_MOST, AT_MOST)
            exemplar.label = Belief(first / first.sum(), told.foretold.since)
        else:
            exemplar.label = Belief(np.full(self._labels, 1.0 / self._labels), told.id)
