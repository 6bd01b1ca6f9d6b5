"""Housekeeping between commits: a driver's way to the journal's compaction, which never stops a mind."""

from __future__ import annotations

import logging

from wakeful.contracts.journal import Journal, JournalError

_LOG = logging.getLogger("wakeful.journal")


class Tidying:
    """Does a little of what the journal's housekeeping has to do, when it is told to.

    Where that fails (a damaged row, a full disk), it is said once, in the log, and nothing more is tried until the next start:
    a journal that grows is no reason for a mind to stop. A defect of the housekeeping is raised by ``turn``, and said with its
    traceback by ``turn_beside`` where nobody would hear of it.

    Args:
        journal: the driver's own, in the thread that commits to it.
    """

    def __init__(self, journal: Journal) -> None:
        self._journal = journal
        self._given_up = False

    def turn(self) -> bool:
        """A few milliseconds' work; returns whether there is more to do at once."""
        if self._given_up:
            return False
        try:
            return self._journal.tidy()
        except JournalError as error:
            self._given_up = True
            _LOG.warning("%s; it grows until the next start", error)
            return False

    def turn_beside(self) -> None:
        """The same beside the mind, in a thread that nobody looks at. What a step of it had begun was rolled back: the journal
        is whole, and to go on with it loses nothing, while to stop would lose what comes."""
        try:
            self.turn()
        except Exception:  # whatever it is, it is said here or nowhere
            self._given_up = True
            _LOG.exception("the journal's housekeeping has a defect; nothing was lost, the journal grows until the next start")
