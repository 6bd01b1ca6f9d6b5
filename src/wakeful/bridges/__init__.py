"""One bridge for each kind of outside world, and which of them reads a path."""

from __future__ import annotations

from pathlib import Path

from wakeful.bridges.jsonl import STDIN, JsonlBridge
from wakeful.bridges.mcap import McapBridge
from wakeful.bridges.rosbag import RosbagBridge
from wakeful.bridges.ulog import UlogBridge
from wakeful.bridges.xlsx import XlsxBridge
from wakeful.contracts.bridge import Bridge, SourceError


def bridges(incarnation: str = "") -> tuple[Bridge, ...]:
    """All bridges, in the order in which they are asked whether they read a path.

    Args:
        incarnation: what stands for the digest of standard input; fresh where empty.
    """
    return (McapBridge(), RosbagBridge(), UlogBridge(), XlsxBridge(), JsonlBridge(incarnation))


def bridge_for(path: Path, incarnation: str = "") -> Bridge:
    """The bridge that reads ``path`` (``-``: standard input).

    Raises:
        SourceError: there is no such file, or no bridge reads it.
    """
    known = bridges(incarnation)
    try:
        if path != STDIN and not path.exists():
            raise SourceError(f"there is no file or directory {path}")
    except OSError as failure:
        raise SourceError(f"{path} cannot be looked at: {failure.strerror or failure}") from failure
    for bridge in known:
        if bridge.claims(path):
            return bridge
    names = ", ".join(sorted(bridge.name for bridge in known))
    raise SourceError(f"nothing reads {path}; there are bridges for {names} (docs/bridges.md says which files are whose)")


__all__ = ["bridge_for", "bridges"]
