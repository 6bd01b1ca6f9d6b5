"""Writes exp1_tables.md from what `wakeful reproduce exp1` printed to files.

Run: `python docs/draw_exp1.py TEN.txt FRESH.txt`, each the output of the command that stands above its tables on the page.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

METRICS = ("overall", "structured", "strict_pair", "random", "task_safety", "automatic", "reasoner_calls")
HEAD = """# Experiment 1: all figures

Written by `python docs/draw_exp1.py` from the command's own output; how and why stands in [experiments](experiments.md).
Mean ± sample standard deviation over the seeds; on variant A below it the paper's figure and the distance in its standard
deviations (z). Percent, but reasoner calls a seed. Deliberation, wherever a method asks, is by a stand-in; its error rates
stand under each table.
"""


def section(text: str) -> str:
    """The three tables of one run, and what was said under them."""
    fresh = re.search(r"over (\d+) seeds \((\d+) to \d+\)", text)
    title, command = "The project's ten seeds", "wakeful reproduce exp1"
    if fresh is not None:
        title, command = f"{fresh[1]} fresh seeds", f"{command} --first-seed {fresh[2]} --seeds {fresh[1]}"
    lines = text.splitlines()
    cells = {}
    for line in lines:
        parts = line.split("\t")
        if len(parts) == 7 and parts[2] in METRICS:
            cells[tuple(parts[:3])] = parts[3:]
    said = lines[max(place for place, line in enumerate(lines) if "\t" in line) + 1 :]
    found = [f"## {title}", "```console", f"$ {command}", "```", ""]
    for variant in ("A", "B", "C"):
        found += [f"### Variant {variant}", "| | " + " | ".join(name.replace("_", " ") for name in METRICS) + " |"]
        found.append("|---" * (len(METRICS) + 1) + "|")
        for method in dict.fromkeys(key[0] for key in cells):
            row = []
            for metric in METRICS:
                paper, ours, z, _ = cells[method, variant, metric]
                row.append(ours if paper == "–" else f"{ours}<br>paper {paper}<br>z {z}")
            name = f"**{method}**" if method == "wakeful" else method
            found.append(f"| {name} | " + " | ".join(row) + " |")
        found.append("")
    kept = [line for line in said if line and not line.startswith("written")]
    return "\n".join([*found, "```text", *kept, "```", ""])


def main() -> None:
    """Read each run's output, write the page beside this file."""
    pages = [section(Path(name).read_text()) for name in sys.argv[1:]]
    (Path(__file__).parent / "exp1_tables.md").write_text(HEAD + "\n" + "\n".join(pages))


if __name__ == "__main__":
    main()
