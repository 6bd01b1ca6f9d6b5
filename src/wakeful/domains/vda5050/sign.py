"""What one part of the watch over a vehicle found in a message, before it is an event."""

from __future__ import annotations

import msgspec

from wakeful.facts.events import Phase
from wakeful.facts.values import Field

CRITICALITY = (0, 1, 2, 2, 3)
"""What the levels none, warning, urgent, critical and fatal mean for attention."""

DEADLINE_S = {3: 10.0, 2: 60.0}


class Sign(msgspec.Struct, frozen=True, kw_only=True):
    """``type`` names the condition where ``phase`` is set; ``level`` indexes LEVELS of the message.

    ``rose``: a change for the worse. ``stops``: the vehicle came to a stop that it can't leave by itself.
    """

    kind: str
    says: str
    type: str = ""
    phase: Phase | None = None
    level: int = 0
    references: tuple[str, ...] = ()
    fields: dict[str, Field] = {}
    criticality: int | None = None
    rose: bool = False
    stops: bool = False
