"""A pack reads back as the lines that it stands for."""

from __future__ import annotations

import msgspec
import pytest

from wakeful.facts.asking import Kind
from wakeful.facts.choices import Basis, Choice
from wakeful.facts.events import Event
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience, Verdict
from wakeful.facts.lines import Answered, Asked, Concluded, Judged, Moved, Trusted
from wakeful.facts.packs import Covered, Inquired, Pack, Ran, Validated, Woken
from wakeful.facts.processes import State, Trigger, after
from wakeful.facts.time import Stamp

BASIS = Basis(
    treatment="memory",
    model=3,
    watermark=120,
    treatments=("description", "memory"),
    labels=("none", "intervention"),
    threshold=0.5,
    result_threshold=0.55,
    novelty_limit=0.99,
    trust_limit=0.4,
    support=12,
)
CHOICE = Choice(basis=BASIS, shares=(0.1, 0.9), prior=(0.8, 0.2), novelty=0.1, trust=0.8, rests_on=(4, 2))
EVENT = Event(id="e1", kind="seen", entity="cup", source="s", position=0, stamp=Stamp(source_ns=1, clock="c", received_ns=2))
RESULT = msgspec.Raw(b'{"type":"memory","says":"known","confidence":0.9,"forecast":{"label":"none","probability":0.8}}')
ASKED = Asked(process=1, seq=1, kind=Kind.EVIDENCE, key="reading\x1fcup", expires_ns=9)
VALIDATED = Validated(
    outcome=Outcome(id="o", topic="t", entity="cup", label="none", at_ns=3),
    judged=Judged(process=1, event="e1", predicted="none", label="none", verdict=Verdict.SUPPORTED, outcome="o"),
    experience=Experience(
        id=1,
        event="e1",
        process=1,
        treatment="memory",
        treatment_label="memory",
        predicted="none",
        outcome="none",
        verdict=Verdict.SUPPORTED,
        mode="auto",
    ),
)
TRUSTED = Trusted(treatment="memory", before=0.8, after=0.82, why="supported", experience=1)
BURSTS = (
    Covered(event=EVENT, process=1, choice=CHOICE),
    Inquired(before=State.CREATED, steps_before=0, asked=ASKED, steps=1),
    Woken(
        answered=Answered(process=1, seq=1, kind=Kind.EVIDENCE, key="reading\x1fcup"), trigger=Trigger.WAKE, steps=1, by="reading"
    ),
    Ran(
        process=1,
        event="e1",
        before=State.SUSPENDED,
        steps_before=1,
        steps=3,
        treatment="memory",
        mode="auto",
        result=RESULT,
        closes_ns=7,
    ),
    VALIDATED,
    msgspec.structs.replace(VALIDATED, trusted=TRUSTED),
)


@pytest.mark.parametrize("burst", BURSTS, ids=lambda burst: type(burst).__name__)
def test_a_burst_has_as_many_lines_as_it_says_and_survives_json(burst: Covered | Inquired | Woken | Ran | Validated) -> None:
    pack = Pack(1, 5, burst)
    assert len(pack.lines()) == burst.count
    assert msgspec.json.decode(msgspec.json.encode(pack), type=Pack).lines() == pack.lines()


def test_the_lines_of_packs_follow_one_another_without_a_gap() -> None:
    position, places = 1, []
    for burst in BURSTS:
        pack = Pack(position, 5, burst)
        places += [line.position for line in pack.lines()]
        position = pack.last + 1
    assert places == list(range(1, 19))


def test_bursts_move_their_process_only_as_the_table_allows() -> None:
    state = State.CREATED
    for burst in BURSTS:
        for record in burst.records():
            if isinstance(record, Moved):
                assert record.before is state
                assert after(state, record.trigger) is record.after
                state = record.after
    assert state is State.COMPLETED


def test_the_forecast_of_a_run_is_its_results_own_where_the_world_is_to_judge_it() -> None:
    ran = BURSTS[3]
    assert isinstance(ran, Ran)
    concluded = ran.records()[1]
    assert isinstance(concluded, Concluded)
    assert concluded.forecast is not None
    assert (concluded.forecast.label, concluded.closes_ns) == ("none", 7)
    assert msgspec.structs.replace(ran, closes_ns=None).forecast is None


def test_what_is_covered_is_admitted_and_has_its_process_and_decision_at_the_same_instant() -> None:
    lines = Pack(1, 5, BURSTS[0]).lines()
    assert [type(line.record).__name__ for line in lines] == ["Admitted", "Created", "Decided"]
    assert {line.at_ns for line in lines} == {5}
