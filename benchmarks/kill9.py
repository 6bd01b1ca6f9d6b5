"""Kill -9 a run at moments spread over its journal, resume each time, and compare the export with an undisturbed run's.

    ./run python benchmarks/kill9.py SOURCE [--kills 50] [--json]

Half of the moments fall within a training (asked for, not yet published) as far as there are any; the others are spread evenly
over the journal's positions. A kill counts where it hit: the position that the journal had reached when the process was gone.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from wakeful.contracts.journal import JournalError
from wakeful.facts.lines import Published, TrainingAsked
from wakeful.journal import open_journal

WAKEFUL = [sys.executable, "-m", "wakeful"]


def run(source: str, journal: Path) -> subprocess.Popen[bytes]:
    """Start a run on that journal."""
    command = [*WAKEFUL, "run", source, "--journal", str(journal), "--json"]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def export(journal: Path) -> bytes:
    """The journal without wall-clock fields and records of resumption."""
    command = [*WAKEFUL, "export", "--journal", str(journal), "--stable"]
    return subprocess.run(command, capture_output=True, check=True).stdout


def last(journal: Path) -> int:
    """How far the journal has come; 0 before it is there."""
    try:
        reader = open_journal(journal, read_only=True)
    except JournalError:
        return 0
    position = reader.last
    reader.close()
    return position


def in_training(journal: Path) -> bool:
    """Whether a training was asked for and not published when the journal ended."""
    reader = open_journal(journal, read_only=True)
    lines = list(reader.lines_of(kinds=("trainingasked", "published")))
    reader.close()
    return bool(lines) and isinstance(lines[-1].record, TrainingAsked)


def kill_at(source: str, journal: Path, target: int) -> bool:
    """Run until the journal has reached ``target``, then SIGKILL; False when the run was over before."""
    process = run(source, journal)
    while process.poll() is None and last(journal) < target:
        time.sleep(0.001)
    if process.poll() is not None:
        _, errors = process.communicate()
        if process.returncode:
            raise SystemExit(errors.decode())
        return False
    process.kill()
    process.communicate()
    return True


def main() -> int:
    """Print what was killed where, and whether the exports are equal; exit 1 where they are not."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("source")
    arguments.add_argument("--kills", type=int, default=50)
    arguments.add_argument("--json", action="store_true")
    given = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        calm, killed = Path(folder, "calm.db"), Path(folder, "killed.db")
        process = run(given.source, calm)
        _, errors = process.communicate()
        if process.returncode:
            raise SystemExit(errors.decode())
        reader = open_journal(calm, read_only=True)
        end = reader.last
        models = sum(isinstance(line.record, Published) for line in reader.lines_of(kinds=("published",)))
        asked = [line.position for line in reader.lines_of(kinds=("trainingasked",))]
        reader.close()
        spread = [round(end * (n + 1) / (given.kills + 1)) for n in range(given.kills - min(len(asked), given.kills // 2))]
        targets = sorted([*spread, *asked[: given.kills // 2]])
        hits: list[int] = []
        trainings = 0
        for target in targets:
            if not kill_at(given.source, killed, target):
                break
            hits.append(last(killed))
            trainings += in_training(killed)
        run(given.source, killed).communicate()
        equal = export(calm) == export(killed)
        audit = subprocess.run([*WAKEFUL, "audit", "--journal", str(killed)], capture_output=True, check=False).returncode
    found = {
        "source": Path(given.source).name,
        "lines": end,
        "models_published": models,
        "kills": len(hits),
        "kills_during_training": trainings,
        "distinct_positions": len(set(hits)),
        "exports_equal": equal,
        "audit_ok": audit == 0,
    }
    if given.json:
        print(json.dumps(found))
    else:
        for name, value in found.items():
            print(f"{name:24} {value}")
    return 0 if equal and audit == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
