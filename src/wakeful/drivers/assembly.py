"""Putting a kernel together from names: the rooms' defaults stand here and nowhere else."""

from __future__ import annotations

from collections.abc import Mapping

from wakeful.contracts.domain import Domain
from wakeful.contracts.learner import Learner
from wakeful.contracts.policy import Policy
from wakeful.domains import load
from wakeful.facts.settings import MindSettings, Selecting
from wakeful.journal.aside import AsideFile
from wakeful.kernel import Kernel
from wakeful.learning.pooled import Pooled, PooledSettings
from wakeful.scheduling.policies.deadline_aware import DeadlineAware, DeadlineAwareSettings
from wakeful.scheduling.policies.primary_share import PrimaryShare
from wakeful.treatments.registry import Registry

POOLED: Mapping[Selecting, PooledSettings] = {
    "two_heads": PooledSettings(joined=False),
    "pooled": PooledSettings(),
    "boosted": PooledSettings(trees="lightgbm"),
}

#: So many steps' time of waiting make up for one step more of work left.
AGEING_STEPS = 160.0

#: What a step is taken to last where it takes no declared time, as in the live driver.
QUICK_STEP_S = 0.01


def assemble(
    domain: str | Domain,
    settings: MindSettings | None = None,
    *,
    registry: Registry | None = None,
    learner: Learner | None = None,
    policy: Policy | None = None,
) -> tuple[Kernel, Learner]:
    """A kernel that has been fed nothing yet, and the learner that the driver trains with.

    Args:
        domain: by name, by path, or itself.
        settings: how the mind thinks; the documented defaults where None.
        registry: the treatments; those of wakeful and of installed packages where None.
        learner: F_θ's trainer; the one that the settings name where None.
        policy: who holds a slot; the deadline-aware one where None.

    Raises:
        DomainError: there is no such domain, or it cannot be read.
        MissingLearner: the learner that the settings name wants a package that is not installed.
        ValueError: the settings' ``primary_share`` is no share.
    """
    found = load(domain) if isinstance(domain, str) else domain
    thinks = settings if settings is not None else MindSettings()
    # Each reads the others' models, so that a journal can go on with another learner.
    trains = learner if learner is not None else Pooled(POOLED[thinks.learner])
    shares = policy if policy is not None else _default_policy(thinks)
    if thinks.primary_share:
        shares = PrimaryShare(shares, thinks.primary_share, thinks.primary_quantum_s)
    kernel = Kernel(
        found,
        registry if registry is not None else Registry(installed=None),
        trains,
        shares,
        thinks,
        AsideFile(),
    )
    return kernel, trains


def _default_policy(settings: MindSettings) -> Policy:
    """Deadline-aware, its ageing in the proportion to a step's length that Experiment 2 was run with (decision 13)."""
    step_s = settings.step_s or QUICK_STEP_S
    return DeadlineAware(DeadlineAwareSettings(wait_s_per_step=AGEING_STEPS * step_s))
