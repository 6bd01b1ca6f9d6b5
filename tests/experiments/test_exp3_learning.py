"""Experiment 3: what a validation can reach, the metrics by hand, the stand-in's stated errors, and ours on one world."""

from __future__ import annotations

from functools import cache

import pytest

from wakeful.experiments.exp3_baselines import AlwaysLLM, Said, TwoHeaded
from wakeful.experiments.exp3_learning import METRICS, SEEDS, Measured, figures, measure_all, one, rows, run
from wakeful.experiments.exp3_reasoner import DriftReasoner
from wakeful.experiments.exp3_trust import Course, courses, newest_wins, two_confirmations
from wakeful.experiments.worlds.service_drift import CLEAN, LATE, NOISY, DriftWorld, Met, world

SEED = 1000


class Recorder:
    """Says what is right, and writes down which validations it had been told."""

    def __init__(self, wrong: frozenset[int] = frozenset()) -> None:
        self.wrong, self.told, self.before = wrong, [], {}  # type: ignore[var-annotated]

    def decide(self, place: int, met: Met) -> Said:
        self.before[place] = list(self.told)
        outcome = 1 - met.outcome if place in self.wrong else met.outcome
        return Said(treatment=met.treatment, outcome=outcome, mode="auto")

    def learn(self, place: int, met: Met, said: Said) -> None:
        self.told.append(place)


@cache
def ours() -> Measured:
    return one("wakeful", CLEAN, SEED)


@pytest.mark.parametrize("of", [world(CLEAN, SEED), world(LATE, SEED)], ids=["clean", "late"])
def test_a_validation_is_told_before_the_first_event_that_comes_after_it_and_never_earlier(of: DriftWorld) -> None:
    method = Recorder()
    list(run(method, of))
    for place, told in method.before.items():
        assert told == sorted(told, key=lambda each: (of.stream[each].known_from, each))
        assert set(told) == {each for each, met in enumerate(of.stream) if met.known_from <= place}
    assert sorted(method.told) == list(range(64))


def test_the_figures_of_a_run_by_hand() -> None:
    of = world(CLEAN, SEED)
    changed = [place for place, met in enumerate(of.stream) if met.signature]
    wrong = frozenset({changed[0], changed[1], changed[5], changed[21]})  # A and B at 1, B at 2, B at 6
    found = figures(of, list(run(Recorder(wrong), of)))
    assert found["joint"] == pytest.approx(100 * 60 / 64)
    assert found["treatment"] == 100.0
    assert (found["drift_initial_joint"], found["drift_joint_rep2"], found["drift_joint_rep6"]) == (50.0, 75.0, 75.0)
    assert found["drift_late_joint"] == pytest.approx(100 * 11 / 12)
    assert found["delayed_revision"] == 50.0
    assert (found["automatic"], found["reasoner_calls"]) == (100.0, 0.0)


def test_nothing_wrong_at_first_leaves_nothing_to_revise() -> None:
    of = world(CLEAN, SEED)
    assert figures(of, list(run(Recorder(), of)))["delayed_revision"] is None


def test_the_stand_in_errs_as_stated() -> None:
    treatments, outcomes = [], []
    for seed in range(60):
        of = world(CLEAN, seed)
        reasoner = DriftReasoner(of)
        for place, met in enumerate(of.stream[:28]):
            treatment, outcome = reasoner.answer(place, met)
            treatments.append(treatment == met.treatment)
            outcomes.append(outcome == met.outcome)
    assert sum(treatments) / len(treatments) == pytest.approx(0.70, abs=0.03)
    assert sum(outcomes) / len(outcomes) == pytest.approx(0.80, abs=0.03)


def test_always_llm_is_the_papers_to_the_figure_where_it_is_by_construction() -> None:
    of = world(CLEAN, SEED)
    found = figures(of, list(run(AlwaysLLM(of), of)))
    assert (found["novel_first_joint"], found["drift_initial_joint"], found["drift_late_joint"]) == (50.0, 25.0, 75.0)
    assert found["novel_reuse_joint"] == pytest.approx(83.33, abs=0.01)
    assert found["delayed_revision"] == pytest.approx(66.67, abs=0.01)


def test_offline_asks_about_every_new_type_twice_and_never_changes_its_mind() -> None:
    of = world(CLEAN, SEED)
    said = list(run(TwoHeaded(of, updates=False), of))
    assert all(each.mode == "fallback" for met, each in zip(of.stream, said, strict=True) if met.novel)
    for name in "ABCD":
        own = [each for met, each in zip(of.stream, said, strict=True) if met.signature == name and each.mode == "auto"]
        assert len({(each.treatment, each.outcome) for each in own}) <= 1


def test_ours_reasons_about_new_types_once_and_recovers_at_the_second_repetition() -> None:
    found = ours().figures
    assert found["novel_first_joint"] == 50.0
    assert (found["novel_reuse_joint"], found["novel_reuse_automatic"]) == (100.0, 100.0)
    assert [found[f"drift_joint_rep{number}"] for number in (2, 3, 4, 5, 6)] == [100.0] * 5
    assert found["delayed_revision"] == 100.0
    assert found["reasoner_calls"] is not None
    assert found["reasoner_calls"] <= 8


def test_familiar_events_of_the_stream_are_not_forgotten() -> None:
    kept = ours().kept
    assert kept is not None
    before, after, _, _ = kept
    assert after >= before


def test_one_seed_is_one_result() -> None:
    first, second = (measure_all((SEED,), lambda *_: None, ("offline_multihead",), (CLEAN, NOISY)) for _ in range(2))
    assert first == second
    assert {each.metric for each in rows(first)} == set(METRICS)


def test_the_projects_seeds_are_ten() -> None:
    assert len(set(SEEDS)) == 10


COURSE = Course(
    signature="A", outcome=1, said=(0, 1, 0, 1, 1, 1), told=(1, 0, 1, 1, 1, 1), known=(0, 1, 2, 3, 4, 5), trust=(None,) * 6
)


def test_swings_count_beyond_the_change_that_was_due() -> None:
    assert COURSE.swings == 2
    assert COURSE.wrong == 1
    assert newest_wins(COURSE).said == COURSE.said
    assert two_confirmations(COURSE).said == (0, 0, 0, 0, 1, 1)


def test_locked_is_wrong_although_the_last_two_validations_told_what_holds() -> None:
    assert COURSE.locked == 0
    stubborn = Course(signature="A", outcome=1, said=(0,) * 6, told=(1,) * 6, known=(0, 0, 0, 1, 2, 3), trust=(None,) * 6)
    assert stubborn.locked == 2


def test_a_course_knows_only_what_had_been_told_by_then() -> None:
    of = world(LATE, SEED)
    found = {each.signature: each for each in courses(of, list(run(Recorder(), of)))}
    assert found["A"].known == (0, 1, 2, 3, 4, 5)
    assert found["B"].known == (0, 0, 0, 1, 2, 3)
