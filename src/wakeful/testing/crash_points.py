"""Crashes at named points, within this process: what is not committed is forgotten, as if it had been killed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from wakeful.facts.crash_points import CRASH_POINTS, UnknownCrashPoint, armed


class Crashed(BaseException):
    """The process would be dead now. No Exception, so that nothing on the way takes it for an error to be handled."""


@contextmanager
def crashing(name: str, nth: int = 1, first: Callable[[], None] | None = None) -> Iterator[None]:
    """Within it ``Crashed`` is raised where the named crash point is reached for the n-th time, and at any later one.

    ``first`` is called just before that: to cut a faulty disk's power, say. Whoever uses it drops kernel and driver then, closes
    the journal's file, and begins anew on it.

    Raises:
        UnknownCrashPoint: there is none of that name.
    """
    if name not in CRASH_POINTS:
        raise UnknownCrashPoint(f"there is no crash point {name!r}; there are {', '.join(map(repr, CRASH_POINTS))}")
    left = nth

    def crash(reached: str) -> None:
        nonlocal left
        left -= reached == name
        if left <= 0:
            if first is not None:
                first()
            raise Crashed(f"{name}@{nth}")

    with armed(crash):
        yield
