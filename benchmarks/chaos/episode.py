"""One episode: a mind that lives, crashes and lives again by its plan, through the real kernel, driver and journal."""

from __future__ import annotations

import gc
import traceback
from collections import deque
from contextlib import AbstractContextManager, closing, nullcontext, suppress
from pathlib import Path

import apsw
import msgspec

from benchmarks.chaos.coverage import uncovered
from benchmarks.chaos.domain import LABELS, Outside, domain, registry
from benchmarks.chaos.ledger import Known, Ledger, Witness
from benchmarks.chaos.plan import End, Plan
from benchmarks.chaos.script import SOURCE, Script, write
from wakeful.contracts.bridge import Item
from wakeful.contracts.journal import Journal, JournalError
from wakeful.contracts.policy import Policy
from wakeful.contracts.reasoner import Reasoner
from wakeful.deliberation.breaker import Breaker
from wakeful.deliberation.budget import Budget, Spent
from wakeful.deliberation.guarded import GuardedReasoner
from wakeful.deliberation.permit import Permit
from wakeful.deliberation.rate import RateLimit
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.drivers.spending import spent
from wakeful.facts.asking import Question, Reply
from wakeful.facts.inputs import Act
from wakeful.facts.lines import Finished, Line
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import to_ns, to_s
from wakeful.journal.audit import audit
from wakeful.journal.export import exported
from wakeful.journal.memory import MemoryJournal
from wakeful.journal.sqlite import SqliteJournal, open_journal
from wakeful.kernel import Kernel
from wakeful.scheduling.policies.deadline_aware import DeadlineAware, DeadlineAwareSettings
from wakeful.scheduling.policies.primary_share import PrimaryShare
from wakeful.scheduling.policies.sequential import Sequential
from wakeful.scheduling.policies.suspend_resume import SuspendResume
from wakeful.testing.crash_points import Crashed, crashing
from wakeful.testing.faulty_disk import FaultyDisk
from wakeful.testing.faulty_reasoner import FaultyReasoner

#: After the last item so much time passes: every limit and window ends within it, and what a reasoner left owing in its hour
#: of silence is repaid.
AFTERWARDS_S = 5_000.0

#: Somebody may be repaid just then: so often so much more time is given, until nothing is open.
MOST_TURNS = 20
TURN_S = 100.0

#: Of so many seeds one is audited after each recovery too; all are at their end, which puts every rule to every position.
AUDITED = 4

#: A mind that dies more often than its plan lets it does not come to its end.
MOST_LIVES = 20


class Report(msgspec.Struct, kw_only=True):
    """What came of an episode. All of the counts but ``in_doubt``, ``lives``, ``calls``, ``asked``, ``events`` must be 0."""

    lost: int
    repeated: int
    in_doubt: int
    stranded: int
    uncovered: int
    overspent: int
    lives: int
    events: int
    calls: int
    asked: int
    wrong: list[str]
    export: list[Line]

    @property
    def failed(self) -> bool:
        """Whether something happened that must not."""
        return bool(self.lost or self.repeated or self.stranded or self.uncovered or self.overspent or self.wrong)


def play(plan: Plan, journal: Path | None) -> Report:
    """Play a plan on a journal that is not there yet.

    Args:
        plan: what happens.
        journal: the file; it stays, for whoever looks closer. None: in memory and unchecked, to compare with; no life may end.
    """
    return _Episode(plan, journal).play()


