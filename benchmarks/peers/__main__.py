"""Workload W through every system that is installed, by turns, each run in a process of its own.

    ./run python -m benchmarks.peers [--systems wakeful,floor,dbos:sqlite] [--events 10000] [--rounds 5] [--json]
    ./run python -m benchmarks.peers --rate 2000 --systems wakeful:live,floor,asyncio,py_trees

Prints the median of each column over the rounds, with the range of CPU time. The checksum of the final states must be the same
for all. Slow systems get fewer events: their CPU time for each event is what counts. At the end each system is killed with
SIGKILL and restarted, on a smaller W with an outside call for each event. See docs/benchmarks_peers.md.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec

from benchmarks.peers import postgres
from benchmarks.peers.crashes import ROOT, killed
from benchmarks.peers.profiled import draw, floor_stages
from benchmarks.peers.report import Found, apart, assembled, row_of, stages, table
from benchmarks.peers.running import Load
from benchmarks.peers.systems import SYSTEMS
from benchmarks.peers.workload import make, save

Chosen = list[tuple[str, str]]

#: Events of the workload on which is measured what outcomes take: so few that no window closes before its outcome.
APART_EVENTS = 2000


def child(system: str, variant: str, workload: Path, store: Path, load: Load, module: str = "child") -> Found:
    """One run in a process of its own."""
    command = [sys.executable, "-m", f"benchmarks.peers.{module}", system, variant, str(workload), str(store)]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    given = msgspec.json.encode(load).decode()
    ended = subprocess.run([*command, given], capture_output=True, text=True, check=False, env=environment, cwd=ROOT)
    if ended.returncode:
        raise SystemExit(f"{system} {variant} failed:\n{ended.stderr}")
    return dict(json.loads(ended.stdout.splitlines()[-1]))


def chosen(names: str) -> Chosen:
    """The systems and variants that were asked for and are installed; what is left out is said."""
    found: Chosen = []
    for name in names.split(","):
        system, _, wanted = name.partition(":")
        if system not in SYSTEMS:
            raise SystemExit(f"no system {system!r}; there are {', '.join(SYSTEMS)}")
        entry = SYSTEMS[system]
        if entry.missing:
            print(f"{system}: left out, not installed: {entry.missing} (the dependency group `peers`)", file=sys.stderr)
            continue
        for variant in entry.variants:
            if wanted not in ("", variant):
                continue
            if variant == "postgres" and postgres.found() is None:
                print(f"{system} {variant}: left out, PostgreSQL is not installed", file=sys.stderr)
                continue
            found.append((system, variant))
    if not found:
        raise SystemExit(f"nothing to run for {names!r}")
    return found


class Stores:
    """Fresh places to keep things in: folders, and for DBOS on PostgreSQL a database too."""

    def __init__(self, folder: Path, server: tuple[str, int] | None) -> None:
        self._folder = folder
        self._server = server
        self._made = 0

    def fresh(self, variant: str) -> Path:
        """One that nobody has used."""
        self._made += 1
        if variant == "postgres" and self._server is not None:
            os.environ["PEERS_POSTGRES"] = postgres.database(self._server[0], f"w{self._made}")
            os.environ["PEERS_POSTGRES_PID"] = str(self._server[1])
        return self._folder / f"store{self._made}"


@contextmanager
def stores(folder: Path, systems: Chosen) -> Iterator[Stores]:
    """Stores, and a database server for as long as they are needed."""
    if any(variant == "postgres" for _, variant in systems):
        folder.chmod(0o755)  # the server's own account must reach its data
        with postgres.server(folder / "postgres") as server:
            yield Stores(folder, server)
    else:
        yield Stores(folder, None)


class Benchmark:
    """One run of the command.

    Args:
        systems: what is run, by turns.
        load: how W is offered.
        folder: where workloads and stores are made.
        fresh: gives a store that nobody has used.
        seed: of the workload.
    """

    def __init__(self, systems: Chosen, load: Load, folder: Path, fresh: Stores, seed: int) -> None:
        self._systems = systems
        self._load = load
        self._folder = folder
        self._fresh = fresh
        self._seed = seed

    def workload(self, events: int) -> Path:
        """The folder of W with so many events, made where it is not there yet."""
        folder = self._folder / f"w{events}"
        if not folder.exists():
            save(make(self._seed, events), folder)
        return folder

    def rounds(self, events: int, rounds: int) -> dict[tuple[str, str], list[Found]]:
        """Every system once, as often as that."""
        runs: dict[tuple[str, str], list[Found]] = {each: [] for each in self._systems}
        for turn in range(rounds):
            for system, variant in self._systems:
                entry = SYSTEMS[system]
                workload = self.workload(max(1, round(events * entry.share)))
                offered = msgspec.structs.replace(self._load, window=entry.window)
                found = child(system, variant, workload, self._fresh.fresh(variant), offered)
                runs[system, variant].append(found)
                _say(f"round {turn + 1}: {system} {variant}: {found['cpu_us_per_event']:,.1f} µs of CPU an event")
        return runs

    def without_outcomes(self) -> dict[tuple[str, str], object]:
        """Bytes of wakeful's journal for an event whose outcome never comes."""
        found = {}
        offered = msgspec.structs.replace(self._load, outcomes=False)
        for system, variant in self._systems:
            if system == "wakeful" and not self._load.rate:
                run = child(system, variant, self.workload(APART_EVENTS), self._fresh.fresh(variant), offered)
                found[system, variant] = run["bytes_per_event"]
        return found

    def crashes(self, events: int, kills: int) -> dict[tuple[str, str], Found]:
        """What SIGKILL costs each."""
        found = {}
        for system, variant in self._systems if kills else ():
            if SYSTEMS[system].crashes:
                cost = killed(system, variant, self.workload(events), self._fresh.fresh(variant), events, kills)
                found[system, variant] = dict(cost)
                _say(f"SIGKILL: {system} {variant}: {cost}")
        return found

    def profile(self, events: int, picture: Path) -> None:
        """Where the first system's time goes, as a list on standard error and as a picture."""
        system, variant = self._systems[0]
        workload = self.workload(max(1, round(events * SYSTEMS[system].share)))
        found = child(system, variant, workload, self._fresh.fresh(variant), self._load, "profiled")
        floor = child("floor", "", workload, self._fresh.fresh(""), self._load)
        beneath = floor_stages(floor)
        title = f"{system} {variant}: {found['cpu_us_per_event']:.0f} µs of CPU an event, floor {floor['floor_us']:.1f} µs"
        _say(title)
        for name, us in sorted(found["stages_us"].items(), key=lambda item: -item[1]):  # type: ignore[attr-defined]
            _say(f"  {name:12} {us:8.2f}   floor {beneath.get(name, 0.0):6.2f}")
        for name, us in found["hottest"]:  # type: ignore[attr-defined]
            _say(f"    {us:8.2f}  {name}")
        draw(found, floor, title, picture)


