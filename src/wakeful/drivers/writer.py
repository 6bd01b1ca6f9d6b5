"""Commits beside the feeding: what several feeds came to is written together while the kernel goes on with the next."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from concurrent.futures import Executor

import msgspec

from wakeful.contracts.journal import Journal, JournalStalled
from wakeful.drivers.receipts import Offered
from wakeful.drivers.stalled import Stall
from wakeful.drivers.tidying import Tidying
from wakeful.facts.crash_points import reach
from wakeful.facts.events import Undecodable
from wakeful.facts.inputs import Mark, Requests
from wakeful.facts.packs import Entry
from wakeful.journal.acts import Handed
from wakeful.scheduling.evidence import KEPT

#: So many feeds wait at most for the commit that is under way; then the kernel waits too.
MOST_GROUPS = 16


class Group(msgspec.Struct, frozen=True, kw_only=True):
    """What one feed came to: committed before anything of it is acted on."""

    requests: Requests
    state: dict[str, bytes | None]
    offered: Offered
    handed: Sequence[Handed] = ()
    point: str = ""
    """The crash point that is reached between its commit and acting on it; none where empty."""


class Writer:
    """Commits groups in their order, all that wait at once, one commit at a time. A group is acted on once it is durable.

    Where nothing can be written for now, it tries again every so often, and says so through the stall.

    Args:
        journal: what is committed to.
        commits: the one thread that does so; an executor that works at once makes a run repeatable.
        stall: told when writing fails for now, and when it goes again.
        retry_s: how often writing is tried again.
        settle: acts on a group that is durable.
        resume: takes what was refused while nothing could be written, once it can.
        moved: told after each commit and each failure: whoever waits for the writer may look again.
    """

    def __init__(
        self,
        journal: Journal,
        commits: Executor,
        stall: Stall,
        retry_s: float,
        settle: Callable[[Group], None],
        resume: Callable[[list[Undecodable | Mark]], None],
        moved: Callable[[], None],
    ) -> None:
        self.error: BaseException | None = None
        self.closing = False
        self._journal = journal
        self._commits = commits
        self._stall = stall
        self._retry_s = retry_s
        self._settle = settle
        self._resume = resume
        self._moved = moved
        self._tidying = Tidying(journal)
        self._loop = asyncio.get_running_loop()
        self._waiting: list[Group] = []
        self._under_way: list[Group] = []
        self._state: dict[str, bytes | None] = {}
        self._began_s = 0.0

    @property
    def idle(self) -> bool:
        """Whether all that was put is durable and acted on."""
        return not self._waiting and not self._under_way

    @property
    def takes_s(self) -> float:
        """For how long the commit that is under way has been; 0 where there is none."""
        return self._loop.time() - self._began_s if self._under_way else 0.0

    @property
    def full(self) -> bool:
        """Whether the kernel is so far ahead of the journal that it waits."""
        return len(self._waiting) >= MOST_GROUPS

    @property
    def held_entries(self) -> int:
        """How many entries are not durable yet."""
        return sum(len(group.requests.lines) for group in (*self._under_way, *self._waiting))

    def put(self, group: Group) -> None:
        """Commit it after all that was put before."""
        self._waiting.append(group)
        if not self._under_way and not self._stall.active and self.error is None:
            self._begin()

    def fail(self, error: Exception) -> None:
        """What is not durable never will be: nobody waits for it for ever."""
        for group in (*self._under_way, *self._waiting):
            group.offered.fail(error)
        self._under_way, self._waiting = [], []

    def _begin(self) -> None:
        taken, self._waiting = self._waiting, []
        self._under_way = taken
        self._began_s = self._loop.time()
        for group in taken:
            self._state.update(group.state)
        lines = taken[0].requests.lines if len(taken) == 1 else [line for group in taken for line in group.requests.lines]
        blobs = {name: blob for group in taken for name, blob in group.requests.blobs.items()}
        # Evidence that nobody waits for yet gives no line, and whoever told it was promised that it is durable.
        if lines or blobs or any(key.startswith(KEPT) for key in self._state):
            reach("feed: decided")
            self._commits.submit(self._commit, lines, self._state, blobs)
        else:
            self._loop.call_soon(self._committed, None)

    def _commit(self, lines: Sequence[Entry], state: dict[str, bytes | None], blobs: dict[str, bytes]) -> None:
        """In the thread."""
        error: BaseException | None = None
        try:
            self._journal.commit(lines, state, blobs)
        except BaseException as raised:  # whatever it is, the loop's thread is where it is raised
            error = raised
        else:
            state.clear()
        self._loop.call_soon_threadsafe(self._committed, error)
        if error is None:
            self._tidying.turn_beside()

    def _committed(self, error: BaseException | None) -> None:
        taken, self._under_way = self._under_way, []
        if isinstance(error, JournalStalled) and not self.closing:
            self._waiting = taken + self._waiting
            self._stall.begin(str(error))
            self._loop.call_later(self._retry_s, self._begin)
        elif error is not None:
            self._waiting = taken + self._waiting
            self.error = error
        else:
            self._durable(taken)
        self._moved()

    def _durable(self, taken: list[Group]) -> None:
        try:
            self._resume(self._stall.over())
            if any(group.requests.blobs for group in taken):
                reach("publication: committed")
            if self._waiting:
                self._begin()  # the next commit goes on while this one is acted on
            for group in taken:
                if group.point:
                    reach(group.point)
                self._settle(group)
        except BaseException as defect:
            self.error = defect
