"""Writes docs/exp2_tables.md and Experiment 2's figures from what `wakeful reproduce` wrote.

    wakeful reproduce exp2 --out ten
    wakeful reproduce exp2 --first-seed 2000 --seeds 100 --out hundred
    wakeful reproduce exp2-untold --first-seed 2000 --seeds 100 --out hundred_untold
    wakeful reproduce exp2-frontier --out ten_frontier
    python docs/draw_exp2.py FOLDER_OF_THE_FOUR

It computes nothing but ratios of the means that stand in the rows.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import msgspec

from wakeful.experiments.exp2_variants import FRONTIER_LOADS, SHARES
from wakeful.experiments.rows import Row, spread

HERE = Path(__file__).parent
LOADS = ("low", "medium", "high", "bursty_delayed")
PUBLISHED = ("task_bounded", "sequential", "reactive_priority", "suspend_resume")
METHODS = (*PUBLISHED, "deadline_aware", "clairvoyant")
STRESS = ("critical_miss", "critical_deadline", "latency_steps", "primary_task")

Cells = dict[tuple[str, str, str], Row]


def read(path: Path) -> Cells:
    """The rows of one run of the command, by (method, workload, metric)."""
    rows = msgspec.json.decode(path.read_bytes(), type=list[Row])
    return {(each.method, each.workload, each.metric): each for each in rows}


def table(cells: Cells, loads: tuple[str, ...], metric: str) -> list[str]:
    """One metric, methods down and workloads across: ours, and below it the paper's with z and the standard errors."""
    lines = [f"| {metric} | " + " | ".join(loads) + " |", "|---" * (len(loads) + 1) + "|"]
    for method in METHODS:
        row = [cells.get((method, load, metric)) for load in loads]
        if any(row):
            lines.append(f"| {method} | " + " | ".join(cell(each) for each in row) + " |")
    return lines


def cell(row: Row | None) -> str:
    """Ours, then the paper's figure and the distance where it has one."""
    if row is None:
        return "–"
    ours = spread(row.mean, row.sd)
    if row.paper_mean is None:
        return ours
    errors = "" if row.standard_errors is None else f" ({row.standard_errors:+.1f} s.e.)"
    distance = "–" if row.z is None else f"z {row.z:+.2f}"
    mark = "" if row.z is not None and abs(row.z) <= 1.0 else " **!**"
    return f"{ours}<br>paper {spread(row.paper_mean, row.paper_sd)}<br>{distance}{errors}{mark}"


def limits(cells: Cells, methods: tuple[str, ...], loads: tuple[str, ...]) -> list[str]:
    """Shares of the clairvoyant's means."""
    lines = ["| of the clairvoyant's, % | " + " | ".join(loads) + " |", "|---" * (len(loads) + 1) + "|"]
    for method in methods:
        parts: list[str] = []
        for load in loads:
            found = [
                f"{100.0 * cells[method, load, metric].mean / cells['clairvoyant', load, metric].mean:.1f}"
                for metric in ("critical_deadline", "completion")
            ]
            parts.append(f"{found[0]} / {found[1]}; {cells[method, load, 'critical_miss'].mean:.2f}")
        lines.append(f"| {method} | " + " | ".join(parts) + " |")
    return lines


def frontier(cells: Cells) -> list[str]:
    """Primary task and completion by share."""
    lines = ["| primary task / completion | " + " | ".join(f"share {share:g}" for share in SHARES) + " |"]
    lines.append("|---" * (len(SHARES) + 1) + "|")
    for load in FRONTIER_LOADS:
        for method in METHODS[:-1]:
            points = (f"{load}@{share:g}" for share in SHARES)
            pairs = [
                f"{cells[method, point, 'primary_task'].mean:.1f} / {cells[method, point, 'completion'].mean:.1f}"
                for point in points
            ]
            lines.append(f"| {load}: {method} | " + " | ".join(pairs) + " |")
    return lines


def counted(cells: Cells, loads: tuple[str, ...]) -> str:
    """How many published cells lie within one published deviation and two standard errors; which don't."""
    compared = [each for each in cells.values() if each.workload in loads and each.paper_mean is not None]
    within = [each for each in compared if each.z is not None and abs(each.z) <= 1.0]
    strict = [each for each in compared if each.standard_errors is not None and abs(each.standard_errors) <= 2.0]
    outside = [f"{each.method} {each.workload} {each.metric} (z {each.z:+.2f})" for each in compared if each not in within]
    said = f"{len(within)} of {len(compared)} cells within one published deviation, {len(strict)} within two standard errors."
    return said + (f" Outside: {'; '.join(outside)}." if outside else "")


def main(folder: Path) -> None:
    """Write the page and copy the figures."""
    page = [
        "# Experiment 2: all figures",
        "",
        "Written by `python docs/draw_exp2.py`; how and why stands in [experiments](experiments.md). Mean ± sample standard",
        "deviation over the seeds; below it the paper's figure and the distance in its standard deviations (z), and in standard",
        "errors of its ten-seed mean (s.e.); **!** marks more than one standard deviation. Percent, but latency in steps.",
    ]
    for name, title in (("ten", "The project's ten seeds"), ("hundred", "100 further seeds, 2000 to 2099")):
        cells = read(folder / name / "exp2.json")
        for loads, which in ((LOADS, "first"), (tuple(f"{load}_2" for load in LOADS), "second")):
            page += ["", f"## {title}: {which} parameter set", counted(cells, loads)]
            for metric in ("completion", *STRESS):
                page += ["", *table(cells, loads, metric)]
            page += ["", "Critical deadlines / completion as shares of the clairvoyant's means; then critical misses, %.", ""]
            page += limits(cells, ("suspend_resume", "deadline_aware"), loads)
    untold = read(folder / "hundred_untold" / "exp2-untold.json")
    names = tuple(dict.fromkeys(method for method, _, _ in untold if method != "clairvoyant"))
    page += ["", "## Without knowing efforts beforehand: 100 further seeds", ""]
    page += limits(untold, names, LOADS)
    page += ["", *limits(untold, names, tuple(f"{load}_2" for load in LOADS))]
    page += ["", *table_of(untold, names)]
    page += ["", "## The frontier: ten seeds, first parameter set", ""]
    page += frontier(read(folder / "ten_frontier" / "exp2-frontier.json"))
    (HERE / "exp2_tables.md").write_text("\n".join(page) + "\n", encoding="utf-8")
    shutil.copy(folder / "ten" / "exp2_completion.svg", HERE / "exp2_completion.svg")
    for load in FRONTIER_LOADS:
        shutil.copy(folder / "ten_frontier" / f"exp2_frontier_{load}.svg", HERE / f"exp2_frontier_{load}.svg")


def table_of(cells: Cells, methods: tuple[str, ...]) -> list[str]:
    """Completion and critical deadlines of some methods on the two heavy workloads of both sets."""
    loads = ("high", "bursty_delayed", "high_2", "bursty_delayed_2")
    lines = ["| completion; critical deadlines, % | " + " | ".join(loads) + " |", "|---" * (len(loads) + 1) + "|"]
    for method in methods:
        parts = [
            f"{cells[method, load, 'completion'].mean:.2f}; {cells[method, load, 'critical_deadline'].mean:.2f}" for load in loads
        ]
        lines.append(f"| {method} | " + " | ".join(parts) + " |")
    return lines


if __name__ == "__main__":
    main(Path(sys.argv[1]))
