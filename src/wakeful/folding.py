"""The kernel's fold: which rooms take up what of a record, one by one or packed. Live and in recovery it is the same."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable

import msgspec

from wakeful.admission import Admission
from wakeful.facts.events import Event
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience, ModelCard
from wakeful.facts.lines import (
    Acted,
    Admitted,
    AnyRecord,
    Compacted,
    Created,
    Duplicate,
    Gained,
    Judged,
    Published,
    Refused,
    TrainingAsked,
)
from wakeful.facts.packs import AnyBurst, Covered, Entry, Inquired, Pack, Ran, Validated, Woken
from wakeful.facts.results import Forecast
from wakeful.learning.cells import Cells
from wakeful.learning.counsel import Counsel
from wakeful.learning.episodes import Episodes
from wakeful.learning.exemplars import Exemplars
from wakeful.learning.plan import Learning
from wakeful.learning.recent import Recent
from wakeful.revision import Debts, Revision
from wakeful.scheduling.process_set import ProcessSet
from wakeful.selection.guarantee import Guarantee
from wakeful.validation import Validation


class Folded(msgspec.Struct):
    """How far a journal went, and which model version was in use in the end.

    ``accepted``: the versions that were published, by number. ``asked``: a training that was still under way.
    """

    position: int = 0
    now_ns: int = 0
    card: ModelCard | None = None
    accepted: dict[int, ModelCard] = {}
    asked: TrainingAsked | None = None

    def see(self, record: AnyRecord) -> None:
        """Follow what is said of model versions."""
        if isinstance(record, Published):
            self.asked = None
            if record.card.accepted:
                self.card = self.accepted[record.card.version] = record.card
        elif isinstance(record, TrainingAsked):
            self.asked = record
        elif isinstance(record, Acted) and record.act == "rollback" and not record.refused:
            self.card, self.asked = self.accepted.get(record.version, self.card), None


class Folding:
    """The rooms whose state is the fold of the journal's entries, in the order in which they take a record up.

    Args:
        keep_events: so many admitted events stay in memory, for late outcomes and reopening.
        admission, processes, validation, learning, exemplars, recent, cells, episodes, counsel, guarantee, revision, debts:
            the rooms.
    """

    def __init__(
        self,
        keep_events: int,
        *,
        admission: Admission,
        processes: ProcessSet,
        validation: Validation,
        learning: Learning,
        exemplars: Exemplars,
        recent: Recent,
        cells: Cells,
        episodes: Episodes,
        counsel: Counsel,
        guarantee: Guarantee | None,
        revision: Revision,
        debts: Debts,
    ) -> None:
        self.events: OrderedDict[str, Event] = OrderedDict()
        self._keep_events = keep_events
        self._admission = admission
        self._processes = processes
        self._validation = validation
        self._learning = learning
        self._exemplars = exemplars
        self._recent = recent
        self._cells = cells
        self._episodes = episodes
        self._counsel = counsel
        self._guarantee = guarantee
        self._revision = revision
        self._debts = debts

    def fold(self, entries: Iterable[Entry]) -> Folded:
        """Take up all that a journal holds, in order."""
        folded = Folded()
        self._episodes.hurry(True)
        for entry in entries:
            folded.now_ns = entry.at_ns
            if isinstance(entry, Pack):
                folded.position = entry.last
                self.apply_burst(entry.burst, entry.at_ns)
            else:
                folded.position = entry.position
                self.apply(entry.record, entry.at_ns)
                folded.see(entry.record)
        self._episodes.hurry(False)
        return folded

    def apply(self, record: AnyRecord, now_ns: int) -> None:
        """Take up one record."""
        if isinstance(record, Admitted):
            self._remember(record.event)
        if isinstance(record, Admitted | Duplicate | Refused | Compacted):
            self._admission.apply(record)
        self._processes.apply(record, now_ns)
        if isinstance(record, Created) and record.event in self.events:
            self._validation.know(self.events[record.event])
        self._validation.apply(record, now_ns)
        if isinstance(record, Gained):
            self._gain(record.experience, -1)
        else:
            self._learning.apply(record)
            self._exemplars.apply(record)
            self._recent.apply(record)
        self._episodes.apply(record)
        self._counsel.apply(record)
        if self._guarantee is not None:
            self._guarantee.apply(record)
        self._revision.apply(record, now_ns)
        self._debts.apply(record, now_ns)

    def apply_burst(self, burst: AnyBurst, now_ns: int, forecast: Forecast | None = None) -> None:
        """What its records do, each in the rooms that it concerns: the same state in the end, at a fraction of the cost.

        ``forecast``: of a run, the result's own, where it is at hand whole.
        """
        match burst:
            case Covered(event=event):
                self._remember(event)
                self._admission.covered(event.id)
                self._processes.covered(burst, now_ns)
                self._validation.covered(event, burst.process)
                self._episodes.admit(event)
                self._exemplars.covered(burst.process, burst.choice)
                self._recent.covered(burst.process, burst.choice)
                self._revision.covered(burst)
            case Inquired():
                self._processes.inquired(burst, now_ns)
            case Woken():
                self._processes.woken(burst, now_ns)
            case Ran():
                process = self._processes.ran(burst, now_ns)
                foretold = burst.forecast if forecast is None else forecast
                cell = process.choice.cell if process.choice is not None else -1
                self._validation.ran(burst, process.event, foretold, now_ns, cell)
                self._episodes.ran(burst, foretold)
                self._revision.ran(burst, foretold.label if foretold is not None else "")
            case Validated():
                self.validated(burst.outcome, burst.judged, burst.experience, now_ns)
                if burst.trusted is not None:
                    self._revision.apply(burst.trusted, now_ns)
        if self._guarantee is not None:
            for record in burst.records():
                self._guarantee.apply(record)

    def validated(self, outcome: Outcome, judged: Judged, experience: Experience, now_ns: int) -> None:
        """Take up a verdict with its outcome and its experience."""
        entry = self._validation.forecast(judged.process)
        self._validation.validated(outcome, judged, experience, now_ns)
        self._gain(experience, entry.cell if entry is not None else -1)
        self._episodes.validated(judged, experience)
        if self._counsel.judged(judged.process):
            self._counsel.apply(judged)
        self._revision.validated(experience, now_ns)

    def _remember(self, event: Event) -> None:
        self.events[event.id] = event
        if len(self.events) > self._keep_events:
            self.events.popitem(last=False)

    def _gain(self, experience: Experience, cell: int) -> None:
        event = self.events.get(experience.event)
        if event is not None:
            self._learning.gain(experience, event)
            self._exemplars.gain(experience, event)
            self._recent.gain(experience, event)
            self._cells.gain(experience.id, event, cell)
