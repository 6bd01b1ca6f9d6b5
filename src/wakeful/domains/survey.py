"""What the channels of a recording look like: types, ranges, how often they change. The ground on which a domain is drafted."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from typing import Final

import msgspec

from wakeful.facts.events import Observation
from wakeful.facts.time import to_s
from wakeful.facts.values import Value

OBSERVATIONS: Final = 50_000
"""How many observations are looked at."""
CHANNELS: Final = 2000
DISTINCT: Final = 24
"""Distinct texts that a category may have."""
DEPTH: Final = 4
KEPT: Final = 2000
RARE: Final = 0.2
"""A flag that is up for less than this share of the time may be an outcome."""
OUTCOMES: Final = 6
TROUBLE: Final = re.compile(r"fail|fault|error|stop|lost|loss|alarm|collision|emergenc|crash|abort|critical|trip", re.IGNORECASE)
_SENTENCE = re.compile(r"[A-Za-z]{2,}\S*\s+\S")


class Channel(msgspec.Struct):
    """What was seen of one channel."""

    topic: str
    name: str
    count: int = 0
    flags: int = 0
    true: int = 0
    rises: int = 0
    numbers: int = 0
    whole: bool = True
    ups: int = 0
    downs: int = 0
    changes: int = 0
    by_one: int = 0
    low: float = 0.0
    high: float = 0.0
    values: list[float] = []
    texts: int = 0
    words: set[str] = set()
    spaced: int = 0
    lists: int = 0
    members: dict[str, int] = {}
    last: float | None = None
    last_flag: bool | None = None
    last_word: str = ""
    turns: int = 0

    @property
    def channel(self) -> str:
        """``topic/name``."""
        return f"{self.topic}/{self.name}"

    @property
    def is_flag(self) -> bool:
        """True and false, or one and zero, both seen."""
        if self.numbers > self.flags:
            return self.whole and set(self.values) == {0.0, 1.0}
        return self.flags > self.texts and 0 < self.true < self.flags

    @property
    def up_share(self) -> float:
        """Of a flag: how much of the time it is up."""
        return self.true / self.flags if self.flags else sum(self.values) / max(len(self.values), 1)

    @property
    def up_times(self) -> int:
        """Of a flag: how often it rose."""
        return self.rises if self.flags else self.ups

    @property
    def is_category(self) -> bool:
        """A few words that come again."""
        return (
            self.texts > max(self.numbers, self.flags) and 1 < len(self.words) <= DISTINCT and self.texts >= 4 * len(self.words)
        )

    @property
    def is_text(self) -> bool:
        """Sentences: log lines, messages."""
        return self.texts > max(self.numbers, self.flags) and not self.is_category and self.spaced >= 0.5 * self.texts

    @property
    def is_counter(self) -> bool:
        """A number that goes on and on: an index, a sequence number, a clock."""
        return self.numbers > 2 and self.downs <= 0.01 * self.numbers and self.ups >= 0.9 * (self.numbers - 1)

    @property
    def is_cycle(self) -> bool:
        """A whole number that now and then goes up by one: the number of a piece of work."""
        seldom = self.numbers > 20 and 3 <= self.changes < 0.2 * self.numbers
        return self.whole and seldom and self.by_one >= 0.8 * self.changes and self.high - self.low >= 3

    @property
    def is_measure(self) -> bool:
        """A number that varies, and is neither counter nor cycle."""
        varies = self.numbers > max(self.flags, self.texts) and len(set(self.values)) > 4
        return varies and not (self.is_counter or self.is_cycle or self.is_code)

    @property
    def is_code(self) -> bool:
        """A whole number of a few values that changes seldom: a mode, a state, an error code."""
        distinct = len(set(self.values))
        seldom = distinct <= 4 or self.changes < 0.02 * self.numbers
        other = self.is_flag or self.is_cycle or self.is_counter
        return self.whole and 1 < distinct <= DISTINCT and seldom and not other

    @property
    def is_state(self) -> bool:
        """A flag, category or code that turns seldom enough for each turn to be news."""
        return (self.is_flag or self.is_category or self.is_code) and self.turns <= max(0.05 * self.count, 3)

    @property
    def is_list_of_conditions(self) -> bool:
        """Lists of objects that name a type."""
        return self.lists > 0 and any("type" in name.lower() for name in self.members)


class Topic(msgspec.Struct):
    """How a topic was heard."""

    count: int = 0
    first_ns: int = 0
    last_ns: int = 0

    @property
    def interval_s(self) -> float:
        """Mean seconds between two of its observations; 0 where there was one."""
        return to_s(max(self.last_ns - self.first_ns, 0)) / (self.count - 1) if self.count > 1 else 0.0


class Survey(msgspec.Struct):
    """A recording's channels and topics, each by name in order of first sight."""

    channels: dict[str, Channel] = {}
    topics: dict[str, Topic] = {}
    source: str = ""
    robot: str = ""

    def outcome_flags(self) -> list[Channel]:
        """Flags that are seldom up and rose at least once; those whose names sound like trouble first."""
        rare = [each for each in self.channels.values() if each.is_flag and each.up_share < RARE and each.up_times > 0]
        return sorted(rare, key=lambda each: not TROUBLE.search(each.name))[:OUTCOMES]

    def cycles(self) -> list[Channel]:
        """Channels that number pieces of work, the one that changes most often first."""
        return sorted((each for each in self.channels.values() if each.is_cycle), key=lambda each: -each.changes)

    def measures(self, topic: str) -> list[Channel]:
        """The numbers of a topic that vary."""
        return [each for each in self.channels.values() if each.topic == topic and each.is_measure]


