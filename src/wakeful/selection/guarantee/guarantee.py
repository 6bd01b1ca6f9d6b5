"""The guarantee gate: which scores of which treatment may be automatic, so that P(wrong and automatic) stays under α.

DESIGN section 5. A treatment is certified by bets on its own sampled outcomes (``bets``), level by level from the strictest
on, watched while it is automatic (``watch``), and revoked when its errors come too fast. All state is the fold of the records
applied; a decision costs one look-up.
"""

from __future__ import annotations

from collections import OrderedDict

import msgspec

from wakeful.facts.choices import likeliest
from wakeful.facts.decisions import Audit, Decision
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Verdict
from wakeful.facts.lines import AnyRecord, Certified, Concluded, Created, Decided, Judged, Moved, Revoked, Witnessed
from wakeful.facts.processes import State
from wakeful.facts.settings import MindSettings
from wakeful.selection.audits import drawn
from wakeful.selection.guarantee.bets import LEVELS, place_of
from wakeful.selection.guarantee.in_order import Waiting
from wakeful.selection.guarantee.settings import GuaranteeSettings
from wakeful.selection.guarantee.standing import NOTHING, Standing

_KEPT_OUTCOMES = 10_000
_DIGITS = 6


class Guarantee:
    """Decides what may be automatic, and says when a certificate begins, widens or ends.

    Args:
        settings: what is promised.
        seed: the mind's, for the draws.
        shadow: count the decisions of another gate as if each had been drawn; for looking at a journal only.
    """

    def __init__(self, settings: GuaranteeSettings, seed: int = 0, shadow: bool = False) -> None:
        self.settings = settings
        self._seed = seed
        self._shadow = shadow
        self._standings: dict[str, Standing] = {}
        self._waiting: dict[int, Waiting] = {}
        self._not_roots: set[int] = set()
        self._said: OrderedDict[str, tuple[str, bool]] = OrderedDict()
        self._touched: dict[str, None] = {}

    @property
    def standings(self) -> dict[str, Standing]:
        """By treatment: those of which anything was ever decided under the guarantee."""
        return self._standings

    def awaiting(self) -> list[tuple[str, str]]:
        """The automatic events that were drawn and whose outcome is still to come, with their treatment, the oldest first."""
        return [(each.event, each.treatment) for each in self._waiting.values() if each.ran and each.drawn and not each.settled]

    def rule(self, event: str, treatment: str, predicted: str, model: int, score: float) -> Audit:
        """Whether an event may be automatic, as far as the guarantee is concerned, and whether it is drawn for an audit.

        Args:
            event: its id, by which the draw is made.
            treatment: what the model chose.
            predicted: the label that it forecasts.
            model: the version that chose: evidence on another one says nothing of it.
            score: the probability that its answer, treatment and forecast together, is right; rounded to 6 digits here.
        """
        standing = self._standings.get(treatment)
        level = standing.level if standing is not None and standing.model == model else NOTHING
        score = round(score, _DIGITS)
        probability = self.settings.audit_rate if score >= level else 1.0
        return Audit(
            treatment=treatment,
            predicted=predicted,
            score=score,
            level=level,
            probability=probability,
            drawn=drawn(self._seed, event, probability),
            alpha=self.settings.alpha,
        )

    def hold(self, ruled: Decision, made: Decision) -> Decision:
        """What else knows of the event (memory) may stop automation. It may neither allow it nor change its answer.

        Args:
            ruled: the decision with which the gate was asked.
            made: what has been made of it.

        Returns:
            ``made``; deliberated where it would be automatic without the gate's leave, or with another answer.
        """
        same = made.treatment == ruled.treatment and likeliest(made.prior)[0] == likeliest(ruled.prior)[0]
        if made.mode != "auto" or (ruled.mode == "auto" and same):
            return made
        why = "The guarantee speaks for the model's own answer alone, so this one is deliberated."
        return msgspec.structs.replace(made, mode="delib", reasons=(*made.reasons, why))

    def changes(self) -> list[Certified | Revoked]:
        """What the records applied since the last call have changed; to be recorded and applied."""
        touched, self._touched = self._touched, {}
        found = (_change(treatment, self._standings[treatment]) for treatment in touched)
        return [record for record in found if record is not None]

    def apply(self, record: AnyRecord) -> None:
        """Take up one record of the journal, live and in recovery alike. Records that concern other rooms are passed over."""
        match record:
            case Created(process=process, parent=parent, reopens=reopens):
                if parent or reopens:
                    self._not_roots.add(process)
            case Decided(process=process, event=event, decision=decision):
                if process not in self._not_roots:
                    self._decided(process, event, decision)
            case Concluded(process=process, mode=mode, closes_ns=closes_ns):
                if (waiting := self._waiting.get(process)) is not None:
                    waiting.mode, waiting.judgeable = mode, closes_ns is not None
            case Moved(process=process, after=State.COMPLETED):
                self._not_roots.discard(process)
                if (waiting := self._waiting.get(process)) is not None and not waiting.judgeable:
                    self._settle(process, waiting, None)
            case Witnessed(outcome=outcome):
                self._witnessed(outcome)
            case Judged(process=process):
                if (waiting := self._waiting.get(process)) is not None:
                    self._settle(process, waiting, self._wrong(record, waiting))
            case Certified(treatment=treatment):
                self._of(treatment).certify(record)
            case Revoked(treatment=treatment):
                self._of(treatment).revoke(record)
            case _:
                pass

    def _decided(self, process: int, event: str, decision: Decision) -> None:
        audit = decision.audit
        if audit is None and self._shadow:
            audit = _as_if(decision, self.settings.alpha)
        if (waiting := self._waiting.get(process)) is not None:
            self._doubt(waiting, decision)
            return
        if audit is None or decision.watermark < self.settings.seek_from:
            return
        standing = self._of(audit.treatment)
        if decision.model != standing.model:
            standing.succeed(decision.model)
        waiting = Waiting(
            process=process,
            event=event,
            number=standing.number,
            treatment=audit.treatment,
            predicted=audit.predicted,
            place=int(place_of(audit.score)),
            automatic=audit.automatic,
            probability=audit.probability,
            drawn=audit.drawn,
            mode=decision.mode,
            ran=decision.mode == "auto",
        )
        self._waiting[process] = waiting
        standing.waiting.add(waiting)
        standing.counted.begin(waiting)

    def _doubt(self, waiting: Waiting, later: Decision) -> None:
        """A reasoner was asked about an audited event. That it disagrees may revoke automation; its consent is no evidence."""
        other = later.treatment != waiting.treatment or likeliest(later.prior)[0] != waiting.predicted
        standing = self._of(waiting.treatment)
        if other and waiting.automatic and waiting.drawn and not waiting.settled and waiting.number == standing.number:
            standing.doubted += not waiting.doubted
            waiting.doubted = True
            self._touched[waiting.treatment] = None

    def _wrong(self, judged: Judged, waiting: Waiting) -> bool | None:
        """Whether the automatic answer was wrong, or would have been; None where neither the world nor a person said so."""
        told, counts = self._said.get(judged.outcome, ("", True))
        if judged.verdict is Verdict.UNDECIDED or not counts:
            return None
        if told and told != waiting.treatment:
            return True
        if waiting.mode == "auto":
            return judged.verdict is Verdict.CONTRADICTED
        return judged.label != waiting.predicted

    def _settle(self, process: int, waiting: Waiting, wrong: bool | None) -> None:
        """The outcome of an event is known, or will not be. A verdict that a later one supersedes is taken up until its turn."""
        if waiting.settled and wrong is None:
            return
        standing = self._of(waiting.treatment)
        if waiting.doubted and not waiting.settled and waiting.number == standing.number:
            standing.doubted -= 1
        waiting.settled, waiting.wrong = True, wrong
        if waiting.number != standing.number:
            del self._waiting[process]
            standing.counted.end(waiting)
            return
        for ready in standing.waiting.ready():
            del self._waiting[ready.process]
            standing.counted.end(ready)
            standing.take(ready)
        self._touched[waiting.treatment] = None

    def _of(self, treatment: str) -> Standing:
        if treatment not in self._standings:
            self._standings[treatment] = Standing(self.settings)
        return self._standings[treatment]

    def _witnessed(self, outcome: Outcome) -> None:
        counts = outcome.origin in ("world", "person")
        if outcome.treatment or not counts:
            self._said.setdefault(outcome.id, (outcome.treatment, counts))
            if len(self._said) > _KEPT_OUTCOMES:
                self._said.popitem(last=False)


