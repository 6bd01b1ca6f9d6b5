"""Texts as TOML and channel patterns want them."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from typing import Final

_SPECIAL: Final = re.compile(r"([*?\[])")
_NUMBER: Final = re.compile(r"\d+")
_OTHER: Final = re.compile(r"[^A-Za-z0-9]+")


def text(words: str) -> str:
    r"""A TOML basic string.

    >>> text('a "b"\x7f')
    '"a \\"b\\"\\u007f"'
    """
    return json.dumps(words.encode("utf-8", "replace").decode(), ensure_ascii=False).replace("\x7f", "\\u007f")


def texts(words: Iterable[str]) -> str:
    """A TOML array of strings."""
    return "[" + ", ".join(text(word) for word in words) + "]"


def comment(words: str) -> str:
    """What may stand in a comment: one line, nothing unprintable."""
    return "".join(sign if sign.isprintable() else " " for sign in words)[:200]


def pattern(channel: str) -> str:
    """The pattern that matches just this channel.

    >>> pattern("scan/ranges[0]")
    'scan/ranges[[]0]'
    """
    return _SPECIAL.sub(r"[\1]", channel)


def alike(topic: str, name: str) -> str:
    """The pattern of the channels of a topic that differ from this one in a number only.

    >>> alike("row", "Current_J3")
    'row/Current_J*'
    """
    return f"{pattern(topic)}/{'*'.join(pattern(part) for part in _NUMBER.split(name))}"


def word(name: str) -> str:
    """A name as one lower-case word.

    >>> word("/diagnostics agg"), word("Robot_ProtectiveStop"), word("42")
    ('diagnostics_agg', 'robot_protectivestop', 'n42')
    """
    made = _OTHER.sub("_", name).strip("_").lower()[:60]
    return f"n{made}" if made[:1].isdigit() else made or "channel"
