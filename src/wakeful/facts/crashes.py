"""What is known of an event whose treatment ended the process that ran the mind: how it is marked, recorded and counted."""

from __future__ import annotations

from typing import Protocol, overload

#: What a Noted says of an event whose step was running when the process ended; ``detail`` names the run that ended.
CRASHED = "crashed while it was treated"

#: What a Noted says of an event that is not treated any more, because that ended the process too often.
QUARANTINED = "quarantined"

#: So many bytes of the page hold the id of the event whose step is running; the first is 0 while none is.
MARKED = 20


class Page(Protocol):
    """Bytes that outlive the process: while a treatment's code runs, they hold its event's id. A ``bytearray`` will do."""

    @overload
    def __setitem__(self, place: int, value: int, /) -> None: ...
    @overload
    def __setitem__(self, place: slice, value: bytes, /) -> None: ...


def mark(page: Page, event: str) -> None:
    """Say whose step is running now; ``page[0] = 0`` takes it back."""
    identity = event.encode()
    page[:MARKED] = identity if len(identity) == MARKED else identity[:MARKED].ljust(MARKED)
