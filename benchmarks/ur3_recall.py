"""How many of the UR3's incidents registration noticed beforehand, how early, and at what rate of events.

    python benchmarks/ur3_recall.py [--recording FILE] [--domain NAME] [--seed N] [--json]

An incident is a stretch of rows with the flag up (`Robot_ProtectiveStop`, `grip_lost`); a blank flag is unknown and neither
begins nor ends one. It was noticed with a lead window of w seconds if an event was registered strictly before its first
row and at most w seconds before. Three columns keep the number honest:

- `chance`: as many events placed at random over the time observed;
- `shifted`: the same events, all shifted in time by the same random amount (1,000 shifts), so that their bunching
  counts: mean and 95 % quantile over the shifts;
- the rows `without` leave out the events that are themselves an incident (stop, lost grip): an incident foretells the next.

The domain's settings were chosen on the first 60 % of the rows; the last 40 % are printed by themselves.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from random import Random
from statistics import fmean, median, quantiles

from wakeful.bridges.xlsx import XlsxBridge
from wakeful.contracts.bridge import SourceError
from wakeful.domains import DomainError, load
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Draft, Observation
from wakeful.facts.time import to_s
from wakeful.registration import Incident, SpecRegistrar, recall

RECORDING = Path(__file__).parents[2] / "shared" / "data" / "ur3_cobotops" / "dataset.xlsx"
WINDOWS_S = (5.0, 10.0, 30.0, 60.0)
TUNED_SHARE = 0.6
LONGEST_STEP_S = 10.0
SHIFTS = 1000
REPEATS = 5


def incidents_in(observations: Sequence[Observation], spec: DomainSpec) -> list[Incident]:
    """The stretches of rows in which a flag is up, with their length in rows."""
    found = []
    for source in spec.outcomes:
        name = source.channel.rpartition("/")[2]
        start_ns, rows = 0, 0
        for observation in observations:
            flag = observation.values.get(name)
            if flag:
                start_ns = start_ns if rows else observation.at_ns
                rows += 1
            elif flag is not None and rows:
                found.append(Incident(label=source.label, at_ns=start_ns, observations=rows))
                rows = 0
        if rows:
            found.append(Incident(label=source.label, at_ns=start_ns, observations=rows))
    return found


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


def tables(observations: Sequence[Observation], events: Sequence[Draft], spec: DomainSpec, seed: int) -> list[dict[str, object]]:
    """One row for each part of the recording, choice of events, window and label."""
    axis = observed_axis(observations)
    incidents = incidents_in(observations, spec)
    own = {source.label for source in spec.outcomes}
    cut = round(TUNED_SHARE * len(observations))
    parts = {"all": observations, "first 60 %": observations[:cut], "last 40 %": observations[cut:]}
    made: list[dict[str, object]] = []
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
                    made.append({
                        "part": part, "events": choice, "window_s": window_s, "label": each.label, "n_events": len(chosen),
                        "events_per_hour": len(chosen) / (span_s[1] - span_s[0]) * 3600, "incidents": each.incidents,
                        "preceded": each.preceded, "recall": each.share, "rows": each.observations, "rows_recall": each.observations_share,
                        "lead_s": each.lead_s, "chance": each.chance, "shifted_mean": mean, "shifted_95": high,
                    })  # fmt: skip
    return made


def cost(observations: Sequence[Observation], domain: str) -> dict[str, float]:
    """Microseconds of processor time an observation, against a plain loop that reads every value of it, in the same process."""

    def plain() -> None:
        total = 0.0
        for observation in observations:
            for value in observation.values.values():
                if value.__class__ is float:
                    total += value

    def spent(run: Callable[[], object]) -> float:
        times = []
        for _ in range(REPEATS):
            start = time.process_time()
            run()
            times.append((time.process_time() - start) / len(observations) * 1e6)
        return median(times)

    unheard = [
        Observation(source="s", position=at, topic="unheard", at_ns=at, values=observations[0].values) for at in range(7000)
    ]
    spec = load(domain).spec
    hears_all = any(detector.detector == "silence" for detector in spec.detect)
    registrar = SpecRegistrar(load(domain), "benchmark")
    silent_us = spent(lambda: [registrar.observe(each) for each in unheard]) * len(observations) / len(unheard)
    loop_us, register_us = spent(plain), spent(lambda: register(observations, domain))
    return {"plain_loop_us": loop_us, "register_us": register_us, "ratio": register_us / loop_us, "unheard_topic_us": silent_us,
            "silence_watches": float(hears_all)}  # fmt: skip


def main() -> int:
    """Print the tables. Returns 0, or 1 with one line on standard error where the recording or the domain can't be used."""
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
    made = tables(observations, events, spec, options.seed)
    names = [source.channel.rpartition("/")[2] for source in spec.outcomes]
    blank = sum(any(each.values.get(name) is None for name in names) for each in observations)
    kinds: dict[str, int] = {}
    for event in events:
        kinds[event.kind] = kinds.get(event.kind, 0) + 1
    costs = cost(observations, options.domain)
    if options.json:
        print(json.dumps({"rows": len(observations), "unlabelled_rows": blank, "events": len(events), "kinds": kinds,
                          "observations_per_event": len(observations) / max(len(events), 1), "cost": costs, "recall": made}))  # fmt: skip
        return 0
    print(
        f"{len(observations)} rows, {blank} without a label; {len(events)} events, one for {len(observations) / max(len(events), 1):.1f} rows"
    )
    print("events by kind: " + ", ".join(f"{kind} {count}" for kind, count in sorted(kinds.items(), key=lambda pair: -pair[1])))
    print(f"{'part':<10} {'events':<8} {'/h':>5} {'window':>6}  {'incident':<16} {'n':>4} {'recall':>7} {'of rows':>8}"
          f" {'chance':>7} {'shifted (95 %)':>15}  lead s: median (quartiles)")  # fmt: skip
    for row in made:
        lead = row["lead_s"]
        early = f"{lead[1]:.0f} ({lead[0]:.0f} to {lead[2]:.0f})" if isinstance(lead, tuple) else "none"
        print(f"{row['part']:<10} {row['events']:<8} {row['events_per_hour']:5.0f} {row['window_s']:6.0f}  {row['label']:<16} {row['incidents']:4d}"
              f" {row['recall']:7.2f} {row['rows_recall']:8.2f} {row['chance']:7.2f} {row['shifted_mean']:8.2f} ({row['shifted_95']:.2f})  {early}")  # fmt: skip
    print(f"cost: {costs['register_us']:.1f} µs a row ({costs['ratio']:.1f} times a plain loop over its values,"
          f" {costs['plain_loop_us']:.1f} µs); a topic nobody looks at: {costs['unheard_topic_us']:.2f} µs")  # fmt: skip
    return 0


if __name__ == "__main__":
    sys.exit(main())
