"""Experiment 3's world: its declared sizes, what changes and what does not."""

from __future__ import annotations

import numpy as np
import pytest

from wakeful.domains.service_robot.world import right_treatment
from wakeful.experiments.worlds.service_drift import (
    CLEAN,
    FIELDS,
    INPUTS,
    JITTER,
    LATE,
    NOISY,
    SIGNATURES,
    VARIANTS,
    Variant,
    features,
    world,
)
from wakeful.experiments.worlds.service_events import TREATMENTS

each_variant = pytest.mark.parametrize("variant", VARIANTS, ids=lambda variant: variant.name)


@each_variant
def test_the_sizes_are_the_papers(variant: Variant) -> None:
    made = world(variant, 1000)
    stages = [met.stage for met in made.stream]
    assert len(made.pretraining) == 198
    assert (stages.count("familiar"), stages.count("novel"), stages.count("drift"), stages.count("reuse")) == (28, 6, 24, 6)
    assert sorted(set(stages), key=stages.index) == ["familiar", "novel", "drift", "reuse"]


def test_familiar_events_are_balanced_over_five_treatments() -> None:
    counts = [[met.case.truth for met in world(CLEAN, 1000).stream[:28]].count(name) for name in TREATMENTS]
    assert sorted(counts) == [0, 5, 5, 6, 6, 6]
    assert counts[TREATMENTS.index("analogy")] == 0


@each_variant
def test_copies_come_with_the_old_outcome_before_the_new_one(variant: Variant) -> None:
    made = world(variant, 1001)
    after = {met.signature: met.outcome for met in made.stream if met.signature}
    for signature in SIGNATURES:
        learned = [met.outcome for met in made.pretraining if met.signature == signature.name]
        assert learned == [1 - after[signature.name]] * signature.old + [after[signature.name]] * signature.new


@each_variant
def test_a_changed_event_keeps_its_right_treatment(variant: Variant) -> None:
    right = {"A": "description", "B": "planning", "C": "memory", "D": "diagnosis"}
    for seed in range(1000, 1020):
        for met in world(variant, seed).stream:
            if met.signature:
                assert met.case.truth == right[met.signature] == right_treatment(met.case)


def test_the_outcome_is_an_intervention_unless_the_state_is_normal_and_the_other_way_round_once_changed() -> None:
    for met in world(CLEAN, 1002).stream:
        usual = int(met.case.state != "normal")
        assert met.outcome == (1 - usual if met.stage == "drift" else usual)


def test_repetitions_are_equal_to_the_digit_and_similar_under_jitter() -> None:
    clean = [met for met in world(CLEAN, 1003).stream if met.signature == "B"]
    assert all(np.array_equal(features(met), features(clean[0])) for met in clean)
    similar = [met for met in world(JITTER, 1003).stream if met.signature == "B"]
    looks = {tuple(getattr(met.case, name) for name in FIELDS) for met in similar}
    assert len(looks) == 1
    assert len({met.case.descriptor for met in similar}) == len(similar)
    loads = [met.case.load for met in similar]
    assert 0.0 < max(loads) - min(loads) <= 0.3 + 1e-6


def test_a_validation_is_known_four_events_later_and_late_ones_ten() -> None:
    for place, met in enumerate(world(LATE, 1004).stream):
        late = met.signature in ("B", "D")
        assert met.known_from - place == (10 if late else 4)


def test_a_tenth_of_the_noisy_validations_is_wrong_and_of_the_others_none() -> None:
    wrong = [met.wrong for seed in range(40) for met in world(NOISY, seed).stream]
    assert np.mean(wrong) == pytest.approx(0.10, abs=0.015)
    assert not any(met.wrong for met in world(CLEAN, 0).stream)
    assert all(met.told == (1 - met.outcome if met.wrong else met.outcome) for met in world(NOISY, 0).stream)


def test_variants_differ_in_what_they_declare_alone() -> None:
    clean, noisy = world(CLEAN, 1005), world(NOISY, 1005)
    assert clean.pretraining == noisy.pretraining
    assert [(met.case, met.outcome) for met in clean.stream] == [(met.case, met.outcome) for met in noisy.stream]


def test_every_new_type_has_a_flag_of_its_own() -> None:
    rows = [features(met) for met in world(CLEAN, 1006).stream]
    flags = np.array([row[-6:] for row in rows])
    assert flags[:28].sum() == 0
    assert (flags[28:34] == np.eye(6)).all()
    assert (flags[58:] == np.eye(6)).all()
    assert all(row.shape == (INPUTS,) for row in rows)


def test_one_seed_is_one_world() -> None:
    assert world(JITTER, 7) == world(JITTER, 7)
    assert world(JITTER, 7) != world(JITTER, 8)
