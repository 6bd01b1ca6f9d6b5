"""The pooled learner keeps the contract, goes on from a network, and its bytes are checked."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from tests.learning.worlds import job
from wakeful.contracts.grounds import Grounded
from wakeful.learning.forest import ForestSettings
from wakeful.learning.material import material_of
from wakeful.learning.pooled import Pooled, PooledSettings
from wakeful.learning.pooled_predictor import PooledPredictor
from wakeful.learning.pooled_weights import is_pooled, pooled_from_bytes, pooled_to_bytes
from wakeful.learning.rule_search import SearchSettings
from wakeful.learning.two_heads import TwoHeads
from wakeful.testing.learner_checks import check_learner

QUICK = PooledSettings(rules=SearchSettings(chains=2, steps=120, steps_again=40), forest=ForestSettings(rounds=15))
LEARNER = Pooled(QUICK)


@pytest.fixture(scope="module")
def weights() -> bytes:
    return LEARNER.train(job())[1]


def test_it_keeps_the_contract_of_learners() -> None:
    assert isinstance(check_learner(LEARNER), PooledPredictor)


def test_one_event_is_estimated_as_many_are(weights: bytes) -> None:
    predictor = LEARNER.load(weights)
    assert isinstance(predictor, PooledPredictor)
    rows = np.random.default_rng(5).random((40, 6))
    many = predictor.estimate_rows(rows)
    for place, row in enumerate(rows):
        one = predictor.estimate(row)
        assert one.treatments == pytest.approx(many.treatments[place], abs=2e-9)
        assert one.labels == pytest.approx(many.labels[place], abs=2e-9)
        assert one.treatments.sum() == pytest.approx(1.0, abs=1e-8)
    assert len(predictor.estimate_rows(rows[:0]).treatments) == 0


def test_bytes_give_back_the_model(weights: bytes) -> None:
    assert is_pooled(weights)
    assert pooled_to_bytes(pooled_from_bytes(weights)) == weights


def test_a_networks_bytes_are_loaded_too() -> None:
    _, alone = TwoHeads().train(job(epochs=3))
    predictor = LEARNER.load(alone)
    assert not is_pooled(alone)
    assert not isinstance(predictor, PooledPredictor)


def test_a_training_goes_on_from_a_network_alone() -> None:
    _, alone = TwoHeads().train(job(epochs=3))
    card, weights = LEARNER.train(job(training=2, base=alone, base_version=1, epochs=3))
    assert card.base == 1
    assert card.champion_loss is not None
    assert is_pooled(weights)


def test_a_champion_is_compared_by_experts_that_have_not_seen_the_held_back_rows(weights: bytes) -> None:
    card, _ = LEARNER.train(job(training=2, base=weights, base_version=1))
    assert card.base == 1
    assert card.champion_loss == pytest.approx(LEARNER.train(job())[0].challenger_loss, abs=0.1)


def test_nothing_that_is_compared_depends_on_the_published_experts(weights: bytes) -> None:
    model = pooled_from_bytes(weights)
    swapped = pooled_to_bytes(msgspec.structs.replace(model, whole=model.tested))
    cards = [LEARNER.train(job(training=2, base=base, base_version=1))[0] for base in (weights, swapped)]
    assert cards[0] == cards[1]


def test_it_is_better_than_its_network_where_rules_are_sharp() -> None:
    def sharp(seed: int) -> object:
        plain = job(rows=240, seed=seed, width=10)
        x = np.round(np.asarray(plain.features))
        y = np.where(x[:, 0] * x[:, 1] > 0, 1, np.where(x[:, 2] * x[:, 3] > 0, 2, 0))
        return msgspec.structs.replace(plain, features=x, treatment=y)

    held = np.asarray(material_of(sharp(1), None)[0].x)  # type: ignore[arg-type]
    truth = material_of(sharp(1), None)[0].treatment  # type: ignore[arg-type]
    right = []
    for learner in (LEARNER, TwoHeads()):
        predictor = learner.load(learner.train(sharp(0))[1])  # type: ignore[arg-type]
        right.append(float(np.mean([estimate.treatments.argmax() for estimate in predictor.estimate_many(held)] == truth)))
    assert right[0] >= right[1]
    assert right[0] > 0.98


def test_with_few_held_back_rows_the_network_alone_is_heard() -> None:
    for share in (0.0, 0.2):
        _, weights = LEARNER.train(job(rows=40, held_back=share, epochs=3))
        assert pooled_from_bytes(weights).weights == (1.0, 0.0, 0.0)
    predictor, network = LEARNER.load(weights), TwoHeads().load(TwoHeads().train(job(rows=40, held_back=0.2, epochs=3))[1])
    row = np.random.default_rng(1).random(6)
    assert predictor.estimate(row).treatments == pytest.approx(network.estimate(row).treatments, abs=1e-6)


def test_a_job_that_holds_everything_back_is_refused() -> None:
    with pytest.raises(ValueError, match="nothing to learn from"):
        LEARNER.train(job(rows=20, held_back=1.0))


def test_damaged_bytes_are_refused(weights: bytes) -> None:
    random = np.random.default_rng(0)
    for cut in (20, len(weights) // 2, len(weights) - 1):
        with pytest.raises(ValueError, match=r"weights|bytes"):
            LEARNER.load(weights[:cut])
    for _ in range(40):
        at = int(random.integers(16, len(weights)))
        broken = weights[:at] + bytes([weights[at] ^ 0xFF]) + weights[at + 1 :]
        try:
            predictor = LEARNER.load(broken)
        except ValueError:
            continue
        predictor.estimate(np.zeros(6))  # what is let through can at least be read


def test_not_joined_it_is_the_network_alone_and_goes_on_from_either(weights: bytes) -> None:
    alone = Pooled(PooledSettings(joined=False))
    assert alone.name == "two_heads"
    assert alone.train(job(epochs=3)) == TwoHeads().train(job(epochs=3))
    card, again = alone.train(job(training=2, base=weights, base_version=1, epochs=3))
    assert card.base == 1
    assert not is_pooled(again)
    assert isinstance(alone.load(weights), PooledPredictor)


def test_the_grounds_of_a_treatment_add_up_to_its_odds(weights: bytes) -> None:
    predictor = LEARNER.load(weights)
    assert isinstance(predictor, Grounded)
    for row in np.random.default_rng(6).random((20, 6)):
        shares = dict(zip(predictor.treatments, predictor.estimate(row).treatments, strict=True))
        for treatment, share in shares.items():
            found = predictor.grounds(row, treatment)
            assert found is not None
            assert found.against != treatment
            assert shares[found.against] == max(other for name, other in shares.items() if name != treatment)
            assert sum(part.nats for part in found.parts) == pytest.approx(math.log(share / shares[found.against]), abs=1e-4)
            assert sum(rule.heard for rule in found.rules) == pytest.approx(1.0, abs=1e-6)
            for ask in (ask for rule in found.rules for ask in rule.asks):
                value = row[ask.column] + (ask.slope * row[ask.other] if ask.other >= 0 else 0.0)
                assert (value > ask.limit) == ask.above
    assert predictor.grounds(row, "dreaming") is None


def test_a_network_alone_has_no_learned_rules_to_name() -> None:
    _, alone = TwoHeads().train(job(epochs=3))
    assert not isinstance(LEARNER.load(alone), Grounded)
