"""``stall``: what is commanded is not what is measured: the wheels are told to turn, and don't."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from wakeful.contracts.detector import Found
from wakeful.contracts.domain import DomainError
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.registration.channels import Channels, named
from wakeful.registration.detectors.base import NotNegative, Positive, Seen, Settings, Share, settings_of, short
from wakeful.registration.plain import elapsed_s, number


class StallSettings(Settings, frozen=True):
    """What `stall` may be told.

    ``commanded``, ``measured``: the two channels; ``moving``: from which size a command counts; ``share``: less than this
    share of it measured is a stall; ``hold_s``: for so long; ``stale_s``: a command older than this is none.
    """

    commanded: str = ""
    measured: str = ""
    moving: NotNegative = 0.05
    share: Share = 0.3
    hold_s: NotNegative = 1.0
    stale_s: Positive = 1.0


class Effort(msgspec.Struct):
    """The last command, and since when it has not been followed."""

    command: float = 0.0
    command_ns: int | None = None
    since_ns: int | None = None
    raised: bool = False


class StallDetector:
    """Compares each measured value with the last command, both without their sign."""

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:
        self.spec = spec
        self._robot = domain.robot
        self._settings = settings_of(spec, StallSettings)
        if not self._settings.commanded or not self._settings.measured:
            raise DomainError(f"detect {spec.kind!r} (stall): give settings.commanded and settings.measured, a channel each")
        self.channels = Channels((self._settings.commanded, self._settings.measured))
        self._commanded = Channels((self._settings.commanded,))
        self._measured = Channels((self._settings.measured,))
        self._effort = Effort()

    def observe(self, observation: Observation) -> Iterable[Seen]:
        """Take up a command, a measured value, or both."""
        found: list[Seen] = []
        for _, value in self._commanded.of(observation):
            if (command := number(value)) is not None:
                self._effort.command, self._effort.command_ns = abs(command), observation.at_ns
        for channel, value in self._measured.of(observation):
            if (measured := number(value)) is not None and (seen := self._compare(channel, abs(measured), observation)):
                found.append(seen)
        return found

    def state(self) -> bytes:
        """The last command, and since when it has not been followed."""
        return msgspec.msgpack.encode(self._effort)

    def restore(self, state: bytes) -> None:
        """Take up what ``state`` gave out."""
        self._effort = msgspec.msgpack.decode(state, type=Effort)

    def _compare(self, channel: str, measured: float, observation: Observation) -> Found | None:
        effort, settings, at_ns = self._effort, self._settings, observation.at_ns
        fresh = elapsed_s(at_ns, effort.command_ns) <= settings.stale_s
        if not fresh or effort.command < settings.moving or measured >= settings.share * effort.command:
            was_raised, effort.since_ns, effort.raised = effort.raised, None, False
            return self._found(channel, measured, 0.0, Phase.CLEARED, observation) if was_raised else None
        if effort.since_ns is None:
            effort.since_ns = at_ns
        lasted_s = elapsed_s(at_ns, effort.since_ns)
        if effort.raised or lasted_s < settings.hold_s:
            return None
        effort.raised = True
        return self._found(channel, measured, lasted_s, Phase.RAISED, observation)

    def _found(self, channel: str, measured: float, lasted_s: float, phase: Phase, observation: Observation) -> Found:
        command = self._effort.command
        entity = named(self.spec.entity, channel, observation.topic, observation.robot or self._robot)
        lasted = {} if lasted_s == float("inf") else {"lasted_s": short(lasted_s)}
        return Found(
            fields={"channel": channel, "commanded": short(command), "measured": short(measured), **lasted},
            says=f"{self.spec.says or self.spec.kind}: {command:.3g} commanded, {measured:.3g} measured",
            entity=entity,
            phase=phase,
            type=self.spec.kind,
            references=(entity,),
        )
