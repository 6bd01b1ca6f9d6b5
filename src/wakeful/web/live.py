"""Changes of a page as server-sent events: each carries the parts that are other than before."""

from __future__ import annotations

import time
from collections.abc import AsyncIterator, Awaitable, Callable

import anyio
import msgspec

from wakeful.contracts.journal import JournalError
from wakeful.web.shell import Document

POLL_S = 0.5
"""How often the journal is asked for new lines."""
_SHARE = 4.0
"""A look is followed by a pause of so many times its length, so that big journals don't fill a core,"""
_LONGEST_S = 2.0
"""but never by a longer one than this."""
_QUIET = 30
"""After so many looks without news a comment keeps the connection from being taken for dead."""
_RETRY_MS = 2_000


class Streams:
    """All open streams of one page server.

    Args:
        pause: waits so many seconds; a test's own may do what it likes.
        ending: whether the server is about to end: streams then end by themselves.
        most: how many may be open at once.
    """

    def __init__(self, pause: Callable[[float], Awaitable[object]], ending: Callable[[], bool], most: int = 32) -> None:
        self._pause = pause
        self._ending = ending
        self._most = most
        self._open = 0

    @property
    def full(self) -> bool:
        """Whether no further stream may be opened."""
        return self._open >= self._most

    async def follow(self, last: Callable[[], int], look: Callable[[], Document], position: int) -> AsyncIterator[bytes]:
        """The changes of one page since ``position``, until the server ends or the reader goes.

        Args:
            last: the journal's last position; cheap, called in a thread.
            look: makes the page as of now; called in a thread, and only where there are new lines.
            position: of the page that the reader has.
        """
        self._open += 1
        try:
            yield f"retry: {_RETRY_MS}\n\n".encode()
            sent: dict[str, str] = {}
            quiet = 0
            while not self._ending():
                began_s = time.monotonic()
                try:
                    found = await anyio.to_thread.run_sync(last)
                    if found != position:
                        page = await anyio.to_thread.run_sync(look)
                        parts = {name: str(part) for name, part in page.parts.items() if sent.get(name) != part}
                        sent.update(parts)
                        position, quiet = page.position, 0
                        yield b"id: %d\n" % position + _message("parts", {"position": position, "parts": parts})
                except JournalError as error:
                    if position >= 0:
                        yield _message("trouble", {"says": str(error)})
                    position = -1
                quiet += 1
                if quiet % _QUIET == 0:
                    yield b": still here\n\n"
                await self._pause(min(_LONGEST_S, max(POLL_S, _SHARE * (time.monotonic() - began_s))))
        finally:
            self._open -= 1


def _message(name: str, value: object) -> bytes:
    """One event; JSON has no line break, so that one data line holds it."""
    return b"event: %b\ndata: %b\n\n" % (name.encode(), msgspec.json.encode(value))


def position_of(header: str, query: str) -> int:
    """The position that a reader has: of its last event where it reconnects, else of the page; 0 where neither says."""
    for text in (header, query):
        if text.isascii() and text.isdigit() and len(text) < 16:
            return int(text)
    return 0
