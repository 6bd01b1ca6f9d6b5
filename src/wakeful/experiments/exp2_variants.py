"""Experiment 2 asked two more ways: without knowing efforts beforehand, and with a share declared for the primary task."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from wakeful.contracts.policy import Policy
from wakeful.experiments.exp2_processing import (
    METHODS,
    METRICS,
    Measured,
    Method,
    against_limit,
    gains,
    measure_all,
    one,
    rows,
)
from wakeful.experiments.plotting import new_figure, save
from wakeful.experiments.rows import Progress, Reproduced, Row, row
from wakeful.experiments.worlds.service_load import FIRST
from wakeful.scheduling.policies.deadline_aware import DeadlineAware, DeadlineAwareSettings
from wakeful.scheduling.policies.primary_share import PrimaryShare
from wakeful.scheduling.policies.suspend_resume import SuspendResume

#: Waiting counts for nothing.
NO_AGEING = DeadlineAwareSettings(wait_s_per_step=1e9)

#: The paper's policy asks for no effort; ours is told all, or only events' kinds, or not even these.
UNTOLD = (
    Method(name="suspend_resume", policy=SuspendResume),
    Method(name="deadline_aware", policy=DeadlineAware),
    Method(name="deadline_aware_learned", policy=DeadlineAware, told="kind"),
    Method(name="deadline_aware_learned_unaged", policy=lambda: DeadlineAware(NO_AGEING), told="kind"),
    Method(name="deadline_aware_untold", policy=DeadlineAware, told="nothing"),
)


def reproduce_untold(seeds: Sequence[int], progress: Progress) -> Reproduced:
    """What it costs not to know how many steps an event needs and whether it will wait, as no live robot does.

    ``learned``: the policy sees an event's kind, and learns in the run, from nothing, what such events take; ``unaged``: and
    lets waiting count for nothing. ``untold``: not even kinds; all that can be learned is what events take in the mean.
    """
    results = measure_all(seeds, progress, UNTOLD)
    said = [line for method in UNTOLD for line in against_limit(results, method.name)]
    return Reproduced(rows(results), said + gains(results, "deadline_aware_learned", "deadline_aware_learned_unaged"))


SHARES = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8)
FRONTIER_LOADS = ("high", "bursty_delayed")
FRONTIER_RUNS = len(FRONTIER_LOADS) * len(SHARES) * len(METHODS)
"""Per seed."""


def reproduce_frontier(seeds: Sequence[int], progress: Progress) -> Reproduced:
    """Every policy with a share of the steps declared for the primary task: a workload's name ends in ``@`` and the share."""
    found: list[Row | None] = []
    runs = events = 0
    for load in (each for each in FIRST.loads if each.name in FRONTIER_LOADS):
        for share in SHARES:
            for method in METHODS:
                shared = Method(name=method.name, policy=_sharing(method.policy, share), blocks=method.blocks)
                measured: list[Measured] = []
                for seed in seeds:
                    measured.append(one(shared, load, FIRST, seed))
                    runs, events = runs + 1, events + measured[-1].events
                    progress(runs, events)
                beside = load.name if share == 0.0 else ""
                found += [
                    row(
                        table, method.name, f"{load.name}@{share:g}", metric, [getattr(each, metric) for each in measured], beside
                    )
                    for metric, table in METRICS.items()
                ]
    return Reproduced([each for each in found if each is not None])


def _sharing(policy: Callable[[], Policy], share: float) -> Callable[[], Policy]:
    return lambda: PrimaryShare(policy(), share, quantum_s=1.0)


def draw_frontier(found: list[Row], out: Path) -> list[Path]:
    """Completion against the primary task, a curve per policy, a figure per workload; returns the files written.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    mean = {(each.method, each.workload, each.metric): each.mean for each in found}
    written: list[Path] = []
    for load in FRONTIER_LOADS:
        figure, axes = new_figure()
        for method in METHODS:
            points = [f"{load}@{share:g}" for share in SHARES]
            axes.plot(
                [mean[method.name, point, "primary_task"] for point in points],
                [mean[method.name, point, "completion"] for point in points],
                marker="o",
                markersize=3,
                label=method.name,
            )
        axes.set_xlabel("primary task, %")
        axes.set_ylabel("completion, %")
        axes.set_title(f"Experiment 2, {load}: shares of {', '.join(f'{share:g}' for share in SHARES)}", fontsize=9)
        axes.legend(fontsize=8)
        written += save(figure, out / f"exp2_frontier_{load}")
    return written
