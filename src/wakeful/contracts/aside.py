"""The contract of what holds parked processes: put away by number, and taken back."""

from __future__ import annotations

from typing import Protocol


class AsideFull(Exception):
    """Nothing more can be put away for now; the message says why. What was put away before is still there."""


class Aside(Protocol):
    """Bytes by process, out of memory. It need not survive a crash: recovery folds the journal, which has all of it."""

    def put(self, process: int, text: bytes) -> None:
        """Put a process away. Raises AsideFull where there is no room."""

    def take(self, process: int) -> bytes:
        """Take it back; it is held no longer. Raises KeyError where it was not put away."""

    def close(self) -> None:
        """Give everything up that was put away."""
