"""Draws docs/journal.svg: a journal's size over an endless stream, and the time of recovery against its length.

python -m benchmarks.growth --json … > growth.jsonl
python -m benchmarks.recovery --json … > recovery.jsonl
python docs/draw_journal.py growth.jsonl recovery.jsonl
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import matplotlib as mpl
from matplotlib import pyplot as plt

OUT = Path(__file__).with_name("journal.svg")


def rows(path: str) -> list[dict[str, float]]:
    """The JSON objects of a file; what else a benchmark printed is left out."""
    return [json.loads(line) for line in Path(path).read_text().splitlines() if line.startswith("{")]


def main(growth: str, recovery: str) -> None:
    """Both curves beside one another."""
    mpl.rcParams["svg.hashsalt"] = "wakeful"
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.2))
    sizes = rows(growth)
    left.plot([row["events"] / 1e3 for row in sizes], [row["file_mb"] for row in sizes], color="#1b7837", label="file")
    without = sizes[0]["file_mb"] / sizes[0]["events"]
    left.plot(
        [row["events"] / 1e3 for row in sizes],
        [row["events"] * without for row in sizes],
        color="#bbbbbb",
        linestyle="--",
        label="without compaction",
    )
    left.set(xlabel="thousand events", ylabel="MB", ylim=(0, 2.5 * max(row["file_mb"] for row in sizes)))
    left.legend(frameon=False)
    times = rows(recovery)
    right.plot(
        [row["events"] / 1e3 for row in times], [row["recovery_s"] for row in times], marker="o", color="#762a83", label="all"
    )
    right.plot(
        [row["events"] / 1e3 for row in times], [row["read_s"] for row in times], marker="o", color="#9ecae1", label="reading"
    )
    right.set(xlabel="thousand events in the journal", ylabel="recovery, s of CPU", xlim=(0, None), ylim=(0, None))
    right.legend(frameon=False)
    for axes in (left, right):
        axes.spines[["top", "right"]].set_visible(False)
    figure.tight_layout()
    figure.savefig(OUT, metadata={"Date": None})


if __name__ == "__main__":
    main(*sys.argv[1:3])
