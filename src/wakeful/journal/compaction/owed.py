"""What is owed: the events that may not be given up, however old they are, followed entry by entry as they are committed."""

from __future__ import annotations

from array import array

import msgspec

from wakeful.facts.lines import Acted, Concluded, Created, Decided, Gained, Imported, Judged, Moved, Trusted, Witnessed
from wakeful.facts.packs import Covered, Entry, Pack, Ran, Validated, last_position
from wakeful.facts.processes import COMPLETIONS, Completion, State
from wakeful.journal.debt import UNFINISHED

#: So many outcomes that have judged nothing yet are kept; older ones are given up with what was told beside them.
_UNJUDGED = 10_000


class _Process(msgspec.Struct):
    event: str
    child: bool
    mode: str = ""


class _Event(msgspec.Struct):
    """An event that is open, awaits its outcome, or is in debt.

    ``awaited``: results whose window is open. ``treated``: one of its own processes gave it more than a provisional treatment.
    """

    processes: list[int]
    rests_on: list[int]
    open: int = 0
    awaited: int = 0
    treated: bool = False


class Owed:
    """Knows the events that are open, await their outcome or are in debt, and on which experiences their decisions rest."""

    def __init__(self) -> None:
        self._open: dict[int, _Process] = {}
        self._events: dict[str, _Event] = {}
        self._awaited: dict[int, str] = {}
        self._acted: set[int] = set()
        self._trusted: dict[str, int] = {}
        self._unjudged: dict[str, int] = {}
        self._late: list[tuple[int, int, str]] = []
        # By experience id, the process that it was made of; 0 for an imported one. Ids count from 1 without a gap.
        self._made_of = array("Q", (0,))

    def __len__(self) -> int:
        return len(self._events)

    def see(self, entry: Entry) -> None:
        """Follow one entry that was committed."""
        said = entry.burst if isinstance(entry, Pack) else entry.record
        if isinstance(said, Covered):
            rests_on = list(said.choice.rests_on)
            self._open[said.process] = _Process(said.event.id, False, "auto")
            self._events[said.event.id] = _Event([said.process], rests_on, open=1)
        elif isinstance(said, Ran):
            if said.closes_ns is not None:
                self._concluded(said.process, said.event)
            self._end(said.process, Completion.RESOLVED)
        elif isinstance(said, Validated):
            self._judged(said.judged.process)
            self._gained(said.experience.id, said.experience.process)
            if said.trusted is not None:
                self._trusted[said.trusted.treatment] = last_position(entry)
        elif isinstance(said, Trusted):
            self._trusted[said.treatment] = entry.position
        elif isinstance(said, Moved):
            if said.after is State.COMPLETED:
                self._end(said.process, COMPLETIONS[said.trigger])
        elif isinstance(said, Created):
            self._created(said)
        elif isinstance(said, Decided):
            self._decided(said)
        elif isinstance(said, Gained):
            self._gained(said.experience.id, said.experience.process)
        elif isinstance(said, Witnessed):
            self._unjudged[said.outcome.id] = entry.position
            if len(self._unjudged) > _UNJUDGED:
                del self._unjudged[next(iter(self._unjudged))]
        elif isinstance(said, Concluded):
            if said.closes_ns is not None:
                self._concluded(said.process, said.event)
        elif isinstance(said, Judged):
            self._judged(said.process)
            came = self._unjudged.pop(said.outcome, None)
            if came is not None and entry.position > came + 1:
                self._late.append((came, entry.position, said.outcome))
        elif isinstance(said, Imported):
            self._gained(said.experience.id, 0)
        elif isinstance(said, Acted) and said.process:
            self._acted.add(said.process)

    def processes(self) -> set[int]:
        """The processes whose lines are kept: of these events, those that an operator acted on, and what decisions rest on."""
        kept = set(self._acted)
        for event in self._events.values():
            kept.update(event.processes)
            kept.update(self._made_of[id_] for id_ in event.rests_on if id_ < len(self._made_of))
        kept.discard(0)
        return kept

    def places(self) -> frozenset[int]:
        """The lines that are kept for themselves: the last change of trust in each treatment."""
        return frozenset(self._trusted.values())

    def outcomes(self, boundary: int) -> set[str]:
        """The outcomes that came before a position, and judge, or may yet judge, a result after it."""
        late = {outcome for came, judged, outcome in self._late if came <= boundary < judged}
        return late | {outcome for outcome, came in self._unjudged.items() if came <= boundary}

    def given_up(self, boundary: int) -> None:
        """What lies up to there was compacted."""
        self._late = [each for each in self._late if each[1] > boundary]

    def _created(self, record: Created) -> None:
        event = self._events.setdefault(record.event, _Event([], []))
        event.open += 1
        event.processes.append(record.process)
        if record.reopens:
            event.processes.append(record.reopens)
        self._open[record.process] = _Process(record.event, record.parent > 0)

    def _decided(self, record: Decided) -> None:
        process = self._open.get(record.process)
        if process is not None:
            process.mode = record.decision.mode
            self._events[process.event].rests_on.extend(record.decision.rests_on)

    def _end(self, number: int, end: Completion) -> None:
        process = self._open.pop(number, None)
        if process is None:
            return
        event = self._events[process.event]
        event.open -= 1
        if not process.child and process.mode not in ("", "fallback") and end not in UNFINISHED:
            event.treated = True
        self._settle(process.event, event)

    def _concluded(self, process: int, event: str) -> None:
        if event in self._events:
            self._events[event].awaited += 1
            self._awaited[process] = event

    def _judged(self, process: int) -> None:
        name = self._awaited.pop(process, None)
        event = self._events.get(name) if name is not None else None
        if name is not None and event is not None:
            event.awaited -= 1
            self._settle(name, event)

    def _settle(self, name: str, event: _Event) -> None:
        if not event.open and not event.awaited and event.treated:
            del self._events[name]

    def _gained(self, id_: int, process: int) -> None:
        if id_ >= len(self._made_of):
            self._made_of.extend([0] * (id_ - len(self._made_of) + 1))
        self._made_of[id_] = process
