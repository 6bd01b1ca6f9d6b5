"""How the base follows its commands: it stalls against them, or does less than is asked."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from wakeful.contracts.detector import Found, Shown
from wakeful.domains.latch import Latch
from wakeful.domains.mobile_base.commands import Command, Commands
from wakeful.domains.mobile_base.motion import MOVING_MPS, Bases, Motion
from wakeful.domains.plain import number, within
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns, to_s

_STALLED = 0.2
"""Less than this share of what was asked for is a stall."""
_SHORT, _ENOUGH = 0.75, 0.85
"""A shortfall begins below the one and ends above the other."""


class _Following(msgspec.Struct):
    stall: Latch = msgspec.field(default_factory=Latch)
    short: Latch = msgspec.field(default_factory=Latch)


class _Memory(msgspec.Struct):
    bases: Bases = msgspec.field(default_factory=Bases)
    commands: Commands = msgspec.field(default_factory=Commands)
    followings: dict[str, _Following] = {}


class Following(Remembering[_Memory]):
    """Two lasting conditions of each base's drive.

    ``stall``: for ``stall_s`` (1.0) less than a fifth of the speed and of the turning rate that is asked for.
    ``shortfall``: it moves, but for ``short_s`` (3.0) slower than three quarters of what is asked: a limiter, a slope, a weak
    battery, a dragging brake. Doing what is asked again shows the outcome ``recovered`` for the drive.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())
        self._stall_ns = to_ns(number(spec.settings, "stall_s") or 1.0)
        self._short_ns = to_ns(number(spec.settings, "short_s") or 3.0)

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Take up a command, or compare an odometry message with it."""
        memory = self.memory
        seen = memory.bases.see(observation)
        if memory.commands.see(observation, memory.bases.clock.now_ns or 0) or seen is None:
            return
        motion = seen[0]
        command = memory.commands.of(observation.topic, seen[0].heard_ns).least
        following = memory.followings.setdefault(observation.topic, _Following())
        entity = memory.bases.part("drive", observation.topic)
        yield from self._stall(observation, entity, motion, command, following.stall)
        yield from self._short(observation, entity, motion, command, following.short)

    def _stall(
        self, observation: Observation, entity: str, motion: Motion, command: Command | None, latch: Latch
    ) -> Iterator[Seen]:
        stalled = (
            command is not None
            and command.asks
            and motion.speed_mps <= _STALLED * command.speed_mps
            and abs(motion.turning_radps) <= _STALLED * command.turn_radps
        )
        phase = latch.see(int(stalled), observation.at_ns, self._stall_ns, to_ns(0.3))
        if phase is None:
            return
        measured = f"{motion.speed_mps:.2f} m/s and {abs(motion.turning_radps):.2f} rad/s measured"
        asked = "" if command is None else f"{command.speed_mps:.2f} m/s and {command.turn_radps:.2f} rad/s asked for"
        says = (
            f"The base moves again, or is not asked to any more ({motion.says()})."
            if phase is Phase.CLEARED
            else f"The base has not done what it is told for {to_s(self._stall_ns):.1f} s: {asked}; {measured}."
        )
        yield from _said("stall", phase, entity, motion, command, says, 0.8, 2, recovered=motion.moving)

    def _short(
        self, observation: Observation, entity: str, motion: Motion, command: Command | None, latch: Latch
    ) -> Iterator[Seen]:
        level = 0
        if command is not None and command.speed_mps >= 2 * MOVING_MPS and motion.speed_mps >= MOVING_MPS:
            share = motion.speed_mps / command.speed_mps
            level = 1 if share < _SHORT else latch.level if share < _ENOUGH else 0
        phase = latch.see(level, observation.at_ns, self._short_ns, to_ns(3.0))
        if phase is None:
            return
        says = (
            f"The base drives as fast as it is asked again, or is not asked to ({motion.says()})."
            if phase is Phase.CLEARED or command is None
            else f"The base drives at {motion.speed_mps:.2f} m/s, {motion.speed_mps / command.speed_mps:.0%} of the"
            f" {command.speed_mps:.2f} m/s that it is asked for."
        )
        followed = command is not None and command.asks and motion.speed_mps >= _ENOUGH * command.speed_mps
        yield from _said("shortfall", phase, entity, motion, command, says, 0.3, 1, recovered=followed)


def _said(
    kind: str,
    phase: Phase,
    entity: str,
    motion: Motion,
    command: Command | None,
    says: str,
    severity: float,
    criticality: int,
    recovered: bool,
) -> Iterator[Seen]:
    # that nobody asks any more ends it too, but shows nothing of the drive
    if phase is Phase.CLEARED and recovered:
        yield Shown(label="recovered", entity=entity)
    yield Found(
        kind=kind,
        entity=entity,
        fields={
            **motion.fields(),
            "commanded_mps": 0.0 if command is None else within(command.speed_mps, 0.0, 20.0),
            "commanded": command is not None and command.asks,
            "severity": severity,
        },
        says=says,
        criticality=criticality,
        deadline_s=10.0,
        phase=phase,
        type=kind,
        references=(entity,),
    )
