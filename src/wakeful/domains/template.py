"""What messages of the same wording have in common: the text without its numbers, names of files and addresses."""

from __future__ import annotations

import re

_COLOUR = re.compile(r"\x1b?\[\d{1,2}(;\d+)*m")
_PATH = re.compile(r"(?<![\w.])\.?/[\w./-]+")
_HEX = re.compile(r"\b0x[0-9a-fA-F]+\b|\b[0-9a-f]{12,}\b")
_NUMBER = re.compile(r"(?<![A-Za-z_])[-+]?\d+([.,:_-]\d+)*")


def plain_text(text: str) -> str:
    """``text`` without terminal colours and surplus blanks.

    >>> plain_text("\\x1b[32mReady  for takeoff!\\x1b[0m\\t")
    'Ready for takeoff!'
    """
    return " ".join(_COLOUR.sub("", text).split())


def template(text: str) -> str:
    """The wording of a message: each path as ``/…``, each address and number as ``#``.

    >>> template("RTL: start return at 491 m (3 m above destination)")
    'RTL: start return at # m (# m above destination)'
    >>> template("no barometer found on /dev/baro0 (2)")
    'no barometer found on /… (#)'
    """
    return _NUMBER.sub("#", _HEX.sub("#", _PATH.sub("/…", plain_text(text))))[:160]
