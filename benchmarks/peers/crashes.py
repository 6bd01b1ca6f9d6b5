"""What SIGKILL costs: a system is killed at moments spread over W, restarted on what it kept, and asked what became of it.

Each treatment makes one outside call, and the callee counts it. Lost: an event that the client was told is durable, without a
final state in the end. Repeated: a call made again though its answer was committed when the system was killed; one whose answer
was not is in doubt, counted apart. The client sends again what was not acknowledged to it, and so every system gets the chance to
recognise it.

    python -m benchmarks.peers.crashes SYSTEM VARIANT STORE     prints whose call's answer is committed in a store
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from importlib import import_module
from pathlib import Path

import msgspec

from benchmarks.peers.running import Load
from benchmarks.peers.systems import SYSTEMS

#: From where `benchmarks` is imported.
ROOT = Path(__file__).parents[2]

#: A restart that takes longer has failed.
LIMIT_S = 300.0


def killed(system: str, variant: str, workload: Path, store: Path, events: int, kills: int) -> dict[str, int]:
    """Kill it so many times; what was lost, repeated and in doubt."""
    store.mkdir(parents=True)
    load = Load(calls=True, window=32)
    marks: list[tuple[int, set[str]]] = []
    for number in range(kills):
        if not _kill_at(system, variant, workload, store, load, round(events * (number + 0.5) / kills)):
            break
        marks.append((len(_called(store)), _answered(system, variant, store)))
    child = _start(system, variant, workload, store, load)
    printed, errors = child.communicate(timeout=LIMIT_S)
    if child.returncode:
        raise SystemExit(f"{system} {variant} did not come up again after SIGKILL:\n{errors}")
    came_to = set(json.loads(printed.splitlines()[-1])["entities"])
    acknowledged = {line for line in (store / "acknowledged").read_text().splitlines() if not line.startswith("cursor ")}
    called = _called(store)
    again = len(called) - len(set(called))
    repeated = sum(entity in answered for at, answered in marks for entity in set(called[at:]))
    return {
        "kills": len(marks),
        "lost": len(acknowledged - came_to),
        "repeated": repeated,
        "in_doubt": again - repeated,
        "acknowledged": len(acknowledged),
    }


def _start(system: str, variant: str, workload: Path, store: Path, load: Load) -> subprocess.Popen[str]:
    words = [sys.executable, "-m", "benchmarks.peers.child", system, variant, str(workload), str(store)]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    return subprocess.Popen(
        [*words, msgspec.json.encode(load).decode()],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
        cwd=ROOT,
    )


def _kill_at(system: str, variant: str, workload: Path, store: Path, load: Load, target: int) -> bool:
    """SIGKILL when so many events have been acknowledged; False when it ended before."""
    child = _start(system, variant, workload, store, load)
    acknowledged = store / "acknowledged"
    until = time.monotonic() + LIMIT_S
    while child.poll() is None and (not acknowledged.exists() or _lines(acknowledged) < target):
        if time.monotonic() > until:
            child.kill()
            raise SystemExit(f"{system} {variant} acknowledged nothing more for {LIMIT_S:.0f} s")
        time.sleep(0.001)
    if child.poll() is not None:
        _, errors = child.communicate()
        if child.returncode:
            raise SystemExit(f"{system} {variant} failed:\n{errors}")
        return False
    child.kill()
    child.communicate()
    return True


def _lines(path: Path) -> int:
    return sum(not line.startswith("cursor ") for line in set(path.read_text().splitlines()))


def _called(store: Path) -> list[str]:
    path = store / "called"
    return path.read_text().split() if path.exists() else []


def _answered(system: str, variant: str, store: Path) -> set[str]:
    words = [sys.executable, "-m", "benchmarks.peers.crashes", system, variant, str(store)]
    return set(json.loads(subprocess.run(words, capture_output=True, text=True, check=True, cwd=ROOT).stdout.splitlines()[-1]))


if __name__ == "__main__":
    name, kind, kept = sys.argv[1:]
    module = import_module(f"benchmarks.peers.{SYSTEMS[name].module}")
    print(json.dumps(sorted(module.answered(Path(kept), kind))))
