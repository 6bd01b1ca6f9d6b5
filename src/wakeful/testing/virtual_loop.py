"""An event loop in virtual time, and executors that belong to it: a live mind runs in it at once, and twice the same."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


class NobodyWakes(RuntimeError):
    """Everything waits, and nothing will ever happen: something was forgotten."""


class VirtualLoop(asyncio.BaseEventLoop):
    """asyncio without a clock, sockets or threads: where nothing is ready, time goes on to the next timer.

    Args:
        start_s: what its time is at first.
    """

    def __init__(self, start_s: float = 0.0) -> None:
        super().__init__()
        self._now_s = start_s
        self._selector = _Waiting(self)
        self._over: BaseException | None = None

    def time(self) -> float:
        """Virtual seconds."""
        return self._now_s

    def go_on(self, seconds: float | None) -> None:
        """Nothing is ready for so long. Raises NobodyWakes where that is for ever."""
        if seconds is None:
            raise NobodyWakes("everything waits and no timer is set")
        self._now_s += seconds

    def end(self, error: BaseException) -> None:
        """The process is dead, as far as this loop is concerned: nothing more of it runs, and ``error`` is raised."""
        self._over = error
        for handle in self._ready:  # type: ignore[attr-defined]
            handle.cancel()

    def _run_once(self) -> None:
        if self._over is not None:
            raise self._over
        super()._run_once()  # type: ignore[misc]

    def _process_events(self, event_list: list[object]) -> None:
        """There are none."""

    def _write_to_self(self) -> None:
        """Nobody sleeps outside."""


class _Waiting:
    """Stands where a selector would."""

    def __init__(self, loop: VirtualLoop) -> None:
        self._loop = loop

    def select(self, timeout: float | None) -> list[object]:
        self._loop.go_on(timeout)
        return []


class Beside(Executor):
    """One thread, as far as whoever waits for it can tell: what it is given is done in order, each later in virtual time.

    Args:
        loop: in whose time.
        takes_s: how long the next one takes.
    """

    def __init__(self, loop: VirtualLoop, takes_s: Callable[[], float]) -> None:
        self._loop = loop
        self._takes_s = takes_s
        self._free_s = 0.0

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Do it once its turn has come."""
        future: Future[T] = Future()
        self._free_s = max(self._free_s, self._loop.time()) + self._takes_s()

        def do() -> None:
            try:
                future.set_result(fn(*args, **kwargs))
            except Exception as error:
                future.set_exception(error)

        self._loop.call_at(self._free_s, do)
        return future
