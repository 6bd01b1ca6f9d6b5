"""The virtual-time driver: recordings and simulations, as fast as the machine goes. Same source, same seed, same journal."""

from __future__ import annotations

import asyncio
import heapq
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from itertools import takewhile

import msgspec

from wakeful.contracts.bridge import Item
from wakeful.contracts.journal import Journal
from wakeful.contracts.learner import Learner
from wakeful.contracts.reasoner import Reasoner
from wakeful.drivers.blobs import JournalBlobs
from wakeful.drivers.outside import make
from wakeful.drivers.poison import CAREFUL_INPUTS, CrashMark, marked, take_up
from wakeful.drivers.sd_notify import Heart
from wakeful.drivers.source_clock import Coming, set_back, source_time_ns
from wakeful.drivers.tidying import Tidying
from wakeful.drivers.trainer import Trainer
from wakeful.facts.crash_points import reach
from wakeful.facts.events import Draft, Observation, Undecodable
from wakeful.facts.evidence import Outcome
from wakeful.facts.inputs import Answer, Begin, Call, End, Input, Instant, Mark, Requests
from wakeful.facts.lines import Line
from wakeful.facts.packs import Entry
from wakeful.facts.time import to_ns
from wakeful.journal.acts import ActSpool
from wakeful.kernel import Kernel

#: Lines are committed in groups of about so many; calls and publications commit before they are acted on.
GROUP_LINES = 512

#: And at least after so many items, so that an eventless stretch moves the source cursor too.
GROUP_ITEMS = 1024

#: So many items of a recording are fed together.
AT_ONCE = 64

#: How often, in seconds of the wall's clock, operators' acts are looked for in the folder beside the journal.
ACTS_POLL_S = 0.2

Pace = Callable[[float], None]


