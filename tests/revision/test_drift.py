"""A drift alarm: rare while nothing changes, soon where something does, and it tells a changed world from a noisier one."""

from __future__ import annotations

from random import Random

from hypothesis import given
from hypothesis import strategies as st

from wakeful.facts.experience import Experience, Verdict
from wakeful.revision.drift import Alarm, Drift, DriftSettings


def experience(number: int, predicted: str, outcome: str) -> Experience:
    return Experience(
        id=number,
        event=f"e{number}",
        process=number,
        treatment="diagnosis",
        treatment_label="",
        predicted=predicted,
        outcome=outcome,
        verdict=Verdict.SUPPORTED if predicted == outcome else Verdict.CONTRADICTED,
        mode="auto",
    )


def alarms(
    seed: int, before: int, after: int, noise: float, changed: bool = False, every: float = 500.0
) -> list[tuple[int, Alarm]]:
    """Three kinds of events; one in ten outcomes is wrong at first. Then noise grows, or one kind's outcome is another one."""
    random, drift, found = Random(seed), Drift(DriftSettings(every=every)), []
    for number in range(before + after):
        predicted = random.choice(("none", "slip", "jam"))
        late = number >= before
        wrong = random.random() < (0.97 if late and changed and predicted == "jam" else noise if late else 0.1)
        drift.learn(experience(number, predicted, "slip" if wrong and predicted != "slip" else "none" if wrong else predicted))
        alarm = drift.alarm("diagnosis")
        if alarm is not None:
            found.append((number, alarm))
            drift.reset("diagnosis")
    return found


def test_while_nothing_changes_alarms_are_at_least_as_far_apart_as_the_setting_says() -> None:
    results = 4_000
    found = sum(len(alarms(seed, results, 0, 0.1)) for seed in range(12))
    assert found <= 12 * results / 500


def test_a_treatment_that_errs_more_is_told_of_in_nearly_every_run() -> None:
    told = [[each for each in alarms(seed, 300, 200, 0.5) if each[0] >= 300] for seed in range(20)]
    assert sum(1 for found in told if found) >= 19


def test_a_changed_outcome_is_told_from_a_noisy_one() -> None:
    changed = [found[-1][1].changed for seed in range(20) if (found := alarms(seed, 300, 300, 0.1, changed=True))]
    noisier = [found[-1][1].changed for seed in range(20) if (found := alarms(seed, 300, 300, 0.35))]
    assert len(changed) >= 18
    assert sum(changed) / len(changed) > 0.8
    assert len(noisier) >= 18
    assert sum(noisier) / len(noisier) < 0.3


def test_the_alarm_names_the_forecast_that_fails_and_what_the_world_shows_in_its_place() -> None:
    _, alarm = next(each for each in alarms(3, 300, 400, 0.1, changed=True) if each[1].changed)
    assert "where it forecasts 'jam' the world now shows 'slip'" in alarm.says


def test_asking_for_the_alarm_changes_nothing_and_an_undecided_result_neither() -> None:
    drift = Drift(DriftSettings(every=50.0, baseline=10))
    for number in range(60):
        drift.learn(experience(number, "none", "none" if number < 10 else "jam"))
        assert drift.alarm("diagnosis") == drift.alarm("diagnosis")
    before = drift.alarm("diagnosis")
    undecided = experience(99, "none", "jam")
    drift.learn(
        Experience(**{name: getattr(undecided, name) for name in undecided.__struct_fields__} | {"verdict": Verdict.UNDECIDED})
    )
    assert drift.alarm("diagnosis") == before


@given(st.lists(st.booleans(), max_size=300))
def test_no_stream_of_results_breaks_it(wrong: list[bool]) -> None:
    drift = Drift(DriftSettings(baseline=5))
    for number, each in enumerate(wrong):
        drift.learn(experience(number, "none", "jam" if each else "none"))
        alarm = drift.alarm("diagnosis")
        assert alarm is None or 0 < alarm.wrong <= alarm.of
