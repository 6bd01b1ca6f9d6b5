"""How many of the UR3's incidents registration noticed beforehand, how early, and at what rate of events.

    python benchmarks/ur3_recall.py [--recording FILE] [--domain NAME] [--seed N] [--json]

An incident is a stretch of rows with the flag up (`Robot_ProtectiveStop`, `grip_lost`); a blank flag is unknown and neither
begins nor ends one. It was noticed with a lead window of w seconds if an event was registered strictly before its first
row and at most w seconds before. Three columns keep the number honest:

- `chance`: as many events placed at random over the time observed;
- `shifted`: the same events, all shifted in time by the same random amount (1,000 shifts), so that their bunching
  counts: mean and 95 % quantile over the shifts;
- the rows `without` leave out the events that are themselves an incident (stop, lost grip): an incident foretells the next.

The domain's settings were chosen on the first 60 % of the rows; the last 40 % are printed by themselves, and are not quite
blind (docs/ur3_recall.md says in what respects).
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from random import Random
from statistics import fmean, median, quantiles

import msgspec

from wakeful.bridges.xlsx import XlsxBridge
from wakeful.contracts.bridge import SourceError
from wakeful.domains import DomainError, load
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Draft, Observation
from wakeful.facts.time import to_s
from wakeful.registration import Incident, Recall, SpecRegistrar, recall

RECORDING = Path(__file__).parents[2] / "shared" / "data" / "ur3_cobotops" / "dataset.xlsx"
WINDOWS_S = (5.0, 10.0, 30.0, 60.0)
TUNED_SHARE = 0.6
LONGEST_STEP_S = 10.0
SHIFTS = 1000
REPEATS = 5


class Row(msgspec.Struct):
    """One line of the table: a part of the recording, a choice of events, a window, a kind of incident."""

    part: str
    events: str
    events_per_hour: float
    recall: Recall
    shifted_mean: float
    shifted_95: float


class Cost(msgspec.Struct):
    """Microseconds of processor time an observation."""

    plain_loop_us: float
    register_us: float
    ratio: float
    unheard_topic_us: float


class Report(msgspec.Struct):
    """All that is printed. ``after_blank``: incidents whose flag was blank just before, so that they may have begun earlier."""

    rows: int
    unlabelled_rows: int
    after_blank: int
    events: int
    kinds: dict[str, int]
    cost: Cost
    recall: list[Row]


def incidents_in(observations: Sequence[Observation], spec: DomainSpec) -> tuple[list[Incident], int]:
    """The stretches of rows in which a flag is up, with their length in rows; and how many begin just after a blank."""
    found, after_blank = [], 0
    for source in spec.outcomes:
        name = source.channel.rpartition("/")[2]
        start_ns, rows, before_is_blank = 0, 0, False
        for observation in observations:
            flag = observation.values.get(name)
            if flag:
                if not rows:
                    start_ns, after_blank = observation.at_ns, after_blank + before_is_blank
                rows += 1
            elif flag is not None and rows:
                found.append(Incident(label=source.label, at_ns=start_ns, observations=rows))
                rows = 0
            before_is_blank = flag is None
        if rows:
            found.append(Incident(label=source.label, at_ns=start_ns, observations=rows))
    return found, after_blank


def register(observations: Sequence[Observation], domain: str) -> list[Draft]:
    """All events, by a fresh registrar that sees the rows in order."""
    registrar = SpecRegistrar(load(domain), "benchmark")
    return [draft for observation in observations for draft in registrar.observe(observation).events]


def observed_axis(observations: Sequence[Observation]) -> Callable[[int], float]:
    """Source time in nanoseconds to seconds observed: a gap counts as LONGEST_STEP_S."""
    seconds, so_far_s, before_ns = {}, 0.0, observations[0].at_ns
    for observation in observations:
        so_far_s += min(to_s(observation.at_ns - before_ns), LONGEST_STEP_S)
        seconds[observation.at_ns], before_ns = so_far_s, observation.at_ns
    return seconds.__getitem__


def shifted(incidents: Sequence[Incident], events_ns: Sequence[int], axis: Callable[[int], float], span_s: tuple[float, float],
            window_s: float, random: Random) -> dict[str, tuple[float, float]]:  # fmt: skip
    """Recall of the same events shifted round by random amounts: mean and 95 % quantile by label."""
    low_s, length_s = span_s[0], span_s[1] - span_s[0]
    moved = [Incident(label=each.label, at_ns=round(axis(each.at_ns) * 1e9)) for each in incidents]
    places = [axis(at_ns) - low_s for at_ns in events_ns]
    shares: dict[str, list[float]] = {}
    for _ in range(SHIFTS):
        by_s = random.uniform(window_s, max(length_s - window_s, window_s))
        events = [round((low_s + (place + by_s) % length_s) * 1e9) for place in places]
        for each in recall(moved, events, window_s):
            shares.setdefault(each.label, []).append(each.share)
    return {label: (fmean(values), quantiles(values, n=20)[-1]) for label, values in shares.items()}


def table(observations: Sequence[Observation], events: Sequence[Draft], spec: DomainSpec, seed: int) -> list[Row]:
    """One row for each part of the recording, choice of events, window and label."""
    axis = observed_axis(observations)
    incidents, _ = incidents_in(observations, spec)
    own = {source.label for source in spec.outcomes}
    cut = round(TUNED_SHARE * len(observations))
    parts = {"all": observations, "first 60 %": observations[:cut], "last 40 %": observations[cut:]}
    made: list[Row] = []
    for part, rows in parts.items():
        first_ns, last_ns = rows[0].at_ns, rows[-1].at_ns
        span_s = (axis(first_ns), axis(last_ns))
        inside = [each for each in incidents if first_ns <= each.at_ns <= last_ns]
        for choice in ("all", "without"):
            chosen = [e.at_ns for e in events if first_ns <= e.at_ns <= last_ns and (choice == "all" or e.kind not in own)]
            for window_s in WINDOWS_S:
                by_shift = shifted(inside, chosen, axis, span_s, window_s, Random(seed))
                for each in recall(inside, chosen, window_s, span_s[1] - span_s[0]):
                    mean, high = by_shift[each.label]
                    per_hour = len(chosen) / (span_s[1] - span_s[0]) * 3600
                    made.append(Row(part, choice, per_hour, each, mean, high))
    return made


def cost(observations: Sequence[Observation], domain: str) -> Cost:
    """Against a plain loop that reads every value of every observation, in the same process; medians of several runs."""

    def plain() -> None:
        total = 0.0
        for observation in observations:
            for value in observation.values.values():
                if value.__class__ is float:
                    total += value

    def spent_us(run: Callable[[], object], count: int) -> float:
        times = []
        for _ in range(REPEATS):
            start = time.process_time()
            run()
            times.append((time.process_time() - start) / count * 1e6)
        return median(times)

    same = observations[0].values
    unheard = [Observation(source="s", position=at, topic="unheard", at_ns=at, values=same) for at in range(len(observations))]
    registrar = SpecRegistrar(load(domain), "benchmark")
    loop_us, register_us = spent_us(plain, len(observations)), spent_us(lambda: register(observations, domain), len(observations))
    unheard_us = spent_us(lambda: [registrar.observe(each) for each in unheard], len(unheard))
    return Cost(loop_us, register_us, register_us / loop_us, unheard_us)


def show(report: Report) -> None:
    """Print the report for a person."""
    print(
        f"{report.rows} rows; {report.unlabelled_rows} have a blank flag, and {report.after_blank} incidents begin just after one"
    )
    print(f"{report.events} events, one for {report.rows / max(report.events, 1):.1f} rows: " + ", ".join(
        f"{kind} {count}" for kind, count in sorted(report.kinds.items(), key=lambda pair: -pair[1])
    ))  # fmt: skip
    print(f"{'part':<10} {'events':<8} {'/h':>4} {'window':>6}  {'incident':<15} {'n':>4} {'recall':>6} {'of rows':>7}", end="")
    print(f" {'chance':>6} {'shifted (95 %)':>14}  lead s: median (quartiles)")
    for row in report.recall:
        each = row.recall
        early = "none" if each.lead_s is None else f"{each.lead_s[1]:.0f} ({each.lead_s[0]:.0f} to {each.lead_s[2]:.0f})"
        print(f"{row.part:<10} {row.events:<8} {row.events_per_hour:4.0f} {each.window_s:4.0f} s  {each.label:<15}", end="")
        print(f" {each.incidents:4d} {each.share:6.2f} {each.observations_share:7.2f} {each.chance:6.2f}", end="")
        print(f"    {row.shifted_mean:.2f} ({row.shifted_95:.2f})  {early}")
    took = report.cost
    plain = f"{took.ratio:.0f} times a plain loop over its values ({took.plain_loop_us:.1f} µs)"
    print(f"cost: {took.register_us:.0f} µs a row, {plain};", end="")
    print(f" an observation that nobody looks at: {took.unheard_topic_us:.2f} µs")


def main() -> int:
    """Print the report. Returns 0, or 1 with one line on standard error where the recording or the domain can't be used."""
    parser = argparse.ArgumentParser(description="Recall of registration on the UR3 recording")
    parser.add_argument("--recording", type=Path, default=RECORDING)
    parser.add_argument("--domain", default="ur3_cobotops")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true", help="one object on standard output")
    options = parser.parse_args()
    try:
        observations = [item for item in XlsxBridge().read(options.recording) if isinstance(item, Observation)]
        spec = load(options.domain).spec
        events = register(observations, options.domain)
    except (SourceError, DomainError) as error:
        print(error, file=sys.stderr)
        return 1
    flags = [source.channel.rpartition("/")[2] for source in spec.outcomes]
    report = Report(
        rows=len(observations),
        unlabelled_rows=sum(any(each.values.get(flag) is None for flag in flags) for each in observations),
        after_blank=incidents_in(observations, spec)[1],
        events=len(events),
        kinds=dict(Counter(event.kind for event in events)),
        cost=cost(observations, options.domain),
        recall=table(observations, events, spec, options.seed),
    )
    if options.json:
        print(msgspec.json.encode(report).decode())
    else:
        show(report)
    return 0


if __name__ == "__main__":
    sys.exit(main())
