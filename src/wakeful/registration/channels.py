"""Channels: ``topic/name`` of every value that an observation carries, and the patterns that choose among them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from operator import itemgetter
from typing import Final

from wakeful.facts.events import Observation
from wakeful.facts.values import Value
from wakeful.registration.plain import clean

TOPICS: Final = 4096
NAMES: Final = 4096
LEAVES: Final = 256
DEPTH: Final = 6

_NUMBER = re.compile(r"\d+")
_PLACEHOLDER = re.compile(r"\{(\w+)\}")
PLACEHOLDERS: Final = ("channel", "topic", "name", "robot", "number")


Take = Callable[[Mapping[str, Value]], Sequence[Value]]


def _nothing(values: Mapping[str, Value]) -> Sequence[Value]:
    del values
    return ()


def _taking(names: list[str]) -> Take:
    if not names:
        return _nothing
    if len(names) == 1:
        (name,) = names
        return lambda values: (values[name],)
    return itemgetter(*names)


class _Topic:
    """What is known of one topic's names. ``shape`` are the names of the observation seen last, with what to take of it."""

    __slots__ = ("channels", "deep", "known", "shape", "take", "take_deep", "wanted")

    def __init__(self) -> None:
        self.known: set[str] = set()
        self.wanted: list[tuple[str, str]] = []
        self.deep: list[str] = []
        self.shape: tuple[str, ...] = ()
        self.channels: tuple[str, ...] = ()
        self.take: Take = _nothing
        self.take_deep: Take = _nothing

    def shaped(self, shape: tuple[str, ...]) -> None:
        """Work out what to take of observations with just these names, in this order."""
        there = set(shape)
        wanted = [(name, channel) for name, channel in self.wanted if name in there]
        self.shape = shape
        self.channels = tuple(channel for _, channel in wanted)
        self.take = _taking([name for name, _ in wanted])
        self.take_deep = _taking([name for name in self.deep if name in there])


class Channels:
    """The values of an observation that a set of patterns chooses.

    A value's channel is ``topic/name``; inside a dict its name goes on after a dot (``odom/pose.position.x``). What a topic's
    names mean is worked out when they are first seen, so that later observations cost little.

    >>> from wakeful.facts.events import Observation
    >>> seen = Observation(source="s", position=0, topic="arm", at_ns=0, values={"J0": 1.5, "J1": 2.0, "pose": {"x": 3}})
    >>> Channels(("arm/J*", "arm/pose.x")).of(seen)
    [('arm/J0', 1.5), ('arm/J1', 2.0), ('arm/pose.x', 3)]
    """

    def __init__(self, patterns: tuple[str, ...]) -> None:
        self._patterns = patterns
        self._topics: dict[str, _Topic] = {}

    def concern(self, topic: str) -> bool:
        """Whether a value of this topic could be chosen: cheap to ask once, and never wrong in saying no."""
        return any(reaches(pattern, f"{topic}/") for pattern in self._patterns)

    def of(self, observation: Observation) -> list[tuple[str, Value]]:
        """The chosen (channel, value) pairs, those of the observation itself by name, then those inside its dicts."""
        values = observation.values
        topic = self._topics.get(observation.topic)
        # messages of one topic nearly always have the same names in the same order: comparing those is cheap
        shape = tuple(values)
        if topic is None or topic.shape != shape:
            if topic is None or not topic.known.issuperset(shape):
                topic = self._learn(observation)
            topic.shaped(shape)
        found = list(zip(topic.channels, topic.take(values), strict=True))
        for value in topic.take_deep(values):
            if value.__class__ is dict:
                return found + self._all_inside(topic, observation)
        return found

    def _all_inside(self, topic: _Topic, observation: Observation) -> list[tuple[str, Value]]:
        found: list[tuple[str, Value]] = []
        for name in topic.deep:
            value = observation.values.get(name)
            if value.__class__ is dict:
                found.extend(self._inside(f"{observation.topic}/{name}", value))
        return found

    def _learn(self, observation: Observation) -> _Topic:
        if len(self._topics) >= TOPICS:
            self._topics.clear()
        topic = self._topics.get(observation.topic)
        if topic is None or len(topic.known) >= NAMES:
            topic = self._topics[observation.topic] = _Topic()
        fresh = observation.values.keys() - topic.known
        topic.known |= fresh
        for name in fresh:
            channel = f"{observation.topic}/{name}"
            if any(fnmatchcase(channel, pattern) for pattern in self._patterns):
                topic.wanted.append((name, clean(channel)))
            if any(reaches(pattern, f"{channel}.") for pattern in self._patterns):
                topic.deep.append(name)
        # by name, not by first sight: the same observations give the same order after a restart
        topic.wanted.sort()
        topic.deep.sort()
        return topic

    def _inside(self, channel: str, value: Value) -> Iterator[tuple[str, Value]]:
        count = 0
        stack: list[tuple[str, Value, int]] = [(channel, value, 0)]
        while stack and count < LEAVES:
            at, inner, depth = stack.pop()
            if inner.__class__ is dict and depth < DEPTH:
                members = inner.items()
                stack.extend(sorted(((f"{at}.{name}", item, depth + 1) for name, item in members), key=_by_name, reverse=True))
            if depth and any(fnmatchcase(at, pattern) for pattern in self._patterns):
                count += 1
                yield clean(at), inner


def _by_name(entry: tuple[str, Value, int]) -> str:
    return entry[0]


def reaches(pattern: str, prefix: str) -> bool:
    """Whether some text that begins with ``prefix`` could match the pattern.

    True exactly when a beginning of the pattern matches the prefix (a ``*`` may stretch past it); a cut inside brackets can
    only make it true too often.

    >>> reaches("row/J*", "row/"), reaches("*/J0", "row/"), reaches("odom/x", "row/")
    (True, True, False)
    """
    return any(fnmatchcase(prefix, pattern[:end]) for end in range(len(pattern) + 1))


def named(template: str, channel: str, topic: str, robot: str) -> str:
    """An entity, key or channel name with its placeholders filled in.

    >>> named("J{number}", "row/Current_J3", "row", "arm")
    'J3'
    """
    if "{" not in template:
        return template
    name = channel[len(topic) + 1 :] if channel.startswith(f"{topic}/") else channel
    words = {"channel": channel, "topic": topic, "name": name, "robot": robot, "number": number_in(name)}
    return clean(_PLACEHOLDER.sub(lambda found: words.get(found[1], found[0]), template))


def number_in(name: str) -> str:
    """The last number in a name, as text; empty where there is none."""
    found = _NUMBER.findall(name)
    return found[-1] if found else ""


def unknown_placeholder(template: str, *also: str) -> str:
    """The first placeholder that nobody fills in, or nothing."""
    return next((word for word in _PLACEHOLDER.findall(template) if word not in PLACEHOLDERS and word not in also), "")
