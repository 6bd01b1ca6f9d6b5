"""Parking: processes that wait long are put out of memory, room by room, and brought back when something comes for them.

What is decided, recorded and answered is the same with and without it. A parked process is held by its bytes outside memory,
and by a small entry in scheduling; after a crash recovery folds it from the journal like any other.
"""

from __future__ import annotations

import logging

import msgspec

from wakeful.contracts.aside import Aside, AsideFull
from wakeful.revision import Made, Revision
from wakeful.scheduling.process import Process, Recorded
from wakeful.scheduling.scheduler import Scheduler
from wakeful.validation import Validation

#: So many are parked after one feed: a quarter of those that are too many, within these bounds, so that nobody waits long for it.
FEWEST, MOST = 128, 256


class _Parked(msgspec.Struct, kw_only=True, omit_defaults=True):
    """What the rooms hold of one process."""

    process: Recorded
    made: Made | None = None
    since_ns: int | None = None
    known: tuple[int, ...] = ()


_encode = msgspec.json.Encoder().encode
_decode = msgspec.json.Decoder(_Parked).decode
_LOG = logging.getLogger(__name__)


class Parking:
    """Keeps the newest ``keep`` waiting processes at hand and parks the others.

    Args:
        aside: where they are put; None: nobody is parked.
        keep: so many stay at hand.
        scheduler, validation, revision: the rooms that hold something of each waiting process.
    """

    def __init__(
        self, aside: Aside | None, keep: int, *, scheduler: Scheduler, validation: Validation, revision: Revision
    ) -> None:
        self._aside = aside
        self._keep = keep
        self._scheduler = scheduler
        self._validation = validation
        self._revision = revision

    def settle(self) -> None:
        """Park the oldest waiters where there are too many, a few at a time."""
        processes = self._scheduler.processes
        excess = processes.parkable - self._keep
        if self._aside is None or excess <= 0:
            return
        for process in processes.oldest(min(excess, MOST, max(FEWEST, excess // 4))):
            try:
                self._park(self._aside, process)
            except AsideFull as error:
                _LOG.warning("%s", error)
                self._keep = 2 * processes.parkable  # they stay at hand: it is tried again when there are twice as many
                break

    def _park(self, aside: Aside, process: Process) -> None:
        parked = _Parked(
            process=process.recorded(),
            made=self._revision.park(process.id),
            since_ns=self._validation.park(process.id),
            known=self._scheduler.processes.park(process),
        )
        try:
            aside.put(process.id, _encode(parked))
        except AsideFull:
            self._give_back(parked)
            raise

    def bring_back(self, process: int) -> None:
        """Have a parked process at hand again. Raises KeyError where it is not parked."""
        if self._aside is None:
            raise KeyError(process)
        self._give_back(_decode(self._aside.take(process)))

    def close(self) -> None:
        """Give up what is parked, at the mind's end: the journal has all of it."""
        if self._aside is not None:
            self._aside.close()

    def _give_back(self, parked: _Parked) -> None:
        process = parked.process
        self._scheduler.bring_back(process, parked.known)
        if parked.made is not None:
            self._revision.bring_back(parked.made)
        if parked.since_ns is not None:
            self._validation.bring_back(process.event, parked.since_ns, process.id)
