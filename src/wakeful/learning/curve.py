"""How automatic share and accuracy developed over experience, read from the records."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import msgspec

from wakeful.facts.experience import Verdict
from wakeful.facts.lines import Admitted, AnyRecord, Concluded, Created, Decided, Judged, Published


class CurvePoint(msgspec.Struct, frozen=True, kw_only=True):
    """One stretch of the stream: events ``first`` to ``last`` by admission, counted from 1.

    Shares are of the events with a decision; accuracies are None where nothing could be compared. ``result_accuracy`` is the
    share of decided verdicts that were supported, ``automatic_accuracy`` the same of what was executed automatically,
    ``treatment_accuracy`` that of events whose right treatment the recording carries, ``joint_accuracy`` both at once.
    ``model`` is the last version that decided in the stretch.
    """

    first: int
    last: int
    auto: float
    delib: float
    fallback: float
    judged: int
    result_accuracy: float | None
    automatic_accuracy: float | None
    treatment_accuracy: float | None
    joint_accuracy: float | None
    experiences: int
    model: int


class _Met(msgspec.Struct):
    """One event as its root process went through: the decision that holds, and how it was judged first."""

    truth: str | None
    treatment: str = ""
    mode: str = ""
    model: int = 0
    right: bool | None = None


class Curve:
    """Folds records into the learning curve. Only an event's first root process counts; reopenings are second thoughts.

    What holds is the last decision before the process concluded, and the first verdict that decided.
    """

    def __init__(self) -> None:
        self._met: dict[str, _Met] = {}
        self._root: dict[str, int] = {}
        self._concluded: set[int] = set()
        self.published: list[tuple[int, int, bool]] = []

    def apply(self, record: AnyRecord) -> None:
        """Take up a record; those that say nothing about decisions and verdicts are passed over."""
        if isinstance(record, Admitted):
            self._met.setdefault(record.event.id, _Met(record.event.truth_treatment))
        elif isinstance(record, Created):
            if not record.parent and not record.reopens:
                self._root.setdefault(record.event, record.process)
        elif isinstance(record, Decided):
            met = self._own(record.event, record.process)
            if met is not None and record.process not in self._concluded:
                met.treatment, met.mode = record.decision.treatment, record.decision.mode
                met.model = max(met.model, record.decision.model)
        elif isinstance(record, Concluded):
            if self._own(record.event, record.process) is not None:
                self._concluded.add(record.process)
        elif isinstance(record, Judged):
            met = self._own(record.event, record.process)
            if met is not None and met.right is None and record.verdict is not Verdict.UNDECIDED:
                met.right = record.verdict is Verdict.SUPPORTED
        elif isinstance(record, Published):
            self.published.append((record.card.version, len(self._met), record.card.accepted))

    def points(self, stretches: int = 10) -> tuple[CurvePoint, ...]:
        """The stream cut into at most ``stretches`` parts of equal numbers of events, in order."""
        met = list(self._met.values())
        cuts = [round(len(met) * part / stretches) for part in range(stretches + 1)]
        points: list[CurvePoint] = []
        experiences = 0
        for first, last in pairwise(cuts):
            if last > first:
                experiences += sum(each.right is not None for each in met[first:last])
                points.append(_point(met[first:last], first + 1, last, experiences))
        return tuple(points)

    def _own(self, event: str, process: int) -> _Met | None:
        return self._met.get(event) if self._root.get(event) == process else None


def _point(met: list[_Met], first: int, last: int, experiences: int) -> CurvePoint:
    decided = [each for each in met if each.mode]
    judged = [each for each in met if each.right is not None]
    labelled = [each for each in decided if each.truth is not None]
    both = [each for each in labelled if each.right is not None]
    modes = [each.mode for each in decided]
    return CurvePoint(
        first=first,
        last=last,
        auto=_share(mode == "auto" for mode in modes) or 0.0,
        delib=_share(mode == "delib" for mode in modes) or 0.0,
        fallback=_share(mode == "fallback" for mode in modes) or 0.0,
        judged=len(judged),
        result_accuracy=_share(each.right is True for each in judged),
        automatic_accuracy=_share(each.right is True for each in judged if each.mode == "auto"),
        treatment_accuracy=_share(each.treatment == each.truth for each in labelled),
        joint_accuracy=_share(each.treatment == each.truth and each.right is True for each in both),
        experiences=experiences,
        model=max((each.model for each in decided), default=0),
    )


def _share(hits: Iterable[bool]) -> float | None:
    marks = list(hits)
    return round(sum(marks) / len(marks), 6) if marks else None
