"""Validation: recorded result + outcome → verdict → experience (Eq. 7 and 10)."""

from __future__ import annotations

import msgspec

from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Event
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience, Verdict
from wakeful.facts.lines import (
    GAP,
    Admitted,
    AnyRecord,
    Compacted,
    Concluded,
    Created,
    Finished,
    Gained,
    Imported,
    Judged,
    Moved,
    Noted,
    Opened,
    Refused,
    Witnessed,
)
from wakeful.facts.packs import Ran
from wakeful.facts.processes import State
from wakeful.facts.results import Forecast
from wakeful.facts.time import to_ns
from wakeful.validation.judging import against, judge, silence, supersedes, too_late, undecided
from wakeful.validation.known import KnownEvents
from wakeful.validation.ledger import Entry, Ledger
from wakeful.validation.recordings import ENDED, Recordings
from wakeful.validation.verdict import verdict
from wakeful.validation.witnesses import Witnesses

KEPT_FORECASTS = 10_000
"""Judged forecasts kept for outcomes that come late."""

KEPT_OUTCOMES = 10_000
"""Outcomes kept for results that are concluded after them."""


class Counts(msgspec.Struct, frozen=True):
    """How many forecasts were made and what came of them. A superseded verdict counts once, as it stands now."""

    forecasts: int
    open: int
    supported: int
    contradicted: int
    undecided: int
    witnessed: int
    foreign: int
    """Outcomes whose label the domain does not know: recorded, compared with nothing."""

    @property
    def share_validated(self) -> float:
        """Supported or contradicted, of all forecasts made; 0 where none was."""
        return (self.supported + self.contradicted) / self.forecasts if self.forecasts else 0.0


