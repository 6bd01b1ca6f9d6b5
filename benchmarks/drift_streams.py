"""Learning while the world drifts: four recorded streams through the whole runtime, outcomes late, beside river's learners.

    ./run python -m benchmarks.drift_streams [--stream NAME] [--events N] [--json]

Wants ../shared/data and river (dev group `bench`). Each row is an event; a kernel with the product's defaults forecasts its class
by a treatment that says what the mind's prior says, and the outcome is told 20 events later. Nobody helps: the reasoner that it
deliberates with is the offline guidelines, and none are written for these streams, so it knows nothing. river's adaptive random
forest and leveraging bagging, both with their defaults and seed 0, answer each event before its class is known and learn it 20
events later; no-change says the class that was last known. Nothing was chosen on any of these streams.

Automatic share and error are those of the gate `guarantee` at α = 5 %: wrong and automatic, of all events. Revision: the events
from a labelled change point until the runtime changes something because of contradictions (trust lowered, an alarm, a certificate
revoked, or a new model version). Costs are CPU time per event, as a ratio to no-change in the same run.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import time
from bisect import bisect_left
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import median

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import msgspec
import numpy as np

from benchmarks.streams import DATA
from wakeful import Event, MindView, Registry, Result, treatment
from wakeful.contracts.detector import DetectorFactory
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.domain import DomainSpec, FieldSpec, OutcomeSpec
from wakeful.facts.events import Draft, Observation
from wakeful.facts.evidence import Outcome
from wakeful.facts.inputs import Mark
from wakeful.facts.lines import Admitted, Answered, Concluded, Drifted, Published, Revoked, Trusted
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import NS_PER_S
from wakeful.journal import MemoryJournal

DELAY = 20
FIRST = 0.1
"""The part of a stream from which the numbers' ranges are taken; nothing of it is counted."""


class Rows(msgspec.Struct, frozen=True):
    """A stream: numbers, class, and the rows at which it is labelled to change."""

    name: str
    x: np.ndarray
    y: tuple[str, ...]
    changes: tuple[int, ...] = ()


class Says(Result, frozen=True, kw_only=True, tag="forecasting"):
    """What the prior says."""


@treatment("forecasting", result=Says, says="Forecasts the class of a row.")
async def forecasting(event: Event, mind: MindView) -> Says:  # noqa: ARG001  # the mind has read it
    """One step, and the mind's own forecast."""
    await mind.work(1)
    return Says(says="a row", confidence=0.5, forecast=mind.forecast())


class OneDomain:
    """A domain that is only its data."""

    def __init__(self, rows: Rows) -> None:
        first = rows.x[: max(50, round(FIRST * len(rows.x)))]
        low, high = first.min(axis=0), first.max(axis=0)
        fields = {
            f"x{place}": FieldSpec(low=float(low[place]), high=float(max(high[place], low[place] + 1e-9)))
            for place in range(rows.x.shape[1])
        }
        self.spec = DomainSpec(
            name=rows.name,
            version=1,
            says="a recorded stream",
            fields=fields,
            outcome=OutcomeSpec(labels=tuple(sorted(set(rows.y))), within_s=10.0 * DELAY),
            treatments=("forecasting",),
        )

    def detectors(self) -> Mapping[str, DetectorFactory]:
        """None: rows are events."""
        return {}

    def simulate(self, seed: int) -> Iterator[Observation] | None:  # noqa: ARG002
        """None: it is recorded."""
        return None


def wakeful(rows: Rows) -> dict[str, object]:
    """The whole runtime over the stream."""
    domain = OneDomain(rows)
    settings = MindSettings(step_s=0.0, gate="guarantee", alpha=0.05, delta=0.05, audit_rate=0.5)
    kernel, learner = assemble(domain, settings, registry=Registry(own=(forecasting,), installed=()))
    journal = MemoryJournal()
    began_s = time.process_time()
    driver = SimulatedDriver(kernel, journal, GuidelineReasoner(domain.spec), learner)
    driver.begin("rows", rows.name)
    names = list(domain.spec.fields)
    waiting: deque[tuple[str, str]] = deque()
    for place, values in enumerate(rows.x.tolist()):
        at_ns = (place + 1) * NS_PER_S
        inputs: list[object] = []
        if len(waiting) == DELAY:
            event, label = waiting.popleft()
            # The world shows it now: an outcome that lay at its event's own instant would not be of that event.
            inputs.append(Outcome(id=event, topic="outcome", entity="rows", label=label, at_ns=at_ns, event=event, source="rows"))
        fields = dict(zip(names, values, strict=True))
        inputs.append(Draft(kind="row", entity="rows", source="rows", position=place, at_ns=at_ns, fields=fields))
        inputs.append(Mark(source="rows", position=place))
        lines = driver.put(inputs, at_ns)  # type: ignore[arg-type]
        event = next(line.record.event.id for line in lines if isinstance(line.record, Admitted))
        waiting.append((event, rows.y[place]))
    driver.close()
    spent_s = time.process_time() - began_s
    return {"method": "wakeful", **_told(rows, journal), "cpu_us": 1e6 * spent_s / len(rows.y)}


