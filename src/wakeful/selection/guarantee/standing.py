"""How one treatment stands with the guarantee: its evidence, its certificate, and the watch over it."""

from __future__ import annotations

import msgspec
import numpy as np

from wakeful.facts.lines import Certified, Revoked
from wakeful.selection.guarantee.bets import LEVELS
from wakeful.selection.guarantee.bounds import clopper_pearson
from wakeful.selection.guarantee.evidence import Evidence
from wakeful.selection.guarantee.in_order import InOrder, Waiting
from wakeful.selection.guarantee.settings import GuaranteeSettings

NOTHING = 1.01
"""The level of a treatment that nothing is certified of: no score reaches it."""


class Counted(msgspec.Struct):
    """What was decided for a treatment, all model versions together, and what came of it."""

    decided: int = 0
    """Events that could be automatic, had the gate allowed."""
    automatic: int = 0
    drawn: int = 0
    validated: int = 0
    """Automatic events whose outcome the world or a person decided."""
    wrong: int = 0
    """Of these, those whose answer was wrong."""
    audited: int = 0
    """Automatic events that were drawn, with a decided outcome: a sample of all of them, drawn blindly."""
    audited_wrong: int = 0
    unknown: int = 0
    """Drawn events whose outcome nobody decided."""
    awaiting: int = 0
    """Automatic events whose outcome may still come."""

    def begin(self, waiting: Waiting) -> None:
        """An event was decided."""
        self.decided += 1
        self.drawn += waiting.drawn
        self.automatic += waiting.ran
        self.awaiting += waiting.ran

    def end(self, waiting: Waiting) -> None:
        """Its outcome is known, or will not be."""
        known = waiting.wrong is not None
        self.unknown += waiting.drawn and not known
        if waiting.ran:
            self.awaiting -= 1
            self.validated += known
            self.wrong += bool(waiting.wrong)
            self.audited += waiting.drawn and known
            self.audited_wrong += waiting.drawn and bool(waiting.wrong)


class Standing:
    """One treatment's part of the guarantee. Changed by what is applied, never by asking."""

    def __init__(self, settings: GuaranteeSettings) -> None:
        self.settings = settings
        self.number = 1
        self.certificate: Certified | None = None
        self.revoked = ""
        self.counted = Counted()
        self.begin(0)

    def begin(self, model: int) -> None:
        """Another model version decides, or a certificate was revoked: evidence begins anew."""
        self.model = model
        self.evidence = Evidence(self.settings, number=self.number)
        self.events, self.known = 0, 0
        self.doubted = 0
        self.waiting = InOrder()

    def certify(self, record: Certified) -> None:
        """A certificate begins, or widens. One whose evidence was given up with old lines of the journal stands all the same."""
        if (self.model, self.number) != (record.model, record.number):
            self.number = record.number
            self.begin(record.model)
        self.certificate, self.revoked = record, ""

    def revoke(self, record: Revoked) -> None:
        """A certificate ends."""
        self.number = record.number + 1
        self.certificate, self.revoked = None, record.why
        self.begin(record.model)

    def succeed(self, model: int) -> None:
        """Another model version decides from here on; what was seen of the one before says nothing of it."""
        self.number += bool(self.events or self.certificate is not None or len(self.waiting))
        self.certificate, self.revoked = None, ""
        self.begin(model)

    @property
    def level(self) -> float:
        """The score from which the treatment is automatic. A certificate of more risk than is allowed now counts for nothing."""
        held = self.certificate
        return held.level if held is not None and held.alpha <= self.settings.alpha else NOTHING

    def take(self, waiting: Waiting) -> None:
        """Count one event as evidence; its turn has come.

        One that was drawn and whose outcome is unknown counts as wrong, unless the settings leave it out.
        """
        if waiting.drawn and waiting.wrong is None and self.settings.unknown == "left out":
            return
        wrong = waiting.wrong if waiting.wrong is not None else waiting.drawn
        self.events += 1
        self.known += waiting.drawn
        self.evidence.take(
            place=np.asarray(waiting.place),
            drawn=np.asarray(waiting.drawn),
            wrong=np.asarray(wrong),
            automatic=np.asarray(waiting.automatic),
            probability=waiting.probability,
            certified=np.asarray(self.certificate is not None),
        )
        self.evidence.weigh()

    @property
    def earned(self) -> float:
        """The loosest level that the evidence certifies; ``NOTHING`` where it certifies none."""
        count = int(self.evidence.proven)
        return LEVELS[count - 1] if count else NOTHING

    @property
    def alarm(self) -> str:
        """Why the watch wants the certificate revoked; empty where it does not."""
        audited, seen = self.evidence.alarms()
        if audited:
            return "audited automatic answers were wrong more often than was promised"
        if self.doubted and self.evidence.alarms(self.doubted)[0]:
            return f"a reasoner answered {self.doubted} audited events otherwise, whose outcomes are still to come"
        return "automatic answers were seen to be wrong more often than was promised" if seen else ""

    @property
    def bound(self) -> float:
        """The risk now: an upper bound at every time at once, at the level in force (the strictest where none is).

        What held when the level was certified holds on: of the two bounds the lesser counts.
        """
        now = float(self.evidence.tally.bound(self.settings.delta_of(self.number))[self._place])
        held = self.certificate
        return min(now, held.bound) if held is not None and self.level < NOTHING else now

    @property
    def errors_now(self) -> int:
        """How many of the drawn events were wrong at the level in force (the strictest where none is)."""
        return int(self.evidence.tally.errors[self._place])

    @property
    def _place(self) -> int:
        return LEVELS.index(self.level) if self.level in LEVELS else 0

    @property
    def needed(self) -> int:
        """How many more events without an error certify the next level; 0 where all are certified."""
        count = int(self.evidence.proven)
        if count == len(LEVELS):
            return 0
        return self.evidence.tally.more_needed(count, self.settings.alpha, self.settings.delta_of(self.number))

    @property
    def conditional(self) -> tuple[float, float] | None:
        """P(wrong | automatic) as drawn blindly: the share seen, and its upper bound for one look; None where none was."""
        counted = self.counted
        if not counted.audited:
            return None
        share = counted.audited_wrong / counted.audited
        return share, clopper_pearson(counted.audited_wrong, counted.audited, self.settings.delta)