def guarantee_of(settings: MindSettings) -> Guarantee | None:
    """The guarantee gate as the mind's settings want it; None under another gate.

    Raises:
        ValueError: α, δ or the audit rate is none.
    """
    if settings.gate != "guarantee":
        return None
    own = GuaranteeSettings(alpha=settings.alpha, delta=settings.delta, audit_rate=settings.audit_rate)
    return Guarantee(own, settings.seed)


def _change(treatment: str, standing: Standing) -> Certified | Revoked | None:
    own = standing.settings
    if standing.certificate is not None and standing.alarm:
        return Revoked(treatment=treatment, model=standing.model, number=standing.number, why=standing.alarm)
    level = standing.earned
    if level >= standing.level:
        return None
    delta = own.delta_of(standing.number)
    place = LEVELS.index(level)
    return Certified(
        treatment=treatment,
        model=standing.model,
        number=standing.number,
        level=level,
        alpha=own.alpha,
        delta=delta,
        promised=own.delta,
        bound=round(float(standing.evidence.tally.bound(delta)[place]), _DIGITS),
        events=standing.events,
        drawn=standing.known,
        errors=int(standing.evidence.tally.errors[place]),
    )


def _as_if(decision: Decision, alpha: float) -> Audit | None:
    """The audit that a decision by another gate would have had, had its outcome been awaited for sure."""
    gate = decision.gate
    if not decision.model or decision.mode == "fallback" or gate.novelty > gate.novelty_limit or gate.trust < gate.trust_limit:
        return None
    score = round(gate.confidence * max(decision.prior.values(), default=1.0), _DIGITS)
    return Audit(
        treatment=decision.treatment,
        predicted=likeliest(decision.prior)[0],
        score=score,
        level=0.0 if decision.mode == "auto" else NOTHING,
        probability=1.0,
        drawn=True,
        alpha=alpha,
    )
