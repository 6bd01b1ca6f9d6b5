"""Progress on a terminal, the pace of a replay, and a clean stop on ctrl-C."""

from __future__ import annotations

import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

import click

from wakeful.journal.wording.words import count, duration

_EVERY_S = 0.1
_BAR = 24


class Stop:
    """Whether the user asked to stop, and the signal that said so. A second one interrupts at once."""

    def __init__(self) -> None:
        self._asked = threading.Event()
        self.signal = 0

    @property
    def asked(self) -> bool:
        """Whether to stop after the present item."""
        return self._asked.is_set()

    def pause(self, seconds: float) -> None:
        """Wait, unless a stop is asked for meanwhile."""
        self._asked.wait(seconds)

    def take(self, number: int, _frame: FrameType | None) -> None:
        """The signal handler."""
        if self.asked:
            raise KeyboardInterrupt
        self.signal = number
        self._asked.set()


@contextmanager
def stoppable() -> Iterator[Stop]:
    """Turn ctrl-C and a termination into a stop at the next item, so that what was done is committed."""
    stop = Stop()
    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before = {number: signal.signal(number, stop.take) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class Progress:
    """A bar on standard error where that is a terminal, and nothing where it is not.

    Args:
        total: the items in all; None where nobody knows.
    """

    def __init__(self, total: int | None) -> None:
        self._total = total
        self._shown = sys.stderr.isatty()
        self._began_s = time.monotonic()
        self._next_s = 0.0

    def show(self, done: int, events: int) -> None:
        """Say how far it is, at most ten times a second."""
        if not self._shown or time.monotonic() < self._next_s:
            return
        now_s = time.monotonic()
        self._next_s = now_s + _EVERY_S
        elapsed_s = now_s - self._began_s
        if self._total:
            share = min(1.0, done / self._total)
            left = f", {duration(elapsed_s / share - elapsed_s)} left" if share > 0.01 else ""
            filled = "█" * round(share * _BAR)
            text = f"{filled.ljust(_BAR, '░')} {share:4.0%}  {done:,} of {self._total:,} items, {events:,} events{left}"
        else:
            text = f"{count(done, 'item')}, {count(events, 'event')}, {duration(elapsed_s)}"
        click.echo(f"\r\x1b[K{text}", nl=False, err=True)

    def clear(self) -> None:
        """Take the bar away."""
        if self._shown:
            click.echo("\r\x1b[K", nl=False, err=True)
