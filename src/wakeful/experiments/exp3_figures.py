"""Experiment 3's figures: recovery after the change (the paper's Fig. 4), trust in the new outcome. Needs the extra ``plots``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import fmean

from wakeful.experiments.exp3_trust import Course
from wakeful.experiments.plotting import new_figure, save
from wakeful.experiments.rows import Row
from wakeful.experiments.worlds.service_drift import REPETITIONS

_NUMBERS = range(1, REPETITIONS + 1)
PUBLISHED = (25.0, 50.0, 57.5, 100.0)
"""Proposed's first four repetitions, as the paper's text gives them."""


def draw(rows: Sequence[Row], noisy: Mapping[str, Sequence[Course]], out: Path) -> list[Path]:
    """Draw recovery for each variant, and trust under ``noisy``; returns the files written.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    written: list[Path] = []
    for variant in dict.fromkeys(each.workload for each in rows):
        written += draw_recovery([each for each in rows if each.workload == variant], variant, out)
    return written + draw_trust(noisy["wakeful"], out)


def draw_recovery(rows: Sequence[Row], variant: str, out: Path) -> list[Path]:
    """Joint accuracy over the repetitions after the change, a line per method."""
    mean = {(each.method, each.metric): each.mean for each in rows}
    figure, axes = new_figure()
    for method in dict.fromkeys(each.method for each in rows):
        joint = [mean[method, f"drift_joint_rep{number}"] for number in _NUMBERS]
        axes.plot(_NUMBERS, joint, marker="o", markersize=4, label=method)
    if variant == "clean":
        axes.plot(range(1, len(PUBLISHED) + 1), PUBLISHED, "x", color="black", label="the paper's proposed")
    axes.set_xlabel("repetition after the change")
    axes.set_ylabel("joint accuracy, %")
    axes.set_ylim(-3, 105)
    axes.set_title(f"Experiment 3, {variant}: four changed signatures", fontsize=9)
    axes.legend(fontsize=8)
    return save(figure, out / f"exp3_recovery_{variant}")


def draw_trust(courses: Sequence[Course], out: Path) -> list[Path]:
    """What probability the outcome that holds was given, one thin line a signature and world, by what had been told."""
    figure, axes = new_figure()
    groups = {
        "all validations right": [each for each in courses if all(told == each.outcome for told in each.told)],
        "some wrong": [each for each in courses if any(told != each.outcome for told in each.told)],
    }
    for colour, (name, group) in zip(("tab:blue", "tab:red"), groups.items(), strict=True):
        for each in group:
            axes.plot(_NUMBERS, [value if value is not None else float("nan") for value in each.trust], color=colour, alpha=0.2)
        if group:
            middle = [fmean(each.trust[at - 1] or 0.0 for each in group) for at in _NUMBERS]
            axes.plot(_NUMBERS, middle, color=colour, linewidth=2.5, label=f"{name} ({len(group)})")
    for each in groups["some wrong"]:
        crosses = [at for at in _NUMBERS if each.told[at - 1] != each.outcome]
        axes.plot(crosses, [each.trust[at - 1] or 0.0 for at in crosses], "x", color="black", markersize=5)
    axes.axhline(0.5, color="grey", linewidth=0.8)
    axes.set_xlabel("repetition after the change (×: its validation will be wrong)")
    axes.set_ylabel("trust in the outcome that holds")
    axes.set_ylim(-0.03, 1.03)
    axes.set_title("Experiment 3, noisy: wakeful's trust, a line per signature and world", fontsize=9)
    axes.legend(fontsize=8)
    return save(figure, out / "exp3_trust_noisy")
