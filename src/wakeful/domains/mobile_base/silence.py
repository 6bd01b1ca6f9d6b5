"""Silence: a stream that comes regularly, and then doesn't. When all are silent at once it is the recording that paused."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from wakeful.contracts.detector import Found, Shown
from wakeful.domains.mobile_base.clock import Clock
from wakeful.domains.mobile_base.messages import STREAMS, message_type
from wakeful.domains.plain import number, within
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns, to_s

_LEARN = 20
_MOST = 256


class Stream(msgspec.Struct):
    """One topic's rhythm: mean interval, how much it varies, and whether it is silent now."""

    last_ns: int
    kind: str
    count: int = 0
    usual_s: float = 0.0
    varies_s: float = 0.0
    silent: bool = False


class _Memory(msgspec.Struct):
    streams: dict[str, Stream] = {}
    clock: Clock = msgspec.field(default_factory=Clock)
    due_ns: int | None = None


class Silence(Remembering[_Memory]):
    """A lasting condition of each topic whose type is a stream: nothing for ``times`` (6) usual intervals and at least
    ``least_s`` (1.0) while other topics go on. Other messages tell the time. A topic whose intervals vary more than their mean is
    irregular and never silent. A pause of everything is one event, ``recording_gap``, and no topic's silence. A silence shows
    the outcome ``fault``, its end ``recovered`` for the topic.
    """

    hears_all = True

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())
        self._times = number(spec.settings, "times") or 6.0
        self._least_s = number(spec.settings, "least_s") or 1.0
        self._gap_ns = to_ns(number(spec.settings, "gap_s") or 2.0)

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Note that a topic was heard; say which are silent by now."""
        memory = self.memory
        before_ns = memory.clock.now_ns
        now_ns = memory.clock.see(observation)
        stream = memory.streams.get(observation.topic)
        if before_ns is not None and now_ns - before_ns > self._gap_ns:
            if stream is not None or memory.streams:
                yield from self._gap(to_s(now_ns - before_ns), now_ns - before_ns)
        elif memory.due_ns is not None and now_ns >= memory.due_ns:
            yield from self._silent(now_ns)
        if stream is not None:
            if stream.silent:
                stream.silent = False
                yield Shown(label="recovered", entity=observation.topic)
                yield self._found(observation.topic, stream, now_ns, Phase.CLEARED)
            self._heard(stream, now_ns)
        elif (kind := message_type(observation)) in STREAMS and "static" not in observation.topic and len(memory.streams) < _MOST:
            memory.streams[observation.topic] = Stream(now_ns, kind)

    def _heard(self, stream: Stream, now_ns: int) -> None:
        gone_s = to_s(now_ns - stream.last_ns)
        stream.last_ns = now_ns
        limit_s = self._limit_s(stream)
        if gone_s < 0.0 or gone_s > 60.0:
            return
        gone_s = gone_s if limit_s is None else min(gone_s, limit_s)
        stream.count = min(stream.count + 1, 200)
        stream.varies_s += (abs(gone_s - stream.usual_s) - stream.varies_s) / stream.count if stream.count > 1 else 0.0
        stream.usual_s += (gone_s - stream.usual_s) / stream.count
        limit_s = self._limit_s(stream)
        if limit_s is not None:
            due_ns = now_ns + to_ns(limit_s)
            self.memory.due_ns = due_ns if self.memory.due_ns is None else min(self.memory.due_ns, due_ns)

    def _limit_s(self, stream: Stream) -> float | None:
        if stream.count < _LEARN or stream.varies_s > stream.usual_s:
            return None
        return max(self._times * stream.usual_s, self._least_s)

    def _silent(self, now_ns: int) -> Iterator[Seen]:
        memory = self.memory
        memory.due_ns = None
        for topic, stream in memory.streams.items():
            limit_s = self._limit_s(stream)
            if limit_s is None or stream.silent:
                continue
            due_ns = stream.last_ns + to_ns(limit_s)
            if now_ns >= due_ns:
                stream.silent = True
                yield Shown(label="fault")
                yield self._found(topic, stream, now_ns, Phase.RAISED)
            else:
                memory.due_ns = due_ns if memory.due_ns is None else min(memory.due_ns, due_ns)

    def _gap(self, gap_s: float, gap_ns: int) -> Iterator[Seen]:
        for stream in self.memory.streams.values():
            stream.last_ns += gap_ns  # the pause was nobody's silence
        if self.memory.due_ns is not None:
            self.memory.due_ns += gap_ns
        yield Found(
            kind="recording_gap",
            entity="recording",
            fields={"silent_s": within(gap_s, 0.0, 100.0), "severity": 0.4},
            says=f"Nothing at all was recorded for {gap_s:.1f} s; what happened then is not known.",
            criticality=1,
        )

    def _found(self, topic: str, stream: Stream, now_ns: int, phase: Phase) -> Found:
        silent_s = to_s(now_ns - stream.last_ns)
        over = phase is Phase.CLEARED
        return Found(
            kind="silence",
            entity=topic,
            fields={
                "silent_s": within(silent_s, 0.0, 100.0),
                "usual_s": within(stream.usual_s, 0.0, 100.0),
                "message": stream.kind,
                "severity": 0.7,
            },
            says=(
                f"{topic} ({stream.kind}) {'is heard again after' if over else 'has been silent for'} {silent_s:.2f} s;"
                f" usually it comes every {stream.usual_s:.3f} s."
            ),
            criticality=2 if stream.kind in ("Odometry", "LaserScan", "Imu", "TFMessage", "tfMessage") else 1,
            deadline_s=5.0,
            phase=phase,
            type="silence",
            references=(topic,),
        )
