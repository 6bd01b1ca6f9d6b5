"""Driving: the base begins to move and comes to rest, asked for or not."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from wakeful.contracts.detector import Found, Shown
from wakeful.domains.mobile_base.commands import Command, Commands
from wakeful.domains.mobile_base.motion import MOVING_MPS, Bases, Motion
from wakeful.domains.plain import number, within
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns, to_s
from wakeful.facts.values import Field

_WINDOW_NS = to_ns(1.5)


class _Drive(msgspec.Struct):
    speeds: list[tuple[int, float]] = []
    """(instant, speed) of the last second and a half: how hard it braked."""
    unexpected: bool = False
    """The last stop was unexpected: moving on from it is a recovery."""


class _Memory(msgspec.Struct):
    bases: Bases = msgspec.field(default_factory=Bases)
    commands: Commands = msgspec.field(default_factory=Commands)
    drives: dict[str, _Drive] = {}


class Drive(Remembering[_Memory]):
    """Registers starts and stops of each base.

    A stop is ``unexpected`` when a fresh command still asked for motion, or when the base braked harder than ``hard_mps2``
    (default 2.0) without a command to stop. Any coming to rest shows the outcome ``stopped``; moving on after an unexpected
    stop ``recovered``.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())
        self._hard_mps2 = number(spec.settings, "hard_mps2") or 2.0

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Take up a command, or compare an odometry message with the last one and with the command."""
        memory = self.memory
        seen = memory.bases.see(observation)
        if memory.commands.see(observation, memory.bases.clock.now_ns or 0) or seen is None:
            return
        motion, phase = seen
        drive = memory.drives.setdefault(observation.topic, _Drive())
        drive.speeds = [one for one in drive.speeds if 0 <= observation.at_ns - one[0] <= _WINDOW_NS][-200:]
        drive.speeds.append((observation.at_ns, motion.speed_mps))
        asked = memory.commands.of(observation.topic, seen[0].heard_ns)
        if phase is Phase.RAISED:
            if drive.unexpected:
                yield Shown(label="recovered", entity=memory.bases.name(observation.topic))
            yield self._start(observation.topic, motion, asked.anything)
        elif phase is Phase.CLEARED:
            yield Shown(label="stopped")
            stop = self._stop(observation.topic, motion, asked.least, drive)
            drive.unexpected = stop.kind == "unexpected_stop"
            yield stop

    def _start(self, topic: str, motion: Motion, asked: bool) -> Found:
        unasked = bool(self.memory.commands.by_topic) and not asked
        return Found(
            kind="start",
            entity=self.memory.bases.name(topic),
            fields={**motion.fields(), "commanded": not unasked, "severity": 0.4 if unasked else 0.1},
            says=f"The base began to move ({motion.says()}){', though no command asked for it' if unasked else ''}.",
            criticality=2 if unasked else 0,
        )

    def _stop(self, topic: str, motion: Motion, command: Command | None, drive: _Drive) -> Found:
        before_mps, braking_mps2 = _braking(drive.speeds)
        asked = command is not None and command.asks
        told = command is not None and not asked
        unexpected = asked or (braking_mps2 >= self._hard_mps2 and not told)
        because = "though a command still asked for motion" if asked else "as commanded" if told else "without a command in sight"
        fields: dict[str, Field] = {
            **motion.fields(),
            "speed_mps": within(before_mps, 0.0, 20.0),
            "braking_mps2": within(braking_mps2, 0.0, 20.0),
            "commanded": told,
            "severity": 0.6 if unexpected else 0.1,
        }
        return Found(
            kind="unexpected_stop" if unexpected else "stop",
            entity=self.memory.bases.name(topic),
            fields=fields,
            says=(
                f"The base came to rest from {before_mps:.2f} m/s, braking at {braking_mps2:.1f} m/s², {because}."
                if before_mps >= MOVING_MPS / 2
                else f"The base stopped turning, {because}."
            ),
            criticality=2 if unexpected else 0,
            deadline_s=10.0 if unexpected else None,
        )


def _braking(speeds: list[tuple[int, float]]) -> tuple[float, float]:
    """The greatest of these speeds, and the hardest braking between two instants at least 0.1 s apart."""
    top = max((speed for _, speed in speeds), default=0.0)
    hardest = 0.0
    for index, (at_ns, speed) in enumerate(speeds):
        later = next((one for one in speeds[index + 1 :] if one[0] - at_ns >= 100_000_000), None)
        if later is not None:
            hardest = max(hardest, (speed - later[1]) / to_s(later[0] - at_ns))
    return top, hardest
