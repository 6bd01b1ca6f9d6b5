"""What PX4's events say: their numbers, put into words by the definitions that the log brings along."""

from __future__ import annotations

import json
import lzma
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from wakeful.bridges.content import extra
from wakeful.bridges.plain import text
from wakeful.facts.values import Value

if TYPE_CHECKING:
    from pyulog import ULog
    from pyulog.libevents_parse.parser import Parser

TOPIC: Final = "event"
_MAX_DEFINITIONS_BYTES: Final = 32_000_000
#: By number, with the severity that all bridges share: 0 debug, 1 info, 2 warning, 3 error, 4 fatal.
LEVELS: Final = (
    *(("emergency", 4), ("alert", 4), ("critical", 4), ("error", 3)),
    *(("warning", 2), ("notice", 1), ("info", 1), ("debug", 0)),
)
PROTOCOL: Final = ("protocol", 0)
"""Levels above debug: between the autopilot and a ground station, not for people."""


class EventTexts:
    """Adds words to a log's events. A log without definitions, or with damaged ones, gives levels alone."""

    def __init__(self, log: ULog) -> None:
        self._parser = _parser(log)

    def words(self, values: Mapping[str, Value]) -> dict[str, Value]:
        """``level`` and ``severity``; and ``name``, ``text`` and ``group`` where the event is defined."""
        levels, number, arguments = values.get("log_levels"), values.get("id"), values.get("arguments")
        internal = levels >> 4 if isinstance(levels, int) else len(LEVELS)
        level, severity = LEVELS[internal] if 0 <= internal < len(LEVELS) else PROTOCOL
        words: dict[str, Value] = {"level": level, "severity": severity}
        if self._parser is None or not isinstance(number, int):
            return words
        packed = bytes(each & 0xFF for each in arguments if isinstance(each, int)) if isinstance(arguments, list) else b""
        try:
            if (event := self._parser.parse(number, packed)) is not None:
                words |= {"name": text(event.name()), "text": text(event.message()), "group": text(event.group())}
        except Exception:
            # The library formats arguments by definitions that nobody checked. An event keeps its number and level.
            return words
        return words


def _parser(log: ULog) -> Parser | None:
    with extra("ulog", "a flight log"):
        from pyulog.libevents_parse.parser import Parser  # noqa: PLC0415
    try:
        packed = b"".join(log.msg_info_multiple_dict["metadata_events"][0])
        unpacker = lzma.LZMADecompressor()
        definitions = json.loads(unpacker.decompress(packed, max_length=_MAX_DEFINITIONS_BYTES))
        parser = Parser()
        parser.load_definitions(definitions)
        parser.set_profile("normal")
    except Exception:
        # Definitions are a help: whatever is wrong with them, the events themselves are still there.
        return None
    return parser
