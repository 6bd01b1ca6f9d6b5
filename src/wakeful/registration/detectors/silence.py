"""``silence``: a topic is not heard for several times its usual interval. Other observations tell the time, not a clock."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import msgspec

from wakeful.contracts.detector import Found
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.registration.channels import named, reaches
from wakeful.registration.detectors.base import Count, NotNegative, Positive, Seen, Settings, said, settings_of, short
from wakeful.registration.plain import clean, elapsed_s

TOPICS: Final = 512
MEMORY: Final = 200
"""Intervals over which a topic's rhythm is learned and forgotten."""


class SilenceSettings(Settings, frozen=True):
    """What `silence` may be told.

    ``times``: the usual interval so many times over is a silence; ``least_s``: and at least so long; ``learn``: intervals until
    there is a usual one; ``steady``: topics whose intervals vary more than so many times their mean are irregular, never silent.
    """

    times: Positive = 5.0
    least_s: NotNegative = 1.0
    learn: Count = 20
    steady: Positive = 3.0


class Rhythm(msgspec.Struct):
    """The memory of one topic: its usual interval and how much it varies, in seconds."""

    last_ns: int
    count: int = 0
    usual_s: float = 0.0
    varies_s: float = 0.0
    silent: bool = False


class SilenceDetector:
    """Hears every observation; costs a comparison while nothing is due."""

    hears_all = True

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:
        self.spec = spec
        self._robot = domain.robot
        self._settings = settings_of(spec, SilenceSettings)
        self._watched: dict[str, bool] = {}
        self._rhythms: dict[str, Rhythm] = {}
        self._due_ns: int | None = None

    def observe(self, observation: Observation) -> Iterable[Seen]:
        """Note that the topic was heard; say which topics are silent by now."""
        found: list[Seen] = []
        topic = clean(observation.topic)
        watched = self._watched.get(topic)
        if watched is None:
            if len(self._watched) > 8 * TOPICS:
                self._watched.clear()
            watched = self._watched[topic] = any(reaches(pattern, f"{topic}/") for pattern in self.spec.channels)
        at_ns = observation.at_ns
        if self._due_ns is not None and at_ns >= self._due_ns:
            found.extend(self._silent(observation))
        if watched:
            rhythm = self._rhythms.get(topic)
            if rhythm is None:
                if len(self._rhythms) < TOPICS:
                    self._rhythms[topic] = Rhythm(last_ns=at_ns)
            else:
                if rhythm.silent:
                    rhythm.silent = False
                    found.append(self._found(topic, rhythm, observation, Phase.CLEARED))
                self._heard(rhythm, at_ns)
        return found

    def state(self) -> bytes:
        """The rhythms, and when the next silence is due."""
        return msgspec.msgpack.encode((self._due_ns, self._rhythms))

    def restore(self, state: bytes) -> None:
        """Take up what ``state`` gave out."""
        self._due_ns, self._rhythms = msgspec.msgpack.decode(state, type=tuple[int | None, dict[str, Rhythm]])

    def _heard(self, rhythm: Rhythm, at_ns: int) -> None:
        gone_s = elapsed_s(at_ns, rhythm.last_ns)
        rhythm.last_ns = at_ns
        if gone_s == float("inf"):
            return
        limit_s = self._limit_s(rhythm)
        rhythm.count += 1
        rate = 1.0 / min(rhythm.count, MEMORY)
        if rhythm.count > 1:
            # a topic that falls silent again and again is irregular: silences count here, though one alone must not decide
            away_s = abs(gone_s - rhythm.usual_s) if limit_s is None else min(abs(gone_s - rhythm.usual_s), 10.0 * limit_s)
            rhythm.varies_s += rate * (away_s - rhythm.varies_s)
        # a silence that was one must not become usual
        rhythm.usual_s += rate * ((gone_s if limit_s is None else min(gone_s, limit_s)) - rhythm.usual_s)
        limit_s = self._limit_s(rhythm)
        if limit_s is not None:
            due_ns = at_ns + round(min(limit_s, 1e9) * 1e9)
            self._due_ns = due_ns if self._due_ns is None else min(self._due_ns, due_ns)

    def _limit_s(self, rhythm: Rhythm) -> float | None:
        settings = self._settings
        if rhythm.count < settings.learn or rhythm.varies_s > settings.steady * rhythm.usual_s:
            return None
        return max(settings.times * rhythm.usual_s, settings.least_s)

    def _silent(self, observation: Observation) -> Iterable[Seen]:
        self._due_ns = None
        for topic, rhythm in self._rhythms.items():
            limit_s = self._limit_s(rhythm)
            if limit_s is None or rhythm.silent:
                continue
            if elapsed_s(observation.at_ns, rhythm.last_ns) >= limit_s:
                rhythm.silent = True
                yield self._found(topic, rhythm, observation, Phase.RAISED)
            else:
                due_ns = rhythm.last_ns + round(min(limit_s, 1e9) * 1e9)
                self._due_ns = due_ns if self._due_ns is None else min(self._due_ns, due_ns)

    def _found(self, topic: str, rhythm: Rhythm, observation: Observation, phase: Phase) -> Found:
        silent_s = elapsed_s(observation.at_ns, rhythm.last_ns)
        silent_s = 0.0 if silent_s == float("inf") else silent_s
        word = "is heard again after" if phase is Phase.CLEARED else "is silent for"
        return Found(
            fields={"topic": topic, "silent_s": short(silent_s), "usual_s": short(rhythm.usual_s)},
            says=f"{self.spec.says or self.spec.kind}: {topic} {word} {said(silent_s)} s, usually every {said(rhythm.usual_s)} s",
            entity=named(self.spec.entity, topic, topic, observation.robot or self._robot),
            phase=phase,
            type=self.spec.kind,
            references=(topic,),
        )