def _told(rows: Rows, journal: MemoryJournal) -> dict[str, object]:
    said: dict[str, str] = {}
    mode: dict[str, str] = {}
    order: list[str] = []
    revisions: list[int] = []
    calls = 0
    for line in journal.lines():
        record = line.record
        if isinstance(record, Admitted):
            order.append(record.event.id)
        elif isinstance(record, Concluded) and record.event not in mode:
            mode[record.event] = record.mode
            said[record.event] = record.forecast.label if record.forecast is not None else ""
        elif isinstance(record, Answered):
            calls += record.calls
        elif (
            isinstance(record, Drifted | Revoked)
            or (isinstance(record, Published) and record.card.accepted)
            or (isinstance(record, Trusted) and record.after < record.before)
        ):
            revisions.append(len(order))
    begin = round(FIRST * len(order))
    right = [said.get(event, "") == label for event, label in zip(order, rows.y, strict=True)][begin:]
    auto = [mode.get(event) == "auto" for event in order][begin:]
    waits = [revisions[at] - change for change in rows.changes if (at := bisect_left(revisions, change)) < len(revisions)]
    return {
        "accuracy": float(np.mean(right)),
        "automatic": float(np.mean(auto)),
        "wrong_and_automatic": float(np.mean([a and not r for a, r in zip(auto, right, strict=True)])),
        "reasoner_calls": calls,
        "events_until_revision": median(waits) if waits else None,
    }


def rivals(rows: Rows) -> Iterator[dict[str, object]]:
    """river's learners and no-change, each told late."""
    from river import dummy, ensemble, forest, preprocessing, tree  # noqa: PLC0415  # a peer, not a dependency

    bagged = ensemble.LeveragingBaggingClassifier(model=tree.HoeffdingTreeClassifier(), seed=0)
    for name, model in (
        ("no change", dummy.NoChangeClassifier()),
        ("adaptive random forest", forest.ARFClassifier(seed=0)),
        ("leveraging bagging", preprocessing.StandardScaler() | bagged),
    ):
        began_s = time.process_time()
        waiting: deque[tuple[dict[str, float], str]] = deque()
        right = []
        for values, label in zip(rows.x.tolist(), rows.y, strict=True):
            if len(waiting) == DELAY:
                model.learn_one(*waiting.popleft())
            row = {f"x{place}": value for place, value in enumerate(values)}
            right.append(model.predict_one(row) == label)
            waiting.append((row, label))
        spent_s = time.process_time() - began_s
        counted = right[round(FIRST * len(right)) :]
        yield {"method": name, "accuracy": float(np.mean(counted)), "cpu_us": 1e6 * spent_s / len(rows.y)}


def streams(limit: int | None) -> Iterator[Rows]:
    """The recorded streams, or their first ``limit`` rows."""
    for name, file in (("elec2", "elec.csv"), ("weather", "weather.csv")):
        table = np.genfromtxt(DATA / "elec2_weather" / file, delimiter=",", skip_header=1)
        yield _cut(Rows(name, table[:, :-1], tuple(f"class {int(each)}" for each in table[:, -1])), limit)
    folder = DATA / "outdoor_robot_stream"
    x = np.loadtxt(folder / "outdoorStream.data")
    yield _cut(Rows("outdoor", np.sqrt(np.maximum(x, 0.0)), tuple(f"object {each}" for each in _words(folder))), limit)
    yield _cut(_skab(DATA / "skab"), limit)


def _words(folder: Path) -> Sequence[str]:
    return (folder / "outdoorStream.labels").read_text().split()


def _skab(folder: Path) -> Rows:
    """The rig's experiments one after the other: is this second anomalous?"""
    values: list[list[float]] = []
    labels: list[str] = []
    changes: list[int] = []
    for path in sorted(folder.glob("valve1/*.csv"), key=lambda each: int(each.stem)):
        with path.open() as file:
            for row in csv.DictReader(file, delimiter=";"):
                if float(row["changepoint"]) > 0:
                    changes.append(len(labels))
                labels.append("anomalous" if float(row["anomaly"]) > 0 else "normal")
                values.append([float(value) for name, value in row.items() if name not in ("datetime", "anomaly", "changepoint")])
    return Rows("skab", np.array(values), tuple(labels), tuple(changes))


def _cut(rows: Rows, limit: int | None) -> Rows:
    if limit is None or len(rows.y) <= limit:
        return rows
    return Rows(rows.name, rows.x[:limit], rows.y[:limit], tuple(each for each in rows.changes if each < limit))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--stream")
    parser.add_argument("--events", type=int)
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    found = []
    for rows in streams(asked.events):
        if asked.stream in (None, rows.name):
            told = [*rivals(rows), wakeful(rows)]
            floor = next(row["cpu_us"] for row in told if row["method"] == "no change")
            found += [{"stream": rows.name, "events": len(rows.y), **row, "ratio": row["cpu_us"] / floor} for row in told]  # type: ignore[operator]
    if asked.json:
        print(json.dumps(found, indent=2))
        return
    print(
        f"{'stream':8} {'events':>6} {'method':24} {'right':>6} {'automatic':>9} {'wrong auto':>10} {'calls':>6} "
        f"{'until revision':>14} {'CPU':>6}"
    )
    for row in found:
        cells = [f"{100 * row[name]:.1f}" if name in row else "" for name in ("automatic", "wrong_and_automatic")]
        until = row.get("events_until_revision")
        print(
            f"{row['stream']:8} {row['events']:>6} {row['method']:24} {100 * row['accuracy']:6.1f} {cells[0]:>9} {cells[1]:>10} "
            f"{row.get('reasoner_calls', ''):>6} {'' if until is None else until:>14} {row['ratio']:5.0f}×"
        )


if __name__ == "__main__":
    main()
