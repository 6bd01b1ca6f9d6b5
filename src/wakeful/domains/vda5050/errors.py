"""The errors that a vehicle lists: each one lasting condition, however many messages repeat it."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from wakeful.domains.vda5050.lasting import Lasting
from wakeful.domains.vda5050.message import LEVELS, Error, StateMessage
from wakeful.domains.vda5050.sign import CRITICALITY, Sign
from wakeful.facts.events import Phase
from wakeful.facts.time import NS_PER_S
from wakeful.facts.values import Field

SWAPS = 3
SWAP_NS = 60 * NS_PER_S
TYPES = 128

_ABOUT = (
    ("localization", ("locali", "position", "pose", "map", "slam", "marker")),
    ("obstacle", ("obstacle", "blocked", "collision", "object", "person")),
    ("safety", ("scanner", "protective", "emergency", "safety", "bumper", "field")),
    ("energy", ("batter", "charg", "voltage", "power", "energy")),
    ("load", ("load", "pallet", "fork", "lift", "gripper", "conveyor", "pick", "drop")),
    ("communication", ("wifi", "wlan", "network", "connect", "communicat", "mqtt", "broker", "timeout")),
    ("drive", ("drive", "motor", "wheel", "steer", "brake", "encoder", "temperature", "traction")),
    ("order", ("order", "route", "node", "edge", "validation", "noroute", "action", "instant", "horizon", "base")),
)


class Errors(msgspec.Struct):
    """What is remembered of a vehicle's errors.

    ``listed``: as last sent, by name. ``swaps``: how often an error was replaced within a minute by one of the same type with
    other references; after SWAPS such references are noise, and the type alone is the condition (``volatile``).
    """

    lasting: Lasting = msgspec.field(default_factory=Lasting)
    listed: dict[str, Error] = {}
    swaps: dict[str, int] = {}
    volatile: list[str] = []

    @property
    def worst(self) -> int:
        """The highest level that is open."""
        return max((entry.level for entry in self.lasting.open.values()), default=0)


def look(message: StateMessage, memory: Errors, at_ns: int) -> Iterator[Sign]:
    """What the message's errors show. A message without a list of errors says nothing about them."""
    if message.errors is None:
        return
    now: dict[str, Error] = {}
    for error in message.errors:
        plain = error if error.type not in memory.volatile else msgspec.structs.replace(error, references=())
        name = _name(plain)
        if name not in now or now[name].level < plain.level:
            now[name] = plain
    _note_swaps(now, memory, at_ns)
    for name, error in now.items():
        before = memory.lasting.open.get(name)
        level = 0 if before is None else before.level
        phase = memory.lasting.see(name, error.level, at_ns)
        memory.listed[name] = error
        if phase is not None:
            yield _sign(error, phase, rose=phase is Phase.CHANGED and error.level > level)
    for name in [name for name in memory.listed if name not in now]:
        phase = memory.lasting.see(name, 0, at_ns)
        if phase is Phase.CLEARED:
            yield _sign(memory.listed[name], phase)
        if name not in memory.lasting.open:
            del memory.listed[name]


def about(error: Error) -> str:
    """What an error is about, from the words of its type, else of its description; ``other`` where they don't say.

    >>> about(Error(type="localizationError", level=1)), about(Error(type="E-4711", level=1, says="Battery voltage low"))
    ('localization', 'energy')
    """
    for words in (error.type.lower(), error.says.lower()):
        for topic, stems in _ABOUT:
            if any(stem in words for stem in stems):
                return topic
    return "other"


def _note_swaps(now: dict[str, Error], memory: Errors, at_ns: int) -> None:
    gone = {
        memory.listed[name].type
        for name, entry in memory.lasting.open.items()
        if name not in now and name in memory.listed and at_ns - entry.since_ns < SWAP_NS
    }
    for error in now.values():
        if error.references and error.type in gone and _name(error) not in memory.lasting.open:
            gone.discard(error.type)
            memory.swaps[error.type] = memory.swaps.get(error.type, 0) + 1
            if memory.swaps[error.type] >= SWAPS:
                del memory.swaps[error.type]
                memory.volatile = [*memory.volatile[-(TYPES - 1) :], error.type]
    while len(memory.swaps) > TYPES:
        del memory.swaps[next(iter(memory.swaps))]


def _sign(error: Error, phase: Phase, rose: bool = False) -> Sign:
    level = LEVELS[error.level].upper()
    fields: dict[str, Field] = {"error": error.type, "about": about(error)}
    fields["text"] = f"{error.type}: {error.says}"[:200] if error.says else error.type
    if error.hint:
        fields["hint"] = error.hint
    where = f" ({', '.join(error.references)})" if error.references else ""
    words = f": {error.says}" if error.says else ""
    done = {Phase.RAISED: "reports", Phase.CHANGED: "now reports", Phase.CLEARED: "no longer reports"}.get(phase, "still reports")
    return Sign(
        kind="error",
        type=error.type,
        references=error.references,
        phase=phase,
        level=error.level,
        criticality=CRITICALITY[error.level],
        rose=rose,
        stops=error.level == len(LEVELS) - 1 and (phase is Phase.RAISED or rose),
        fields=fields,
        says=f"{done} {level} {error.type}{where}{words}",
    )


def _name(error: Error) -> str:
    return "|".join((error.type, *error.references))
