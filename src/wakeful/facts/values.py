"""The plain data that events, evidence and answers are made of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias

import msgspec

#: One field of a registered event. ``tuple`` holds a short numeric vector (a trace, a descriptor).
Field: TypeAlias = None | bool | int | float | str | tuple[float, ...]

#: Anything JSON can say: what a bridge delivers, before registration.
Value: TypeAlias = "None | bool | int | float | str | Sequence[Value] | Mapping[str, Value]"

#: JSON text that the kernel carries and records without looking inside.
Raw: TypeAlias = msgspec.Raw

NOTHING = msgspec.Raw(b"null")


class Fact(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, forbid_unknown_fields=True):
    """Base of every frozen value that is recorded or crosses a room's door."""
