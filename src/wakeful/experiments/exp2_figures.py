"""Experiment 2's figures: completion as the load grows (the paper's Fig. 3). Needs the extra ``plots``."""

from __future__ import annotations

from pathlib import Path

from wakeful.experiments.plotting import new_figure, save
from wakeful.experiments.rows import Row

_LOADS = ("low", "medium", "high", "bursty_delayed")
_NAMES = ("Low", "Medium", "High", "Bursty-delayed")


def draw_completion(rows: list[Row], out: Path) -> list[Path]:
    """Draw completion by workload, one line per method, with the paper's figures as crosses; returns the files written.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    figure, axes = new_figure()
    completion = {(each.method, each.workload): each for each in rows if each.metric == "completion"}
    for method in dict.fromkeys(each.method for each in rows):
        cells = [completion[method, load] for load in _LOADS if (method, load) in completion]
        places = [_LOADS.index(each.workload) for each in cells]
        drawn = axes.errorbar(
            places, [each.mean for each in cells], yerr=[each.sd or 0.0 for each in cells], marker="o", capsize=3, label=method
        )
        published = [(place, each.paper_mean) for place, each in zip(places, cells, strict=True) if each.paper_mean is not None]
        if published:
            axes.plot(*zip(*published, strict=True), "x", color=drawn[0].get_color(), markersize=8)
    axes.set_xticks(range(len(_LOADS)), _NAMES)
    axes.set_ylabel("completion (the paper's cognitive coverage), %")
    axes.set_ylim(0, 105)
    axes.set_title("Experiment 2: × the paper's mean, ± sample standard deviation", fontsize=9)
    axes.legend(fontsize=8)
    return save(figure, out / "exp2_completion")
