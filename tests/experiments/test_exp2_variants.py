"""Experiment 2 without known efforts, and with a share for the primary task."""

from __future__ import annotations

from pathlib import Path

import pytest

from wakeful.experiments import exp2_variants
from wakeful.experiments.exp2_processing import METHODS, holders, one, run
from wakeful.experiments.worlds.service_load import FIRST, NOMINAL_STEPS, arrivals
from wakeful.scheduling.policies.primary_share import PrimaryShare
from wakeful.scheduling.policies.suspend_resume import SuspendResume

HIGH = FIRST.loads[2]


def quiet(done: int, events: int) -> None:
    pass


def test_a_share_of_nothing_changes_nothing() -> None:
    world = arrivals(HIGH, FIRST, 1000)
    plain, shared = run(world, SuspendResume()), run(world, PrimaryShare(SuspendResume(), 0.0))
    assert list(plain.lines()) == list(shared.lines())


@pytest.mark.parametrize("share", [0.25, 0.5, 1.0])
def test_the_declared_share_of_the_steps_is_kept_free_of_all_but_critical_processes(share: float) -> None:
    world = arrivals(HIGH, FIRST, 1000)
    held = holders(run(world, PrimaryShare(SuspendResume(), share)))[:NOMINAL_STEPS]
    routine = sum(holder is not None and not world[holder - 1].critical for holder in held)
    assert routine <= (1.0 - share) * NOMINAL_STEPS + 1
    assert sum(holder is not None and world[holder - 1].critical for holder in held) > 0


def test_a_larger_share_gives_the_primary_task_more_and_completes_less(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(exp2_variants, "SHARES", (0.0, 0.3, 0.8))
    found = exp2_variants.reproduce_frontier((1000,), quiet).rows
    mean = {(each.method, each.workload, each.metric): each.mean for each in found}
    for load in exp2_variants.FRONTIER_LOADS:
        for method in METHODS:
            primary = [mean[method.name, f"{load}@{share}", "primary_task"] for share in ("0", "0.3", "0.8")]
            assert primary == sorted(primary)
            completion = [mean[method.name, f"{load}@{share}", "completion"] for share in ("0", "0.8")]
            assert completion[1] < completion[0]
    pytest.importorskip("matplotlib")
    written = exp2_variants.draw_frontier(found, tmp_path)
    assert all(path.stat().st_size > 1000 for path in written)
    assert len(written) == 2 * len(exp2_variants.FRONTIER_LOADS)


def test_what_efforts_are_is_learned_within_the_run() -> None:
    known, learned, untold = (
        sum(one(method, HIGH, FIRST, seed).completion or 0.0 for seed in (1000, 1001, 1002))
        for method in exp2_variants.UNTOLD
        if method.name in ("deadline_aware", "deadline_aware_learned", "deadline_aware_untold")
    )
    assert untold < learned
    assert learned > 0.96 * known


def test_the_runs_counted_for_progress_are_the_runs_made(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(exp2_variants, "METHODS", METHODS[:1])
    told: list[int] = []
    exp2_variants.reproduce_frontier((1000,), lambda done, events: told.append(done))
    assert told == list(range(1, 2 * len(exp2_variants.SHARES) + 1))
    assert len(METHODS) * told[-1] == exp2_variants.FRONTIER_RUNS
