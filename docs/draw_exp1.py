"""Writes exp1_tables.md from what `wakeful reproduce exp1` printed to files.

Run: `python docs/draw_exp1.py TEN.txt FIFTY.txt`, each the output of the command that stands above its table on the page.
"""

from __future__ import annotations

import sys
from pathlib import Path

METRICS = ("overall", "structured", "strict_pair", "random", "task_safety", "automatic", "reasoner_calls")
COMMANDS = ("wakeful reproduce exp1", "wakeful reproduce exp1 --first-seed 1000 --seeds 50")
TITLES = ("The project's ten seeds", "Fifty fresh seeds")
HEAD = """# Experiment 1: all figures

Written by `python docs/draw_exp1.py` from the command's own output; how and why stands in [experiments](experiments.md).
Mean ± sample standard deviation over the seeds; on variant A below it the paper's figure and the distance in its standard
deviations (z). Percent, but reasoner calls a seed. Deliberation, wherever a method asks, is by a stand-in; its error rates
stand under each table.
"""


def section(title: str, command: str, text: str) -> str:
    """The three tables of one run, and what was said under them."""
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
    pages = [
        section(title, command, Path(name).read_text())
        for title, command, name in zip(TITLES, COMMANDS, sys.argv[1:], strict=False)
    ]
    (Path(__file__).parent / "exp1_tables.md").write_text(HEAD + "\n" + "\n".join(pages))


if __name__ == "__main__":
    main()
