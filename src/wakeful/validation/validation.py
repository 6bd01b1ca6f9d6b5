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
from wakeful.validation.known import KnownEvents
from wakeful.validation.ledger import Entry, Ledger
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
        self._ended_ns: dict[str, int] = {}
        self._broken_ns: dict[str, int] = {}
        self._offset_ns: dict[str, int] = {}
        self._next_experience = 1
        self._made = 0
        self._verdicts = dict.fromkeys(Verdict, 0)
        self._witnessed = 0
        self._foreign = 0

    def apply(self, record: AnyRecord, at_ns: int) -> None:
        """Take up one record of the journal, live and in recovery alike. Records that concern other rooms are passed over."""
        match record:
            case Admitted(event=event):
                self._events.admitted(event, event.stamp.source_ns + self._offset_ns.get(event.source, 0))
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
                self._ended_ns[source] = at_ns
            case Opened(source=source, offset_ns=offset_ns):
                self._ended_ns.pop(source, None)
                self._offset_ns[source] = offset_ns
            case Refused(source=source, unread=True):  # it may have been an outcome
                self._broken_ns[source] = at_ns
            case Noted(what=what, source=source) if what == GAP:
                self._broken_ns[source] = at_ns

    def knows(self, outcome: str) -> bool:
        """Whether an outcome of that id was witnessed before: the same id counts once."""
        return self._witnesses.get(outcome) is not None

    def match(self, outcome: Outcome, now_ns: int) -> list[Judged]:
        """The verdicts that an outcome brings about (Eq. 10), possibly on several forecasts. Asking twice changes nothing."""
        outcome = self._in_kernel_time(outcome)
        first = self._witnesses.get(outcome.id)
        if (first is not None and first != outcome) or outcome.label not in self._spec.labels:
            return []
        concerned = self._ledger.concerned(outcome, self._within_ns)
        found = (self._against(entry, outcome, now_ns) for entry in concerned if self._reaches(outcome, entry))
        return [judged for judged in found if judged is not None]

    def _reaches(self, outcome: Outcome, entry: Entry) -> bool:
        """Whether an outcome may speak of a recording's event: another recording, begun after that one's end, does not."""
        ended_ns = self._ended_ns.get(entry.source)
        apart = bool(outcome.source) and outcome.source != entry.source and not outcome.event
        return not (apart and ended_ns is not None and outcome.at_ns >= ended_ns)

    def _in_kernel_time(self, outcome: Outcome) -> Outcome:
        """The outcome with its instant in kernel time: two recordings' own clocks cannot be compared."""
        offset_ns = self._offset_ns.get(outcome.source, 0)
        return msgspec.structs.replace(outcome, at_ns=outcome.at_ns + offset_ns) if offset_ns else outcome

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
        decisive = self._judge(entry, first, "the outcome came before the result was concluded")
        return [decisive, *(self._late(entry, other, first.label) for other in later if other.label != first.label)]

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
        return [self._closed(entry) if entry.closes_ns < now_ns else self._undecided(entry, _ENDED) for entry in concerned]

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
        self._events.covered(event, event.stamp.source_ns + self._offset_ns.get(event.source, 0), process)

    def ran(self, burst: Ran, event: Event, forecast: Forecast | None, at_ns: int, cell: int = -1) -> None:
        """A process has concluded, as ``apply`` would be told. ``cell``: where its event lies in experience, if that is known."""
        if burst.closes_ns is not None and forecast is not None:
            since_ns = self._events.ran(burst.process, event.id)
            self._await(burst, burst.closes_ns, event, forecast, since_ns, at_ns, cell)
        else:
            self._events.completed(burst.process)

    def park(self, process: int) -> int | None:
        """Give away the event of a process that is put out of memory while it waits, and return when it happened; None where it
        is still needed."""
        return self._events.park(process)

    def take_up(self, event: Event, since_ns: int, process: int) -> None:
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
        if self._offset_ns.get(outcome.source):
            outcome = self._in_kernel_time(outcome)
        entry = self._ledger.sole(outcome)
        if entry is None or entry.verdict is not None or entry.closes_ns < now_ns:
            return None
        if self._ended_ns and not self._reaches(outcome, entry):
            return None
        label = entry.label
        if label == outcome.label:
            seen = Verdict.SUPPORTED
        else:
            seen = verdict(label, outcome.label, outcome.acted_on, self._spec.labels[0])
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
        if self._offset_ns.get(outcome.source):
            outcome = self._in_kernel_time(outcome)
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
        if self._witnesses.add(self._in_kernel_time(outcome), at_ns):
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
            if outcome is None or not _supersedes(outcome, entry):
                entry.overruled |= {record.outcome}
                return
            self._verdicts[entry.verdict] -= 1
        entry.verdict = record.verdict
        entry.shown = record.label
        entry.decided_by = record.outcome
        entry.decided_ns = None if outcome is None else outcome.at_ns
        self._verdicts[record.verdict] += 1
        self._ledger.judged(record.process)

    def _against(self, entry: Entry, outcome: Outcome, now_ns: int) -> Judged | None:
        """What one outcome says of one forecast, given what is known of it already."""
        if entry.verdict is None:
            return self._judge(entry, outcome, "came late but lies inside the window" if entry.closes_ns < now_ns else "")
        if outcome.id == entry.decided_by or outcome.id in entry.overruled:
            return None
        if not _supersedes(outcome, entry):
            return None if outcome.label == entry.shown else self._late(entry, outcome, entry.shown)
        if outcome.label == entry.shown:
            # Recorded although it changes no verdict: what comes later still, but lies between the two, must not supersede it.
            return self._judge(entry, outcome, "came late and bears out what was judged")
        if entry.decided_by:
            return self._judge(entry, outcome, f"came late but lies before the outcome {entry.shown!r}: supersedes it")
        return self._judge(entry, outcome, "came late but lies inside the window: supersedes what its close said")

    def _judge(self, entry: Entry, outcome: Outcome, why: str = "") -> Judged:
        seen = verdict(entry.label, outcome.label, outcome.acted_on, self._spec.labels[0])
        reasons = [why] if why else []
        if seen is Verdict.UNDECIDED:
            reasons.append("the result had been acted on: what it forecast may have been prevented")
        return Judged(
            process=entry.process,
            event=entry.event,
            predicted=entry.label,
            label=outcome.label,
            verdict=seen,
            outcome=outcome.id,
            why="; ".join(reasons),
            lead_ns=outcome.at_ns + entry.offset_ns - entry.concluded_ns,
        )

    def _late(self, entry: Entry, outcome: Outcome, standing: str) -> Judged:
        return Judged(
            process=entry.process,
            event=entry.event,
            predicted=entry.label,
            label=outcome.label,
            verdict=Verdict.UNDECIDED,
            outcome=outcome.id,
            why=f"the world showed {standing!r} first, and the first in source time decides",
        )

    def _closed(self, entry: Entry) -> Judged:
        ended_ns = self._ended_ns.get(entry.source)
        if ended_ns is not None and ended_ns < entry.closes_ns:
            return self._undecided(entry, _ENDED)
        broken_ns = self._broken_ns.get(entry.source)
        if broken_ns is not None and entry.since_ns + entry.offset_ns <= broken_ns:
            return self._undecided(entry, _GAP)
        if not entry.heard_all:
            return self._undecided(entry, "outcomes of its window are no longer remembered")
        label = self._spec.labels[0]
        why = f"the window closed over an unbroken recording: {label!r}"
        return Judged(
            process=entry.process,
            event=entry.event,
            predicted=entry.label,
            label=label,
            verdict=verdict(entry.label, label),
            why=why,
        )

    def _undecided(self, entry: Entry, why: str) -> Judged:
        return Judged(
            process=entry.process, event=entry.event, predicted=entry.label, label="", verdict=Verdict.UNDECIDED, why=why
        )


_GAP = "the recording has a gap within the window, or an input that could not be read: what came then is not known"
_ENDED = "the recording ended or broke before the window closed"


def _supersedes(outcome: Outcome, entry: Entry) -> bool:
    """Whether an outcome overrides the verdict that stands: it does over a closed window, and over a later outcome."""
    return entry.decided_ns is None or outcome.at_ns < entry.decided_ns
