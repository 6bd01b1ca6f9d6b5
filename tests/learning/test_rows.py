"""Estimates of many events at once are those of each alone."""

from __future__ import annotations

import numpy as np
import pytest

from wakeful.learning.two_heads import TwoHeads
from wakeful.testing.learner_checks import training_job

LEARNER = TwoHeads()
JOB = training_job(120, 20, 3)
PREDICTOR = LEARNER.load(LEARNER.train(JOB)[1])


def test_rows_are_estimated_as_each_of_them_alone() -> None:
    random = np.random.default_rng(0)
    known = np.asarray(JOB.features)
    rows = np.vstack([known, np.round(known), random.normal(size=(50, known.shape[1])) * 3.0, known[:1] + 1e3])
    together = PREDICTOR.estimate_rows(rows)
    for place, row in enumerate(rows):
        alone = PREDICTOR.estimate(row)
        assert together.treatments[place].tolist() == alone.treatments.tolist()
        assert together.labels[place].tolist() == alone.labels.tolist()
        assert (together.novelty[place], together.cells[place]) == (alone.novelty, alone.cell)


def test_of_equally_near_exemplars_the_first_is_the_cell() -> None:
    rows = np.repeat(np.asarray(JOB.features)[:1], 3, axis=0)
    assert set(PREDICTOR.estimate_rows(rows).cells.tolist()) == {PREDICTOR.estimate(rows[0]).cell}


def test_features_of_another_shape_are_refused() -> None:
    with pytest.raises(ValueError, match="was fitted on"):
        PREDICTOR.estimate_rows(np.zeros((2, 1)))
