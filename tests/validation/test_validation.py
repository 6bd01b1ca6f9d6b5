"""The verdicts of validation: which outcome judges which recorded forecast, and what an experience says."""

from __future__ import annotations

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.validation.bench import LABELS, WITHIN_S, Bench, kernel_ns, ns, outcome, spec
from wakeful.facts.experience import Verdict
from wakeful.facts.lines import Judged
from wakeful.facts.time import NS_PER_S
from wakeful.validation import Validation


def verdicts(found: list[Judged]) -> list[tuple[int, str, Verdict]]:
    return [(judged.process, judged.label, judged.verdict) for judged in found]


def test_an_outcome_is_compared_with_the_recorded_forecast() -> None:
    bench = Bench()
    right = bench.forecast(0.0, "intervention")
    wrong = bench.forecast(1.0, "none")
    found = bench.witness(outcome("o", 20.0))
    assert verdicts(found) == [
        (right, "intervention", Verdict.SUPPORTED),
        (wrong, "intervention", Verdict.CONTRADICTED),
    ]
    assert [judged.lead_ns for judged in found] == [20 * NS_PER_S, 19 * NS_PER_S]


def test_an_outcome_at_the_instant_of_the_event_is_not_later_than_it() -> None:
    bench = Bench()
    bench.forecast(5.0, "intervention")
    assert bench.witness(outcome("o", 5.0)) == []


def test_the_last_instant_of_the_window_belongs_to_it_and_the_next_does_not() -> None:
    bench = Bench()
    bench.forecast(0.0, "intervention")
    assert bench.witness(outcome("after", WITHIN_S + 1e-6)) == []
    assert len(bench.witness(outcome("last", WITHIN_S))) == 1


def test_an_outcome_of_another_entity_or_topic_judges_nothing() -> None:
    bench = Bench()
    bench.forecast(0.0, "intervention", entity="door")
    assert bench.witness(outcome("lift", 1.0, entity="lift")) == []
    other = outcome("topic", 1.0)
    assert bench.witness(type(other)(id="t", topic="gossip", entity="door", label="failure", at_ns=ns(2.0))) == []


def test_an_outcome_of_the_whole_robot_judges_every_open_forecast() -> None:
    bench = Bench()
    processes = [bench.forecast(float(i), "none", entity=entity) for i, entity in enumerate(("door", "lift", "arm"))]
    found = bench.witness(outcome("o", 10.0, entity="*"))
    assert [judged.process for judged in found] == processes


def test_in_robot_scope_any_outcome_of_the_robot_counts() -> None:
    bench = Bench(scope="robot")
    process = bench.forecast(0.0, "intervention", entity="door")
    assert verdicts(bench.witness(outcome("o", 10.0, entity="lift"))) == [(process, "intervention", Verdict.SUPPORTED)]


def test_a_forecast_about_another_entity_is_judged_by_that_one() -> None:
    bench = Bench()
    process = bench.admit(0.0, "door")
    bench.conclude(process, 0.0, 0.0, "failure", entity="lift")
    assert bench.witness(outcome("door", 1.0, "failure", entity="door")) == []
    assert len(bench.witness(outcome("lift", 2.0, "failure", entity="lift"))) == 1


def test_an_outcome_that_names_its_event_judges_that_event_alone() -> None:
    bench = Bench()
    first, second = bench.forecast(0.0), bench.forecast(1.0)
    found = bench.witness(outcome("o", 500.0, event=f"e{second}", entity="elsewhere"))
    assert [judged.process for judged in found] == [second]
    assert first not in [judged.process for judged in found]


def test_an_unbroken_window_without_an_outcome_yields_the_first_label() -> None:
    bench = Bench()
    right, wrong = bench.forecast(0.0, "none"), bench.forecast(1.0, "failure")
    assert bench.validation.next_close_ns() == kernel_ns(WITHIN_S) + 1
    assert bench.close(WITHIN_S) == []
    assert verdicts(bench.close(WITHIN_S + 2)) == [
        (right, "none", Verdict.SUPPORTED),
        (wrong, "none", Verdict.CONTRADICTED),
    ]
    assert bench.validation.next_close_ns() is None


def test_a_recording_that_breaks_off_leaves_open_forecasts_undecided() -> None:
    bench = Bench()
    closed, open_ = bench.forecast(0.0), bench.forecast(50.0)
    assert verdicts(bench.break_off(70.0)) == [(closed, "none", Verdict.SUPPORTED), (open_, "", Verdict.UNDECIDED)]


def test_breaking_off_one_source_leaves_the_others_open() -> None:
    bench = Bench()
    here, there = bench.forecast(0.0, source="here"), bench.forecast(0.0, source="there")
    assert [judged.process for judged in bench.break_off(10.0, "here")] == [here]
    assert bench.validation.counts().open == 1
    assert [judged.process for judged in bench.close(100.0)] == [there]


