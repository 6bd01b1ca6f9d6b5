"""LightGBM's trees become a forest of ours: the same numbers, read without the package."""

from __future__ import annotations

import sys

import msgspec
import numpy as np
import pytest

from tests.learning.test_rule_lists import rows_of, world
from tests.learning.worlds import job
from wakeful.contracts.learner import MissingLearner
from wakeful.drivers.assembly import assemble
from wakeful.facts.settings import MindSettings
from wakeful.learning.forest import ForestReader, ForestSettings
from wakeful.learning.network import softmax
from wakeful.learning.packaged_trees import grow_packaged
from wakeful.learning.pooled import Pooled, PooledSettings
from wakeful.learning.rule_search import SearchSettings
from wakeful.testing.learner_checks import check_learner

QUICK = PooledSettings(
    trees="lightgbm", rules=SearchSettings(chains=2, steps=120, steps_again=40), forest=ForestSettings(rounds=15), joined_from=10
)


def test_the_forest_says_what_lightgbm_says(monkeypatch: pytest.MonkeyPatch) -> None:
    lightgbm = pytest.importorskip("lightgbm", reason="needs the extra wakeful[boosting]")
    boosters = []
    train = lightgbm.train

    def kept(*args: object, **more: object) -> object:
        boosters.append(train(*args, **more))
        return boosters[-1]

    monkeypatch.setattr(lightgbm, "train", kept)
    x, y = world()
    forest = grow_packaged(rows_of(x, y), 4, 1, ForestSettings(rounds=20))
    new, _ = world(300, seed=1)
    ours = softmax(ForestReader(forest).logits_many(new))
    assert ours == pytest.approx(boosters[0].predict(new), abs=1e-6)
    assert np.allclose([ForestReader(forest).logits(row) for row in new], ForestReader(forest).logits_many(new))


def test_a_treatment_that_nothing_was_seen_of_is_unlikely_and_nowhere_impossible() -> None:
    pytest.importorskip("lightgbm", reason="needs the extra wakeful[boosting]")
    x, y = world()
    forest = grow_packaged(rows_of(x, y + 1), 6, 1, ForestSettings(rounds=10))
    shares = softmax(ForestReader(forest).logits_many(x))
    assert shares[:, [0, 5]].max() < 0.05
    assert shares.min() > 0.0


def test_of_a_single_treatment_there_is_nothing_to_grow() -> None:
    pytest.importorskip("lightgbm", reason="needs the extra wakeful[boosting]")
    x, y = world()
    forest = grow_packaged(rows_of(x, np.ones_like(y)), 4, 1, ForestSettings(rounds=10))
    assert softmax(ForestReader(forest).logits_many(x)).argmax(axis=1).tolist() == [1] * len(x)


def test_it_keeps_the_contract_of_learners() -> None:
    pytest.importorskip("lightgbm", reason="needs the extra wakeful[boosting]")
    learner = Pooled(QUICK)
    assert learner.name == "boosted"
    check_learner(learner)


def test_what_it_trained_is_read_without_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("lightgbm", reason="needs the extra wakeful[boosting]")
    _, weights = Pooled(QUICK).train(job())
    row = np.random.default_rng(5).random(6)
    said = Pooled().load(weights).estimate(row)
    monkeypatch.setitem(sys.modules, "lightgbm", None)
    again = Pooled().load(weights).estimate(row)
    assert again.treatments.tolist() == said.treatments.tolist()


def test_trees_that_see_everything_are_kept_where_they_foretell_better() -> None:
    pytest.importorskip("lightgbm", reason="needs the extra wakeful[boosting]")
    # Thirty numbers that all matter a little: more than short lists can ask for.
    random = np.random.default_rng(3)
    x = random.random((400, 30))
    learned = msgspec.structs.replace(
        job(rows=400, width=30),
        features=x,
        treatment=(x @ random.normal(size=30) > 0.0).astype(np.int64),
        held_back=np.arange(400) % 4 == 3,
    )
    model = Pooled(QUICK).load(Pooled(QUICK).train(learned)[1]).model  # type: ignore[attr-defined]
    assert len(model.whole.inputs) == 30


def test_without_the_package_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "lightgbm", None)
    with pytest.raises(MissingLearner, match=r"wakeful\[boosting\]"):
        assemble("service_robot", MindSettings(learner="boosted"))
