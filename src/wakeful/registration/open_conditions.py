"""The conditions that last: which key is open, so that one that lasts is one event and not a flood."""

from __future__ import annotations

from typing import Final

import msgspec

from wakeful.contracts.detector import Found
from wakeful.facts.events import Phase

KEPT: Final = 2048


class OpenConditions:
    """Decides what a detector's phase amounts to, given what is open. Of too many, the one longest unheard of is forgotten."""

    def __init__(self) -> None:
        self.open: dict[str, int] = {}

    def take(self, key: str, phase: Phase, at_ns: int) -> Phase | None:
        """The phase that holds: raised where it was not open, repeated where raised again; None for clearing what is not open."""
        was_open = self.open.pop(key, None) is not None
        if phase is Phase.CLEARED:
            return phase if was_open else None
        self.open[key] = at_ns
        if len(self.open) > KEPT:
            del self.open[next(iter(self.open))]
        if not was_open:
            return Phase.RAISED
        return Phase.REPEATED if phase is Phase.RAISED else phase

    def state(self) -> bytes:
        """What is open, as bytes."""
        return msgspec.msgpack.encode(self.open)

    def restore(self, state: bytes) -> None:
        """Take up what ``state`` gave out."""
        self.open = msgspec.msgpack.decode(state, type=dict[str, int])


def condition_key(found: Found, robot: str, source: str) -> str:
    """(robot, else zone; source; type; references), joined by ``|``. A ``|`` inside a part becomes ``/``."""
    parts = (robot or found.zone, source, found.type or found.kind, ",".join(found.references))
    return "|".join(part.replace("|", "/")[:200] for part in parts)
