"""The benchmark of the guarantee measures what it says."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.deployments import World, guarded, thresholded
from wakeful.selection.guarantee import GuaranteeSettings
from wakeful.selection.guarantee.watch import excess_bound

SETTINGS = GuaranteeSettings(audit_rate=0.5)


def test_the_worlds_risk_is_what_its_events_show() -> None:
    world = World.make(4, seed=1)
    limits = np.tile([0.9, 0.6], (4, 1))
    for changed in (False, True):
        risk, share = world.risk(limits, changed)
        scores = world.scores(40_000)
        wrong = world.random.random(scores.shape) < world.wrong(scores, changed)
        for place in range(2):
            inside = scores >= limits[:, place]
            assert inside.mean(axis=0) == pytest.approx(share[:, place], abs=0.01)
            assert (inside & wrong).mean(axis=0) == pytest.approx(risk[:, place], abs=0.01)


def test_in_simulated_deployments_the_risk_is_held_and_a_change_costs_no_more_than_stated() -> None:
    world = World.make(150, seed=2)
    lived = guarded(world, SETTINGS, 1600, "guarantee")
    assert lived.above.mean() <= 0.05
    assert lived.automatic.mean() > 0.3
    bounds = np.array([excess_bound(0.05, 0.2, 0.5, int(delay), SETTINGS.patience, 0.05) for delay in world.delay])
    changed = lived.at_change
    assert changed.sum() > 100
    assert (lived.delay[changed] > 0).all()
    assert (lived.after[changed] > bounds[changed]).mean() <= 0.05
    assert (lived.first[lived.first >= 0] >= 87 + world.delay[lived.first >= 0]).all()


def test_a_threshold_that_was_chosen_on_few_events_breaks_the_same_promise() -> None:
    world = World.make(300, seed=3)
    lived = thresholded(world, SETTINGS, 1600, 42, strict=False)
    assert lived.above.mean() > 0.3
    assert (lived.delay == -1).all()
