"""Novelty as a quantile of familiar distances."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wakeful.learning.novelty import NEAR, Novelty, cover, learn_novelty


def test_a_repetition_is_never_novel_even_where_all_are_repetitions() -> None:
    rows = np.repeat(np.eye(4) * 4.0, 30, axis=0)
    novelty = learn_novelty(rows, rows[::3], 64)
    assert novelty.of(rows[5]) == 0.0
    assert novelty.of(rows[5] + 0.1) == 0.0
    assert novelty.of(np.full(4, 9.0)) > 0.99


def test_what_was_seen_once_is_kept_among_few_exemplars() -> None:
    common = np.random.default_rng(0).normal(size=(300, 3)) * 0.1
    once = np.array([[8.0, 0.0, 0.0]])
    novelty = learn_novelty(np.concatenate([common[:100], once, common[100:]]), common[:40], 16)
    assert novelty.exemplars.shape == (16, 3)
    assert novelty.of(once[0]) == 0.0


def test_without_experience_everything_is_novel() -> None:
    assert Novelty(np.zeros((0, 3)), np.zeros(0)).of(np.zeros(3)) == 1.0
    assert Novelty(np.zeros((1, 3)), np.zeros(0)).of(np.zeros(3)) == 1.0


@given(st.lists(st.floats(0.0, 50.0), min_size=1, max_size=60), st.floats(0.0, 1e6), st.floats(0.0, 1e6))
def test_novelty_grows_with_distance_and_stays_within_its_bounds(reference: list[float], one: float, other: float) -> None:
    novelty = Novelty(np.zeros((1, 1)), np.sort(np.array(reference)))
    low, high = novelty.quantile(min(one, other)), novelty.quantile(max(one, other))
    assert 0.0 <= low <= high <= 1.0
    assert novelty.quantile(NEAR) == 0.0


@given(st.integers(1, 40), st.integers(1, 12), st.integers(0, 5))
def test_a_cover_is_of_different_rows_and_of_no_more_than_asked(rows: int, limit: int, seed: int) -> None:
    chosen = cover(np.random.default_rng(seed).normal(size=(rows, 3)), limit)
    assert len(set(chosen)) == len(chosen) == min(rows, limit)
    assert chosen == sorted(chosen)


@pytest.mark.parametrize("rate", [0.05, 0.1, 0.2])
def test_as_many_familiar_events_are_taken_for_unfamiliar_ones_as_the_rate_allows(rate: float) -> None:
    """Held-back and new events are exchangeable, so that the rank of a new one's distance among theirs is uniform."""
    alarms = []
    for seed in range(40):
        rows = np.random.default_rng(seed).normal(size=(340, 6))
        novelty = learn_novelty(rows[:160], rows[160:200], limit=256)
        alarms.append(np.mean([novelty.of(row) > 1.0 - rate for row in rows[200:]]))
    error = 3 * np.std(alarms, ddof=1) / np.sqrt(len(alarms))
    assert rate / 2 < np.mean(alarms) <= rate + error
