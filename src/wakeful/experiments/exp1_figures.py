"""Experiment 1's figures: Table 2 as bars, reliability, risk against coverage, and calls against accuracy. Needs ``plots``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from wakeful.experiments.exp1_shape import Cell, calibration_error, deferral_curve, oracle_curve, reliability
from wakeful.experiments.plotting import new_figure, save
from wakeful.experiments.rows import Row

_BARS = ("overall", "structured", "strict_pair", "random", "task_safety", "automatic")


def draw(rows: Sequence[Row], cells: Mapping[str, Sequence[Cell]], out: Path) -> list[Path]:
    """All four figures; returns the files written.

    Args:
        rows: of all variants; the bars are variant A's.
        cells: the test events of ``wakeful``, by variant, for the curves.
        out: the folder.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    return [*_bars(rows, out), *_reliability(cells, out), *_risk(cells, out), *_calls(rows, out)]


def _bars(rows: Sequence[Row], out: Path) -> list[Path]:
    cells = {(each.method, each.metric): each for each in rows if each.workload == "A"}
    methods = list(dict.fromkeys(method for method, _ in cells))
    figure, axes = new_figure(9.0, 4.0)
    width = 0.8 / len(methods)
    for place, method in enumerate(methods):
        at = [index + (place - len(methods) / 2 + 0.5) * width for index in range(len(_BARS))]
        shown = [cells[method, metric] for metric in _BARS]
        axes.bar(at, [each.mean for each in shown], width, yerr=[each.sd or 0.0 for each in shown], label=method)
        published = [(x, each.paper_mean) for x, each in zip(at, shown, strict=True) if each.paper_mean is not None]
        if published:
            axes.plot(*zip(*published, strict=True), "kx", markersize=5)
    axes.set_xticks(range(len(_BARS)), [name.replace("_", " ") for name in _BARS])
    axes.set_ylabel("%")
    axes.set_ylim(0, 105)
    axes.set_title("Experiment 1, variant A: × the paper's mean, ± sample standard deviation", fontsize=9)
    axes.legend(fontsize=7, ncols=4, loc="lower center")
    return save(figure, out / "exp1_table2")


def _reliability(cells: Mapping[str, Sequence[Cell]], out: Path) -> list[Path]:
    figure, axes = new_figure(4.5, 4.0)
    axes.plot([0, 1], [0, 1], color="grey", linewidth=0.8)
    for variant, of_variant in cells.items():
        bins = reliability(of_variant)
        error = 100.0 * calibration_error(bins)
        axes.plot(
            [each.confidence for each in bins],
            [each.right for each in bins],
            marker="o",
            label=f"{variant}: expected calibration error {error:.2f} %",
        )
    axes.set_xlabel("wakeful's confidence in its treatment")
    axes.set_ylabel("share right")
    axes.legend(fontsize=8)
    return save(figure, out / "exp1_reliability")


def _risk(cells: Mapping[str, Sequence[Cell]], out: Path) -> list[Path]:
    figure, axes = new_figure(5.5, 4.0)
    for variant, of_variant in cells.items():
        drawn = axes.plot(*_percents(deferral_curve(of_variant)), label=f"{variant}: by confidence")
        axes.plot(*_percents(oracle_curve(of_variant)), linestyle=":", color=drawn[0].get_color(), label=f"{variant}: oracle")
    axes.set_xlabel("coverage: events handled automatically, %")
    axes.set_ylabel("risk: wrong among them, %")
    axes.legend(fontsize=8)
    return save(figure, out / "exp1_risk_coverage")


def _percents(curve: Sequence[tuple[float, float]]) -> tuple[list[float], list[float]]:
    return [100.0 * x for x, _ in curve], [100.0 * y for _, y in curve]


def _calls(rows: Sequence[Row], out: Path) -> list[Path]:
    mean = {(each.method, each.workload, each.metric): each.mean for each in rows}
    figure, axes = new_figure(5.5, 4.0)
    for workload, marker in (("A", "o"), ("B", "s"), ("C", "^")):
        for place, method in enumerate(dict.fromkeys(each.method for each in rows)):
            calls, overall = mean[method, workload, "reasoner_calls"], mean[method, workload, "overall"]
            axes.plot([calls], [overall], marker, color=f"C{place}", label=method if workload == "A" else None)
    axes.set_xlabel("reasoner calls a seed")
    axes.set_ylabel("overall accuracy, %")
    axes.set_title("● variant A, ■ B, ▲ C", fontsize=9)
    axes.legend(fontsize=7)
    return save(figure, out / "exp1_calls")
