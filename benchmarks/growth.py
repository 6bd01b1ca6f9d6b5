"""Growth: an endless stream keeps the journal under a bound, with open processes, debt and provenance as they were.

    python -m benchmarks.growth --events 10000000 --days 30

writes synthetic events (eight fields, automatic, judged) straight into a journal, as the entries that a kernel gives, with
the documented retention; compaction runs between the commits, as between a mind's. One event in 2,000 stays open, one in 2,000
ends in debt, and one in 50,000 comes with a new model. Prints the file's size over time, and in the end whether what is owed is
there.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from collections.abc import Iterator
from hashlib import blake2b
from pathlib import Path
from random import Random

import msgspec

from wakeful.facts.choices import Basis, Choice
from wakeful.facts.decisions import Decision
from wakeful.facts.events import Event, event_id
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience, ModelCard, Verdict
from wakeful.facts.lines import (
    Admitted,
    AnyRecord,
    Compacted,
    Concluded,
    Created,
    Decided,
    Judged,
    Line,
    Moved,
    Opened,
    Published,
    TrainingAsked,
)
from wakeful.facts.packs import AnyBurst, Covered, Entry, Pack, Ran, Validated
from wakeful.facts.processes import State, Trigger
from wakeful.facts.time import Stamp
from wakeful.facts.values import Raw
from wakeful.journal import open_journal
from wakeful.journal.audit import audit
from wakeful.journal.retention import Retention

OPEN_ONE_IN, DEBT_ONE_IN, MODEL_ONE_IN = 2_000, 2_000, 50_000
EVENTS_PER_COMMIT = 200

#: The audit reads every line that is left: above so many events it takes longer than the stream.
AUDITED = 200_000

LABELS = ("none", "intervention")
TREATMENTS = ("analogy", "description", "diagnosis", "memory", "planning", "risk_prediction")
_RESULT = Raw(
    b'{"type":"description","says":"as usual; expect none (98 %).","confidence":0.9,'
    b'"forecast":{"label":"none","probability":0.98}}'
)


class Size(msgspec.Struct):
    """The journal at one instant of the stream. ``file_mb`` is what lies on the disk, ``wal_mb`` its write-ahead file."""

    events: int
    day: float
    file_mb: float
    wal_mb: float
    open: int
    debt: int
    cpu_us_per_event: float
    tidy_us_per_event: float
    longest_step_ms: float
    longest_step_cpu_ms: float


class Stream:
    """Entries of synthetic events, as a kernel would have them committed; one in so many stays open, or brings a new model."""

    def __init__(
        self, days: float, events: int, seed: int, open_one_in: int = OPEN_ONE_IN, model_one_in: int = MODEL_ONE_IN
    ) -> None:
        self._open_one_in, self._model_one_in = open_one_in, model_one_in
        self._draw = Random(seed)
        self._spacing_ns = int(days * 86_400e9 / events)
        self._position = 0
        self._number = 0
        self._experience = 0
        self._model = 0
        self.kept: dict[int, list[Line]] = {}
        """What must still be there at the end: the lines of open processes and of debt, and of published models."""
        self.open = self.debt = 0
        self.blobs: dict[str, bytes] = {}
        self._basis: Basis | None = None

    def begin(self) -> list[Entry]:
        """The opening of the source."""
        return [
            self._line(Opened(source="robot", digest="growth", domain="service_robot", domain_version=1, offset_ns=0, seed=0))
        ]

    def next(self) -> Iterator[Entry]:
        """One more event, wholly treated and judged, or open, or in debt."""
        self._number += 1
        number = self._number
        event = self._event(number)
        if number % self._model_one_in == 0:
            self._model += 1
            yield from self._published()
        if number % self._open_one_in == 7:
            self.open += 1
            yield self._keep(self._pack(self._covered(event)))
        elif number % DEBT_ONE_IN == 11:
            self.debt += 1
            for record in self._fallback(event):
                yield self._keep(self._line(record))
        else:
            yield self._pack(self._covered(event))
            yield self._pack(
                Ran(
                    process=number,
                    event=event.id,
                    before=State.CREATED,
                    steps_before=0,
                    steps=3,
                    treatment="description",
                    mode="auto",
                    result=_RESULT,
                    closes_ns=self._at_ns + 30_000_000_000,
                )
            )
            yield self._pack(self._judged(event))

    @property
    def _at_ns(self) -> int:
        return self._number * self._spacing_ns

    def _line(self, record: AnyRecord) -> Line:
        self._position += 1
        return Line(self._position, self._at_ns, record)

    def _pack(self, burst: AnyBurst) -> Pack:
        pack = Pack(self._position + 1, self._at_ns, burst)
        self._position = pack.last
        return pack

    def _keep(self, entry: Entry) -> Entry:
        lines = list(entry.lines()) if isinstance(entry, Pack) else [entry]
        self.kept.setdefault(self._number, []).extend(lines)
        return entry

    def _event(self, number: int) -> Event:
        draw = self._draw.random()
        return Event(
            id=event_id("", "growth", number, "object", 0),
            kind="object",
            entity=f"item-{number % 997:04d}",
            source="robot",
            position=number,
            stamp=Stamp(source_ns=self._at_ns, received_ns=self._at_ns),
            fields={
                "category": "item" if draw < 0.5 else "obstacle",
                "location": "center",
                "state": "normal",
                "route": "outside",
                "load": round(draw, 3),
                "x": round(5 * draw - 2.5, 2),
                "y": round(2.5 - 5 * draw, 2),
                "context": "safety",
            },
        )

    def _covered(self, event: Event) -> Covered:
        share = round(0.9 + 0.09 * self._draw.random(), 6)
        rests_on = tuple(max(1, self._experience - self._draw.randrange(10_000)) for _ in range(3)) if self._experience else ()
        choice = Choice(
            basis=self._basis or self._new_basis(),
            shares=(0.01, share, 0.01, 0.01, 0.01, 0.01),
            prior=(0.98, 0.02),
            novelty=round(share / 3, 6),
            trust=0.8,
            rests_on=rests_on,
        )
        return Covered(event=event, process=event.position, choice=choice)

    def _new_basis(self) -> Basis:
        self._basis = Basis(
            treatment="description",
            model=self._model,
            watermark=self._experience,
            treatments=TREATMENTS,
            labels=LABELS,
            threshold=0.6,
            result_threshold=0.5,
            novelty_limit=0.99,
            trust_limit=0.4,
            support=100,
        )
        return self._basis

    def _judged(self, event: Event) -> Validated:
        self._experience += 1
        label = LABELS[0]
        return Validated(
            outcome=Outcome(
                id=event_id("", "o", event.position, "", 0),
                topic="outcome",
                entity=event.entity,
                label=label,
                at_ns=self._at_ns + 1,
                event=event.id,
            ),
            judged=Judged(
                process=event.position,
                event=event.id,
                predicted=label,
                label=label,
                verdict=Verdict.SUPPORTED,
                outcome=event_id("", "o", event.position, "", 0),
            ),
            experience=Experience(
                id=self._experience,
                event=event.id,
                process=event.position,
                treatment="description",
                treatment_label="description",
                predicted=label,
                outcome=label,
                verdict=Verdict.SUPPORTED,
                mode="auto",
            ),
        )

    def _fallback(self, event: Event) -> Iterator[AnyRecord]:
        process = event.position
        decision: Decision = msgspec.structs.replace(self._covered(event).choice.decision(), mode="fallback")
        yield Admitted(event=event)
        yield Created(process=process, event=event.id, treatment=decision.treatment, criticality=0)
        yield Decided(process=process, event=event.id, decision=decision)
        yield Moved(process=process, before=State.CREATED, trigger=Trigger.DISPATCH, after=State.ACTIVE)
        yield Concluded(process=process, event=event.id, treatment=decision.treatment, mode="fallback", result=_RESULT)
        yield Moved(process=process, before=State.ACTIVE, trigger=Trigger.RESOLVE, after=State.COMPLETED, steps=3)

    def _published(self) -> Iterator[Entry]:
        number, base, watermark = self._model, self._model - 1, self._experience
        asked = TrainingAsked(training=number, base=base, watermark=watermark, seed=number, epochs=35, publish_ns=self._at_ns)
        yield self._keep(self._line(asked))
        weights = f"weights of version {number}".encode()
        name = blake2b(weights, digest_size=16).hexdigest()
        self.blobs[name] = weights
        card = ModelCard(version=number, base=base, watermark=watermark, seed=number, epochs=35, blob=name, accepted=True)
        yield self._keep(self._line(Published(training=number, card=card)))
        self._basis = None


class Growth:
    """Writes a stream into a journal, compacting between the commits.

    Args:
        path: of the journal; made.
        events: how many.
        days: of simulated time that they take.
        retention: what the journal keeps.
    """

    def __init__(self, path: Path, events: int, days: float, retention: Retention) -> None:
        self.stream = Stream(days, events, seed=0)
        self.journal = open_journal(path, full_sync=False, retention=retention)
        self._path = path
        self._events, self._days = events, days
        self._spent_s = self._longest_s = self._longest_cpu_s = 0.0

    def run(self, rows: int) -> Iterator[Size]:
        """Yields the journal's size so many times, and at the end."""
        self.journal.commit(self.stream.begin(), {}, {})
        began_s, done, told = time.process_time(), 0, 0
        while done < self._events:
            group = [entry for _ in range(EVENTS_PER_COMMIT) for entry in self.stream.next()]
            self.journal.commit(group, {}, self.stream.blobs)
            self.stream.blobs.clear()
            done += EVENTS_PER_COMMIT
            self._tidy(3)
            if done * rows // self._events > told or done >= self._events:
                told = done * rows // self._events
                yield self._size(done, began_s)

    def finish(self) -> None:
        """Give up all that is old enough by now."""
        while self._tidy(1, least_events=1):
            pass

    def _tidy(self, steps: int, least_events: int = 0) -> bool:
        for _ in range(steps):
            step_s, step_cpu_s = time.perf_counter(), time.process_time()
            more = self.journal.tidy(least_events)
            spent_s = time.process_time() - step_cpu_s
            self._spent_s += spent_s
            self._longest_cpu_s = max(self._longest_cpu_s, spent_s)
            self._longest_s = max(self._longest_s, time.perf_counter() - step_s)
            if not more:
                return False
        return True

    def _size(self, done: int, began_s: float) -> Size:
        wal = self._path.with_name(self._path.name + "-wal")
        longest_s, self._longest_s = self._longest_s, 0.0
        longest_cpu_s, self._longest_cpu_s = self._longest_cpu_s, 0.0
        return Size(
            events=done,
            day=round(self._days * done / self._events, 2),
            file_mb=round(self._path.stat().st_size / 1e6, 1),
            wal_mb=round(wal.stat().st_size / 1e6, 1) if wal.exists() else 0.0,
            open=self.stream.open,
            debt=self.stream.debt,
            cpu_us_per_event=round((time.process_time() - began_s) / done * 1e6, 1),
            tidy_us_per_event=round(self._spent_s / done * 1e6, 2),
            longest_step_ms=round(longest_s * 1e3, 1),
            longest_step_cpu_ms=round(longest_cpu_s * 1e3, 1),
        )

    def missing(self) -> tuple[int, int, Compacted]:
        """How many lines of what is owed lay in what was compacted, how many of them are not as they were, and the counts of the
        rest."""
        boundary = self.journal.compacted()
        owed = {line.position: line for lines in self.stream.kept.values() for line in lines if line.position <= boundary}
        looked, gone = 0, Compacted(first=1, lines=0)
        for line in self.journal.lines():
            if line.position > boundary:
                break
            if isinstance(line.record, Compacted):
                gone = Compacted(first=1, lines=gone.lines + line.record.lines, admitted=gone.admitted + line.record.admitted)
            elif owed.get(line.position) == line:
                looked += 1
        return len(owed), len(owed) - looked, gone


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--events", type=int, default=200_000)
    parser.add_argument("--days", type=float, default=30.0)
    parser.add_argument("--keep-events", type=int, default=Retention().events)
    parser.add_argument("--rows", type=int, default=20, help="lines of the table")
    parser.add_argument("--json", action="store_true")
    chosen = parser.parse_args()
    retention = msgspec.structs.replace(Retention(), events=chosen.keep_events)
    with tempfile.TemporaryDirectory() as folder:
        growth = Growth(Path(folder) / "mind.db", chosen.events, chosen.days, retention)
        names = Size.__struct_fields__
        if not chosen.json:
            print("  ".join(name.rjust(max(9, len(name))) for name in names))
        for size in growth.run(chosen.rows):
            if chosen.json:
                print(msgspec.json.encode(size).decode(), flush=True)
            else:
                cells = (str(getattr(size, name)).rjust(max(9, len(name))) for name in names)
                print("  ".join(cells), flush=True)
        growth.finish()
        owed, missing, gone = growth.missing()
        print(f"compacted: {gone.admitted:,} events, {gone.lines:,} lines")
        print(f"of what is owed {owed:,} lines lie there, {missing} of them are missing")
        if chosen.events <= AUDITED:
            report = audit(growth.journal)
            print(f"audit: {'clean' if report.ok else report.first_offender}, {report.lines:,} lines")
        peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(f"peak memory {peak_mb:.0f} MB")
        growth.journal.close()


if __name__ == "__main__":
    main()
