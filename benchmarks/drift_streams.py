"""Learning while the world drifts: five recorded streams through the whole runtime, outcomes late, beside river's learners.

    ./run python -m benchmarks.drift_streams [--stream NAME] [--events N] [--json]

Wants ../shared/data, river (dev group `bench`) and the extra `xlsx`. Each row is an event; a kernel with the product's defaults
forecasts its class by a treatment that says what the mind's prior says, and the outcome is told 20 events later. Nobody helps:
the reasoner that it deliberates with is the offline guidelines, and none are written for these streams, so it is a stand-in that
knows nothing but how like cases ended. river's adaptive random forest and leveraging bagging, both with their defaults and seed
0, answer each event before its class is known and learn it 20 events later; no-change says the class that was last known.

What was chosen was chosen on the first 3,000 events of Elec2, which are left out here: `elec2` begins after them. Of UR3 the
class is what comes within the next 20 s. Of `outdoor` half as many events are taken: leveraging bagging takes a tenth of a second
for each.

Automatic share and error are those of the gate `guarantee` at α = 5 %: wrong and automatic, of all events. Revision: the events
from a labelled change point until the runtime changes something because of contradictions (trust lowered, an alarm, a certificate
revoked, or a new model version). Costs are CPU time per event. The first tenth of a stream gives the numbers' ranges and is not
counted.
"""

from __future__ import annotations

import argparse
import csv
import itertools
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
from wakeful.bridges.xlsx import XlsxBridge
from wakeful.contracts.detector import DetectorFactory
from wakeful.contracts.learner import Learner
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.domain import DomainSpec, FieldSpec, OutcomeSpec
from wakeful.facts.events import Draft, Observation
from wakeful.facts.evidence import Outcome
from wakeful.facts.inputs import Mark
from wakeful.facts.lines import Admitted, Answered, Concluded, Decided, Drifted, Published, Revoked, Trusted
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import NS_PER_S
from wakeful.journal import MemoryJournal
from wakeful.kernel import Kernel

DELAY = 20
CHOSEN_ON = 3000
"""The first events of Elec2, on which learning's settings were chosen."""
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


def mind(rows: Rows) -> tuple[Kernel, Learner]:
    """A kernel with the product's defaults, under the guarantee gate."""
    settings = MindSettings(step_s=0.0, gate="guarantee", alpha=0.05, delta=0.05, audit_rate=0.5)
    return assemble(OneDomain(rows), settings, registry=Registry(own=(forecasting,), installed=()))


def wakeful(rows: Rows) -> dict[str, object]:
    """The whole runtime over the stream."""
    journal = MemoryJournal()
    began_s = time.process_time()
    lived(rows, *mind(rows), journal)
    spent_s = time.process_time() - began_s
    return {"method": "wakeful", **_told(rows, journal), "cpu_us": 1e6 * spent_s / len(rows.y)}


def lived(rows: Rows, kernel: Kernel, learner: Learner, journal: MemoryJournal) -> None:
    """The mind meets every row, and hears of each outcome ``DELAY`` rows later."""
    domain = kernel.domain
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


def _told(rows: Rows, journal: MemoryJournal) -> dict[str, object]:
    said: dict[str, str] = {}
    mode: dict[str, str] = {}
    alone: dict[str, str] = {}
    order: list[str] = []
    revisions: list[int] = []
    calls = 0
    for line in journal.lines():
        record = line.record
        if isinstance(record, Admitted):
            order.append(record.event.id)
        elif isinstance(record, Decided) and record.event not in alone:
            model = record.decision.foretold or record.decision.prior
            alone[record.event] = max(model, key=lambda label: model[label], default="")
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
    by_model = [alone.get(event, said.get(event, "")) == label for event, label in zip(order, rows.y, strict=True)][begin:]
    return {
        "accuracy": float(np.mean(right)),
        "model_alone": float(np.mean(by_model)),
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
    for name, file, skipped in (("elec2", "elec.csv", CHOSEN_ON), ("weather", "weather.csv", 0)):
        table = np.genfromtxt(DATA / "elec2_weather" / file, delimiter=",", skip_header=1)[skipped:]
        yield _cut(Rows(name, table[:, :-1], tuple(f"class {int(each)}" for each in table[:, -1])), limit)
    folder = DATA / "outdoor_robot_stream"
    x = np.loadtxt(folder / "outdoorStream.data")
    yield _cut(
        Rows("outdoor", np.sqrt(np.maximum(x, 0.0)), tuple(f"object {each}" for each in _words(folder))), limit and limit // 2
    )
    yield _cut(_ur3(DATA / "ur3_cobotops" / "dataset.xlsx"), limit)
    yield _cut(_skab(DATA / "skab"), limit)


def _words(folder: Path) -> Sequence[str]:
    return (folder / "outdoorStream.labels").read_text().split()


def _ur3(path: Path) -> Rows:
    """The arm, second by second: will it stop to protect, or lose its grip, within what follows?"""
    values: list[list[float]] = []
    ends: list[str] = []
    for item in XlsxBridge().read(path):
        if isinstance(item, Observation):
            told = {name: value for name, value in item.values.items() if isinstance(value, bool | int | float)}
            ends.append("stop" if told.get("Robot_ProtectiveStop") else "grip lost" if told.get("grip_lost") else "")
            values.append([float(value) for name, value in sorted(told.items()) if name not in ("Num", "cycle", "cycle ")])
    width = max(map(len, values))
    whole = [place for place, row in enumerate(values) if len(row) == width]
    coming = [next((end for end in ends[place + 1 : place + 1 + DELAY] if end), "none") for place in whole]
    return Rows("ur3", np.array([values[place] for place in whole]), tuple(coming))


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
    parser.add_argument("--events", type=int, default=3000)
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    found = []
    if not asked.json:
        print(
            f"{'stream':8} {'events':>6} {'method':24} {'right':>6} {'model alone':>11} {'automatic':>9} {'wrong auto':>10} "
            f"{'calls':>6} {'until revision':>14} {'ms/event':>9}"
        )
    for rows in streams(asked.events):
        if asked.stream not in (None, rows.name):
            continue
        for told in itertools.chain(rivals(rows), [wakeful(rows)]):
            row = {"stream": rows.name, "events": len(rows.y), **told}
            found.append(row)
            if not asked.json:
                print(line(row), flush=True)
    if asked.json:
        print(json.dumps(found, indent=2))


def line(row: Mapping[str, object]) -> str:
    """One row of the table."""
    shares = [f"{100 * row[name]:.1f}" if name in row else "" for name in ("model_alone", "automatic", "wrong_and_automatic")]  # type: ignore[operator]
    until = row.get("events_until_revision")
    return (
        f"{row['stream']:8} {row['events']:>6} {row['method']:24} {100 * row['accuracy']:6.1f} {shares[0]:>11} {shares[1]:>9} "  # type: ignore[operator]
        f"{shares[2]:>10} {row.get('reasoner_calls', ''):>6} {'' if until is None else until:>14} {row['cpu_us'] / 1000:9.2f}"  # type: ignore[operator]
    )


if __name__ == "__main__":
    main()
