"""Every process as a lane of time: the stretches of its states, who preempted it, and what came to it."""

from __future__ import annotations

from wakeful.facts.asking import Kind
from wakeful.facts.lines import (
    Acted,
    Admitted,
    Answered,
    Concluded,
    Created,
    Decided,
    Finished,
    Judged,
    Line,
    Moved,
    Opened,
    Witnessed,
)
from wakeful.facts.processes import COMPLETIONS, State, Trigger
from wakeful.journal.readable import Readable, View


class Stretch(View, frozen=True):
    """One stay in one state. ``why`` is the trigger that began it, ``by`` who; ``steps`` had been done at its end."""

    state: State
    begin_ns: int
    end_ns: int
    why: str = ""
    by: str = ""
    steps: int = 0


class Mark(View, frozen=True):
    """Something at one instant.

    ``kind``: of a process ``evidence``, ``answer``, ``limit`` (passed), ``act``, ``verdict``, ``result``; of a source ``event``,
    ``outcome``.
    """

    kind: str
    at_ns: int
    says: str


class Lane(View, frozen=True):
    """One process. ``end`` is how it completed, empty while it is open."""

    process: int
    event: str
    kind: str
    entity: str
    treatment: str
    mode: str
    criticality: int
    stretches: tuple[Stretch, ...]
    marks: tuple[Mark, ...]
    parent: int = 0
    deadline_ns: int | None = None
    end: str = ""


class Preemption(View, frozen=True):
    """One process took another's slot."""

    at_ns: int
    preempted: int
    preempting: int


class Track(View, frozen=True):
    """One source, from its opening to its end, with the events that it brought and what it showed later."""

    source: str
    begin_ns: int
    end_ns: int
    marks: tuple[Mark, ...]


class Lanes(View, frozen=True):
    """A journal as lanes: processes in the order of their creation, all within [begin_ns, end_ns]."""

    begin_ns: int
    end_ns: int
    lanes: tuple[Lane, ...]
    preemptions: tuple[Preemption, ...]
    tracks: tuple[Track, ...]


def lanes(journal: Readable, event: str = "", last: int = 0) -> Lanes:
    """A journal as lanes of time. O(lines).

    Args:
        journal: any journal; what is open in it lasts until its last line.
        event: only this event's processes, and those that preempted them; all where empty.
        last: only the last so many processes; 0: all.
    """
    reader = _Reader()
    for line in journal.lines():
        reader.take(line)
    return reader.told(event, last)