def main(words: list[str] | None = None) -> int:
    """Run what was asked for; 1 where a system came to other final states than the workload's."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--systems", default=",".join(SYSTEMS), help="names, each optionally with :variant")
    parser.add_argument("--events", type=int, default=10_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rate", type=float, default=0.0, help="events a second, open loop; 0: as fast as they are taken")
    parser.add_argument("--group-ms", type=float, default=2.0, help="for how long an open-loop system may gather a commit")
    parser.add_argument("--full-sync", action="store_true", help="every acknowledgement survives power loss too")
    parser.add_argument("--kills", type=int, default=3, help="SIGKILLs for each system; 0: none")
    parser.add_argument("--crash-events", type=int, default=200, help="events of the workload on which systems are killed")
    parser.add_argument("--profile", type=Path, help="draw what the first system's distance from the floor is spent on (.svg)")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args(words)
    systems = chosen(given.systems)
    load = Load(rate=given.rate, group_s=given.group_ms / 1000, full_sync=given.full_sync)
    with tempfile.TemporaryDirectory() as name, stores(Path(name), systems) as fresh:
        benchmark = Benchmark(systems, load, Path(name), fresh, given.seed)
        without = benchmark.without_outcomes()
        runs = benchmark.rounds(given.events, given.rounds)
        crashes = benchmark.crashes(given.crash_events, given.kills)
        if given.profile:
            benchmark.profile(given.events, given.profile)
    rows = [
        row_of(*each, found, crashes.get(each), {"rate": given.rate, "bytes_without_outcomes": without.get(each)})
        for each, found in runs.items()
    ]
    if given.json:
        print(json.dumps(rows))
    else:
        parts = (table(rows), apart(rows), assembled(rows), *(stages(row) for row in rows if "stages_us" in row))
        print(*filter(None, parts), sep="\n\n")
    return 0 if all(row["right"] for row in rows) else 1


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