def test_a_result_concluded_after_the_recording_ended_is_undecided_when_its_window_closes() -> None:
    bench = Bench()
    process = bench.admit(10.0)
    bench.finish(20.0)
    bench.conclude(process, 10.0, 30.0)
    (judged,) = bench.close(100.0)
    assert judged.verdict is Verdict.UNDECIDED
    assert "ended" in judged.why


def test_an_outcome_before_the_conclusion_is_kept_and_decides_with_a_negative_lead() -> None:
    bench = Bench()
    process = bench.admit(0.0)
    assert bench.witness(outcome("o", 5.0)) == []
    (judged,) = bench.conclude(process, 0.0, 12.0, "intervention")
    assert (judged.verdict, judged.lead_ns) == (Verdict.SUPPORTED, -7 * NS_PER_S)
    assert "before the result" in judged.why


def test_an_outcome_that_comes_after_the_close_supersedes_none() -> None:
    bench = Bench()
    process = bench.forecast(0.0, "intervention")
    (none,) = bench.close(61.0)
    assert none.verdict is Verdict.CONTRADICTED
    (late,) = bench.witness(outcome("o", 30.0), at_s=90.0)
    assert (late.process, late.verdict) == (process, Verdict.SUPPORTED)
    assert "late" in late.why
    counts = bench.validation.counts()
    assert (counts.supported, counts.contradicted) == (1, 0)


def test_of_contradictory_outcomes_the_first_in_source_time_decides() -> None:
    bench = Bench()
    bench.forecast(0.0, "intervention")
    (first,) = bench.witness(outcome("a", 10.0, "intervention"))
    (second,) = bench.witness(outcome("b", 20.0, "failure"))
    assert (first.verdict, second.verdict) == (Verdict.SUPPORTED, Verdict.UNDECIDED)
    assert "first in source time" in second.why
    assert bench.validation.counts().supported == 1


def test_an_earlier_outcome_that_comes_late_overrides_the_later_one() -> None:
    bench = Bench()
    bench.forecast(0.0, "intervention")
    bench.witness(outcome("b", 20.0, "failure"))
    (late,) = bench.witness(outcome("a", 10.0, "intervention"), at_s=25.0)
    assert late.verdict is Verdict.SUPPORTED
    assert bench.validation.counts().contradicted == 0


def test_a_repeated_outcome_changes_nothing() -> None:
    bench = Bench()
    bench.forecast(0.0, "none")
    assert len(bench.witness(outcome("o", 10.0))) == 1
    assert bench.validation.knows("o")
    assert bench.witness(outcome("o", 10.0)) == []
    assert bench.witness(outcome("o", 10.0, "failure")) == []
    assert bench.validation.counts().witnessed == 1


def test_what_had_been_acted_on_may_have_been_prevented() -> None:
    bench = Bench()
    bench.forecast(0.0, "failure")
    (judged,) = bench.witness(outcome("o", 10.0, "none", acted_on=True))
    assert judged.verdict is Verdict.UNDECIDED
    assert "prevented" in judged.why
    assert bench.gain(judged) is None


@pytest.mark.parametrize(("forecast", "came"), [("none", "intervention"), ("failure", "intervention")])
def test_what_was_not_forecast_and_came_contradicts_though_the_result_had_been_acted_on(forecast: str, came: str) -> None:
    bench = Bench()
    process = bench.admit(0.0)
    bench.conclude(process, 0.0, 1.0, forecast)
    (judged,) = bench.witness(outcome("o", 10.0, came, acted_on=True))
    assert judged.verdict is Verdict.CONTRADICTED


def test_a_label_that_the_domain_does_not_know_is_compared_with_nothing() -> None:
    bench = Bench()
    bench.forecast(0.0)
    assert bench.witness(outcome("o", 10.0, "apocalypse")) == []
    assert bench.validation.counts().foreign == 1


def test_experiences_count_up_and_say_what_was_right() -> None:
    bench = Bench()
    bench.forecast(0.0, "intervention")
    bench.forecast(1.0, "none")
    gained = [bench.gain(judged) for judged in bench.witness(outcome("o", 10.0))]
    assert [(e.id, e.treatment_label, e.verdict) for e in gained if e] == [
        (1, "memory", Verdict.SUPPORTED),
        (2, "", Verdict.CONTRADICTED),
    ]


def test_a_person_who_names_the_right_treatment_gives_it_to_the_experience() -> None:
    bench = Bench()
    process = bench.forecast(0.0, "none")
    (judged,) = bench.witness(outcome("o", 10.0, "failure", treatment="diagnosis", event=f"e{process}", origin="person"))
    experience = bench.gain(judged)
    assert experience is not None
    assert (experience.treatment, experience.treatment_label, experience.outcome) == ("memory", "diagnosis", "failure")


def test_a_reopened_event_is_judged_for_each_of_its_processes() -> None:
    bench = Bench()
    process = bench.forecast(0.0, "none")
    second = 99
    from_event = bench.records[0][0]
    bench.record(from_event, 1.0)
    record = next(record for record, _ in bench.records if record.__class__.__name__ == "Concluded")
    bench.record(type(record)(**{f: getattr(record, f) for f in record.__struct_fields__} | {"process": second}), 2.0)
    assert [judged.process for judged in bench.witness(outcome("o", 10.0))] == [process, second]


