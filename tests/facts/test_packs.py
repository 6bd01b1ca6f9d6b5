"""A pack reads back as the lines that it stands for."""

from __future__ import annotations

from wakeful.facts.decisions import Candidate, Decision, Gate
from wakeful.facts.events import Event
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience, Verdict
from wakeful.facts.lines import Judged
from wakeful.facts.packs import LINES_PER_BURST, Covered, Pack, Ran, Validated
from wakeful.facts.processes import State, after
from wakeful.facts.time import Stamp
from wakeful.facts.values import NOTHING

GATE = Gate(confidence=0.9, threshold=0.5, novelty=0.1, novelty_limit=0.9, trust=1.0, trust_limit=0.5)
DECISION = Decision(
    treatment="memory",
    mode="auto",
    confidence=0.9,
    candidates=(Candidate(treatment="memory", probability=0.9),),
    reasons=("known",),
    gate=GATE,
)
EVENT = Event(id="e1", kind="seen", entity="cup", source="s", position=0, stamp=Stamp(source_ns=1, clock="c", received_ns=2))
BURSTS = (
    Covered(event=EVENT, process=1, decision=DECISION),
    Ran(process=1, event="e1", before=State.CREATED, steps_before=0, steps=3, treatment="memory", mode="auto", result=NOTHING),
    Validated(
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
    ),
)


def test_the_lines_of_packs_follow_one_another_without_a_gap() -> None:
    position, places = 1, []
    for burst in BURSTS:
        pack = Pack(position, 5, burst)
        assert len(pack.lines()) == LINES_PER_BURST
        places += [line.position for line in pack.lines()]
        position = pack.last + 1
    assert places == list(range(1, 10))


def test_a_run_moves_its_process_only_as_the_table_allows() -> None:
    first, _, second = BURSTS[1].records()
    for moved in (first, second):
        assert after(moved.before, moved.trigger) is moved.after  # type: ignore[union-attr]  # both are Moved


def test_what_is_covered_is_admitted_and_has_its_process_and_decision_at_the_same_instant() -> None:
    lines = Pack(1, 5, BURSTS[0]).lines()
    assert [type(line.record).__name__ for line in lines] == ["Admitted", "Created", "Decided"]
    assert {line.at_ns for line in lines} == {5}
