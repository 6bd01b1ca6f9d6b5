"""What a user may set about a mind. Each setting is read somewhere; its default is documented here and nowhere else."""

from __future__ import annotations

from typing import Literal

from wakeful.facts.overload import OverloadSettings
from wakeful.facts.values import Fact

Gating = Literal["benefit", "threshold", "guarantee"]
Selecting = Literal["two_heads", "pooled", "boosted"]
"""By what rule a treatment may be executed automatically."""


class MindSettings(Fact, frozen=True):
    """How one mind thinks.

    ``slots``: processes that may be active at once. ``step_s``: kernel time that one step of work takes (0: the step is over as
    soon as its code has run, as in the live driver). ``slotted``: steps begin only at multiples of ``step_s``, as in a
    time-slotted simulator, so that all that came within a step is known before the next one begins. ``keep_evidence_s``: for how
    long evidence of undeclared topics is kept for who asks later. ``reopen_limit``: at most so many processes are reopened by one
    contradiction. ``reasoner_slots``: calls of the reasoner that may be under way at once, the others queue by priority (0: no
    limit). ``repay_after_s``: so long after a reasoner refused it is asked again about the riskiest event that holds a
    provisional treatment for it, each pause twice as long, up to an hour; where it answers, the others are repaid too, one each
    ``repay_every_s`` (``repay_after_s`` 0: never by themselves). ``keep_events``: completed events kept in memory for late
    outcomes and reopening. ``keep_waiting``: processes that wait for evidence and stay at hand; those that have waited longest
    are parked outside memory until it comes. ``keep_ids``: admitted events whose ids are known, at least half of them: one that
    comes again is a duplicate. ``episodes``: events that episodic memory keeps to be recalled (above 100,000 with the extra
    ``memory``). ``nearest``: how many validated experiences a decision names as what it rests on. ``primary_share``: the share of
    time in which only critical processes may run, for the robot's own task; ``primary_quantum_s`` at a time. ``consult``: in
    delib mode treatments put typed questions of their own to the reasoner, beside the one that chooses the treatment.
    ``max_steps``, ``max_requests``, ``max_depth``: what one attempt of a process may spend, ask, and nest in child processes; one
    that wants more has failed. ``tries``: an event whose treatment has ended the mind's process so often (it crashed, or a
    watchdog killed it) is quarantined: completed as unresolved, and debt. ``overload``: what is given up, in which order, when
    more comes than can be thought about.

    ``gate`` says when a treatment may be automatic: ``benefit``, where deliberation would do no better; ``threshold``, from
    the paper's threshold on; ``guarantee``, where the risk P(wrong and automatic) of each treatment is held under ``alpha``
    with probability 1 − ``delta``. Under the last, outcomes count as evidence only for events that were drawn for an audit,
    automatic ones with probability ``audit_rate``. ``novelty_rate``: the share of familiar events that may be taken for
    unfamiliar ones, so that those that are get a provisional treatment. ``learner``: what is trained to select, the network of
    Eq. 8 alone, or joined by decision lists and trees, which learn sharper rules from few events and take seconds to train, or
    the same with LightGBM's trees (the extra ``boosting``).
    ``trains``: without it the published model version stays, whatever is experienced.
    """

    slots: int = 1
    reasoner_slots: int = 0
    step_s: float = 0.02
    slotted: bool = False
    max_steps: int = 10_000
    max_requests: int = 256
    max_depth: int = 8
    tries: int = 3
    overload: OverloadSettings = OverloadSettings()
    seed: int = 0
    keep_evidence_s: float = 30.0
    reopen_limit: int = 8
    repay_after_s: float = 60.0
    repay_every_s: float = 1.0
    keep_events: int = 10_000
    keep_waiting: int = 4_096
    keep_ids: int = 250_000
    episodes: int = 20_000
    nearest: int = 3
    consult: bool = False
    primary_share: float = 0.0
    primary_quantum_s: float = 0.1
    learner: Selecting = "two_heads"
    trains: bool = True
    gate: Gating = "benefit"
    alpha: float = 0.05
    delta: float = 0.05
    audit_rate: float = 0.2
    novelty_rate: float = 0.01
