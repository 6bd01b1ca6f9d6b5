"""The kernel itself: what it counts, what it does not lose, and what it leaves undecided."""

from __future__ import annotations

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wakeful.contracts.detector import DetectorFactory
from wakeful.contracts.domain import Domain
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.domains import load
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.domain import DomainSpec, FieldSpec
from wakeful.facts.events import Condition, Draft, Observation, Phase, Undecodable
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Verdict
from wakeful.facts.lines import Admitted, AnyRecord, Created, Judged, Noted, Published, Refused
from wakeful.facts.time import NS_PER_S
from wakeful.journal import MemoryJournal
from wakeful.journal.audit import audit

START_NS = 1_700_000_000 * NS_PER_S


class WithGap:
    """Anybody's events, from a source whose silence means that nobody was recording."""

    def __init__(self, gap_s: float | None) -> None:
        spec = load("jsonl").spec
        self.spec: DomainSpec = msgspec.structs.replace(spec, outcome=msgspec.structs.replace(spec.outcome, gap_s=gap_s))

    def detectors(self) -> dict[str, DetectorFactory]:
        return {}

    def simulate(self, seed: int) -> None:
        return None


def run(items: list, domain: Domain | None = None) -> MemoryJournal:
    kernel, learner = assemble(domain if domain is not None else "jsonl")
    journal = MemoryJournal()
    driver = SimulatedDriver(kernel, journal, GuidelineReasoner(kernel.domain.spec), learner)
    for _ in driver.run("made", "digest", lambda after: iter(items[after + 1 :])):
        pass
    driver.close()
    return journal


def records(journal: MemoryJournal, kind: type[AnyRecord]) -> list:
    return [line.record for line in journal.lines() if isinstance(line.record, kind)]


def event(position: int, at_s: float, phase: Phase | None = None, **fields: object) -> Draft:
    made = {"kind": "alarm", "entity": "pump", "source": "made", "position": position, "at_ns": START_NS + round(at_s * NS_PER_S)}
    condition = None if phase is None else Condition(key="robot|hall;made;leak;pump", phase=phase)
    return Draft(**{**made, "condition": condition, **fields})  # type: ignore[arg-type]


def beat(position: int, at_s: float) -> Observation:
    return Observation(source="made", position=position, topic="beat", at_ns=START_NS + round(at_s * NS_PER_S), values={})


def test_a_repeat_of_what_was_never_raised_is_admitted_as_its_raise_and_later_ones_join_it() -> None:
    journal = run([event(0, 0, Phase.REPEATED), event(1, 1, Phase.REPEATED), event(2, 2, Phase.REPEATED)])
    (admitted,) = records(journal, Admitted)
    assert admitted.event.condition.phase is Phase.RAISED
    assert len(records(journal, Created)) == 1
    source = msgspec.json.decode(journal.state()["kernel"])["sources"]["made"]
    assert (source["offered"], source["joined"]) == (1, 2)


def test_clearing_what_is_not_open_is_refused_with_its_reason() -> None:
    journal = run([event(0, 0, Phase.RAISED), event(1, 1, Phase.CLEARED), event(2, 2, Phase.CLEARED)])
    assert len(records(journal, Admitted)) == 1
    (refused,) = records(journal, Refused)
    assert "nothing to clear" in refused.reason


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"deadline_s": 1e300}, "deadline_s"),
        ({"deadline_s": -1.0}, "deadline_s"),
        ({"entity": ""}, "entity"),
        ({"kind": ""}, "kind"),
        ({"at_ns": 2**63}, "instant"),
        ({"criticality": 9}, "criticality"),
        ({"fields": {"load": float("inf")}}, "finite"),
        ({"condition": Condition(key="", phase=Phase.RAISED)}, "key"),
    ],
)
def test_a_bad_event_is_refused_and_the_next_one_is_admitted(fields: dict, reason: str) -> None:
    journal = run([event(0, 0, **fields), event(1, 1)])
    (refused,) = records(journal, Refused)
    assert reason in refused.reason
    assert len(records(journal, Admitted)) == 1
    assert audit(journal).ok


def test_a_window_over_an_unbroken_recording_yields_none() -> None:
    journal = run([event(0, 0), *(beat(n, n * 5) for n in range(1, 80))], WithGap(10.0))
    (judged,) = records(journal, Judged)
    assert judged.label == "none"


def test_a_window_over_a_gap_stays_undecided_although_the_recording_goes_on() -> None:
    journal = run([event(0, 0), beat(1, 5), *(beat(n, 200 + n * 5) for n in range(2, 80))], WithGap(10.0))
    (judged,) = records(journal, Judged)
    assert judged.verdict is Verdict.UNDECIDED
    assert "gap" in judged.why


def test_an_input_that_could_not_be_read_leaves_open_windows_undecided() -> None:
    lost = Undecodable(source="made", position=1, reason="not JSON")
    journal = run([event(0, 0), lost, *(event(n, 400 + n) for n in range(2, 5))])
    first = records(journal, Judged)[0]
    assert first.verdict is Verdict.UNDECIDED


