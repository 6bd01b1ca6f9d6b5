"""The gate itself, as numbers: what counts for a certificate, when there is one, and when it must go.

One treatment's, or those of many treatments (many simulated deployments) side by side: every array has the shape that it was
made with, and the same code runs over one and over a thousand.
"""

from __future__ import annotations

import numpy as np

from wakeful.selection.guarantee.bets import LEVELS, Counts, Flags, Floats, Tally
from wakeful.selection.guarantee.settings import GuaranteeSettings
from wakeful.selection.guarantee.watch import step


class Evidence:
    """Evidence on one model version since it began to decide, or since its certificate was revoked.

    Args:
        settings: what is promised.
        shape: () for one treatment.
        number: of the certificate that is sought: each uses its own part of δ.
    """

    def __init__(self, settings: GuaranteeSettings, shape: tuple[int, ...] = (), number: int = 1) -> None:
        self.settings = settings
        self.tally = Tally(shape)
        self.number: Counts = np.full(shape, number, dtype=np.int64)
        self.proven: Counts = np.zeros(shape, dtype=np.int64)
        self.audited: Floats = np.zeros(shape)
        self.seen: Floats = np.zeros(shape)

    @property
    def delta(self) -> Floats:
        """The part of δ that each certificate may use."""
        return np.asarray(self.settings.delta / (self.number * (self.number + 1.0)))

    def take(
        self,
        place: Counts,
        drawn: Flags,
        wrong: Flags,
        automatic: Flags,
        probability: float,
        certified: Flags,
        where: Flags | None = None,
    ) -> None:
        """Take up one event each, in the order in which they were decided.

        An undrawn event counts as one without an error, by the same right by which a drawn one's error counts for more.

        Args:
            place: the strictest level that its score reaches (``place_of``).
            drawn: whether its outcome counts.
            wrong: whether its answer is known to be wrong; of an undrawn one only the watch over what is seen hears.
            automatic: whether it was within the level in force when it was decided.
            probability: with which it was drawn.
            certified: whether there is a certificate to watch over.
            where: take up only there; everywhere without it.
        """
        own = self.settings
        shown = np.asarray(drawn) & wrong
        self.tally.count(place, shown, probability, where)
        watched = np.asarray(certified) if where is None else np.asarray(certified) & where
        audited = step(self.audited, shown & automatic, probability, own.alpha, own.to)
        seen = step(self.seen, np.asarray(wrong) & automatic, 1.0, own.alpha, own.to)
        self.audited = np.where(watched, audited, self.audited)
        self.seen = np.where(watched, seen, self.seen)

    def weigh(self) -> Counts:
        """How many levels are certified now, from the strictest on. What was once certified stays so until ``restart``.

        Only the next looser level is tested, and the one after it once that has passed. This is fixed-sequence testing
        (Angelopoulos et al. 2022, *Learn then Test*): the risk grows with every looser level, so the first that is too risky is
        the only one whose test can go wrong, and no correction for the number of levels is needed.
        """
        limit = -np.log(self.delta)
        while True:
            left = self.proven < len(LEVELS)
            place = np.minimum(self.proven, len(LEVELS) - 1)
            passed = left & (self.tally.log_capital(self.settings.alpha, place) >= limit)
            if not passed.any():
                return self.proven
            self.proven = self.proven + passed

    def alarms(self, doubted: int = 0) -> tuple[Flags, Flags]:
        """Whether the watch over audited answers gives alarm, and the one over all that are seen to be wrong.

        ``doubted`` further audited answers are taken for wrong.
        """
        limit = np.log(self.settings.patience)
        more = doubted * np.log(self.settings.to / self.settings.alpha)
        return np.asarray(self.audited + more >= limit), np.asarray(self.seen >= limit)

    def restart(self, where: Flags) -> None:
        """A certificate was revoked there: nothing that was seen counts for the next one."""
        self.tally.clear(where)
        self.proven = np.where(where, 0, self.proven)
        self.number = self.number + where
        self.audited = np.where(where, 0.0, self.audited)
        self.seen = np.where(where, 0.0, self.seen)
