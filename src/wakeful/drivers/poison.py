"""The mark of what is running, beside the journal: after a crash it says whose treatment ended the process (DESIGN section 3)."""

from __future__ import annotations

import inspect
import mmap
import os
import secrets
from collections.abc import Awaitable, Coroutine, Generator
from pathlib import Path
from typing import cast

import msgspec

from wakeful.contracts.journal import Journal, JournalError
from wakeful.facts.crashes import CRASHED, MARKED, Page, mark
from wakeful.facts.inputs import Call, Outside
from wakeful.facts.lines import Line, Noted

#: After a crash so many inputs are taken with care: each is durable before its treatment runs, so that the next crash has a name.
CAREFUL_INPUTS = 1_000

_RUN = slice(MARKED, MARKED + 16)
_BOOT = slice(_RUN.stop, _RUN.stop + 36)
_BYTES = _BOOT.stop


class Left(msgspec.Struct, frozen=True):
    """What the run before left behind: the event that it was treating when it ended, and the run's own name."""

    event: str
    run: str


class CrashMark:
    """The file ``<journal>.running``, mapped into memory: what is written to ``page`` outlives the process, at no system call.

    Nothing is synced: a process that dies leaves the page to the kernel of the operating system. After a restart of the machine
    the mark is not trusted, since nobody knows when the disk last heard of it.

    Args:
        journal: the journal's file, whose writer alone may hold its mark.

    Raises:
        JournalError: the file cannot be made.
    """

    def __init__(self, journal: Path) -> None:
        path = journal.with_name(journal.name + ".running")
        try:
            handle = os.open(path, os.O_CREAT | os.O_RDWR | os.O_NOFOLLOW, 0o600)
            try:
                os.fchmod(handle, 0o600)
                os.ftruncate(handle, _BYTES)
                self._map = mmap.mmap(handle, _BYTES)
            finally:
                os.close(handle)
        except OSError as error:
            raise JournalError(f"{path} cannot be written: {error.strerror}; it belongs beside the journal") from error

    @property
    def page(self) -> Page:
        """Where whoever runs treatments says whose step is running."""
        return self._map

    def left(self) -> Left | None:
        """What the run before was treating when it ended; None where it was treating nothing, or the machine has restarted."""
        event = self._map[:MARKED]
        if not event[0] or self._map[_BOOT] != _boot_id():
            return None
        return Left(event.decode(errors="replace").rstrip(), self._map[_RUN].decode(errors="replace"))

    def begin(self) -> None:
        """A run begins: it has a name of its own, and is treating nothing yet."""
        self._map[:_BYTES] = bytes(MARKED) + secrets.token_hex(8).encode() + _boot_id()

    def close(self) -> None:
        """The run has ended in good order."""
        self._map[0] = 0
        self._map.close()


def take_up(crash_mark: CrashMark | None, journal: Journal) -> Left | None:
    """Record what the run before was treating when it ended, before anything of it is run again; then begin a new run.

    Args:
        crash_mark: the mark beside the journal; None where there is no file.
        journal: open for writing, not yet recovered from.

    Returns:
        what was recorded; None where the run before ended in good order.

    Raises:
        JournalError: it could not be written.
    """
    if crash_mark is None:
        return None
    left = crash_mark.left()
    if left is not None:
        # A crash between this commit and ``begin`` records the same run again: whoever counts, counts runs.
        last = next(iter(journal.lines(journal.last - 1)), None) if journal.last else None
        record = Noted(what=CRASHED, detail=left.run, event=left.event)
        journal.commit([Line(journal.last + 1, last.at_ns if last is not None else 0, record)], {}, {})
    crash_mark.begin()
    return left


def marked(call: Call, crash_mark: CrashMark | None) -> Call:
    """The same call, with its event marked whenever the user's function runs. What it does in a thread of its own is not seen."""
    if crash_mark is None or call.function is None:
        return call
    event = call.key.rsplit("/", 2)[0]
    page, function = crash_mark.page, call.function
    return msgspec.structs.replace(call, function=lambda: _run(function, page, event))


async def _run(function: Outside, page: Page, event: str) -> object:
    mark(page, event)
    try:
        value = function()
    finally:
        page[0] = 0
    if inspect.iscoroutine(value):
        return await _Steps(value, page, event)
    return await cast("Awaitable[object]", value) if inspect.isawaitable(value) else value


class _Steps:
    """A coroutine whose event is marked at each of its steps, and at no time between them."""

    def __init__(self, inner: Coroutine[object, object, object], page: Page, event: str) -> None:
        self._inner = inner
        self._page = page
        self._event = event

    def __await__(self) -> Generator[object, object, object]:
        error: BaseException | None = None
        came: object = None
        while True:
            mark(self._page, self._event)
            try:
                wanted = self._inner.send(came) if error is None else self._inner.throw(error)
            except StopIteration as stop:
                return stop.value
            finally:
                self._page[0] = 0
            error, came = None, None
            try:
                came = yield wanted
            except BaseException as thrown:  # a cancellation too: it is the inner coroutine's to take
                error = thrown


def _boot_id() -> bytes:
    try:
        found = Path("/proc/sys/kernel/random/boot_id").read_bytes().strip()
    except OSError:
        found = b""
    return found[:36].ljust(36)
