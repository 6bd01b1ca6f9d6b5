"""Crash points: the named places at which a crash could matter. Unarmed, reaching one costs a comparison with None.

    WAKEFUL_CRASH_AT="commit: lines written@3" wakeful run service_robot

kills the process, by SIGKILL, when it gets to that place for the third time. The tests do so at every name, and start it again.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

#: Read once, when wakeful is imported: the name of a crash point, and ``@n`` for the n-th time that it is reached.
CRASH_AT = "WAKEFUL_CRASH_AT"

#: Every crash point, with what a crash there leaves behind. Whoever writes a ``reach`` names it here: a test compares the two.
CRASH_POINTS: dict[str, str] = {
    "journal: file made": "an empty file and its lock, no schema",
    "journal: schema written": "an uncommitted schema",
    "recovery: begun": "the journal as it was; nothing of it is in memory",
    "recovery: folded": "every record was applied again; no coroutine is rebuilt",
    "recovery: rebuilt": "coroutines stand where they stood; what had to be mended is not committed",
    "recovery: committed": "what had to be mended is committed; the calls under way are not made again",
    "feed: decided": "the kernel has decided; nothing of it is written",
    "commit: begun": "a transaction without a line",
    "commit: lines written": "lines in an open transaction; state and blobs are not in it",
    "commit: state written": "all of the commit but its COMMIT",
    "commit: done": "a durable commit that nobody acted on",
    "acting: call": "a call was recorded as asked; it is not made",
    "acting: call made": "somebody outside has done it; its answer is not recorded",
    "acting: training": "a training was recorded as asked; it is not begun",
    "publication: trained": "the weights are in memory alone",
    "publication: decided": "the new version selects; neither its weights nor its record are committed",
    "publication: committed": "the new version is durable; nothing has been selected with it",
    "migration: backed up": "the journal in its older schema, and a verified copy of it",
    "migration: rewritten": "the journal in its older schema, its copy, and beside them the same journal in today's",
    "migration: done": "the journal in today's schema, and the copy of what it was",
    "compaction: begun": "what will stand in the place of old rows is being put beside them; it is not the journal's yet",
    "compaction: rows replaced": "all of it is there; the journal is about to be counted on to it",
    "compaction: done": "a part of the past is replaced by its counts, durably; the old rows still take up the disk",
    "acts: fed": "an operator's act has been done and is not committed; it still lies in its folder",
    "acts: committed": "the act is durable and still lies in its folder",
}

Action = Callable[[str], None]


class UnknownCrashPoint(Exception):
    """There is no crash point of that name. The message lists those that there are."""


def reach(name: str) -> None:
    """Say that the named place was reached. Does nothing unless it was armed."""
    if _armed is not None:
        _armed(name)


@contextmanager
def armed(action: Action) -> Iterator[None]:
    """Within it ``action`` is called with the name of each crash point that is reached, in whatever thread."""
    global _armed  # noqa: PLW0603
    before, _armed = _armed, action
    try:
        yield
    finally:
        _armed = before


def killing(where: str) -> Action:
    """The action that kills this process at a place, written ``name`` or ``name@n``.

    Raises:
        UnknownCrashPoint: there is none of that name.

    >>> killing("commit: undone")
    Traceback (most recent call last):
    wakeful.facts.crash_points.UnknownCrashPoint: there is no crash point 'commit: undone'; there are ...
    """
    name, _, nth = where.partition("@")
    if name not in CRASH_POINTS:
        raise UnknownCrashPoint(f"there is no crash point {name!r}; there are {', '.join(map(repr, CRASH_POINTS))}")
    left = int(nth or "1")

    def kill(reached: str) -> None:
        nonlocal left
        left -= reached == name
        if left == 0:
            os.write(2, f"{CRASH_AT}: killed at {where!r}\n".encode())
            os.kill(os.getpid(), signal.SIGKILL)

    return kill


_armed: Action | None = killing(os.environ[CRASH_AT]) if os.environ.get(CRASH_AT) else None
