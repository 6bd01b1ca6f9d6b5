"""The drift alarm, measured: how often it is false while nothing changes, how soon it comes, and what it takes a change for.

Run: `python -m benchmarks.drift_alarm [--json]`. Streams of results of one treatment over four kinds of events, made from seeds:
a share of outcomes is wrong from the beginning; then either nothing changes, or outcomes become noisier for all kinds, or the
outcome of one kind is another one from then on (a quarter of the events). The alarm is the product's, with its own settings.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from random import Random
from statistics import median

from wakeful.facts.experience import Experience, Verdict
from wakeful.revision.drift import Alarm, Drift, DriftSettings

QUIET_RUNS, QUIET_RESULTS = 100, 4_000
CHANGED_RUNS, BEFORE, AFTER = 200, 400, 400
KINDS = ("none", "slip", "jam", "stall")


def stream(random: Random, results: int, noise: float, changed: bool = False) -> Iterator[Experience]:
    """``results`` decided results; with ``changed`` a forecast of the last kind fails nearly always."""
    for number in range(results):
        predicted = random.choice(KINDS)
        wrong = random.random() < (0.97 if changed and predicted == KINDS[-1] else noise)
        others = [kind for kind in KINDS if kind != predicted]
        outcome = (others[0] if changed and predicted == KINDS[-1] else random.choice(others)) if wrong else predicted
        yield Experience(
            id=number,
            event=str(number),
            process=number,
            treatment="diagnosis",
            treatment_label="",
            predicted=predicted,
            outcome=outcome,
            verdict=Verdict.CONTRADICTED if wrong else Verdict.SUPPORTED,
            mode="auto",
        )


def alarms(parts: list[Iterator[Experience]]) -> Iterator[tuple[int, Alarm]]:
    """The alarms over the parts one after the other, with the number of results up to each."""
    drift, seen = Drift(), 0
    for part in parts:
        for experience in part:
            seen += 1
            drift.learn(experience)
            alarm = drift.alarm(experience.treatment)
            if alarm is not None:
                yield seen, alarm
                drift.reset(experience.treatment)


def quiet(noise: float) -> dict[str, object]:
    """False alarms while nothing changes."""
    found = sum(1 for seed in range(QUIET_RUNS) for _ in alarms([stream(Random(seed), QUIET_RESULTS, noise)]))
    results = QUIET_RUNS * QUIET_RESULTS
    return {"world": f"nothing changes, {noise:.0%} wrong", "runs": QUIET_RUNS, "false_alarms_per_10000": 1e4 * found / results}


def changing(name: str, noise: float, after: float, changed: bool) -> dict[str, object]:
    """How soon the first alarm after the change comes, and what it says that happened."""
    delays: list[int] = []
    called_changed = 0
    for seed in range(CHANGED_RUNS):
        random = Random(10_000 + seed)
        parts = [stream(random, BEFORE, noise), stream(random, AFTER, after, changed)]
        first = next(((seen, alarm) for seen, alarm in alarms(parts) if seen > BEFORE), None)
        if first is not None:
            delays.append(first[0] - BEFORE)
            called_changed += first[1].changed
    delays.sort()
    return {
        "world": name,
        "runs": CHANGED_RUNS,
        "told": len(delays) / CHANGED_RUNS,
        "delay_median": median(delays) if delays else None,
        "delay_p90": delays[int(0.9 * (len(delays) - 1))] if delays else None,
        "called_changed": called_changed / len(delays) if delays else None,
    }


def rows() -> list[dict[str, object]]:
    """Every world that is measured."""
    return [
        *(quiet(noise) for noise in (0.02, 0.1, 0.3)),
        changing("noise 10 % → 20 %", 0.1, 0.2, False),
        changing("noise 10 % → 30 %", 0.1, 0.3, False),
        changing("noise 10 % → 50 %", 0.1, 0.5, False),
        changing("one kind's outcome changes, 2 % noise", 0.02, 0.02, True),
        changing("one kind's outcome changes, 10 % noise", 0.1, 0.1, True),
    ]


def main() -> None:
    """Print the table."""
    found = rows()
    if "--json" in sys.argv:
        print(json.dumps(found, indent=2))
        return
    print(
        f"alarms at most once in {DriftSettings().every:,.0f} results on average (setting); "
        f"seeds 0 to {QUIET_RUNS - 1}, and {CHANGED_RUNS} from 10000 on"
    )
    print(f"{'world':42} {'runs':>5} {'false/10,000':>13} {'told':>6} {'delay':>6} {'p90':>5} {'called changed':>15}")
    for row in found:
        cells = [
            f"{row['false_alarms_per_10000']:.2f}" if "false_alarms_per_10000" in row else "",
            f"{row['told']:.0%}" if "told" in row else "",
            str(row.get("delay_median", "")),
            str(row.get("delay_p90", "")),
            f"{row['called_changed']:.0%}" if row.get("called_changed") is not None else "",
        ]
        print(f"{row['world']:42} {row['runs']:>5} {cells[0]:>13} {cells[1]:>6} {cells[2]:>6} {cells[3]:>5} {cells[4]:>15}")


if __name__ == "__main__":
    main()
