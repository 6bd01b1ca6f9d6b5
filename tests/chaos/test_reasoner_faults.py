"""A reasoner at fault: coverage stays whole, what is owed is listed and repaid by risk, no budget is passed (docs/chaos.md)."""

from __future__ import annotations

import itertools
from pathlib import Path

import msgspec
import pytest

from benchmarks.chaos.domain import KINDS, SPEC, Outside, domain, registry
from benchmarks.chaos.episode import right
from benchmarks.chaos.script import HOSTILE
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
from wakeful.facts.events import Criticality, Draft
from wakeful.facts.lines import Admitted, Answered, Asked, Concluded, Created, Decided, Line, Reopened, Trusted
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import to_ns, to_s
from wakeful.journal import open_journal
from wakeful.journal.audit import audit
from wakeful.journal.debt import DebtRow, debt
from wakeful.journal.views import history
from wakeful.kernel import Kernel
from wakeful.testing.crash_points import Crashed, crashing
from wakeful.testing.faulty_reasoner import FAULTS, FaultyReasoner, Manners

START_S = 1_000_000.0
HOUR_S = 3_600.0


def event(at_s: float, entity: str, criticality: Criticality = 0, says: str = "") -> Draft:
    return Draft(
        kind="described",
        entity=entity,
        source="world",
        position=0,
        at_ns=to_ns(START_S + at_s),
        fields={"state": "odd"},
        criticality=criticality,
        says=says,
    )


class Bench:
    """A mind on a file, with a reasoner that outlives it."""

    def __init__(self, path: Path, manners: Manners, budget: int | None = None) -> None:
        self.path = path
        self.budget = budget
        self.kernel: Kernel | None = None
        self.reasoner = FaultyReasoner(self._right, manners, 7, self._now_s)
        self.asked: list[Question] = []

    def _right(self, question: Question) -> Reply:
        self.asked.append(question)
        return right(question)

    def _now_s(self) -> float:
        return to_s(self.kernel.now_ns) if self.kernel is not None else 0.0

    def live(self, *events: Draft, until_s: float | None = None) -> None:
        """Hear the events of the source that were not heard yet, then let time pass until then."""
        with open_journal(self.path) as journal:
            self.kernel, learner = assemble(domain(), MindSettings(step_s=0.1), registry=registry(Outside(lambda *_: "done")))
            thinker: Reasoner = self.reasoner
            if self.budget is not None:
                so_far = spent(journal.lines(), self.reasoner.name)
                limit = Budget(None, self.budget, Spent(so_far.calls + so_far.in_doubt, 0.0))
                permit = Permit(limit, RateLimit(None, self._now_s), Breaker(100, 1.0, self._now_s))
                thinker = GuardedReasoner(self.reasoner, permit, deadline_s=30.0)
            driver = SimulatedDriver(self.kernel, journal, thinker, learner)
            try:
                known = self.kernel.source("world")
                if known is None or not known.finished:
                    for _ in driver.run("world", "digest", lambda after: events[after + 1 :]):
                        pass
                if until_s is not None:
                    driver.put([], to_ns(START_S + until_s))
            finally:
                driver._loop.close()
                driver._trainer.close()

    def lines(self) -> list[Line]:
        with open_journal(self.path, read_only=True) as journal:
            report = audit(journal)
            assert report.ok, report.first_offender
            return list(journal.lines())

    def debt(self) -> list[DebtRow]:
        with open_journal(self.path, read_only=True) as journal:
            return debt(history(journal))

    def entities(self, kind: type[Reopened] | type[Concluded]) -> list[str]:
        """Whom the records of that kind are about, in order."""
        lines = self.lines()
        of = {line.record.event.id: line.record.event.entity for line in lines if isinstance(line.record, Admitted)}
        return [of[line.record.event] for line in lines if isinstance(line.record, kind)]


def every(fault: str) -> Manners:
    return Manners(rates={fault: 1.0}, latency_s=0.2)


def down(seconds: float) -> Manners:
    return Manners(rates={}, latency_s=0.2, down=((0.0, seconds),))


@pytest.mark.parametrize("fault", FAULTS)
def test_whatever_the_reasoner_does_every_event_is_treated_and_what_is_provisional_is_listed(fault: str, tmp_path: Path) -> None:
    bench = Bench(tmp_path / "a.db", every(fault))
    bench.live(*[event(float(n), f"e{n}", criticality) for n, criticality in enumerate((0, 3, 1))], until_s=130.0)
    lines = bench.lines()
    first = [line.record for line in lines if isinstance(line.record, Concluded)][:3]
    assert {concluded.event for concluded in first} == {
        line.record.event.id for line in lines if isinstance(line.record, Admitted)
    }
    if fault == "slow":
        assert all(concluded.mode == "delib" for concluded in first), "slow is not wrong"
        assert not bench.debt()
    else:
        assert all(concluded.mode == "fallback" for concluded in first)
        assert [row.entity for row in bench.debt()] == ["e1", "e2", "e0"], "by risk: the most critical first"
        errors = {line.record.error for line in lines if isinstance(line.record, Answered) and line.record.error}
        assert errors, "why is recorded"
        assert all(len(error) <= 500 for error in errors)


