"""Verdicts: V(r, y) (Eq. 10) put again to what is recorded, and experiences that say what their verdicts say."""

from __future__ import annotations

import msgspec

from wakeful.facts.events import Event
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience, Verdict
from wakeful.facts.lines import Admitted, Compacted, Concluded, Gained, Imported, Judged, Line, Opened, Witnessed
from wakeful.journal.checks.check import Check


class _Standing(msgspec.Struct):
    """The verdict that holds on one result: an outcome that lies earlier in source time takes its place, a later one does not."""

    judged: Judged
    decided_ns: int | None
    gained: bool = False


class Verdicts(Check):
    """Every verdict is the one that its recorded result and its recorded outcome give.

    A window without an outcome is judged once it has closed, all of them by the same label; one over which the recording ended,
    or had a gap, is undecided and names none.
    """

    name = "verdicts"
    says = (
        "every verdict is what the recorded result and the recorded outcome, or the closed window, give; experiences say the same"
    )

    def __init__(self) -> None:
        super().__init__()
        self._events: dict[str, Event] = {}
        self._since_ns: dict[str, int] = {}
        self._offset_ns: dict[str, int] = {}
        self._concluded: dict[int, Concluded] = {}
        self._outcomes: dict[str, Outcome] = {}
        self._standing: dict[int, _Standing] = {}
        self._last: dict[int, Judged] = {}
        self._quiet: str | None = None
        self._experiences = 0
        self._imported: set[tuple[str, int]] = set()

    def see(self, line: Line) -> None:
        """Follow a result to its verdict and its experience."""
        record = line.record
        match record:
            case Admitted(event=event):
                if event.id not in self._events:
                    self._events[event.id] = event
                    self._since_ns[event.id] = event.stamp.source_ns + self._offset_ns.get(event.source, 0)
            case Opened(source=source, offset_ns=offset_ns):
                self._offset_ns[source] = offset_ns
            case Concluded():
                self._concluded.setdefault(record.process, record)
            case Witnessed(outcome=outcome):
                at_ns = outcome.at_ns + self._offset_ns.get(outcome.source, 0)
                self._outcomes[outcome.id] = msgspec.structs.replace(outcome, at_ns=at_ns)
            case Judged():
                self.checked += 1
                self._judge(line, record)
            case Gained():
                self.checked += 1
                self._experiences += 1
                wrong = self._wrong_experience(record.experience)
                if wrong:
                    self.offend(line, f"experience {record.experience.id} {wrong}")
            case Compacted():
                self._experiences += record.gained
            case Imported():
                self.checked += 1
                self._experiences += 1
                if record.experience.id != self._experiences:
                    self.offend(line, f"imported experience {record.experience.id} follows {self._experiences - 1}")
                elif (record.origin, record.origin_id) in self._imported:
                    self.offend(line, f"experience {record.origin_id} of {record.origin} was imported before")
                self._imported.add((record.origin, record.origin_id))
            case _:
                pass

    def _judge(self, line: Line, record: Judged) -> None:
        wrong = self._wrong_verdict(line.at_ns, record)
        if wrong:
            self.offend(line, f"process {record.process} {wrong}")
        self._last[record.process] = record
        standing = self._standing.get(record.process)
        outcome = self._outcomes.get(record.outcome)
        if standing is None or (outcome is not None and _supersedes(outcome, standing)):
            self._standing[record.process] = _Standing(record, None if outcome is None else outcome.at_ns)

    def _wrong_verdict(self, now_ns: int, record: Judged) -> str:
        concluded = self._concluded.get(record.process)
        if concluded is None:
            return "was judged before it concluded"
        forecast = concluded.forecast.label if concluded.forecast else ""
        if forecast != record.predicted:
            return f"was judged on {record.predicted!r}, but had forecast {forecast!r}"
        if record.event != concluded.event:
            return f"was judged on event {record.event}, but is about {concluded.event}"
        if not record.outcome:
            return self._wrong_window(now_ns, record, concluded)
        outcome = self._outcomes.get(record.outcome)
        if outcome is None:
            return f"was judged by outcome {record.outcome}, which never arrived"
        return self._wrong_outcome(record, outcome)

    def _wrong_window(self, now_ns: int, record: Judged, concluded: Concluded) -> str:
        """What is wrong with a verdict that no outcome brought; empty where nothing is."""
        if record.process in self._standing:
            return "was judged by its window, but it had a verdict already"
        if record.verdict is Verdict.UNDECIDED:
            return f"is undecided, but by the label {record.label!r}" if record.label else ""
        if concluded.closes_ns is None or now_ns < concluded.closes_ns:
            return "was judged by its window before that had closed"
        if self._quiet is None:
            self._quiet = record.label
        if record.label != self._quiet:
            return f"has a window that closed over {record.label!r}; others closed over {self._quiet!r}"
        return _wrong(record, self._compared(record, acted_on=False))

    def _wrong_outcome(self, record: Judged, outcome: Outcome) -> str:
        """What is wrong with a verdict that an outcome brought; empty where nothing is."""
        event = self._events.get(record.event)
        if outcome.label != record.label:
            return f"was judged by {record.label!r}, but outcome {outcome.id} is {outcome.label!r}"
        if outcome.event and outcome.event != record.event:
            return f"was judged by outcome {outcome.id}, which is of event {outcome.event}"
        if event is not None and outcome.at_ns <= self._since_ns[event.id]:
            return f"was judged by outcome {outcome.id}, which came before its event"
        standing = self._standing.get(record.process)
        if standing is not None and not _supersedes(outcome, standing):
            # The first in source time decides; what comes after it and says something else changes nothing.
            return _wrong(record, Verdict.UNDECIDED)
        return _wrong(record, self._compared(record, outcome.acted_on))

    def _compared(self, record: Judged, acted_on: bool) -> Verdict:
        """V(r, y): what was acted on and did not come, by the label that says that nothing came, may have been prevented.

        The journal does not say which label that is: the first verdict that rests on it does, and all others must agree.
        """
        if record.predicted == record.label:
            return Verdict.SUPPORTED
        if acted_on and self._quiet is None and record.verdict is Verdict.UNDECIDED:
            self._quiet = record.label
        prevented = acted_on and record.label == self._quiet
        return Verdict.UNDECIDED if prevented else Verdict.CONTRADICTED

    def _wrong_experience(self, gained: Experience) -> str:
        judged, concluded = self._last.get(gained.process), self._concluded.get(gained.process)
        standing = self._standing.get(gained.process)
        if gained.id != self._experiences:
            return f"follows {self._experiences - 1}"
        if judged is None or concluded is None or standing is None:
            return f"comes from process {gained.process}, which was never judged"
        if standing.judged is not judged or standing.gained or judged.verdict is Verdict.UNDECIDED:
            return f"comes from process {gained.process}, whose last verdict gives none, or gave one already"
        standing.gained = True
        outcome, event = self._outcomes.get(judged.outcome), self._events.get(gained.event)
        applied = concluded.treatment if judged.verdict is Verdict.SUPPORTED else ""
        expected = msgspec.structs.replace(
            gained,
            event=judged.event,
            treatment=concluded.treatment,
            treatment_label=(outcome.treatment if outcome is not None else "") or applied,
            predicted=judged.predicted,
            outcome=judged.label,
            verdict=judged.verdict,
            mode=concluded.mode,
            robot=event.robot if event is not None else gained.robot,
            acted_on=outcome is not None and outcome.acted_on,
        )
        differing = [name for name in Experience.__struct_fields__ if getattr(gained, name) != getattr(expected, name)]
        return f"differs from the verdict on process {gained.process} in {', '.join(differing)}" if differing else ""


def _supersedes(outcome: Outcome, standing: _Standing) -> bool:
    """Whether an outcome overrides the verdict that stands: it does over a window's, and over a later outcome's."""
    return standing.decided_ns is None or outcome.at_ns < standing.decided_ns


def _wrong(record: Judged, is_due: Verdict) -> str:
    if record.verdict is is_due:
        return ""
    return f"is said to be {record.verdict}, but {record.predicted!r} against {record.label!r} is {is_due}"