class _Episode:
    def __init__(self, plan: Plan, journal: Path | None) -> None:
        self.plan = plan
        self.path = journal
        self.script: Script = write(plan)
        self.ledger = Ledger()
        self.registry = registry(Outside(self.ledger.does))
        self.domain = domain()
        self.kernel: Kernel | None = None
        self.reasoner = FaultyReasoner(right, plan.manners, plan.seed, self._now_s)
        self.wrong: list[str] = []
        self.lives = 0

    def _now_s(self) -> float:
        return to_s(self.kernel.now_ns) if self.kernel is not None else 0.0

    def play(self) -> Report:
        """Live until the script is over and everything is settled."""
        ends = deque(self.plan.ends)
        while True:
            self.lives += 1
            end = ends.popleft() if ends else None
            try:
                # A disk for each life: what the life before left in its files is what there is.
                with FaultyDisk(100 * self.plan.seed + self.lives) if self.plan.needs_disk else nullcontext() as disk:
                    self._live(end, disk)
                break
            except (Crashed, JournalError, apsw.Error) as last:
                if self.lives == MOST_LIVES or end is None:
                    self.wrong.append(f"the mind does not come to its end: {last!r}")
                    break
            except Exception:  # a defect, of the mind or of its world: the seed says so, and the others go on
                self.wrong.append(traceback.format_exc(limit=-6))
                break
        return self._report()

    # --- one life ---

    def _dying(self, end: End | None, disk: FaultyDisk | None) -> AbstractContextManager[None]:
        """Within it the life ends as planned."""
        if end is None or not end.at:
            return nullcontext()
        if end.how == "power" and disk is not None:
            return crashing(end.at, end.nth, first=disk.cut_power)
        return crashing(end.at, end.nth)

    def _live(self, end: End | None, disk: FaultyDisk | None) -> None:
        if end is not None and end.how == "disk" and disk is not None:
            disk.fail(end.fault, after_writes=end.nth)
        try:
            with self._dying(end, disk):
                inner = self._opened(disk)
                try:
                    failing = end.nth if end is not None and end.how == "commit" else 0
                    journal = Witness(inner, self.ledger, failing)
                    if self.plan.seed % AUDITED == 0 and isinstance(inner, SqliteJournal):
                        self._check(inner)
                    self._think_on(journal)
                finally:
                    with suppress(apsw.Error, JournalError):
                        inner.close()
        finally:
            if end is not None and end.how == "power" and disk is not None:
                gc.collect(0)  # a connection that was being opened is closed before its files are put back
                disk.restore_power(end.survival)

    def _opened(self, disk: FaultyDisk | None) -> Journal:
        if self.path is None:
            return MemoryJournal()
        return open_journal(self.path, vfs=disk.name if disk is not None else None)

    def _driver(self, journal: Witness) -> SimulatedDriver:
        plan = self.plan
        settings = MindSettings(
            slots=plan.slots,
            reasoner_slots=plan.reasoner_slots,
            step_s=plan.step_s,
            seed=plan.seed,
            keep_waiting=plan.keep_waiting,
        )
        thinker = self._thinker()
        self.kernel, learner = assemble(self.domain, settings, registry=self.registry, policy=_policy(plan))
        return SimulatedDriver(self.kernel, journal, thinker, learner)

    def _thinker(self) -> Reasoner:
        """The reasoner as this life knows it: where there is a budget, guarded, charged with what the journal tells."""
        if self.plan.budget is None:
            return self.reasoner
        budget = Budget(None, self.plan.budget, at_most(spent(self.ledger.known, self.reasoner.name, self.plan.reasoner_slots)))
        permit = Permit(budget, RateLimit(None, self._now_s), Breaker(4, 30.0, self._now_s))
        return _Guarded(self.reasoner, GuardedReasoner(self.reasoner, permit, deadline_s=30.0))

    def _think_on(self, journal: Witness) -> None:
        driver = self._driver(journal)
        try:
            self._think(driver)
        finally:
            _drop(driver)

    def _think(self, driver: SimulatedDriver) -> None:
        readings = sum(isinstance(line.record, Finished) for line in self.ledger.known)
        if readings == 0:
            known = driver.kernel.source(SOURCE)
            self._act(driver, -1 if known is None else known.cursor)
            with closing(driver.run(SOURCE, "digest", self._after)) as positions:
                for position in positions:
                    self._act(driver, position)
        if readings < 2 and self.plan.rereads:
            with closing(driver.run(SOURCE, "digest", self._after)) as positions:
                deque(positions, maxlen=0)
        holds = [act for acts in self.script.acts.values() for act in acts if act.act == "hold"]
        releases = [Act(who="ana", act="release", process=act.process, why="over", id=f"over {act.id}") for act in holds]
        driver.put(list(releases), driver.kernel.now_ns)
        over_ns = max(line.at_ns for line in self.ledger.known if isinstance(line.record, Finished))
        for turn in range(MOST_TURNS):
            driver.put([], over_ns + to_ns(AFTERWARDS_S + turn * TURN_S))
            if not len(driver.kernel._scheduler.processes):
                break

    def _after(self, position: int) -> tuple[Item, ...]:
        return self.script.items[position + 1 :]

    def _act(self, driver: SimulatedDriver, position: int) -> None:
        """Hand in the acts that belong after an item, as the driver takes them: fed and made durable; time does not go on."""
        acts = self.script.acts.get(position)
        if acts:
            driver._feed(list(acts), driver.kernel.now_ns)
            driver._commit()

    # --- what must hold ---

    def _check(self, journal: SqliteJournal) -> None:
        found = audit(Known(self.ledger, journal))
        if not found.ok:
            bad = [f"{name}: {each.first_offender}" for name, each in found.checks.items() if not each.ok]
            self.wrong.append(f"audit in life {self.lives}: {'; '.join(bad)}")

    def _report(self) -> Report:
        holes: list[str] = []
        if self.path is not None:
            with open_journal(self.path) as journal:
                self.ledger.reopened(list(journal.lines()))
                self._check(journal)
            holes = uncovered(self.ledger.known, self.ledger.commits)
        self.wrong += holes[:3]
        processes = self.kernel._scheduler.processes if self.kernel is not None else ()
        overspent = max(0, self.reasoner.made - self.plan.budget) if self.plan.budget is not None else 0
        return Report(
            lost=self.ledger.lost,
            repeated=self.ledger.repeated,
            in_doubt=self.ledger.in_doubt,
            stranded=len(processes),
            uncovered=len(holes),
            overspent=overspent,
            lives=self.lives,
            events=self.kernel.counts.admitted if self.kernel is not None else 0,
            calls=self.ledger.calls,
            asked=self.reasoner.made,
            wrong=self.wrong,
            export=list(exported(self.ledger, stable=True)),
        )