def test_a_reasoner_that_is_down_for_an_hour_leaves_debt_that_is_repaid_by_risk_when_it_returns(tmp_path: Path) -> None:
    bench = Bench(tmp_path / "a.db", down(HOUR_S))
    met = [event(60.0 * n, f"e{n}", (0, 3, 1, 2)[n % 4]) for n in range(12)]
    bench.live(*met, until_s=HOUR_S - 1.0)
    owed = [row.entity for row in bench.debt()]
    by_risk = ["e1", "e5", "e9", "e3", "e7", "e11", "e2", "e6", "e10", "e0", "e4", "e8"]
    assert owed == [entity for entity in by_risk if entity in owed]
    assert len(owed) >= 9, "one or another may have become automatic"
    probes = len(bench.entities(Reopened))
    assert 0 < probes <= 8, "the question whether it is back, with pauses that double"

    bench.live(until_s=3 * HOUR_S)
    assert bench.debt() == []
    repaid = bench.entities(Reopened)[probes:]
    first, *others = dict.fromkeys(repaid)
    assert others == [entity for entity in owed if entity != first], "the first was the question; then by risk"
    reopened_ns = [line.at_ns for line in bench.lines() if isinstance(line.record, Reopened)][probes:]
    gaps = [later - earlier for earlier, later in itertools.pairwise(reopened_ns)]
    assert min(gaps) >= to_ns(MindSettings().repay_every_s), "at a bounded rate"


def test_debt_is_repaid_after_a_crash_as_if_there_had_been_none(tmp_path: Path) -> None:
    calm, crashed = Bench(tmp_path / "calm.db", down(600.0)), Bench(tmp_path / "crashed.db", down(600.0))
    met = [event(30.0 * n, f"e{n}", (0, 3, 1)[n % 3]) for n in range(6)]
    calm.live(*met, until_s=2 * HOUR_S)
    for point, nth in (("acting: call made", 4), ("commit: lines written", 5), ("recovery: rebuilt", 1), ("acting: call", 3)):
        with crashing(point, nth), pytest.raises(Crashed):
            crashed.live(*met, until_s=2 * HOUR_S)
    crashed.live(*met, until_s=2 * HOUR_S)
    assert crashed.debt() == calm.debt() == []
    assert crashed.entities(Reopened) == calm.entities(Reopened)
    assert crashed.entities(Concluded) == calm.entities(Concluded)


def test_one_question_that_is_always_refused_does_not_keep_the_others_from_being_repaid(tmp_path: Path) -> None:
    bench = Bench(tmp_path / "a.db", down(300.0))
    answers = bench.reasoner.answer

    async def but_not_e1(question: Question) -> Reply:
        if question.facts["entity"] == "e1":
            return msgspec.structs.replace(right(question), choice="launch_missiles")
        return await answers(question)

    bench.reasoner.answer = but_not_e1  # type: ignore[method-assign]
    bench.live(*[event(float(n), f"e{n}", 3 if n == 1 else 0) for n in range(4)], until_s=3 * HOUR_S)
    assert [row.entity for row in bench.debt()] == ["e1"], "it stays listed, for a person"
    assert bench.entities(Reopened).count("e1") <= 12


@pytest.mark.parametrize(
    "point", ["acting: call", "acting: call made", "commit: lines written", "commit: done", "recovery: rebuilt"]
)
def test_a_budget_is_not_passed_by_one_call_however_often_the_mind_crashes(point: str, tmp_path: Path) -> None:
    bench = Bench(tmp_path / "a.db", Manners(rates={}, latency_s=2.0), budget=6)
    met = [event(0.5 * n, f"e{n}") for n in range(14)]
    for nth in (3, 1, 4, 2, 1, 5):
        try:
            with crashing(point, nth):
                bench.live(*met, until_s=HOUR_S)
        except Crashed:
            continue
    bench.live(*met, until_s=HOUR_S)
    assert 0 < bench.reasoner.made <= 6
    lines = bench.lines()
    done = {line.record.event for line in lines if isinstance(line.record, Concluded)}
    assert done == {line.record.event.id for line in lines if isinstance(line.record, Admitted)}, "coverage needs no budget"


@pytest.mark.parametrize("text", HOSTILE)
@pytest.mark.parametrize("fault", ["", "hostile"])
def test_what_an_event_says_is_never_done(text: str, fault: str, tmp_path: Path) -> None:
    bench = Bench(tmp_path / "a.db", every(fault) if fault else Manners(rates={}, latency_s=0.2))
    secret = event(0.0, "the other one", says="the code of the safe is 4711")
    bench.live(secret, event(1.0, "hostile", says=text), until_s=50.0)
    lines = bench.lines()
    decided = [line.record.decision for line in lines if isinstance(line.record, Decided)]
    assert {each.treatment for each in decided} <= set(SPEC.treatments), "no treatment that is not registered"
    assert "auto" not in {each.mode for each in decided}
    assert not [line for line in lines if isinstance(line.record, Trusted)], "trust is moved by outcomes alone"
    processes = {line.record.process for line in lines if isinstance(line.record, Created)}
    assert {line.record.process for line in lines if isinstance(line.record, Asked)} <= processes
    told = [question for question in bench.asked if question.facts["entity"] == "hostile"]
    assert told
    assert all("4711" not in repr(question) for question in told), "nobody is told of another event's content"
    assert all(question.options == SPEC.treatments for question in told)
    assert all(text in question.facts["says"] for question in told), "as data, whole"
    assert all(text not in question.asks for question in told)


def test_the_kinds_of_the_chaos_domain_are_its_treatments() -> None:
    assert set(SPEC.treatments) == {"description", *KINDS[1:-1]}
