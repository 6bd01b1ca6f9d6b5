"""How much a source looks like a domain."""

from __future__ import annotations

from fnmatch import fnmatchcase
from pathlib import Path

from wakeful.contracts.bridge import Peek
from wakeful.facts.domain import Recognise

_CHANNEL, _SUFFIX, _BRIDGE = 100, 10, 1


def score(wanted: Recognise, peek: Peek, path: Path) -> int:
    """Points for a source, 0 where it is none of this domain's. All that is declared must hold; nothing declared is 0.

    A channel pattern may name alternatives with ``|``: ``odom/*|*/odom/*``. Channels weigh more than the suffix, and
    the suffix more than the bridge: a more particular domain wins over one that takes every file of a bridge.
    """
    points = 0
    if wanted.bridges:
        if peek.bridge not in wanted.bridges:
            return 0
        points += _BRIDGE
    if wanted.suffixes:
        if not any(path.name.lower().endswith(suffix.lower()) for suffix in wanted.suffixes):
            return 0
        points += _SUFFIX
    for pattern in wanted.channels:
        alternatives = pattern.split("|")
        if not any(fnmatchcase(channel, one) for channel in peek.channels for one in alternatives):
            return 0
        points += _CHANNEL
    return points
