"""Experiment 1's world: sizes and structure in every seed, the labelling rule, and what a variant changes."""

from __future__ import annotations

import msgspec
import pytest

from wakeful.domains.service_robot.world import CATEGORIES, right_treatment
from wakeful.experiments.exp1_treatment import SEEDS
from wakeful.experiments.worlds.service_events import BOUNDARY, VARIANTS, A, B, C, Case, Variant, world

EVERY = [pytest.param(variant, seed, id=f"{variant.name}-{seed}") for variant in VARIANTS for seed in (*SEEDS, 1000, 1001)]


def case(**fields: object) -> Case:
    calm: dict[str, object] = {
        "part": "random", "category": "item", "location": "center", "state": "normal", "history": "unchanged", "route": "none",
        "context": "none", "load": 0.5, "descriptor": (0.0,), "entity": "item-00", "truth": "", "ruled": "",
    }  # fmt: skip
    return msgspec.convert({**calm, **fields}, Case)


@pytest.mark.parametrize(("variant", "seed"), EVERY)
def test_sizes_pairs_and_singletons_are_the_papers(variant: Variant, seed: int) -> None:
    of = world(variant, seed)
    assert (len(of.training), len(of.calibration), len(of.test)) == (268, 42, 82)
    assert sum(each.structured for each in of.test) == 34
    assert [each.part for each in of.test[:34]] == ["pair"] * 32 + ["plain_unknown", "odd_unknown"]
    assert [each.pair for each in of.test[:32]] == [place // 2 for place in range(32)]


@pytest.mark.parametrize(("variant", "seed"), EVERY)
def test_both_members_of_a_pair_show_the_same_object_and_need_different_treatments(variant: Variant, seed: int) -> None:
    test = world(variant, seed).test
    for first, second in zip(test[:32:2], test[1:32:2], strict=True):
        assert first.entity == second.entity
        assert first.truth == "description"
        assert second.truth in ("risk_prediction", "planning", "diagnosis", "memory")
    assert [each.truth for each in test[32:34]] == ["analogy", "analogy"]


@pytest.mark.parametrize("variant", VARIANTS, ids=lambda each: each.name)
def test_no_object_is_met_in_two_splits(variant: Variant) -> None:
    of = world(variant, 3)
    objects = [{each.descriptor for each in split} for split in (of.training, of.calibration, of.test)]
    names = [{each.entity for each in split} for split in (of.training, of.calibration, of.test)]
    for sets in (objects, names):
        assert not sets[0] & sets[1] | sets[0] & sets[2] | sets[1] & sets[2]


def test_a_world_belongs_to_its_seed() -> None:
    assert world(A, 7) == world(A, 7)
    assert world(A, 7) != world(A, 8)


@pytest.mark.parametrize(
    ("fields", "treatment"),
    [
        ({}, "description"),
        ({"state": "unstable", "location": "edge"}, "risk_prediction"),
        ({"state": "unstable", "context": "safety", "load": 0.61}, "risk_prediction"),
        ({"state": "unstable", "context": "safety", "load": 0.59}, "description"),
        ({"state": "unstable", "context": "task", "load": 0.9}, "description"),
        ({"route": "blocking"}, "description"),
        ({"route": "blocking", "context": "safety"}, "planning"),
        ({"route": "outside", "context": "task", "load": 0.61}, "planning"),
        ({"route": "outside", "context": "safety", "load": 0.61}, "description"),
        ({"category": "device", "state": "abnormal"}, "diagnosis"),
        ({"category": "item", "state": "abnormal"}, "description"),
        ({"category": "unknown", "history": "none"}, "analogy"),
        ({"history": "moved"}, "memory"),
        # Which of several cues comes first depends on the context.
        ({"state": "unstable", "location": "edge", "route": "blocking", "context": "task"}, "planning"),
        ({"state": "unstable", "location": "edge", "route": "blocking", "context": "safety"}, "risk_prediction"),
        ({"category": "device", "state": "abnormal", "route": "blocking", "context": "safety"}, "diagnosis"),
        ({"history": "moved", "state": "unstable", "location": "edge"}, "risk_prediction"),
    ],
)
def test_the_first_active_cue_in_the_contexts_order_is_the_label(fields: dict[str, object], treatment: str) -> None:
    assert right_treatment(case(**fields)) == treatment


def test_the_load_boundary_moves_with_the_object_in_variant_c_alone() -> None:
    for variant in (A, C):
        for each in world(variant, 11).test:
            boundary = BOUNDARY + variant.moves * each.descriptor[0]
            assert each.truth == right_treatment(each, boundary)
    assert any(each.truth != right_treatment(each) for seed in range(5) for each in world(C, seed).training)


def test_variants_a_and_c_show_the_same_events_but_for_the_loads_beside_a_boundary() -> None:
    plain, moved = world(A, 5).test, world(C, 5).test
    assert [each.entity for each in plain] == [each.entity for each in moved]
    assert [each.load for each in plain if not each.structured] == [each.load for each in moved if not each.structured]


def test_hard_members_lie_just_below_their_own_boundary() -> None:
    for variant, hard in ((A, 6), (B, 4), (C, 6)):
        close = 0
        for each in world(variant, 2).test[:32:2]:
            boundary = BOUNDARY + variant.moves * each.descriptor[0]
            close += abs(boundary - each.load - variant.below) < 2e-6 and each.context in ("task", "safety")
        assert close == hard


def test_noise_replaces_about_two_percent_of_random_labels_and_nothing_else() -> None:
    events = [each for seed in range(40) for each in world(B, seed).training]
    noisy = [each for each in events if each.truth != each.ruled]
    assert all(each.part == "random" for each in noisy)
    assert 0.015 < len(noisy) / sum(each.part == "random" for each in events) < 0.025
    assert not any(each.truth != each.ruled for seed in range(5) for each in world(A, seed).training)


def test_the_ten_worlds_are_typical_in_what_they_contain() -> None:
    ten = [each for seed in SEEDS for each in world(A, seed).test if not each.structured]
    many = [each for seed in range(300, 400) for each in world(A, seed).test if not each.structured]
    for category in CATEGORIES:
        shares = [sum(each.category == category for each in crowd) / len(crowd) for crowd in (ten, many)]
        assert shares[0] == pytest.approx(shares[1], abs=0.03)