def survey(observations: Iterable[Observation]) -> Survey:
    """Look at (the beginning of) a recording."""
    found = Survey()
    for observation in islice(observations, OBSERVATIONS):
        found.source, found.robot = observation.source, observation.robot or found.robot
        topic = found.topics.setdefault(observation.topic, Topic(first_ns=observation.at_ns))
        topic.count += 1
        topic.last_ns = observation.at_ns
        for name, value in _leaves(observation.values):
            channel = f"{observation.topic}/{name}"
            seen = found.channels.get(channel)
            if seen is None:
                if len(found.channels) >= CHANNELS:
                    continue
                seen = found.channels[channel] = Channel(observation.topic, name)
            _take(seen, value)
    return found


def _leaves(values: Mapping[str, Value], before: str = "", depth: int = 0) -> Iterator[tuple[str, Value]]:
    for name, value in values.items():
        if isinstance(value, dict) and depth < DEPTH:
            yield from _leaves(value, f"{before}{name}.", depth + 1)
        else:
            yield f"{before}{name}", value


def _take(seen: Channel, value: Value) -> None:
    seen.count += 1
    if isinstance(value, bool):
        seen.flags += 1
        seen.true += value
        seen.rises += value and seen.last_flag is False
        seen.turns += seen.last_flag is not None and value is not seen.last_flag
        seen.last_flag = value
    elif isinstance(value, int | float):
        if -1e150 < value < 1e150:
            _take_number(seen, float(value))
    elif isinstance(value, str) and value.strip():
        seen.texts += 1
        seen.spaced += _SENTENCE.search(value) is not None
        seen.turns += seen.last_word not in ("", value[:200])
        seen.last_word = value[:200]
        if len(seen.words) <= DISTINCT:
            seen.words.add(value[:200])
    elif isinstance(value, list | tuple):
        for item in list(value)[:8]:
            if isinstance(item, dict):
                seen.lists += 1
                for name in list(item)[:32]:
                    seen.members[name] = seen.members.get(name, 0) + 1


def _take_number(seen: Channel, value: float) -> None:
    seen.low = min(seen.low, value) if seen.numbers else value
    seen.high = max(seen.high, value) if seen.numbers else value
    seen.numbers += 1
    seen.whole = seen.whole and value.is_integer()
    if seen.last is not None and value != seen.last:
        seen.changes += 1
        seen.turns += 1
        seen.ups += value > seen.last
        seen.downs += value < seen.last
        seen.by_one += value - seen.last == 1.0
    seen.last = value
    if len(seen.values) < KEPT or seen.numbers % 16 == 0:
        if len(seen.values) >= 2 * KEPT:
            del seen.values[::2]
        seen.values.append(value)