class _Reader:
    def __init__(self) -> None:
        self._first_ns: int | None = None
        self._now_ns = 0
        self._events: dict[str, Admitted] = {}
        self._created: dict[int, Created] = {}
        self._decided: dict[int, tuple[str, str]] = {}
        self._stretches: dict[int, list[Stretch]] = {}
        self._marks: dict[int, list[Mark]] = {}
        self._ends: dict[int, str] = {}
        self._preemptions: list[Preemption] = []
        self._tracks: dict[str, tuple[int, int | None]] = {}
        self._source_marks: dict[str, list[Mark]] = {}

    def take(self, line: Line) -> None:
        """Follow one line."""
        record, at_ns = line.record, line.at_ns
        # A journal begins when its first event comes: before it, kernel time may stand at zero.
        if self._first_ns is None and not isinstance(record, Opened):
            self._first_ns = at_ns
        self._now_ns = max(self._now_ns, at_ns)
        match record:
            case Opened(source=source):
                self._tracks.setdefault(source, (at_ns, None))
            case Finished(source=source) if source in self._tracks:
                self._tracks[source] = (self._tracks[source][0], at_ns)
            case Admitted(event=event):
                self._events[event.id] = record
                self._source_marks.setdefault(event.source, []).append(
                    Mark(kind="event", at_ns=at_ns, says=f"{event.kind} of {event.entity}")
                )
            case Witnessed(outcome=outcome):
                source = next(reversed(self._tracks), "")
                self._source_marks.setdefault(source, []).append(
                    Mark(kind="outcome", at_ns=at_ns, says=f"{outcome.label} of {outcome.entity}")
                )
            case Created(process=process):
                self._created[process] = record
                self._stretches[process] = [Stretch(state=State.CREATED, begin_ns=at_ns, end_ns=-1)]
            case Decided(process=process, decision=decision):
                self._decided[process] = (decision.treatment, decision.mode)
            case Moved():
                self._move(record, at_ns)
            case _:
                self._mark(line)

    def _move(self, record: Moved, at_ns: int) -> None:
        found = self._stretches.get(record.process)
        if not found:
            return
        before = found[-1]
        found[-1] = Stretch(
            state=before.state, begin_ns=before.begin_ns, end_ns=at_ns, why=before.why, by=before.by, steps=record.steps
        )
        if record.after is State.COMPLETED:
            self._ends[record.process] = COMPLETIONS.get(record.trigger, "")
        else:
            found.append(
                Stretch(state=record.after, begin_ns=at_ns, end_ns=-1, why=record.trigger, by=record.by, steps=record.steps)
            )
        if record.trigger is Trigger.PREEMPT and record.by.removeprefix("P").isdigit():
            self._preemptions.append(
                Preemption(at_ns=at_ns, preempted=record.process, preempting=int(record.by.removeprefix("P")))
            )

    def _mark(self, line: Line) -> None:
        record, at_ns = line.record, line.at_ns
        match record:
            case Answered(kind=kind, key=key, error=error):
                came = not error and (kind is not Kind.EVIDENCE or bytes(record.value) != b"[]")
                name = ("evidence" if kind is Kind.EVIDENCE else "answer") if came else "limit"
                says = f"{kind}: {key.replace(chr(31), ' of ')}" + ("" if came else f" ({error or 'nothing came in time'})")
                self._marks.setdefault(record.process, []).append(Mark(kind=name, at_ns=at_ns, says=says))
            case Concluded(process=process, treatment=treatment):
                self._marks.setdefault(process, []).append(Mark(kind="result", at_ns=at_ns, says=f"result of {treatment}"))
            case Judged(process=process, verdict=verdict, label=label):
                self._marks.setdefault(process, []).append(Mark(kind="verdict", at_ns=at_ns, says=f"{verdict}: {label}"))
            case Acted(process=process, act=act, who=who):
                self._marks.setdefault(process, []).append(Mark(kind="act", at_ns=at_ns, says=f"{act} by {who}"))
            case _:
                pass

    def told(self, event: str, last: int) -> Lanes:
        """The lanes of one event, or of the last processes."""
        chosen = self._chosen(event, last)
        begin_ns = self._first_ns or 0
        return Lanes(
            begin_ns=begin_ns,
            end_ns=max(self._now_ns, begin_ns),
            lanes=tuple(self._lane(process) for process in chosen),
            preemptions=tuple(each for each in self._preemptions if each.preempted in chosen and each.preempting in chosen),
            tracks=tuple(
                Track(
                    source=source,
                    begin_ns=max(opened_ns, begin_ns),
                    end_ns=self._now_ns if finished_ns is None else max(finished_ns, begin_ns),
                    marks=tuple(self._source_marks.get(source, ())),
                )
                for source, (opened_ns, finished_ns) in self._tracks.items()
            ),
        )

    def _chosen(self, event: str, last: int) -> dict[int, None]:
        chosen = [process for process, created in self._created.items() if event in ("", created.event)]
        if event:
            own = set(chosen)
            chosen += [
                each.preempting for each in self._preemptions if each.preempted in own and each.preempting in self._created
            ]
        return dict.fromkeys(sorted(set(chosen))[-last:])

    def _lane(self, process: int) -> Lane:
        created = self._created[process]
        admitted = self._events.get(created.event)
        treatment, mode = self._decided.get(process, (created.treatment, ""))
        return Lane(
            process=process,
            event=created.event,
            kind=admitted.event.kind if admitted else "",
            entity=admitted.event.entity if admitted else "",
            treatment=treatment,
            mode=mode,
            criticality=created.criticality,
            stretches=tuple(
                each
                if each.end_ns >= 0
                else Stretch(
                    state=each.state, begin_ns=each.begin_ns, end_ns=self._now_ns, why=each.why, by=each.by, steps=each.steps
                )
                for each in self._stretches[process]
            ),
            marks=tuple(self._marks.get(process, ())),
            parent=created.parent,
            deadline_ns=created.deadline_ns,
            end=self._ends.get(process, ""),
        )
