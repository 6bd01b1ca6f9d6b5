"""One seed, played twice and compared; and the sums over many."""

from __future__ import annotations

import tempfile
from pathlib import Path

import msgspec

from benchmarks.chaos.episode import Report, play
from benchmarks.chaos.live import play_live
from benchmarks.chaos.plan import NOBODY_PARKED, Plan, draw
from wakeful.facts.lines import Answered, Line
from wakeful.scheduling.running import IN_DOUBT

#: Journals are kept in memory where the machine offers that: what a disk loses is simulated, not waited for.
_SHM = Path("/dev/shm")


class Trial(msgspec.Struct, kw_only=True):
    """What came of one seed. ``differs`` says where the two runs part, empty where they don't."""

    plan: Plan
    first: Report
    second: Report
    compared: str
    differs: str
    driver: str = "simulated"

    @property
    def failed(self) -> bool:
        """Whether something happened that must not."""
        return self.first.failed or self.second.failed or bool(self.differs)

    def describe(self) -> str:
        """A failing seed for people: what went wrong, its plan, and how to play it again."""
        said = [f"seed {self.plan.seed} FAILED"]
        for name, report in (("first run", self.first), ("second run", self.second)):
            counts = {key: getattr(report, key) for key in ("lost", "repeated", "stranded", "uncovered", "overspent")}
            if report.failed:
                said.append(f"  {name}: {counts}; lives {report.lives}")
                said += [f"    {each}" for each in report.wrong]
        if self.differs:
            said.append(f"  not as {self.compared}: {self.differs}")
        said.append(f"  plan: {msgspec.json.encode(self.plan).decode()}")
        said.append(f"  again: python -m benchmarks.chaos --driver {self.driver} --first-seed {self.plan.seed} --seeds 1")
        return "\n".join(said)


class Totals(msgspec.Struct, kw_only=True):
    """Sums over seeds. ``failed`` counts seeds; the five after it must all be 0."""

    seeds: int = 0
    failed: int = 0
    lost: int = 0
    repeated: int = 0
    stranded: int = 0
    uncovered: int = 0
    overspent: int = 0
    different: int = 0
    as_undisturbed: int = 0
    as_before: int = 0
    restarts: int = 0
    events: int = 0
    outside_calls: int = 0
    in_doubt: int = 0
    reasoner_calls: int = 0
    cpu_s: float = 0.0

    def add(self, told: Trial) -> None:
        """Take in one seed."""
        self.seeds += 1
        self.failed += told.failed
        self.different += bool(told.differs)
        self.as_undisturbed += told.compared == "undisturbed"
        self.as_before += told.compared == "before"
        for report in (told.first, told.second):
            self.lost += report.lost
            self.repeated += report.repeated
            self.stranded += report.stranded
            self.uncovered += report.uncovered
            self.overspent += report.overspent
            self.restarts += report.lives - 1
            self.events += report.events
            self.outside_calls += report.calls
            self.in_doubt += report.in_doubt
            self.reasoner_calls += report.asked

    def as_row(self) -> dict[str, int | float]:
        """The sums by name."""
        counted = {name: getattr(self, name) for name in self.__struct_fields__}
        return counted | {"cpu_s_per_seed": round(self.cpu_s / max(1, self.seeds), 4)}


def trial(seed: int, driver: str = "simulated") -> Trial:
    """Play a seed twice, and compare."""
    plan = draw(seed)
    with tempfile.TemporaryDirectory(prefix="wakeful-chaos-", dir=_SHM if _SHM.is_dir() else None) as folder:
        if driver == "live":
            journal = Path(folder, "mind.db")  # what is refused while the disk is full names it
            first = play_live(plan, journal)
            for file in Path(folder).iterdir():
                file.unlink()
            second = play_live(plan, journal)  # who is parked takes time to be rebuilt, and time decides what a turn holds
            differs = _difference(first.export, second.export)
            return Trial(plan=plan, driver=driver, first=first, second=second, compared="before", differs=differs)
        first = play(plan, Path(folder, "first.db"))
        calm = plan.repeatable and bool(plan.ends)
        again = msgspec.structs.replace(plan, ends=() if calm else plan.ends, keep_waiting=NOBODY_PARKED)
        second = play(again, Path(folder, "second.db") if again.ends else None)
    differs = _difference(first.export, second.export)
    return Trial(plan=plan, first=first, second=second, compared="undisturbed" if calm else "before", differs=differs)


def _difference(first: list[Line], second: list[Line]) -> str:
    if first == second or any(isinstance(line.record, Answered) and line.record.error == IN_DOUBT for line in first):
        return ""  # a call with effect that was in doubt is told to a person and not made again: that life went another way
    for one, other in zip(first, second, strict=False):
        if one != other:
            return f"line {one.position} is {str(one)[:300]} and was {str(other)[:300]}"
    return f"it has {len(first)} lines and had {len(second)}"
