"""What repeated validations tell: noise reverts, change stays."""

from __future__ import annotations

import numpy as np
import pytest

from wakeful.learning.belief import MEMORY, Belief, Repeatability

EVEN = np.array([0.5, 0.5])


def told(values: str, common: Repeatability, first: np.ndarray = EVEN, apart: int = 4) -> Belief:  # type: ignore[type-arg]
    belief = Belief(first, 0)
    for place, value in enumerate(values):
        belief.learn(int(value), place * apart, common)
    return belief


def noisy(share: float, seed: int = 0, things: int = 8, times: int = 40) -> Repeatability:
    """What is known of noise after things that never change, each told many times."""
    random = np.random.default_rng(seed)
    common = Repeatability()
    beliefs = [Belief(EVEN, 0) for _ in range(things)]
    for at in range(things * times):
        belief = beliefs[at % things]
        belief.learn(int(random.random() < share), at, common)
    return common


def test_one_validation_suffices_to_believe() -> None:
    common = Repeatability()
    assert told("1", common).shares(1, common)[1] > 0.9


def test_one_contradiction_turns_a_belief_where_validations_have_proved_reliable() -> None:
    common = noisy(0.0)
    belief = told("00000", common)
    belief.learn(1, 150, common)
    assert belief.shares(151, common)[1] > 0.6


def test_one_contradiction_does_not_turn_it_where_they_are_noisy_and_a_second_does() -> None:
    common = noisy(0.1)
    belief = told("00000", common)
    belief.learn(1, 20, common)
    assert belief.shares(21, common)[0] > 0.5
    belief.learn(1, 24, common)
    belief.learn(1, 28, common)
    assert belief.shares(29, common)[1] > 0.5


def test_the_share_of_wrong_validations_is_found() -> None:
    assert noisy(0.0).noise < 0.02
    assert noisy(0.1).noise == pytest.approx(0.1, abs=0.05)
    assert noisy(0.3).noise == pytest.approx(0.3, abs=0.12)


def test_change_is_told_from_noise() -> None:
    """As many contradictions: each reverting at the next validation, or each staying."""
    reverting, staying = Repeatability(), Repeatability()
    for _ in range(10):
        told("000010000", reverting)
        told("000001111", staying)
    assert reverting.noise > 2 * staying.noise
    assert staying.change > reverting.change


def test_what_was_told_long_ago_binds_less() -> None:
    common = Repeatability()
    belief = told("000", common)
    shares = [belief.shares(at, common)[0] for at in (9, 100, 1000, 100_000)]
    assert shares == sorted(shares, reverse=True)
    assert shares[-1] == pytest.approx(0.5, abs=0.01)


def test_noise_that_ended_is_forgotten() -> None:
    common = noisy(0.3)
    before = common.noise
    for _ in range(int(4 * MEMORY)):
        told("0000", common, apart=1)
    assert common.noise < 0.1 < before


def test_a_sure_forecast_is_overruled_by_one_validation_where_these_have_proved_reliable_and_else_not() -> None:
    sure = np.array([0.95, 0.05])
    for common, overruled in ((noisy(0.0), True), (noisy(0.2), False)):
        belief = Belief(sure, 1000)
        belief.learn(1, 1001, common)
        assert bool(belief.shares(1002, common)[1] > 0.5) is overruled


def test_forecasts_that_are_contradicted_now_and_then_tell_of_noise() -> None:
    common, quiet = Repeatability(), Repeatability()
    for number in range(40):
        Belief(np.array([0.98, 0.02]), number).learn(int(number % 8 == 0), number, common)
        Belief(np.array([0.98, 0.02]), number).learn(0, number, quiet)
    assert common.noise > 2 * quiet.noise


def test_shares_add_up_to_one_over_many_values() -> None:
    common = Repeatability()
    belief = Belief(np.full(6, 1 / 6), 0)
    belief.learn(3, 1, common)
    belief.learn(5, 9, common)
    shares = belief.shares(10, common)
    assert shares.sum() == pytest.approx(1.0)
    assert int(shares.argmax()) in (3, 5)
