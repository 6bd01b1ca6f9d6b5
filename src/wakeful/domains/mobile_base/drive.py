"""Driving: the base begins to move and comes to rest, asked for or not, and stalls against what it was told."""

from __future__ import annotations

from collections.abc import Iterator
from math import hypot

import msgspec

from wakeful.contracts.detector import Found, Shown
from wakeful.domains.latch import Latch
from wakeful.domains.mobile_base.messages import is_command, nearest_topic
from wakeful.domains.mobile_base.motion import MOVING_MPS, MOVING_RADPS, Bases, Motion
from wakeful.domains.plain import number, within
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns, to_s
from wakeful.facts.values import Field

_FRESH_NS = to_ns(1.0)
"""A command that is older than this asks for nothing."""
_SHARE = 0.2
"""Less than this share of what was asked for is a stall."""
_WINDOW_NS = to_ns(1.0)


class Command(msgspec.Struct):
    """The last command of one topic."""

    at_ns: int
    speed_mps: float
    turn_radps: float


class _Drive(msgspec.Struct):
    stall: Latch = msgspec.field(default_factory=Latch)
    speeds: list[tuple[int, float]] = []
    """(instant, speed) of the last second: how hard it braked."""


class _Memory(msgspec.Struct):
    bases: Bases = msgspec.field(default_factory=Bases)
    commands: dict[str, Command] = {}
    drives: dict[str, _Drive] = {}


class Drive(Remembering[_Memory]):
    """Registers starts and stops of each base, and a stall as a lasting condition.

    A stop is ``unexpected`` when a fresh command still asked for motion, or when the base braked harder than ``hard_mps2``
    (default 2.0) without a command to stop. Any coming to rest shows the outcome ``stopped``; a stall that ends ``recovered``.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())
        self._hard_mps2 = number(spec.settings, "hard_mps2") or 2.0
        self._hold_ns = to_ns(number(spec.settings, "stall_s") or 1.0)

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Take up a command, or compare an odometry message with the last one and with the command."""
        memory = self.memory
        if is_command(observation):
            forward, turn = number(observation.values, "vx"), number(observation.values, "wz")
            if forward is not None and turn is not None and (observation.topic in memory.commands or len(memory.commands) < 16):
                speed = hypot(forward, number(observation.values, "vy") or 0.0)
                memory.commands[observation.topic] = Command(observation.at_ns, speed, abs(turn))
            return
        if (seen := memory.bases.see(observation)) is None:
            return
        motion, phase = seen
        drive = memory.drives.setdefault(observation.topic, _Drive())
        drive.speeds = [one for one in drive.speeds if 0 <= observation.at_ns - one[0] <= _WINDOW_NS][-100:]
        drive.speeds.append((observation.at_ns, motion.speed_mps))
        command, asked = self._command(observation)
        if phase is Phase.RAISED:
            yield self._start(observation.topic, motion, asked)
        elif phase is Phase.CLEARED:
            yield Shown(label="stopped")
            yield self._stop(observation.topic, motion, command, drive)
        yield from self._stall(observation, motion, command, drive)

    def _command(self, observation: Observation) -> tuple[Command | None, bool]:
        """What is asked of the base of this odometry now, and whether anything is.

        Several may command it, and which of them is obeyed is not recorded. So motion is asked for when one asks for it, and
        only what is the least of all fresh commands is due.
        """
        commands = self.memory.commands
        nearest = nearest_topic(observation.topic, list(commands))
        space = "" if nearest is None else nearest.rpartition("/")[0]
        fresh = [
            one
            for topic, one in commands.items()
            if nearest is not None and topic.rpartition("/")[0] == space and 0 <= observation.at_ns - one.at_ns <= _FRESH_NS
        ]
        least = min(fresh, key=lambda one: (_asks(one), one.speed_mps, one.turn_radps), default=None)
        return least, any(_asks(one) for one in fresh)

    def _start(self, topic: str, motion: Motion, asked: bool) -> Found:
        unasked = bool(self.memory.commands) and not asked
        return Found(
            kind="start",
            entity=self.memory.bases.name(topic),
            fields={**motion.fields(), "commanded": not unasked, "severity": 0.4 if unasked else 0.1},
            says=f"The base began to move ({motion.says()}){', though no command asked for it' if unasked else ''}.",
            criticality=2 if unasked else 0,
        )

    def _stop(self, topic: str, motion: Motion, command: Command | None, drive: _Drive) -> Found:
        before_mps, braking_mps2 = _braking(drive.speeds)
        asked = command is not None and _asks(command)
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
            says=f"The base came to rest from {before_mps:.2f} m/s, braking at {braking_mps2:.1f} m/s², {because}.",
            criticality=2 if unexpected else 0,
            deadline_s=10.0 if unexpected else None,
        )

    def _stall(self, observation: Observation, motion: Motion, command: Command | None, drive: _Drive) -> Iterator[Seen]:
        wanted = command is not None and _asks(command)
        stalled = (
            command is not None
            and wanted
            and motion.speed_mps <= _SHARE * command.speed_mps
            and abs(motion.turning_radps) <= _SHARE * command.turn_radps
        )
        phase = drive.stall.see(int(stalled), observation.at_ns, self._hold_ns, to_ns(0.3))
        if phase is None:
            return
        entity = self.memory.bases.name(observation.topic)
        if phase is Phase.CLEARED:
            yield Shown(label="recovered", entity=entity)
        asked = "" if command is None else f"{command.speed_mps:.2f} m/s and {command.turn_radps:.2f} rad/s asked for"
        yield Found(
            kind="stall",
            entity=entity,
            fields={
                **motion.fields(),
                "commanded_mps": 0.0 if command is None else within(command.speed_mps, 0.0, 20.0),
                "commanded": wanted,
                "severity": 0.8,
            },
            says=(
                f"The base does not do what it is told for {to_s(self._hold_ns):.1f} s: {asked}; {motion.speed_mps:.2f} m/s and"
                f" {abs(motion.turning_radps):.2f} rad/s measured."
                if phase is Phase.RAISED
                else f"The base moves again or is not asked to any more ({motion.says()})."
            ),
            criticality=2,
            deadline_s=10.0,
            phase=phase,
            type="stall",
            references=(entity,),
        )


def _asks(command: Command) -> bool:
    """Whether a command asks for motion at all."""
    return command.speed_mps >= MOVING_MPS or command.turn_radps >= MOVING_RADPS


def _braking(speeds: list[tuple[int, float]]) -> tuple[float, float]:
    """The greatest speed of the last second, and the hardest braking between two instants at least 0.1 s apart."""
    top = max((speed for _, speed in speeds), default=0.0)
    hardest = 0.0
    for index, (at_ns, speed) in enumerate(speeds):
        later = next((one for one in speeds[index + 1 :] if one[0] - at_ns >= 100_000_000), None)
        if later is not None:
            hardest = max(hardest, (speed - later[1]) / to_s(later[0] - at_ns))
    return top, hardest