def test_forgotten_outcomes_make_a_silent_window_undecided() -> None:
    bench = Bench(keep_outcomes=2)
    process = bench.admit(0.0, "door")
    for i in range(5):
        bench.witness(outcome(f"lift{i}", 1.0 + i, entity="lift"))
    bench.conclude(process, 0.0, 30.0)
    (judged,) = bench.close(100.0)
    assert (judged.verdict, judged.label) == (Verdict.UNDECIDED, "")


def test_memory_is_bounded_and_open_forecasts_are_never_forgotten() -> None:
    bench = Bench(keep_forecasts=3, keep_outcomes=3)
    kept_open = bench.forecast(0.0, "intervention", entity="lift")
    for i in range(50):
        bench.forecast(float(i), "none", entity="door")
    bench.witness(outcome("doors", 55.0, "failure"))
    assert bench.validation.counts().contradicted == 50
    (judged,) = bench.witness(outcome("lift", 58.0, entity="lift"))
    assert (judged.process, judged.verdict) == (kept_open, Verdict.SUPPORTED)


STEPS = st.lists(
    st.tuples(
        st.sampled_from(["event", "outcome", "close"]),
        st.integers(0, 200),
        st.sampled_from(["door", "lift"]),
        st.sampled_from(LABELS),
        st.integers(0, 90),
    ),
    max_size=40,
)


def play(
    steps: list[tuple[str, int, str, str, int]],
) -> tuple[Bench, dict[int, tuple[int, str, str]], list[tuple[int, str, str]]]:
    """Steps in order of arrival; an outcome may be about as much as 90 s ago, a conclusion as much as 90 s late."""
    bench = Bench()
    events: dict[int, tuple[int, str, str]] = {}
    outcomes: list[tuple[int, str, str]] = []
    waiting: list[tuple[int, int]] = []
    for i, (what, at, entity, label, delay) in enumerate(sorted(steps, key=lambda step: step[1])):
        for process, due in [item for item in waiting if item[1] <= at]:
            waiting.remove((process, due))
            bench.conclude(process, events[process][0], at, events[process][2])
        if what == "event":
            process = bench.admit(at, entity)
            events[process] = (at, entity, label)
            waiting.append((process, at + delay))
        elif what == "outcome" and at > delay:
            outcomes.append((at - delay, entity, label))
            bench.witness(outcome(f"o{i}", at - delay, label, entity), at_s=at)
        bench.close(at)
    for process, _ in waiting:
        bench.conclude(process, events[process][0], 300, events[process][2])
    bench.close(400)
    return bench, events, outcomes


@settings(max_examples=150, deadline=None)
@example(steps=[("event", 0, "lift", "none", 0), ("outcome", 61, "lift", "none", 2), ("outcome", 61, "lift", "intervention", 1)])
@given(STEPS)
def test_whatever_the_order_of_arrival_the_first_outcome_in_source_time_decides(
    steps: list[tuple[str, int, str, str, int]],
) -> None:
    bench, events, outcomes = play(steps)
    standing = {
        record.process: record
        for record, _ in bench.records
        if isinstance(record, Judged) and record.verdict is not Verdict.UNDECIDED
    }
    for process, (at, entity, label) in events.items():
        inside = [(o, shown) for o, whom, shown in outcomes if whom == entity and at < o <= at + WITHIN_S]
        first = min((o for o, _ in inside), default=None)
        possible = {shown for o, shown in inside if o == first} or {"none"}
        assert standing[process].label in possible
        assert (standing[process].verdict is Verdict.SUPPORTED) == (standing[process].label == label)
    assert bench.validation.counts().open == 0
    assert bench.validation.counts().share_validated == (1.0 if events else 0.0)


@settings(max_examples=60, deadline=None)
@given(STEPS, st.integers(0, 200))
def test_recovery_from_the_records_continues_as_if_nothing_had_happened(
    steps: list[tuple[str, int, str, str, int]], cut: int
) -> None:
    bench, _, _ = play(steps)
    recovered = Validation(spec())
    for record, at_ns in bench.records:
        recovered.apply(record, at_ns)
    assert recovered.counts() == bench.validation.counts()
    question = outcome("new", cut, "failure")
    assert recovered.match(question, kernel_ns(400)) == bench.validation.match(question, kernel_ns(400))


@pytest.mark.parametrize("scope", ["entity", "robot"])
def test_asking_twice_changes_nothing(scope: str) -> None:
    bench = Bench(scope=scope)
    bench.forecast(0.0)
    question = outcome("o", 5.0)
    assert bench.validation.match(question, kernel_ns(5)) == bench.validation.match(question, kernel_ns(5))
    assert bench.validation.close(kernel_ns(99)) == bench.validation.close(kernel_ns(99))
    assert bench.validation.break_off(kernel_ns(9)) == bench.validation.break_off(kernel_ns(9))
