"""What a treatment's coroutine yields to the kernel: one value per kind of await."""

from __future__ import annotations

from collections.abc import Generator
from hashlib import blake2b
from types import coroutine
from typing import TypeVar

import msgspec

from wakeful.facts.asking import Kind, Query, Question, Safety
from wakeful.facts.events import Event
from wakeful.facts.inputs import Outside

T = TypeVar("T")


class Work(msgspec.Struct):
    """Steps of cognitive effort still to be spent. Not recorded one by one."""

    left: int


class Want(msgspec.Struct, frozen=True, kw_only=True):
    """A request as the coroutine made it, before it has a sequence number."""

    kind: Kind
    key: str
    within_s: float | None
    count: int = 1
    safety: Safety = "read"
    query: Query | None = None
    question: Question | None = None
    event: Event | None = None
    role: str = ""
    function: Outside | None = None

    def digest(self) -> str:
        """Digest of the arguments, by which a recorded answer is known to fit this request."""
        # An event by its repr: as JSON, one that was read back names defaults that one which was just made leaves out.
        event = None if self.event is None else repr(self.event)
        args = msgspec.json.encode((self.key, self.count, self.query, self.question, event, self.role))
        return blake2b(args, digest_size=8).hexdigest()


@coroutine
def give(want: Work | Want) -> Generator[Work | Want, object, object]:
    """Hand a want to whoever drives the coroutine, and take the answer back."""
    return (yield want)


@coroutine
def nothing() -> Generator[Work | Want, object, None]:
    """What is awaited where nothing is to be done."""
    yield from ()
