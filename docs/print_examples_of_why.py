"""Prints docs/examples-of-why.md: ten events each, drawn at random, of the UR3 and of the flight recordings.

./run python docs/print_examples_of_why.py ../shared/data > docs/examples-of-why.md
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

WAKEFUL = [sys.executable, "-m", "wakeful"]
DRAW = ["why", "--sample", "10", "--seed", "0"]


def wakeful(*arguments: str, folder: Path) -> str:
    """What the command prints, as in a terminal of 110 columns."""
    environment = {**os.environ, "COLUMNS": "110"}
    done = subprocess.run([*WAKEFUL, *arguments], cwd=folder, env=environment, capture_output=True, text=True, check=True)
    return done.stdout


def main() -> int:
    """Run both, draw from each, print the page."""
    data = Path(sys.argv[1]).resolve()
    print(
        "# Ten events, drawn at random\n\n"
        "From each of two journals: one of the UR3 recording, one of the six flight logs read one after the other. Unedited, as "
        "the draw fell. Made by\n\n"
        "```sh\n./run python docs/print_examples_of_why.py ../shared/data > docs/examples-of-why.md\n```"
    )
    with tempfile.TemporaryDirectory() as folder:
        for title, name, sources in (
            ("The UR3 arm", "ur3.db", [data / "ur3_cobotops" / "dataset.xlsx"]),
            ("The flights", "flights.db", sorted((data / "px4_ulog").glob("*.ulg"))),
        ):
            for source in sources:
                wakeful("run", source.name, "--journal", str(Path(folder, name)), "--json", folder=source.parent)
            story = wakeful(*DRAW, "--journal", str(Path(folder, name)), folder=Path(folder))
            shown = " ".join(["wakeful", *DRAW, "--journal", name])
            print(f"\n## {title}\n\n```text\n$ {shown}\n{story.rstrip()}\n```")
    return 0


if __name__ == "__main__":
    sys.exit(main())