class Validation:
    """The ledger of open forecasts. Pure: no clock; state changes only in ``apply``.

    What the kernel does with it, each returned Judged being recorded and applied before the next question is put:

    - a result is concluded: ``apply(Concluded)``, then ``concluded(process)`` for outcomes that were there before it;
    - an outcome comes: skip it if ``knows(outcome.id)``; ``apply(Witnessed)``, then ``match(outcome, now)``;
    - at ``next_close_ns()``: ``close(now)``; when a source ends or breaks: ``break_off(now)``;
    - after each ``apply(Judged)``: ``experience(judged)``, recorded as Gained.

    The first outcome in source time decides. A later one that says something else is recorded as undecided and changes
    nothing; one that comes late but lies earlier in source time, or inside a window that had closed over ``none``, supersedes.
    So of several Judged of one process the last that is not undecided holds.
    """

    def __init__(self, spec: DomainSpec, keep_forecasts: int = KEPT_FORECASTS, keep_outcomes: int = KEPT_OUTCOMES) -> None:
        self._spec = spec.outcome
        self._within_ns = to_ns(spec.outcome.within_s)
        self._ledger = Ledger(spec.outcome.scope, keep_forecasts)
        self._witnesses = Witnesses(spec.outcome.scope, keep_outcomes)
        self._events = KnownEvents(keep_forecasts)
        self._quiet = spec.outcome.labels[0]
        self._recordings = Recordings()
        self._next_experience = 1
        self._made = 0
        self._verdicts = dict.fromkeys(Verdict, 0)
        self._witnessed = 0
        self._foreign = 0

    def apply(self, record: AnyRecord, at_ns: int) -> None:
        """Take up one record of the journal, live and in recovery alike. Records that concern other rooms are passed over."""
        match record:
            case Admitted(event=event):
                self._events.admitted(event, self._recordings.since_ns(event))
            case Created(process=process, event=event_id):
                self._events.created(process, event_id)
            case Moved(process=process, after=State.COMPLETED):
                self._events.completed(process)
            case Concluded(forecast=forecast):
                self._enter(record, forecast, at_ns)
            case Witnessed(outcome=outcome):
                self._witness(outcome, at_ns)
            case Judged():
                self._decide(record)
            case Gained(experience=experience) | Imported(experience=experience):
                self._next_experience = max(self._next_experience, experience.id + 1)
            case Compacted(experience=highest):
                self._next_experience = max(self._next_experience, highest + 1)
            case Finished(source=source):
                self._recordings.ended(source, at_ns)
            case Opened(source=source, offset_ns=offset_ns):
                self._recordings.opened(source, offset_ns)
            case Refused(source=source, unread=True):  # it may have been an outcome
                self._recordings.broken(source, at_ns)
            case Noted(what=what, source=source) if what == GAP:
                self._recordings.broken(source, at_ns)

    def knows(self, outcome: str) -> bool:
        """Whether an outcome of that id was witnessed before: the same id counts once."""
        return self._witnesses.get(outcome) is not None

    def match(self, outcome: Outcome, now_ns: int) -> list[Judged]:
        """The verdicts that an outcome brings about (Eq. 10), possibly on several forecasts. Asking twice changes nothing."""
        outcome = self._recordings.in_kernel_time(outcome)
        first = self._witnesses.get(outcome.id)
        if (first is not None and first != outcome) or outcome.label not in self._spec.labels:
            return []
        concerned = self._ledger.concerned(outcome, self._within_ns)
        reached = (entry for entry in concerned if self._recordings.reaches(outcome, entry))
        found = (against(entry, outcome, now_ns, self._quiet) for entry in reached)
        return [judged for judged in found if judged is not None]

    def concluded(self, process: int) -> list[Judged]:
        """The verdicts on a result that was concluded just now, by outcomes witnessed before it.

        Its lead is negative: the world was faster than the thought. At most the first outcome decides; the others are
        recorded as ``match`` would.
        """
        entry = self._ledger.get(process)
        if entry is None or entry.verdict is not None:
            return []
        outcomes = [outcome for outcome in self._witnesses.concerning(entry) if outcome.label in self._spec.labels]
        if not outcomes:
            return []
        first, *later = outcomes
        decisive = judge(entry, first, self._quiet, "the outcome came before the result was concluded")
        return [decisive, *(too_late(entry, other, first.label) for other in later if other.label != first.label)]

    def close(self, now_ns: int, source: str = "") -> list[Judged]:
        """The verdicts on forecasts whose window has closed: ``labels[0]`` over an unbroken recording, else undecided.

        ``source`` confines it to the forecasts on that source's events.
        """
        return [self._closed(entry) for entry in self._ledger.closed(now_ns) if source in ("", entry.source)]

    def break_off(self, now_ns: int, source: str = "") -> list[Judged]:
        """The verdicts when a recording ended or broke: what had closed by then as ``close``, the rest undecided.

        ``source`` confines it to the forecasts on that source's events.
        """
        concerned = [entry for entry in self._ledger.still_open() if source in ("", entry.source)]
        return [self._closed(entry) if entry.closes_ns < now_ns else undecided(entry, ENDED) for entry in concerned]

    def next_close_ns(self) -> int | None:
        """Kernel time at which ``close`` has something to say; None while no forecast is open."""
        return self._ledger.next_close_ns()

    def experience(self, judged: Judged) -> Experience | None:
        """The learning material of an applied verdict (Eq. 7); None where it is undecided or no longer the one that holds.

        An experience of the same process as an earlier one replaces it: the world was heard late.
        """
        entry = self._ledger.get(judged.process)
        if entry is None or judged.verdict is Verdict.UNDECIDED or entry.decided_by != judged.outcome:
            return None
        return self._experience(entry, judged, self._witnesses.get(judged.outcome))

    def _experience(self, entry: Entry, judged: Judged, outcome: Outcome | None) -> Experience:
        told = outcome.treatment if outcome is not None else ""
        applied = entry.treatment if judged.verdict is Verdict.SUPPORTED else ""
        return Experience(
            id=self._next_experience,
            event=entry.event,
            process=entry.process,
            treatment=entry.treatment,
            treatment_label=told or applied,
            predicted=judged.predicted,
            outcome=judged.label,
            verdict=judged.verdict,
            mode=entry.mode,
            robot=entry.robot,
            acted_on=outcome is not None and outcome.acted_on,
        )

    def covered(self, event: Event, process: int) -> None:
        """An event was admitted and a process is open on it, as ``apply`` would be told."""
        self._events.covered(event, self._recordings.since_ns(event), process)

    def ran(self, burst: Ran, event: Event, forecast: Forecast | None, at_ns: int, cell: int = -1) -> None:
        """A process has concluded, as ``apply`` would be told. ``cell``: where its event lies in experience, if that is known."""
        if burst.closes_ns is not None and forecast is not None:
            since_ns = self._events.ran(burst.process, event.id)
            self._await(burst, burst.closes_ns, event, forecast, since_ns, at_ns, cell)
        else:
            self._events.completed(burst.process)

    def know(self, event: Event) -> None:
        """A process is about to be open on that event again: it is remembered, also where it was given away with a parked one."""
        if event.id not in self._events:
            self._events.admitted(event, self._recordings.since_ns(event))

    def park(self, process: int) -> int | None:
        """Give away the event of a process that is put out of memory while it waits, and return when it happened; None where it
        is still needed."""
        return self._events.park(process)

    def bring_back(self, event: Event, since_ns: int, process: int) -> None:
        """Take a parked process's event back."""
        self._events.covered(event, since_ns, process)

    def forecast(self, process: int) -> Entry | None:
        """The forecast of a process, with its window and what came of it; None where there is none any more."""
        return self._ledger.get(process)

    def sole(self, outcome: Outcome, now_ns: int) -> tuple[Judged, Experience] | None:
        """What an outcome that was not witnessed yet brings about in the ordinary case: it decides one open forecast.

        Returns:
            tuple[Judged, Experience] | None: the verdict and its experience; None where the case is another (known already,
            nothing or several concerned, nothing decided, late, a foreign label), and ``match`` is to be asked.
        """
        if outcome.label not in self._spec.labels or self._witnesses.get(outcome.id) is not None:
            return None
        outcome = self._recordings.in_kernel_time(outcome)
        entry = self._ledger.sole(outcome)
        if entry is None or entry.verdict is not None or entry.closes_ns < now_ns:
            return None
        if not self._recordings.reaches(outcome, entry):
            return None
        label = entry.label
        if label == outcome.label:
            seen = Verdict.SUPPORTED
        else:
            seen = verdict(label, outcome.label, outcome.acted_on, self._quiet)
            if seen is Verdict.UNDECIDED:
                return None
        judged = Judged(
            process=entry.process,
            event=entry.event,
            predicted=label,
            label=outcome.label,
            verdict=seen,
            outcome=outcome.id,
            lead_ns=outcome.at_ns + entry.closes_ns - entry.until_ns - entry.concluded_ns,
        )
        return judged, self._experience(entry, judged, outcome)

    def validated(self, outcome: Outcome, judged: Judged, experience: Experience, at_ns: int) -> None:
        """An outcome decided a forecast, as ``apply`` would be told."""
        outcome = self._recordings.in_kernel_time(outcome)
        entry = self._ledger.get(judged.process)
        if entry is None or entry.verdict is not None or not self._witnesses.add(outcome, at_ns):
            return  # never so where this is called as it is to be
        self._witnessed += 1
        entry.verdict, entry.shown = judged.verdict, judged.label
        entry.decided_by, entry.decided_ns = judged.outcome, outcome.at_ns
        self._verdicts[judged.verdict] += 1
        self._ledger.judged(judged.process)
        self._next_experience = experience.id + 1

    def counts(self) -> Counts:
        """What came of the forecasts so far."""
        return Counts(
            forecasts=self._made,
            open=self._ledger.open_now,
            supported=self._verdicts[Verdict.SUPPORTED],
            contradicted=self._verdicts[Verdict.CONTRADICTED],
            undecided=self._verdicts[Verdict.UNDECIDED],
            witnessed=self._witnessed,
            foreign=self._foreign,
        )

    def _witness(self, outcome: Outcome, at_ns: int) -> None:
        if self._witnesses.add(self._recordings.in_kernel_time(outcome), at_ns):
            self._witnessed += 1
            self._foreign += outcome.label not in self._spec.labels

    def _enter(self, record: Concluded, forecast: Forecast | None, at_ns: int) -> None:
        event = self._events.get(record.event)
        if record.closes_ns is None or forecast is None or event is None or self._ledger.get(record.process) is not None:
            return
        self._await(record, record.closes_ns, event, forecast, self._events.since_ns(event.id), at_ns)

    def _await(
        self,
        made: Concluded | Ran,
        closes_ns: int,
        event: Event,
        forecast: Forecast,
        since_ns: int,
        at_ns: int,
        cell: int = -1,
    ) -> None:
        """A forecast waits for its outcome from now on."""
        forgotten_ns = self._witnesses.forgotten_ns
        self._made += 1
        self._ledger.open(
            Entry(
                process=made.process,
                event=event.id,
                treatment=made.treatment,
                mode=made.mode,
                label=forecast.label,
                topic=forecast.topic or self._spec.topic,
                entity=forecast.entity or event.entity,
                robot=event.robot,
                source=event.source,
                since_ns=since_ns,
                until_ns=since_ns + self._within_ns,
                closes_ns=closes_ns,
                concluded_ns=at_ns,
                heard_all=forgotten_ns is None or forgotten_ns < event.stamp.received_ns,
                cell=cell,
            )
        )

    def _decide(self, record: Judged) -> None:
        entry = self._ledger.get(record.process)
        if entry is None:
            return
        outcome = self._witnesses.get(record.outcome)
        if entry.verdict is not None:
            if outcome is None or not supersedes(outcome, entry):
                entry.overruled |= {record.outcome}
                return
            self._verdicts[entry.verdict] -= 1
        entry.verdict = record.verdict
        entry.shown = record.label
        entry.decided_by = record.outcome
        entry.decided_ns = None if outcome is None else outcome.at_ns
        self._verdicts[record.verdict] += 1
        self._ledger.judged(record.process)

    def _closed(self, entry: Entry) -> Judged:
        doubt = self._recordings.doubt(entry)
        return undecided(entry, doubt) if doubt else silence(entry, self._quiet)