_ITEM = st.one_of(
    st.builds(
        lambda at, phase, deadline, criticality: (at, phase, {"deadline_s": deadline, "criticality": criticality}),
        st.integers(-(2**66), 2**66) | st.integers(0, 10**11),
        st.none() | st.sampled_from(Phase),
        st.none() | st.floats(),
        st.integers(-2, 9),
    ),
    st.just("lost"),
    st.builds(lambda at, label: (at, label), st.integers(0, 10**11), st.sampled_from(["none", "failure", "unheard of"])),
)


@settings(max_examples=60, deadline=None)
@given(st.lists(_ITEM, max_size=12))
def test_whatever_comes_is_admitted_or_refused_and_the_audit_is_clean(made: list) -> None:
    items: list = []
    offered = 0
    for position, each in enumerate(made):
        if each == "lost":
            items.append(Undecodable(source="made", position=position, reason="lost"))
            offered += 1
        elif len(each) == 2:
            at, label = each
            items.append(Outcome(id=f"o{position}", topic="outcome", entity="pump", label=label, at_ns=START_NS + at))
        else:
            at, phase, fields = each
            items.append(msgspec.structs.replace(event(position, 0, phase, **fields), at_ns=START_NS + at))
    journal = run(items)
    found = audit(journal)
    assert found.ok, [check for check in found.checks.values() if not check.ok]


def test_what_one_recording_shows_is_never_the_outcome_of_another_whose_clock_overlaps() -> None:
    kernel, learner = assemble("jsonl")
    journal = MemoryJournal()
    driver = SimulatedDriver(kernel, journal, GuidelineReasoner(kernel.domain.spec), learner)
    later = Outcome(id="o", topic="outcome", entity="pump", label="failure", at_ns=START_NS + 9 * NS_PER_S)
    for name, items in (("first", [event(0, 0), event(1, 20)]), ("second", [event(0, 5, kind="other"), later, event(2, 15)])):
        for _ in driver.run(name, name, lambda after, made=items: iter(made[after + 1 :])):
            pass
    driver.close()
    of = {record.event.id: record.event.source for record in records(journal, Admitted)}
    assert {of[judged.event] for judged in records(journal, Judged) if judged.label == "failure"} == {"second"}


def test_a_model_of_other_fields_is_named_and_the_mind_goes_on_by_guidelines() -> None:
    journal = run([event(n, n * 400, kind="leak" if n % 2 else "alarm") for n in range(40)])
    assert any(record.card.accepted for record in records(journal, Published))
    other = WithGap(None)
    spec = msgspec.structs.replace(other.spec, fields={**other.spec.fields, "load": FieldSpec(values=("light", "heavy"))})
    other.spec = spec
    kernel, learner = assemble(other)
    driver = SimulatedDriver(kernel, journal, GuidelineReasoner(spec), learner)
    for _ in driver.run("later", "later", lambda after: iter([event(0, 50_000)][after + 1 :])):
        pass
    driver.close()
    assert [record.what for record in records(journal, Noted)].count("model not usable") == 1
    assert records(journal, Admitted)[-1].event.source == "later"
    assert audit(journal).ok


def test_a_model_that_forecasts_what_is_no_outcome_any_more_is_named_and_the_mind_goes_on_by_guidelines() -> None:
    journal = run([event(n, n * 400, kind="leak" if n % 2 else "alarm") for n in range(40)])
    other = WithGap(None)
    labels = tuple(f"new {label}" for label in other.spec.outcome.labels)
    other.spec = msgspec.structs.replace(other.spec, outcome=msgspec.structs.replace(other.spec.outcome, labels=labels))
    kernel, learner = assemble(other)
    driver = SimulatedDriver(kernel, journal, GuidelineReasoner(other.spec), learner)
    for _ in driver.run("later", "later", lambda after: iter([event(0, 50_000)][after + 1 :])):
        pass
    driver.close()
    named = [record.detail for record in records(journal, Noted) if record.what == "model not usable"]
    assert len(named) == 1
    assert "which is no outcome of domain" in named[0]
    assert records(journal, Admitted)[-1].event.source == "later"


def test_a_clock_that_runs_backwards_keeps_the_events_times_and_kernel_time_stands_still() -> None:
    journal = run([event(0, 1000), event(1, 10), event(2, 1001)])
    assert [record.event.stamp.source_ns - START_NS for record in records(journal, Admitted)] == [
        1000 * NS_PER_S,
        10 * NS_PER_S,
        1001 * NS_PER_S,
    ]
    times = [line.at_ns for line in journal.lines()]
    assert times == sorted(times)
    assert audit(journal).ok


def test_an_event_carries_whose_clock_it_was_and_how_sure_it_is() -> None:
    journal = run([event(0, 0, clock="gps", uncertainty_ns=40), event(1, 1)])
    stamps = [record.event.stamp for record in records(journal, Admitted)]
    assert [(stamp.clock, stamp.uncertainty_ns) for stamp in stamps] == [("gps", 40), ("source", 0)]
