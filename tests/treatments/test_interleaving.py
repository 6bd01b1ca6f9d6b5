"""Eq. 6 with treatments that think: diagnosis waits for a sensor, planning and risk prediction go ahead, diagnosis goes on."""

from __future__ import annotations

import msgspec
import pytest

from tests.scheduling.world import Repertoire, World
from tests.treatments.worlds import DOMAIN, event
from wakeful.facts.asking import Episode, Query, Reply
from wakeful.facts.decisions import Candidate, Decision, Gate, Mode
from wakeful.facts.lines import Admitted, Answered, Asked, Concluded
from wakeful.facts.processes import State
from wakeful.facts.time import to_ns
from wakeful.scheduling import Scheduler, SuspendResume
from wakeful.scheduling.evidence import EvidenceShelf
from wakeful.treatments.registry import Registry


class Depot(World):
    """The scheduler's world with the real treatments and a domain with all its tables."""

    def __init__(self) -> None:
        super().__init__(Repertoire())

    def _begin(self) -> None:
        registry = Registry(installed=())
        self.events = {}
        self.shelf = EvidenceShelf({}, to_ns(30.0))
        self.scheduler = Scheduler(self, SuspendResume(), registry, DOMAIN, registry.names(), self.shelf)

    def recall(self, query: Query) -> tuple[Episode, ...]:
        return ()

    def think_about(self, name: str, kind: str, entity: str, treatment: str, mode: Mode, **fields: float | str) -> int:
        met = event(kind, entity, id=name, at_s=self.now_ns / 1e9, **fields)
        self.write(Admitted(event=met))
        decision = Decision(
            treatment=treatment,
            mode=mode,
            confidence=1.0,
            candidates=(Candidate(treatment=treatment, probability=1.0),),
            reasons=("a test",),
            gate=Gate(confidence=1, threshold=0, novelty=0, novelty_limit=1, trust=1, trust_limit=0),
        )
        return self.scheduler.create(met, decision, deadline_ns=None)


def the_day(crash_at: int | None) -> Depot:
    """The story; killed before its moment ``crash_at`` and recovered, if given."""
    depot = Depot()

    def moment(number: int) -> None:
        if number == crash_at:
            depot.crash()

    sick = depot.think_about("sick", "current_high", "J3", "diagnosis", "delib")
    depot.until(1.0)
    moment(1)
    depot.until(2.0)
    depot.answer(Reply(choice="diagnosis", confidence=0.9))
    moment(2)
    depot.until(8.0)
    assert depot.scheduler.processes[sick].state is State.WAITING
    moment(3)
    depot.think_about("blocked", "route_blocked", "hall", "planning", "auto", start="dock", goal="loft")
    depot.until(9.0)
    moment(4)
    depot.think_about("shaky", "object", "cup", "risk_prediction", "auto", state="unstable")
    depot.until(20.0)
    assert depot.scheduler.processes[sick].state is State.WAITING
    moment(5)
    depot.tell("heat", "arm/temperature_J3", 81.0)
    moment(6)
    depot.until(20.5)
    moment(7)
    depot.until(60.0)
    return depot


def test_diagnosis_waits_for_the_sensor_while_a_route_is_planned_and_a_risk_predicted() -> None:
    ends = the_day(None).ends()
    assert [name for name, _ in ends] == ["blocked", "shaky", "sick"]
    said = dict(ends)
    assert "go dock → yard → shelf → loft" in said["blocked"]
    assert "high risk (falls)" in said["shaky"]
    assert "worn gear" in said["sick"]
    assert "temperature > 70 °C" in said["sick"]


def told(depot: Depot) -> list[object]:
    """What was asked, answered and concluded, without when: a crash may cost time, but changes no thought."""
    kinds = (Asked, Answered, Concluded)
    records = [line.record for line in depot.lines if isinstance(line.record, kinds)]
    return [msgspec.structs.replace(record, expires_ns=None) if isinstance(record, Asked) else record for record in records]


@pytest.mark.parametrize("moment", range(1, 8))
def test_a_crash_at_any_moment_changes_no_thought(moment: int) -> None:
    assert told(the_day(moment)) == told(the_day(None))
