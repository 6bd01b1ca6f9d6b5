"""Champion and challenger, and what a model version is as bytes."""

from __future__ import annotations

import os
import subprocess
import sys
from hashlib import blake2b

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.learning.worlds import LABELS, TREATMENTS, job
from wakeful.learning.two_heads import TwoHeads, TwoHeadsSettings

LEARNER = TwoHeads()
FIRST_CARD, FIRST = LEARNER.train(job(rows=200, epochs=60))


def test_the_same_job_gives_the_same_bytes_and_another_seed_others() -> None:
    card, weights = LEARNER.train(job(rows=200, epochs=60))
    assert weights == FIRST
    assert card == FIRST_CARD
    assert card.blob == blake2b(weights, digest_size=16).hexdigest()
    assert LEARNER.train(msgspec.structs.replace(job(rows=200, epochs=60), seed=77))[1] != FIRST


def test_the_bytes_do_not_depend_on_the_number_of_blas_threads() -> None:
    code = (
        "import hashlib; from tests.learning.worlds import job; from wakeful.learning.two_heads import TwoHeads;"
        "print(hashlib.sha256(TwoHeads().train(job(rows=400, epochs=6, width=120))[1]).hexdigest())"
    )
    runs = {
        subprocess.run(
            [sys.executable, "-c", code],
            env={**os.environ, "OPENBLAS_NUM_THREADS": threads, "PYTHONPATH": os.pathsep.join(["", *sys.path])},
            check=True,
            capture_output=True,
        ).stdout
        for threads in ("1", "2")
    }
    assert len(runs) == 1


def test_a_separable_world_is_learned_and_the_card_says_how_well() -> None:
    assert FIRST_CARD.accepted
    assert FIRST_CARD.treatment_accuracy is not None
    assert FIRST_CARD.treatment_accuracy > 0.8
    assert FIRST_CARD.result_accuracy is not None
    assert FIRST_CARD.result_accuracy > 0.8
    assert FIRST_CARD.challenger_accuracy is not None
    assert FIRST_CARD.challenger_accuracy <= min(FIRST_CARD.treatment_accuracy, FIRST_CARD.result_accuracy)
    assert sum(FIRST_CARD.support.values()) == 200
    assert FIRST_CARD.version == 1
    assert (FIRST_CARD.champion_loss, FIRST_CARD.base) == (None, 0)


def test_a_continued_training_is_compared_with_its_base_on_the_same_rows() -> None:
    card, weights = LEARNER.train(job(rows=200, training=2, base=FIRST, base_version=1, epochs=20))
    assert card.base == 1
    assert card.champion_loss is not None
    assert card.accepted
    assert weights != FIRST


def test_a_challenger_that_learned_nonsense_is_not_accepted() -> None:
    good = job(rows=200, training=2, base=FIRST, base_version=1, epochs=40)
    held_back = np.asarray(good.held_back)
    nonsense = np.where(held_back, good.result, 1 - np.asarray(good.result))
    card, _ = LEARNER.train(msgspec.structs.replace(good, result=nonsense))
    assert not card.accepted
    assert "worse" in card.why


def test_a_changed_world_is_learned_again_from_the_old_weights() -> None:
    card, weights = LEARNER.train(job(rows=200, training=2, base=FIRST, base_version=1, epochs=60, flip=True))
    assert card.accepted
    features = np.asarray(job(rows=50, seed=9).features)
    old, new = LEARNER.load(FIRST).estimate_many(features), LEARNER.load(weights).estimate_many(features)
    flipped = np.mean([a.labels.argmax() != b.labels.argmax() for a, b in zip(old, new, strict=True)])
    assert flipped > 0.75


def test_one_row_and_many_agree_to_the_last_bit() -> None:
    features = np.asarray(job(rows=150, seed=5).features)
    predictor = LEARNER.load(FIRST)
    many = predictor.estimate_many(features)
    for row, estimate in zip(features, many, strict=True):
        alone = predictor.estimate(row)
        assert (alone.treatments == estimate.treatments).all()
        assert (alone.labels == estimate.labels).all()
        assert alone.novelty == estimate.novelty
        assert (alone.treatments == np.round(alone.treatments, 9)).all()
        assert 0.0 <= alone.novelty <= 1.0


def test_a_loaded_model_knows_its_vocabulary_and_refuses_other_features() -> None:
    predictor = LEARNER.load(FIRST)
    assert (predictor.treatments, predictor.labels, predictor.typical.shape) == (TREATMENTS, LABELS, (6,))
    with pytest.raises(ValueError, match="fitted on"):
        predictor.estimate(np.zeros(5))


@settings(max_examples=60)
@given(st.integers(0, len(FIRST) - 1), st.binary(max_size=40))
def test_bytes_that_are_no_model_are_refused(at: int, noise: bytes) -> None:
    with pytest.raises(ValueError, match="weights"):
        LEARNER.load(noise)
    with pytest.raises(ValueError, match="weights"):
        LEARNER.load(FIRST[:at])


def test_a_treatment_registered_later_is_added_and_is_not_chosen_before_it_is_learned() -> None:
    wider = (*TREATMENTS[:1], "dreaming", *TREATMENTS[1:])
    old = job(rows=200, training=2, base=FIRST, base_version=1, epochs=40)
    moved = np.asarray(old.treatment) + (np.asarray(old.treatment) > 0)
    card, weights = LEARNER.train(msgspec.structs.replace(old, treatments=wider, treatment=moved))
    assert card.base == 1
    assert card.accepted
    features = np.asarray(job(rows=80, seed=6).features)
    before, after = LEARNER.load(FIRST), LEARNER.load(weights)
    chosen = [before.treatments[e.treatments.argmax()] for e in before.estimate_many(features)]
    still = [after.treatments[e.treatments.argmax()] for e in after.estimate_many(features)]
    assert "dreaming" not in still
    assert np.mean([a == b for a, b in zip(chosen, still, strict=True)]) > 0.9


def test_a_base_of_other_features_is_not_continued_and_the_card_says_so() -> None:
    other = job(rows=60, training=4, base=FIRST, base_version=1, epochs=2, width=9)
    card, _ = TwoHeads(TwoHeadsSettings(epochs_again=5)).train(other)
    assert (card.base, card.epochs) == (0, 5)
    assert "scratch" in card.why


def test_with_nothing_held_back_the_challenger_is_accepted_uncalibrated() -> None:
    card, weights = LEARNER.train(job(rows=40, held_back=0.0, epochs=3))
    assert card.accepted
    assert (card.thresholds, card.held_back, card.challenger_loss) == ({}, 0, None)
    assert LEARNER.load(weights).estimate(np.zeros(6)).treatments.sum() == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"held_back": np.ones(120, dtype=bool)}, "nothing to learn from"),
        ({"result": np.zeros(3, dtype=int)}, "don't fit together"),
        ({"treatment": np.full(120, 7)}, "index below 3"),
        ({"features": np.full((120, 6), np.nan)}, "finite"),
        ({"base_weights": b"noise"}, "not the weights"),
    ],
)
def test_a_job_that_makes_no_sense_is_refused(changed: dict[str, object], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        LEARNER.train(msgspec.structs.replace(job(), **changed))


def test_what_was_never_seen_is_more_novel_than_what_was() -> None:
    predictor = LEARNER.load(FIRST)
    features = np.asarray(job(rows=200, seed=0).features)
    familiar = [estimate.novelty for estimate in predictor.estimate_many(features)]
    assert predictor.estimate(np.full(6, 9.0)).novelty > 0.99 > np.median(familiar)
