"""Putting a kernel together: the rooms' defaults."""

from __future__ import annotations

import asyncio

import pytest

from wakeful.contracts.policy import Policy
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.drivers.assembly import assemble
from wakeful.drivers.live import LiveDriver
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.settings import MindSettings
from wakeful.journal import MemoryJournal
from wakeful.journal.aside import AsideFile
from wakeful.kernel import Kernel
from wakeful.scheduling.policies.deadline_aware import DeadlineAware
from wakeful.scheduling.policies.primary_share import PrimaryShare
from wakeful.scheduling.policies.suspend_resume import SuspendResume


def policy_of(kernel: Kernel) -> Policy:
    return kernel._scheduler.processes.policy


def test_a_mind_is_deadline_aware_unless_told_otherwise() -> None:
    assert isinstance(policy_of(assemble("jsonl")[0]), DeadlineAware)
    assert isinstance(policy_of(assemble("jsonl", policy=SuspendResume())[0]), SuspendResume)


def test_a_share_for_the_primary_task_is_kept_by_whatever_policy_is_used() -> None:
    kernel, _ = assemble("jsonl", MindSettings(primary_share=0.3), policy=SuspendResume())
    shared = policy_of(kernel)
    assert isinstance(shared, PrimaryShare)
    assert shared.name == "suspend_resume"


def test_a_share_that_is_none_is_refused() -> None:
    with pytest.raises(ValueError, match="primary_share is 2"):
        assemble("jsonl", MindSettings(primary_share=2.0))


@pytest.mark.parametrize("lives", [False, True], ids=["simulated", "live"])
def test_what_waiters_are_parked_in_is_closed_when_the_mind_ends(monkeypatch: pytest.MonkeyPatch, lives: bool) -> None:
    made = AsideFile()
    monkeypatch.setattr("wakeful.drivers.assembly.AsideFile", lambda: made)
    kernel, learner = assemble("service_robot", MindSettings(step_s=0.0))
    reasoner = GuidelineReasoner(kernel.domain.spec)
    made.put(1, b"parked")

    async def live() -> None:
        async with LiveDriver(kernel, MemoryJournal(), reasoner, learner):
            assert made._db is not None

    if lives:
        asyncio.run(live())
    else:
        SimulatedDriver(kernel, MemoryJournal(), reasoner, learner).close()
    assert made._db is None