class SimulatedDriver:
    """Drives a kernel in virtual time over one source after the other.

    Args:
        kernel: fed nothing yet; it is recovered from the journal at once.
        journal: what is committed to.
        reasoner: answers the kernel's questions; in virtual time an answer takes its ``latency_s``.
        learner: trains off the kernel's thread; published at the instant that the training declared.
        pace: called with the seconds of source time since the last item, before each one (for ``--speed``).
        acts: where operators at another terminal hand in their acts; None: nowhere.
        crash_mark: says after a crash whose treatment was running; None: nobody will know.
        heart: beats for whoever supervises this process.
    """

    def __init__(
        self,
        kernel: Kernel,
        journal: Journal,
        reasoner: Reasoner,
        learner: Learner,
        pace: Pace | None = None,
        acts: ActSpool | None = None,
        crash_mark: CrashMark | None = None,
        heart: Heart | None = None,
    ) -> None:
        self.kernel = kernel
        self.journal = journal
        self._reasoner = reasoner
        self._trainer = Trainer(learner)
        self._tidying = Tidying(journal)
        self._pace = pace
        self._acts = acts
        self._acts_due_s = 0.0
        self._crash_mark = crash_mark
        self._heart = heart if heart is not None else Heart()
        self._loop = asyncio.new_event_loop()
        self._answers: list[tuple[int, int, int, Answer]] = []
        self._lines: list[Entry] = []
        self._blobs: dict[str, bytes] = {}
        self._state: dict[str, bytes | None] = {}
        self._wake_ns: int | None = None
        self._group_ns = 0
        self._careful = CAREFUL_INPUTS if take_up(crash_mark, journal) is not None else 0
        if crash_mark is not None:
            kernel.mark_on(crash_mark.page)
        recovered = kernel.recover(journal.entries(), journal.state(), JournalBlobs(journal))
        self._lines.extend(recovered.lines)
        self._commit()
        reach("recovery: committed")
        self._take(msgspec.structs.replace(recovered, lines=()))
        self._take_acts()
        self._heart.ready(self._says)

    def run(self, name: str, digest: str, items: Callable[[int], Iterable[Item]], at_once: int = 1) -> Iterator[int]:
        """Read a source to its end; yields the number of items done so far, after each.

        A source that was begun before and not finished goes on after its cursor; a finished one is read again, and its
        events are duplicates. Closing the generator early (ctrl-C) commits what was done; the cursor is where it stopped.

        Args:
            name: of the source, as it is recorded.
            digest: of its content.
            items: gives the items after a position.
            at_once: so many items are read before they are fed together, which costs much less and gives the same journal; for
                sources whose next item never keeps anybody waiting.

        Yields:
            int: the position of the item that was just done.
        """
        known = self.kernel.source(name)
        resumes = known is not None and not known.finished and known.digest == digest
        after = known.cursor if resumes and known is not None else -1
        offset_ns = known.offset_ns if resumes and known is not None else None
        if resumes:
            self._feed([Begin(source=name, digest=digest)], self.kernel.now_ns)
        position = told = after
        source_ns: int | None = None
        pending = 0
        group: list[Input] = []
        together = at_once if self._pace is None else 1
        try:
            coming = Coming(items(after))
            for item in self._heart.over(coming):
                position += 1
                at_ns = source_time_ns(item)
                if offset_ns is None:
                    # One without a time may be the first: the clock is that of the next which has one.
                    first_ns = at_ns if at_ns is not None else next(iter(coming.next_times_ns()), None)
                    offset_ns = 0 if first_ns is None else max(0, self.kernel.now_ns - first_ns)
                    self._feed([Begin(source=name, digest=digest, offset_ns=offset_ns)], self.kernel.now_ns)
                if at_ns is not None:
                    if source_ns is not None:
                        self._keep_pace(max(0, at_ns - source_ns) / 1e9)
                    source_ns = at_ns
                    shown_ns = max(self.kernel.now_ns, self._group_ns) - offset_ns
                    if set_back(at_ns, coming, shown_ns):
                        self._feed_group(group)
                        offset_ns = self.kernel.now_ns - at_ns
                        self._feed([Begin(source=name, digest=digest, offset_ns=offset_ns)], self.kernel.now_ns)
                    self._group_ns = max(self.kernel.now_ns, self._group_ns, at_ns + offset_ns)
                    group.append(Instant(self._group_ns))
                group += (_named(item, name, position), Mark(source=name, position=position))
                pending += 1
                if position - told >= together:
                    self._feed_group(group)
                    self._take_acts()
                    if pending >= GROUP_ITEMS or len(self._lines) >= GROUP_LINES:
                        self._commit()
                        pending = 0
                    yield from range(told + 1, position + 1)
                    told = position
            if group:
                self._feed_group(group)
                yield from range(told + 1, position + 1)
            if offset_ns is None:
                self._feed([Begin(source=name, digest=digest, offset_ns=0)], self.kernel.now_ns)
            self._settle()
            self._feed([End(source=name)], self.kernel.now_ns)
            self._settle()
        finally:
            self._commit()

    def _feed_group(self, group: list[Input]) -> None:
        """Feed what was gathered, as if one by one: where something outside is to be done its answer comes when it is due."""
        waiting, at = deque(group), self._group_ns
        group.clear()
        while waiting:
            first = waiting[0]
            if isinstance(first, Instant):
                self._advance(first.at_ns)
                waiting.popleft()
                continue
            # Alone while answers or publications are to come, else all at once.
            one_by_one = self._answers or self._trainer.next_publication_ns() is not None
            inputs = list(takewhile(_is_no_instant, waiting)) if one_by_one else list(waiting)
            requests = self.kernel.feed(inputs, self.kernel.now_ns, stop=True)
            for _ in range(len(inputs) - requests.left):
                waiting.popleft()
            self._take(requests)
        self._group_ns = max(at, self.kernel.now_ns)

    def begin(self, name: str, digest: str) -> int:
        """Begin, or go on with, a source whose items are put one by one; returns the position of its last item, -1 for none."""
        known = self.kernel.source(name)
        resumes = known is not None and not known.finished
        held = known.digest if known is not None and resumes else digest
        self._feed([Begin(source=name, digest=held)], self.kernel.now_ns)
        self._commit()
        return known.cursor if known is not None and resumes else -1

    def put(self, inputs: list[Input], at_ns: int) -> tuple[Line, ...]:
        """Bring the kernel to ``at_ns``, feed, let what can run run to its end, commit; returns the lines that this gave."""
        before = self.journal.last
        self._advance(max(self.kernel.now_ns, at_ns))
        if self._careful > 0:  # the run before crashed: an event is durable before its treatment can end this run too
            self._take(self.kernel.feed(inputs, self.kernel.now_ns, hold=True))
            self._commit()
            self._careful -= 1
            inputs = []
        self._feed(inputs, self.kernel.now_ns)
        self._settle()
        self._commit()
        return tuple(self.journal.lines(before))

    def close(self) -> None:
        """Commit and let go of thread, loop and kernel; the journal stays open."""
        self._commit()
        self._trainer.close()
        self._loop.close()
        self.kernel.close()
        if self._crash_mark is not None:
            self._crash_mark.close()
        self._heart.stop()

    def _says(self) -> str:
        counts = self.kernel.counts
        return f"{counts.admitted} admitted, {counts.refused} refused, {self.kernel.runnable} at work or ready"

    # --- time ---

    def _advance(self, until_ns: int) -> None:
        """Bring the kernel to ``until_ns``, stopping at every instant at which an answer or a publication is due."""
        while True:
            # The kernel's own instants too: a call that is made at one of them is answered from there on.
            instants = [instant for instant in (self._next_due_ns(), self._wake_ns) if instant is not None]
            due_ns = min(instants, default=None)
            if due_ns is None or due_ns > until_ns:
                break
            self._feed(self._due(due_ns), due_ns)
        if until_ns > self.kernel.now_ns:
            self._feed([], until_ns)

    def _settle(self) -> None:
        """Let what can run run to its end, and what is being answered be answered; waits for the world stay."""
        while self.kernel.runnable or self._awaited() or self._trainer.next_publication_ns() is not None:
            due_ns = self._next_due_ns()
            wake_ns = self._wake_ns if self.kernel.runnable else None
            instants = [instant for instant in (due_ns, wake_ns) if instant is not None]
            if not instants:
                break
            self._advance(min(instants))

    def _awaited(self) -> bool:
        """Whether somebody still waits for an answer; those for processes that were cancelled or gave up are dropped."""
        self._answers = [each for each in self._answers if self.kernel.awaits(each[1], each[2])]
        heapq.heapify(self._answers)
        return bool(self._answers)

    def _next_due_ns(self) -> int | None:
        publication_ns = self._trainer.next_publication_ns()
        answer_ns = self._answers[0][0] if self._answers else None
        instants = [instant for instant in (publication_ns, answer_ns) if instant is not None]
        return min(instants, default=None)

    def _due(self, now_ns: int) -> list[Input]:
        due: list[Input] = []
        while self._answers and self._answers[0][0] <= now_ns:
            due.append(heapq.heappop(self._answers)[3])
        if self._trainer.next_publication_ns() is not None:
            with self._heart:  # a training that is waited for is no stall
                due.extend(self._trainer.take(now_ns))
        return due

    # --- operators ---

    def _keep_pace(self, seconds: float) -> None:
        """Wait as the source did, hearing operators meanwhile."""
        while self._pace is not None and seconds > 0:
            self._pace(min(seconds, ACTS_POLL_S))
            self._heart.beat()
            seconds -= ACTS_POLL_S
            self._take_acts()

    def _take_acts(self) -> None:
        """Do what operators handed in, now, and make it durable before it is taken out of their folder."""
        now_s = time.monotonic()
        if self._acts is None or now_s < self._acts_due_s:
            return
        self._acts_due_s = now_s + ACTS_POLL_S
        handed = self._acts.waiting()
        if handed:
            self._feed([each.act for each in handed], self.kernel.now_ns)
            reach("acts: fed")
            self._commit()
            reach("acts: committed")
            self._acts.done(handed)

    # --- the kernel's requests ---

    def _feed(self, inputs: list[Input], now_ns: int) -> None:
        self._heart.beat()
        self._take(self.kernel.feed(inputs, now_ns))

    def _take(self, requests: Requests) -> None:
        self._lines.extend(requests.lines)
        self._blobs.update(requests.blobs)
        self._wake_ns = requests.wake_ns
        if requests.calls or requests.trainings:
            self._commit()  # record first, then act
        for call in requests.calls:
            self._call(call)
        for training in requests.trainings:
            reach("acting: training")
            self._trainer.start(training)

    def _call(self, call: Call) -> None:
        reach("acting: call")
        making = make(marked(call, self._crash_mark), self._reasoner)
        if call.function is not None:  # a user's function that never ends is a stall
            answer = self._loop.run_until_complete(making)
            self._heart.beat()
        else:
            with self._heart:  # a reasoner has a limit of its own
                answer = self._loop.run_until_complete(making)
        reach("acting: call made")
        latency_ns = to_ns(self._reasoner.latency_s) if call.question is not None and not call.role else 0
        due_ns = min(call.asked_ns + latency_ns, call.expires_ns)
        heapq.heappush(self._answers, (due_ns, call.process, call.seq, answer))

    def _commit(self) -> None:
        self._state.update(self.kernel.changed())  # after a commit that failed too: it is all still to be written
        reach("feed: decided")
        self.journal.commit(self._lines, self._state, self._blobs)
        if self._blobs:
            reach("publication: committed")
        self._lines, self._blobs, self._state = [], {}, {}
        self._tidying.turn()


def _is_no_instant(item: Input) -> bool:
    return not isinstance(item, Instant)


def _named(item: Item, source: str, position: int) -> Input:
    """The item under the name by which the kernel knows its source, at its position in it."""
    if isinstance(item, Observation | Draft | Undecodable) and (item.source, item.position) != (source, position):
        return msgspec.structs.replace(item, source=source, position=position)
    if isinstance(item, Outcome):
        return msgspec.structs.replace(item, source=source)
    return item
