from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from wakeful.contracts.learner import Estimate, Learner, Predictor, Vector
from wakeful.facts.experience import ModelCard
from wakeful.facts.inputs import TrainingJob
from wakeful.learning.two_heads import TwoHeads
from wakeful.testing import ContractBroken, check_learner


def test_the_two_headed_learner_keeps_its_contract() -> None:
    predictor = check_learner(TwoHeads())
    assert predictor.treatments == ("description", "diagnosis", "planning")


class Wrapped:
    """The real predictor, but for one thing."""

    def __init__(self, inner: Predictor, change: Callable[[Estimate], Estimate], many: bool) -> None:
        self._inner = inner
        self._change = change
        self._many = many
        self.treatments = inner.treatments
        self.labels = inner.labels
        self.typical = inner.typical

    def estimate(self, features: Vector) -> Estimate:
        return self._change(self._inner.estimate(features))

    def estimate_many(self, features: Vector) -> list[Estimate]:
        found = self._inner.estimate_many(features)
        return [self._change(each) for each in found] if self._many else found


class Broken(TwoHeads):
    def __init__(self, change: Callable[[Estimate], Estimate], many: bool = True) -> None:
        super().__init__()
        self._change = change
        self._many = many

    def load(self, weights: bytes) -> Predictor:  # type: ignore[override]
        return Wrapped(super().load(weights), self._change, self._many)


class Forgetful(TwoHeads):
    """Its bytes depend on how often it was called."""

    calls = 0

    def train(self, job: TrainingJob) -> tuple[ModelCard, bytes]:
        self.calls += 1
        return super().train(msgspec.structs.replace(job, seed=job.seed + self.calls))


class Trusting(TwoHeads):
    def load(self, weights: bytes) -> Predictor:  # type: ignore[override]
        try:
            return super().load(weights)
        except ValueError:
            return super().load(self._last)

    def train(self, job: TrainingJob) -> tuple[ModelCard, bytes]:
        card, self._last = super().train(job)
        return card, self._last


class Meddling(TwoHeads):
    def train(self, job: TrainingJob) -> tuple[ModelCard, bytes]:
        np.asarray(job.weight)[:] *= 2.0
        return super().train(msgspec.structs.replace(job, weight=np.ones_like(np.asarray(job.weight))))


def changed(name: str, change: Callable[[Vector], Vector]) -> Callable[[Estimate], Estimate]:
    return lambda estimate: msgspec.structs.replace(estimate, **{name: change(getattr(estimate, name))})


@pytest.mark.parametrize(
    ("learner", "why"),
    [
        (Forgetful(), "another model"),
        (Trusting(), "must raise ValueError"),
        (Meddling(), "changed the job's arrays"),
        (Broken(changed("treatments", lambda shares: shares * 2.0)), "are no probabilities"),
        (Broken(changed("labels", lambda shares: shares[:1])), "probabilities over 2 names"),
        (Broken(changed("novelty", lambda novelty: novelty + 2.0)), "novelty"),
        (Broken(changed("treatments", lambda shares: shares[::-1].copy()), many=False), "depends on what it is batched with"),
    ],
)
def test_a_learner_that_breaks_its_contract_is_caught(learner: Learner, why: str) -> None:
    with pytest.raises(ContractBroken, match=why):
        check_learner(learner)
