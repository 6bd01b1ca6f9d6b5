"""``text``: log lines. Lines of one wording are one condition: the first raises it, the others repeat it."""

from __future__ import annotations

import re
from typing import Final

import msgspec

from wakeful.contracts.domain import DomainError
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.values import Field, Value
from wakeful.registration.detectors.base import NotNegative, PerChannel, Seen, Settings, levels_of, settings_of
from wakeful.registration.plain import clean, elapsed_s, number

TEMPLATES: Final = 512
"""Wordings that one channel remembers."""

LEVELS: Final = {
    **dict.fromkeys(("debug", "trace"), 10),
    **dict.fromkeys(("info", "notice"), 20),
    **dict.fromkeys(("warn", "warning"), 30),
    **dict.fromkeys(("error", "err"), 40),
    **dict.fromkeys(("fatal", "critical", "alert", "emergency", "emerg", "panic"), 50),
}
"""The scale on which levels are compared: that of Python's and ROS 2's loggers."""

_VARIABLE = re.compile(
    r"0x[0-9a-fA-F]+|\b[0-9a-fA-F]{8,}\b|(?<![A-Za-z])[-+]?\d[\d.,:eE+-]*|(?<![\w.])/[\w./-]+|\"[^\"]*\"|'[^']*'"
)


class TextSettings(Settings, frozen=True):
    """What `text` may be told.

    ``level``: the name of the value beside the text that gives its level; ``least``: the level from which a line counts;
    ``levels``: what the source's own levels mean, as ``"8=40"``; ``again_s``: a wording unheard for so long is raised anew;
    ``match``: a regular expression that a line must contain (empty: any).
    """

    level: str = "level"
    least: int = 30
    levels: list[str] = []
    again_s: NotNegative = 60.0
    match: str = ""


class Heard(msgspec.Struct):
    """The wordings of one channel, and when each was heard last."""

    last_ns: dict[str, int] = {}


class TextDetector(PerChannel[Heard]):
    """Registers log lines by their wording."""

    memory_type = Heard

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:
        super().__init__(spec, domain)
        self._settings = settings_of(spec, TextSettings)
        own = levels_of(spec, "levels", self._settings.levels)
        self._own_levels = {name.lower(): level for name, level in own.items()}
        try:
            self._match = re.compile(self._settings.match)
        except re.error as error:
            raise DomainError(
                f"detect {spec.kind!r} (text): settings.match is no regular expression: {error}; correct it"
            ) from error

    def look(self, channel: str, value: Value, memory: Heard, observation: Observation) -> Seen | None:
        """Take one line."""
        if not isinstance(value, str) or not value.strip():
            return None
        level = self._level(observation.values.get(self._settings.level))
        if level is not None and level < self._settings.least:
            return None
        text = clean(" ".join(value[:2000].split()))
        if self._settings.match and not self._match.search(text):
            return None
        wording = template(text)
        heard_ns = memory.last_ns.pop(wording, None)
        memory.last_ns[wording] = observation.at_ns
        if len(memory.last_ns) > TEMPLATES:
            del memory.last_ns[next(iter(memory.last_ns))]
        repeated = elapsed_s(observation.at_ns, heard_ns) < self._settings.again_s
        fields: dict[str, Field] = {"text": text, "wording": wording}
        if level is not None:
            fields["level"] = level
        return self.found(channel, observation, fields, text, Phase.REPEATED if repeated else Phase.RAISED, type=wording)

    def _level(self, value: object) -> int | None:
        if isinstance(value, str):
            word = value.strip().lower()
            return self._own_levels.get(word, LEVELS.get(word))
        level = number(value)
        if level is None:
            return None
        return self._own_levels.get(str(int(level)), int(level))


def template(text: str) -> str:
    """The wording of a line: what varies (numbers, addresses, paths, quoted parts) becomes ``#``.

    >>> template("Motor 3 at 81.5 C exceeds 'limit' in /dev/can0")
    'Motor # at # C exceeds # in #'
    """
    return _VARIABLE.sub("#", text)[:120]
