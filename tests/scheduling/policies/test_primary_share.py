"""A share for the primary task: kept free of all but critical processes, evenly, by the clock alone."""

from __future__ import annotations

import pytest

from tests.scheduling.policies.views import seen
from wakeful.contracts.policy import LearningPolicy, Pick
from wakeful.facts.time import NS_PER_S, to_ns
from wakeful.scheduling.policies.deadline_aware import DeadlineAware
from wakeful.scheduling.policies.primary_share import PrimaryShare
from wakeful.scheduling.policies.suspend_resume import SuspendResume
from wakeful.testing import check_policy


@pytest.mark.parametrize("share", [0.1, 0.25, 0.5, 0.75])
def test_the_share_is_kept_and_evenly_spread(share: float) -> None:
    policy = PrimaryShare(SuspendResume(), share)
    policy.runnable(seen(1), 0)
    free = [policy.pick((1,), 1, second * NS_PER_S).run == () for second in range(400)]
    assert sum(free) == share * 400
    for start in range(0, 360, 40):
        assert abs(sum(free[start : start + 40]) - share * 40) <= 1


def test_in_its_quanta_critical_processes_still_run_and_the_policy_asks_to_be_asked_again() -> None:
    policy = PrimaryShare(SuspendResume(), 1.0, quantum_s=2.0)
    policy.runnable(seen(1), 0)
    assert policy.pick((), 2, to_ns(3)) == Pick((), again_ns=to_ns(4))
    policy.runnable(seen(2, critical=True), to_ns(3))
    assert policy.pick((), 2, to_ns(3)) == Pick((2,), again_ns=to_ns(4))
    policy.gone(1, to_ns(3))
    assert policy.pick((), 2, to_ns(3)) == Pick((2,))


def test_it_tells_the_inner_policy_everything() -> None:
    heard: list[str] = []

    class Listening(DeadlineAware):
        def waiting(self, view: object, now_ns: int) -> None:
            heard.append("waiting")

        def completed(self, view: object, now_ns: int) -> None:
            heard.append("completed")

    policy = PrimaryShare(Listening(), 0.5)
    assert isinstance(policy, LearningPolicy)
    policy.waiting(seen(1), 0)
    policy.completed(seen(1), 0)
    assert heard == ["waiting", "completed"]
    assert policy.name == "deadline_aware"
    PrimaryShare(SuspendResume(), 0.5).completed(seen(1), 0)


@pytest.mark.parametrize("inner", [SuspendResume, DeadlineAware])
def test_it_keeps_the_contract_of_a_policy(inner: type[SuspendResume] | type[DeadlineAware]) -> None:
    for seed in range(3):
        assert check_policy(lambda: PrimaryShare(inner(), 0.3), seed=seed) > 0


@pytest.mark.parametrize(("share", "quantum_s"), [(-0.1, 1.0), (1.1, 1.0), (float("nan"), 1.0), (0.5, 0.0)])
def test_what_is_no_share_or_no_quantum_is_refused_with_its_name(share: float, quantum_s: float) -> None:
    with pytest.raises(ValueError, match="primary_"):
        PrimaryShare(SuspendResume(), share, quantum_s)
