"""The kernel: the one place that knows the order of the rooms (Eq. 11). Sans-IO and synchronous.

    encounter → register → cover → select treatment → process → validate → learn → reuse/revise

It decides, writes a record, and applies it; every change of its state but registration's memory is the application of a
record, so recovery is the same code over the journal's lines.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import msgspec

from wakeful.admission import Admission, Counts
from wakeful.admission.overload import Overload
from wakeful.contracts.aside import Aside
from wakeful.contracts.domain import Domain
from wakeful.contracts.learner import Learner
from wakeful.contracts.policy import Policy
from wakeful.facts.asking import Episode, Query, Reply
from wakeful.facts.crash_points import reach
from wakeful.facts.crashes import Page
from wakeful.facts.decisions import Decision, Mode
from wakeful.facts.events import Draft, Event, Observation, Undecodable
from wakeful.facts.evidence import Evidence, Outcome
from wakeful.facts.experience import Experience, ModelCard
from wakeful.facts.inputs import Act, Answer, Begin, Call, End, Input, Instant, Mark, Requests, Trained, Training
from wakeful.facts.lines import (
    GAP,
    Acted,
    Admitted,
    AnyRecord,
    Concluded,
    Gained,
    Judged,
    Noted,
    Published,
    Reopened,
    TrainingAsked,
    Witnessed,
)
from wakeful.facts.packs import AnyBurst, Entry, Ran, Validated
from wakeful.facts.results import Forecast, Result
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import LARGEST_NS, Stamp, to_ns, to_s
from wakeful.folding import Folding
from wakeful.learning.cells import Cells
from wakeful.learning.counsel import Counsel
from wakeful.learning.episodes import Episodes
from wakeful.learning.exemplars import Exemplars
from wakeful.learning.plan import Learning, LearningSettings
from wakeful.learning.recent import Recent
from wakeful.outgoing import Outgoing
from wakeful.parking import Parking
from wakeful.registration import CLEARED, Sources, SourceState
from wakeful.revision import Debts, Revision
from wakeful.scheduling.evidence import EvidenceShelf
from wakeful.scheduling.scheduler import Scheduler
from wakeful.selection.foresight import Seen
from wakeful.selection.gating import SelectionSettings
from wakeful.selection.guarantee import guarantee_of
from wakeful.selection.recalled import with_memory
from wakeful.selection.selector import Selector
from wakeful.treatments.registry import Registry
from wakeful.validation import Validation
from wakeful.versions import Versions

_STATE_KEY = "kernel"

#: From so many events at a time on, a batch costs less than one by one.
MANY = 5


class _KernelState(msgspec.Struct, kw_only=True):
    now_ns: int
    sources: dict[str, SourceState]


class Kernel:
    """One mind. The driver commits what ``feed`` returns before it acts on it.

    Args:
        domain: one robot family's vocabulary.
        registry: the treatments that may be chosen.
        learner: trains and loads F_θ.
        policy: chooses among ready processes.
        settings: how this mind thinks.
        aside: where long waiters are parked; None: they stay in memory.
    """

    def __init__(
        self,
        domain: Domain,
        registry: Registry,
        learner: Learner,
        policy: Policy,
        settings: MindSettings,
        aside: Aside | None = None,
    ) -> None:
        self.domain = domain
        self.settings = settings
        spec = domain.spec
        options = spec.treatments or registry.names()
        self._now_ns = 0
        self._within_ns = to_ns(spec.outcome.within_s)
        self._left: int | None = None
        self.steps_done = 0
        """Steps and limits done since it was made: by which a live driver measures how long a step takes."""
        self._calm_ns = 0
        self._stops = False
        self._sources = Sources(domain, settings.seed)
        self._admission = Admission(settings.keep_ids)
        self._overload = Overload(settings.overload)
        self._guarantee = guarantee_of(settings)
        gate = SelectionSettings.under(settings)
        self._selector = Selector(spec, options, learner, gate, self._guarantee)
        self._episodes = Episodes(self._selector.encode, settings.episodes, encode_many=self._selector.encode_many)
        self._exemplars = Exemplars(self._selector.encode, options, spec.outcome.labels)
        self._recent = Recent(self._selector.encode, self._selector.encode_many, spec.outcome.labels)
        shelf = EvidenceShelf({each.topic: to_ns(each.keep_s) for each in spec.evidence}, to_ns(settings.keep_evidence_s))
        self._scheduler = Scheduler(self, policy, registry, spec, options, shelf)
        self._validation = Validation(spec)
        self._gap_ns = None if spec.outcome.gap_s is None else to_ns(spec.outcome.gap_s)
        self._learning = Learning(
            spec, options, learner, self._selector.encode, LearningSettings.under(settings), self._selector.encode_many
        )
        self._counsel = Counsel()
        self._cells = Cells(self._selector.cells)
        self._versions = Versions(self._selector, self._cells)
        self._foreseen: dict[int, Seen] = {}
        self._debts = Debts(settings.repay_after_s, settings.repay_every_s)
        self._revision = Revision(spec)
        self._folding = Folding(
            settings.keep_events,
            admission=self._admission,
            processes=self._scheduler.processes,
            validation=self._validation,
            learning=self._learning,
            exemplars=self._exemplars,
            recent=self._recent,
            cells=self._cells,
            episodes=self._episodes,
            counsel=self._counsel,
            guarantee=self._guarantee,
            revision=self._revision,
            debts=self._debts,
        )
        self._parking = Parking(
            aside, settings.keep_waiting, scheduler=self._scheduler, validation=self._validation, revision=self._revision
        )
        self._out = Outgoing()

    # --- what the driver may ask ---

    @property
    def now_ns(self) -> int:
        """Kernel time; it never runs back."""
        return self._now_ns

    @property
    def runnable(self) -> int:
        """How many processes could use a slot now, or hold one."""
        return self._scheduler.processes.runnable

    @property
    def steps_left(self) -> int | None:
        """How many steps may still be done in this feed; None: all that are due."""
        return self._left

    def enough(self) -> None:
        """No further step in this feed: its driver's clock says so, between two treatments' turns."""
        self._left = 0

    def spent(self, steps: int) -> None:
        """So many steps were done within this feed."""
        self.steps_done += steps
        if self._left is not None:
            self._left = max(0, self._left - steps)

    @property
    def backlog(self) -> int:
        """How many processes have not begun to be treated, or queue for the reasoner."""
        return self._scheduler.processes.backlog

    @property
    def parked(self) -> int:
        """How many waiting processes are parked outside memory."""
        return len(self._scheduler.processes.parked)

    @property
    def counts(self) -> Counts:
        """received = admitted + duplicate + refused."""
        return self._admission.counts()

    def mark_on(self, page: Page) -> None:
        """Say on that page, from now on, whose treatment's code is running: a crash leaves it to be read."""
        self._scheduler.mark_on(page)

    def source(self, name: str) -> SourceState | None:
        """What is known of a source: where to go on, or that it was finished."""
        return self._sources.states.get(name)

    def awaits(self, process: int, seq: int) -> bool:
        """Whether that process waits for the answer to its request of that number."""
        found = self._scheduler.processes.get(process)
        pending = found.pending if found is not None else None
        return pending is not None and pending.seq == seq

    def result(self, concluded: Concluded) -> Result:
        """A recorded result in its treatment's own type."""
        return self._scheduler.result(concluded)

    def feed(
        self, inputs: Iterable[Input], now_ns: int, steps: int | None = None, hold: bool = False, stop: bool = False
    ) -> Requests:
        """Take inputs at ``now_ns`` and say what is to be done.

        What falls due up to ``now_ns`` (steps, limits, windows) is done first, in order of (time, rank, sequence number).

        Args:
            inputs: in the order of their arrival; an Instant among them brings the kernel to the time of the next ones.
            now_ns: kernel time; an earlier one than before counts as that.
            steps: do at most so many of the steps that are due, so that a live driver hears of what comes between two awaits
                of a treatment; the others stay due. None: all of them. Limits pass when they are due.
            hold: run no treatment's code at this feed, so that what it admits can be durable before that; the next one lets go.
            stop: don't go on to the next Instant once anything outside is to be done, so that in virtual time its answer comes
                when it is due; ``Requests.left`` says how many of the inputs are left, that Instant the first of them.

        Returns:
            Requests: to be committed as a whole before anything else of it is acted on.
        """
        self._left = 0 if hold else steps
        if hold or self._scheduler.held_back:
            self._calm_ns = 0
            self._scheduler.hold_back(hold)
        self._until(now_ns)
        self._now_ns = max(self._now_ns, now_ns)
        inputs = list(inputs)
        self._foresee(inputs)
        self._stops = stop
        left = len(inputs)
        for each in inputs:
            if isinstance(each, Instant):
                if stop and self._out.asks:
                    break
                self._go_on_to(each.at_ns)
                left -= self._now_ns >= each.at_ns
                continue
            left -= 1
            if isinstance(each, Draft):
                self._encountered(each)
            elif isinstance(each, Mark):
                self._sources.states[each.source].cursor = each.position
                continue
            elif isinstance(each, Outcome):
                self._validate(each)
            else:
                self._take(each)
            if self._calm_ns <= self._now_ns:
                self._until(self._now_ns)
        self._foreseen.clear()
        self._stops = False
        self._parking.settle()
        return self._requests(left)

    def _foresee(self, inputs: list[Input]) -> None:
        """See at once what the model says of all events that come; under which conditions they join others is seen one by one."""
        drafts = [each for each in inputs if each.__class__ is Draft and each.condition is None]
        if len(drafts) >= MANY:
            seen = self._selector.foresee(drafts)
            if seen is not None:
                self._foreseen = dict(zip(map(id, drafts), seen, strict=True))

    # --- the cycle of Eq. 11 ---

    def _take(self, item: Input) -> None:
        """All that comes seldom; what comes with each event, ``feed`` takes itself."""
        match item:
            case Observation():
                self._encounter(item)
            case Evidence():
                self._evidence(item)
            case Answer():
                self._scheduler.answer(item)
            case Trained():
                self._reuse(item)
            case Undecodable():
                self._hear(item.source)
                self._refuse(item)
            case Begin():
                self._begin(item)
            case End():
                self._break_off(item)
            case Act(act="rollback"):
                self._roll_back(item)
            case Act():
                self._scheduler.act(item)

    def _begin(self, begin: Begin) -> None:
        opened = self._sources.begin(begin)
        self.write(opened)
        if opened.resumed_at and begin.offset_ns:
            told = f"{begin.source}: its clock was set anew; {to_s(begin.offset_ns):.1f} s now take it to kernel time"
            self.write(Noted(what="clock set anew", detail=told, source=begin.source))

    def _go_on_to(self, at_ns: int) -> None:
        if at_ns > self._now_ns:
            if self._calm_ns <= at_ns:
                self._until(at_ns)
            if not self._stops or not self._out.asks:
                self._now_ns = at_ns

    def _encountered(self, draft: Draft) -> None:
        """An event that was registered elsewhere."""
        source = self._sources.states[draft.source]
        if source.heard_ns != self._now_ns:
            self._hear(draft.source)
        if draft.condition is None:
            source.offered += 1
            self._cover(draft)
        else:
            self._offer(draft)

    def _encounter(self, observation: Observation) -> None:
        """Encounter and register: e = D(o, c) (Eq. 1)."""
        self._hear(observation.source)
        registered = self._sources.observe(observation)
        for outcome in registered.outcomes:
            self._validate(outcome)
        for evidence in registered.evidence:
            self._evidence(evidence)
        for draft in registered.events:
            self._cover(draft)

    def _hear(self, name: str) -> None:
        """The source was heard: what lies before a stretch in which it was not recording cannot be judged by silence."""
        silent_ns = self._sources.hear(name, self._now_ns)
        if self._gap_ns is not None:
            if silent_ns > self._gap_ns:
                self.write(Noted(what=GAP, detail=f"{name} was not heard for {to_s(silent_ns):.1f} s", source=name))
            self._judge(self._validation.close(self._now_ns, name))

    def _refuse(self, undecodable: Undecodable) -> None:
        self._sources.states[undecodable.source].offered += 1
        self.write(self._admission.refuse(undecodable))

    def _offer(self, draft: Draft) -> None:
        """An event that was registered elsewhere is covered, or joins the condition that it repeats or clears."""
        joined = self._sources.join(draft)
        if isinstance(joined, Draft):
            self._cover(joined)
        elif isinstance(joined, Evidence):
            self._evidence(joined)
        else:
            key = draft.condition.key if draft.condition is not None else ""
            self.write(self._admission.reject(draft, f"no condition {key!r} of this source is open: nothing to clear"))

    def _cover(self, draft: Draft) -> None:
        """Cover: an admitted event has a process with a decision from the same instant on (Eq. 3)."""
        digest = self._sources.states[draft.source].digest
        stamp = Stamp(source_ns=draft.at_ns, clock=draft.clock, uncertainty_ns=draft.uncertainty_ns, received_ns=self._now_ns)
        record = self._admission.admit(draft, digest, stamp)
        if not isinstance(record, Admitted):
            self.write(record)
            return
        shed = ""
        if self._scheduler.processes.backlog or len(self._scheduler.processes) >= self._overload.settings.most_open:
            load = self._scheduler.load(draft.source)
            if objection := self._overload.objection(record.event, load):
                self.write(self._admission.reject(draft, objection))
                return
            shed = self._overload.sheds(record.event, load)
        self._covered(record, draft, shed)

    def _covered(self, admitted: Admitted, draft: Draft, shed: str) -> None:
        """Give an admitted event its process: in one go where its decision is automatic."""
        event = admitted.event
        seen = self._foreseen.get(id(draft))
        if seen is None:
            seen = self._selector.see(event)
        if seen is not None and not self._recent.heard:
            nearest = self._nearest(event, seen)
            choice = self._selector.choose(seen, self._revision.level(seen[0].treatment, nearest), nearest)
            if choice is not None and not self._contested(event):
                self._scheduler.cover(event, choice, deadline_ns=self._deadline_ns(event))
                return
        self.write(admitted)
        self._start(event, why=shed, seen=seen)

    def _deadline_ns(self, event: Event) -> int | None:
        return None if event.deadline_s is None else self._now_ns + to_ns(event.deadline_s)

    def _start(self, event: Event, reopens: int = 0, why: str = "", mode: Mode | None = None, seen: Seen | None = None) -> int:
        decision = self._select(event, seen)
        if reopens:
            # What was refuted is not done again unthinkingly.
            mode = mode or ("delib" if decision.mode == "auto" else decision.mode)
            decision = msgspec.structs.replace(decision, mode=mode, audit=None, reasons=(why, *decision.reasons))
        elif why and decision.mode == "delib":
            # Coverage before deliberation: a provisional treatment now, a better one is owed.
            decision = msgspec.structs.replace(decision, mode="fallback", audit=None, reasons=(why, *decision.reasons))
        return self._scheduler.create(event, decision, deadline_ns=self._deadline_ns(event), reopens=reopens)

    def _select(self, event: Event, seen: Seen | None = None) -> Decision:
        """Select what treatment, and separately how (Eq. 4)."""
        seen = self._selector.see(event) if seen is None else seen
        nearest = self._nearest(event, seen)
        card = self._selector.card
        watermark = card.watermark if card is not None else 0
        joined = self._joined(event, seen)
        decision = self._selector.decide(event, self._revision.levels(nearest), nearest, watermark, joined)
        if joined is not seen and seen is not None:
            own = self._selector.forecast(seen)
            decision = msgspec.structs.replace(decision, foretold=own, reasons=(*decision.reasons, self._recent.says(own)))
        if self._recent.outdoes_memory or (decision.mode == "auto" and not self._contested(event)):
            return decision
        made = with_memory(decision, self._exemplars.recall(self._selector.encode(event), self._selector.predictor))
        return made if self._guarantee is None else self._guarantee.hold(decision, made)

    def _joined(self, event: Event, seen: Seen | None) -> Seen | None:
        """What the model says of the event, its forecast joined by recent experience where that has proved to know better."""
        predictor = self._selector.predictor
        if seen is None or predictor is None or not self._recent.heard or predictor.labels != self._recent.labels:
            return seen
        return self._selector.joined(seen, self._recent.join(seen[2], self._selector.encode(event)))

    def _contested(self, event: Event) -> bool:
        """Whether memory holds otherwise than the model of events like it, so that it is asked however sure the model is."""
        predictor = self._selector.predictor
        return self._exemplars.disputes(predictor) and self._exemplars.contested(self._selector.encode(event), predictor)

    def _nearest(self, event: Event, seen: Seen | None) -> tuple[int, ...]:
        """The experiences that a decision rests on: of the event's cell, where the model has cells, else the likest of all."""
        if seen is not None and seen[4] >= 0:
            return self._cells.newest(seen[4], self.settings.nearest)
        return self._episodes.nearest(self._selector.encode(event), self.settings.nearest)

    def _evidence(self, evidence: Evidence) -> None:
        evidence = msgspec.structs.replace(evidence, received_ns=self._now_ns)
        if evidence.topic == CLEARED:
            self._scheduler.deliver(evidence)
            self._scheduler.moot(evidence.key)
        else:
            self._scheduler.deliver(evidence)

    def concluded(self, process: int) -> None:
        """A process has its result: it may be judged at once, by an outcome that was there before it."""
        judged = self._validation.concluded(process)
        if judged:
            self._judge(judged)

    def _validate(self, outcome: Outcome) -> None:
        """Validate: V(r, y) against the recorded result (Eq. 10)."""
        sole = self._validation.sole(outcome, self._now_ns) if self._guarantee is None else None
        if sole is None:
            if self._validation.knows(outcome.id):
                return
            self.write(Witnessed(outcome=outcome))
            self._judge(self._validation.match(outcome, self._now_ns))
            return
        judged, experience = sole
        self._folding.validated(outcome, judged, experience, self._now_ns)
        trusted, *more = self._revision.weigh(experience) or (None,)
        if trusted is not None:
            self._revision.apply(trusted, self._now_ns)
        burst = Validated(outcome=outcome, judged=judged, experience=experience, trusted=trusted)
        self._out.pack(burst, self._now_ns)
        for each in more:
            self.write(each)
        self._reconsider(experience)
        self._learn()

    def _break_off(self, end: End) -> None:
        self.write(self._sources.end(end.source))
        self._judge(self._validation.break_off(self._now_ns, end.source))

    def _judge(self, verdicts: Iterable[Judged]) -> None:
        for judged in verdicts:
            self.write(judged)
            experience = self._validation.experience(judged)
            if experience is not None:
                self.write(Gained(experience=experience))
                self._revise(experience)
                self._learn()
            if self._guarantee is not None:
                for change in self._guarantee.changes():
                    self.write(change)

    def _revise(self, experience: Experience) -> None:
        """Revise: trust moves; what rested on refuted knowledge and is still open to correction is thought about again."""
        for trusted in self._revision.weigh(experience):
            self.write(trusted)
        self._reconsider(experience)

    def _reconsider(self, experience: Experience) -> None:
        for drifted in self._revision.drifted(experience.treatment):
            self.write(drifted)
        for stale in self._revision.reopen(experience, limit=self.settings.reopen_limit):
            event = self._folding.events.get(stale.event)
            if event is None:
                continue
            process = self._scheduler.processes.next_id
            self.write(Reopened(process=process, reopens=stale.process, event=stale.event, because=stale.because))
            self._start(event, reopens=stale.process, why=stale.because)

    def _repay(self) -> None:
        """The riskiest event whose deliberation was refused is thought about again."""
        debt = self._debts.due(self._now_ns)
        if debt is None:
            return
        event = self._folding.events.get(debt.event)
        if event is None:
            self._debts.forget(debt.event)
            return
        because = f"it was treated provisionally in process {debt.process}: the reasoner had not answered"
        self.write(Reopened(process=self._scheduler.processes.next_id, reopens=debt.process, event=debt.event, because=because))
        self._start(event, reopens=debt.process, why=because, mode="delib")

    def closed_to(self, act: Act) -> str:
        """Why a completed process cannot be reopened; empty where it can."""
        return "" if act.event in self._folding.events else f"event {act.event or 'of that process'} is no longer in memory"

    def reopen(self, act: Act) -> None:
        """Think about a completed process's event again, because a person wants it: in a new process linked to the old."""
        because = f"{act.who}: {act.why}"
        self.write(Reopened(process=self._scheduler.processes.next_id, reopens=act.process, event=act.event, because=because))
        self._start(self._folding.events[act.event], reopens=act.process, why=because)

    def _learn(self) -> None:
        """Learn: ask for a training where enough was gained (Eq. 8); it runs off the kernel's thread."""
        asked = self._learning.due(self._now_ns)
        if asked is not None:
            self.write(asked)
            self._out.train(self._training(asked))

    def _training(self, asked: TrainingAsked) -> Training:
        job = self._learning.job(asked, self._versions.base(asked.base))
        return Training(training=asked.training, publish_ns=asked.publish_ns, job=job)

    def _reuse(self, trained: Trained) -> None:
        """Reuse: a new version selects from here on, if it is not worse on held-back experience."""
        pending = self._learning.pending
        if pending is None or pending.training != trained.training:
            return
        if trained.card.accepted:
            self._out.blob(trained.card.blob, trained.weights)
            self._versions.accept(trained.card, trained.weights)
            self._use(trained.card, trained.weights)
            reach("publication: decided")
        for trusted in self._revision.relearned(trained.card):
            self.write(trusted)
        self.write(Published(training=trained.training, card=trained.card))
        self._learn()

    def _roll_back(self, act: Act) -> None:
        """Decide with an earlier accepted version from here on; what is learned next goes on from it."""
        if act.id and self._scheduler.processes.acted(act.id):
            return
        found = self._versions.find(act.version)
        refused = "" if found else f"model version {act.version} is not at hand (at hand: {self._versions.listed()})"
        self.write(Acted(who=act.who, act=act.act, process=0, why=act.why, id=act.id, refused=refused, version=act.version))
        if found is not None:
            self._use(*found)

    def _use(self, card: ModelCard, weights: bytes) -> None:
        """Select with that version; one that was fitted to other fields of the domain is named and left, guidelines go on."""
        try:
            self._versions.use(card, weights)
        except ValueError as error:
            self.note("model not usable", f"{error}; decided by guidelines until the next version")
            return
        self._foreseen.clear()  # it was another version that saw them

    # --- time ---

    def stir(self, at_ns: int) -> None:
        """Something falls due at that instant."""
        if at_ns < self._calm_ns:
            self._calm_ns = at_ns

    def resolved(self, burst: Ran, forecast: Forecast | None) -> None:
        """Record that a process ran to its end, and what came of it; ``forecast`` is the result's own."""
        self.pack(burst, forecast)
        if burst.closes_ns is not None:
            self.stir(burst.closes_ns)
        self.concluded(burst.process)

    def _until(self, now_ns: int) -> None:
        """Do what falls due up to ``now_ns``, in the order of its instants."""
        if self._calm_ns > now_ns:
            return
        self._do_until(now_ns)
        wake_ns = self._wake_ns()
        self._calm_ns = LARGEST_NS if wake_ns is None else wake_ns

    def _do_until(self, now_ns: int) -> None:
        while True:
            put_off = self._left == 0  # steps are; limits pass when they are due
            due_ns = self._scheduler.passes_ns() if put_off else self._scheduler.next_due_ns()
            closes_ns = self._closes_next_ns()
            repays_ns = self._debts.next_due_ns()
            if repays_ns is not None and repays_ns <= min(each for each in (now_ns, due_ns, closes_ns) if each is not None):
                self._now_ns = max(self._now_ns, repays_ns)
                self._repay()
            elif closes_ns is not None and (due_ns is None or closes_ns < due_ns):
                if closes_ns > now_ns:
                    break
                self._now_ns = max(self._now_ns, closes_ns)
                self._judge(self._validation.close(self._now_ns))
            elif due_ns is not None and due_ns <= now_ns:
                if self._left and self._scheduler.step_next:
                    self._left -= 1
                self.steps_done += 1
                self._now_ns = max(self._now_ns, due_ns)
                self._scheduler.run_due(put_off)
            else:
                break
            if self._stops and self._out.asks:
                break

    def _wake_ns(self) -> int | None:
        """When something falls due next; None: nothing does by itself."""
        instants = (self._scheduler.next_due_ns(), self._closes_next_ns(), self._debts.next_due_ns())
        return min((each for each in instants if each is not None), default=None)

    def _closes_next_ns(self) -> int | None:
        """When a window closes by the clock; where a source's silence means a gap, windows close when it is heard again."""
        return self._validation.next_close_ns() if self._gap_ns is None else None

    # --- records ---

    def write(self, record: AnyRecord) -> None:
        """Record, then apply: the only way in which the kernel's state changes."""
        self._out.line(record, self._now_ns)
        self._calm_ns = 0  # what a record of any kind lets fall due is looked for
        self._folding.apply(record, self._now_ns)

    def pack(self, burst: AnyBurst, forecast: Forecast | None = None) -> None:
        """The same for what an automatic event writes in one go: one entry for several records."""
        self._out.pack(burst, self._now_ns)
        self._folding.apply_burst(burst, self._now_ns, forecast)

    def event(self, identity: str) -> Event:
        """An admitted event that is still in memory. Raises KeyError where it is not."""
        return self._folding.events[identity]

    def bring_back(self, process: int) -> None:
        """Have a parked process at hand again."""
        self._parking.bring_back(process)

    def close(self) -> None:
        """Let go of where long waiters are parked. It is fed nothing more."""
        self._parking.close()

    def call(self, call: Call) -> None:
        """Have the driver make a call outside, once the lines are durable."""
        self._out.call(call)

    def recall(self, query: Query) -> tuple[Episode, ...]:
        """Search episodic memory for a process."""
        return self._episodes.search(query, self._now_ns)

    def counselled(self, decision: Decision, reply: Reply) -> dict[str, float]:
        """The forecast to go on with after deliberation: the model's and the reasoner's, by how well each has forecast."""
        return self._counsel.pool(decision.prior, decision.model > 0, reply, self.domain.spec.outcome.labels)

    def closes_ns(self, arrived_ns: int) -> int:
        """When the window closes in which the world may show the outcome of an event that arrived then."""
        return arrived_ns + self._within_ns

    def _requests(self, left: int = 0) -> Requests:
        return self._out.take(self._wake_ns(), left)

    def changed(self) -> dict[str, bytes | None]:
        """The keyed state that changed since the last call: the driver commits it with the lines of all feeds up to now."""
        state = {**self._scheduler.shelf.changed(), **self._sources.changed()}
        state[_STATE_KEY] = msgspec.json.encode(_KernelState(now_ns=self._now_ns, sources=self._sources.states))
        return state

    # --- recovery ---

    def recover(self, entries: Iterable[Entry], state: Mapping[str, bytes], blobs: Mapping[str, bytes]) -> Requests:
        """Take up what a journal holds, into a kernel that has been fed nothing yet.

        Args:
            entries: all of the journal's, in order.
            state: its keyed state.
            blobs: weights by name (a mapping that reads lazily will do).

        Returns:
            Requests: the calls and trainings that were under way, to be made again; and lines where something had to be
            mended (a call in doubt, code that no longer matches its record).
        """
        reach("recovery: begun")
        folded = self._folding.fold(entries)
        self._out.position, self._now_ns = folded.position, folded.now_ns
        if _STATE_KEY in state:
            found = msgspec.json.decode(state[_STATE_KEY], type=_KernelState)
            self._now_ns = max(self._now_ns, found.now_ns)
            self._sources.restore(found.sources, state)
        self._scheduler.shelf.restore(state)
        self._versions.restore(folded.accepted.values(), blobs)
        if folded.card is not None:
            self._use(folded.card, blobs[folded.card.blob])
        reach("recovery: folded")
        self._scheduler.recover()
        reach("recovery: rebuilt")
        if folded.asked is not None:
            self._out.train(self._training(folded.asked))
        self._learn()  # there may be experience that was imported at rest
        return self._requests()

    def note(self, what: str, detail: str, process: int = 0, event: str = "") -> None:
        """Record something that a person should know."""
        self.write(Noted(what=what, detail=detail, process=process, event=event))
