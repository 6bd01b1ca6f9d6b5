from collections.abc import Callable, Sequence

import pytest

from wakeful.contracts.policy import Pick, Policy
from wakeful.facts.processes import ProcessView
from wakeful.scheduling.policies.reactive_priority import ReactivePriority
from wakeful.scheduling.policies.sequential import Sequential
from wakeful.scheduling.policies.suspend_resume import SuspendResume
from wakeful.scheduling.policies.task_bounded import TaskBounded
from wakeful.testing import ContractBroken, check_policy


@pytest.mark.parametrize("make", [SuspendResume, Sequential, TaskBounded, ReactivePriority])
@pytest.mark.parametrize("seed", range(5))
def test_every_policy_keeps_its_contract(make: Callable[[], Policy], seed: int) -> None:
    check_policy(make, seed=seed, abandons=make is ReactivePriority)


@pytest.mark.parametrize("make", [SuspendResume, Sequential])
def test_a_policy_that_drops_nothing_completes_everything(make: Callable[[], Policy]) -> None:
    assert check_policy(make, processes=25) == 25


class Greedy(SuspendResume):
    name = "greedy"

    def pick(self, running: Sequence[int], slots: int, now_ns: int) -> Pick:
        return super().pick(running, slots + 1, now_ns)


class Deaf(SuspendResume):
    name = "deaf"

    def waiting(self, view: ProcessView, now_ns: int) -> None:
        pass


class ByCall(SuspendResume):
    """Takes whoever was told of last."""

    name = "by_call"

    def __init__(self) -> None:
        super().__init__()
        self._told: list[int] = []

    def runnable(self, view: ProcessView, now_ns: int) -> None:
        self.gone(view.id, now_ns)
        self._told.append(view.id)

    def gone(self, process: int, now_ns: int) -> None:
        if process in self._told:
            self._told.remove(process)

    def pick(self, running: Sequence[int], slots: int, now_ns: int) -> Pick:
        return Pick(tuple(self._told[-slots:]))


class Lazy(SuspendResume):
    name = "lazy"

    def pick(self, running: Sequence[int], slots: int, now_ns: int) -> Pick:
        return Pick(())


@pytest.mark.parametrize(
    ("make", "why"),
    [
        (Greedy, "picks 3 for 2 slots"),
        (Deaf, "which wait, are gone"),
        (ByCall, "in another order"),
        (Lazy, "none was ever completed"),
        (ReactivePriority, "only an experiment's policy may"),
    ],
)
def test_a_policy_that_breaks_its_contract_is_caught(make: Callable[[], Policy], why: str) -> None:
    with pytest.raises(ContractBroken, match=why):
        check_policy(make)
