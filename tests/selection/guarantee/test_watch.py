"""The watch: seldom a false alarm, and after a change an alarm before the stated number of errors."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wakeful.selection.guarantee.watch import events_to_alarm, excess_bound, step

ALPHA, TO, PATIENCE = 0.05, 0.2, 100.0


def simulate(risk: float, rate: float, runs: int, events: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """The event of the first alarm (``events`` where none came), and the wrong answers up to each event, per run."""
    random = np.random.default_rng(seed)
    watch, alarm = np.zeros(runs), np.full(runs, events)
    wrong = random.random((events, runs)) < risk
    for at in range(events):
        watch = step(watch, wrong[at] & (random.random(runs) < rate), rate, ALPHA, TO)
        alarm = np.where((watch >= math.log(PATIENCE)) & (alarm == events), at + 1, alarm)
    return alarm, wrong.cumsum(axis=0)


def test_the_watch_never_falls_below_where_it_began_and_an_error_always_raises_it() -> None:
    quiet = step(np.zeros(3), np.array([False, False, True]), 0.2, ALPHA, TO)
    assert quiet[:2].tolist() == [0.0, 0.0]
    assert quiet[2] == pytest.approx(math.log(4))


@pytest.mark.parametrize("rate", [1.0, 0.2])
def test_at_the_promised_risk_false_alarms_are_no_more_frequent_than_the_patience_says(rate: float) -> None:
    alarm, _ = simulate(ALPHA, rate, 2000, 3000)
    assert float(alarm.mean()) >= PATIENCE


@pytest.mark.parametrize(("rate", "risk"), [(1.0, 0.2), (0.2, 0.2), (0.2, 0.4)])
def test_after_a_change_the_alarm_comes_by_the_stated_event(rate: float, risk: float) -> None:
    by = events_to_alarm(risk, ALPHA, TO, rate, PATIENCE, 0.05)
    alarm, _ = simulate(risk, rate, 4000, by + 1, seed=1)
    late = float((alarm > by).mean())
    assert late <= 0.05 + 3 * math.sqrt(0.05 * 0.95 / 4000)
    assert late > 0.01, "the bound is not a guess far from what happens"


@pytest.mark.parametrize(("rate", "risk", "delay"), [(1.0, 0.2, 0), (0.2, 0.25, 30), (0.5, 0.6, 60)])
def test_no_more_errors_come_before_revocation_than_is_stated(rate: float, risk: float, delay: int) -> None:
    bound = excess_bound(ALPHA, TO, rate, delay, PATIENCE, 0.05)
    alarm, errors = simulate(risk, rate, 4000, 1200, seed=2)
    revoked = np.minimum(alarm + delay, 1200) - 1
    came = errors[revoked, np.arange(4000)]
    assert float((came > bound).mean()) <= 0.05
    assert float(came.mean()) > bound / 8


def test_more_audits_mean_fewer_errors_and_more_delay_means_more() -> None:
    bounds = [excess_bound(ALPHA, TO, rate, 20, PATIENCE, 0.05) for rate in (0.1, 0.2, 0.5, 1.0)]
    assert bounds == sorted(bounds, reverse=True)
    assert excess_bound(ALPHA, TO, 0.5, 100, PATIENCE, 0.05) > excess_bound(ALPHA, TO, 0.5, 0, PATIENCE, 0.05)
    assert excess_bound(ALPHA, TO, 0.5, 20, PATIENCE, 0.05, spared=True) < bounds[2]


def test_a_change_smaller_than_declared_has_no_bound() -> None:
    with pytest.raises(ValueError, match="smaller than the declared"):
        events_to_alarm(0.1, ALPHA, TO, 0.2, PATIENCE, 0.05)
