"""One limit in time around an answer, retries and waits included."""

from __future__ import annotations

import asyncio
from types import TracebackType


class Deadline:
    """An ``asyncio.timeout`` that can say how much of it is left, and whether it was what cancelled a call.

    Leaving the block after it passed raises TimeoutError.

    Args:
        seconds: how long the whole block may take, from entering it.
    """

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self._timeout = asyncio.timeout(None)

    async def __aenter__(self) -> Deadline:
        await self._timeout.__aenter__()
        self._timeout.reschedule(asyncio.get_running_loop().time() + self.seconds)
        return self

    async def __aexit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        await self._timeout.__aexit__(kind, error, at)

    @property
    def remaining_s(self) -> float:
        """Seconds left; 0 when it has passed."""
        until_s = self._timeout.when()
        return 0.0 if until_s is None else max(0.0, until_s - asyncio.get_running_loop().time())

    @property
    def passed(self) -> bool:
        """Whether the limit has cancelled the block."""
        return self._timeout.expired()