class _Guarded:
    """A guarded reasoner whose answers take as long as the inner one says each time."""

    def __init__(self, inner: FaultyReasoner, guarded: GuardedReasoner) -> None:
        self.name = inner.name
        self._inner = inner
        self._guarded = guarded

    @property
    def latency_s(self) -> float:
        """What the last answer took."""
        return self._inner.latency_s

    async def answer(self, question: Question) -> Reply:
        """One answer within the budget."""
        return await self._guarded.answer(question)


def at_most(so_far: Spent) -> Spent:
    """With a reasoner that makes one call an answer, an answer in doubt was one call."""
    return Spent(so_far.calls + so_far.in_doubt, so_far.usd)


def _policy(plan: Plan) -> Policy:
    ageing = DeadlineAware(DeadlineAwareSettings(wait_s_per_step=160.0 * (plan.step_s or 0.01)))
    match plan.policy:
        case "deadline_aware":
            return ageing
        case "suspend_resume":
            return SuspendResume()
        case "sequential":
            return Sequential()
        case _:
            return PrimaryShare(ageing, 0.3, 0.1)


def right(question: Question) -> Reply:
    """What a reasoner without faults says in this domain."""
    kind = question.facts.get("kind", "")
    choice = kind if kind in question.options else "description"
    forecast = LABELS[1] if question.facts.get("state") == "odd" else LABELS[0]
    return Reply(choice=choice, confidence=0.9, forecast=forecast, forecast_probability=0.8, because=("so it is written",))


def _drop(driver: SimulatedDriver) -> None:
    """Let go of what a killed process would leave to the operating system; nothing is committed."""
    driver._loop.close()
    driver._trainer.close()
