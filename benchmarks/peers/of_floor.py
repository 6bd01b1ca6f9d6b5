"""The floor as a program: the faster implementation of each stage, put together, coming to W's final states."""

from __future__ import annotations

from collections.abc import Iterator

from benchmarks.peers.floor import (
    ManyTable,
    Row,
    Table,
    decode_by_hand,
    decode_each,
    decode_together,
    features_listed,
    forward_32,
    forward_64,
    measured,
)
from benchmarks.peers.floor_steps import Steps, treat_async, treat_generator
from benchmarks.peers.lean import features
from benchmarks.peers.messages import LABELS, TREATMENTS, Event, Evidence, Outcome
from benchmarks.peers.running import Run, size_of
from benchmarks.peers.treating import final, verdict


class Floor:
    """The faster stages, put together."""

    def __init__(self, run: Run, _variant: str) -> None:
        self._run = run
        self._stages = measured(run)
        fastest = {name: min(found, key=found.__getitem__) for name, found in self._stages.items()}
        self._decode = {"each": decode_each, "together": decode_together, "by hand": decode_by_hand}[fastest["decode"]]
        self._features = {"vectorised": features, "listed": features_listed}[fastest["features"]]
        self._forward = (forward_64 if fastest["forward"] == "float64" else forward_32)(run.lean)
        kind = Table if fastest["append"] == "multi-row" else ManyTable
        self._table = kind(str(run.store / "floor.db"), run.load.full_sync)
        self._treat = treat_async if fastest["steps"] == "coroutine" else treat_generator
        self._finals: list[str] = []

    @property
    def extra(self) -> dict[str, object]:
        """Each stage's microseconds for an event, and the sum of the faster ones: the floor."""
        return {
            "stages_us": self._stages,
            "floor_us": sum(min(found.values()) for name, found in self._stages.items() if name != "raw file"),
        }

    def run(self) -> None:
        """Micro-batches of a window each."""
        run, times = self._run, self._run.times
        steps = Steps(self._treat, times.stepped, times.resumed)
        early: dict[str, float] = {}
        results: dict[str, tuple[str, str, float | None, int]] = {}
        position = 0

        def concluded_now(done: Iterator[tuple[Event, float | None, int]]) -> None:
            for event, reading, concluded in done:
                name, predicted, _, _ = results[event.entity]
                results[event.entity] = name, predicted, reading, concluded

        for came, texts in run.windows():
            messages = self._decode(texts)
            events = [message for message in messages if type(message) is Event]
            chosen = self._forward(self._features(events))
            rows: list[Row] = []
            at = 0
            for came_ns, text, message in zip(came, texts, messages, strict=True):
                for entity in steps.late(message.at_ns):
                    steps.wake(entity, None)
                    concluded_now(steps.run())
                    rows.append((position, entity, b"%d" % results[entity][3]))
                    position += 1
                kind = type(message)
                if kind is Event:
                    treatment, label = chosen[at]
                    at += 1
                    entity = message.entity
                    times.came[entity] = came_ns
                    results[entity] = TREATMENTS[treatment], LABELS[label], None, 0
                    steps.begin(message, LABELS[label])
                    if entity in early:
                        concluded_now(steps.run())
                        steps.wake(entity, early[entity])
                    concluded_now(steps.run())
                    rows.append((position, entity, b"%d%d%d%s" % (treatment, label, results[entity][3], text)))
                elif kind is Evidence:
                    times.read.setdefault(message.entity, came_ns)
                    if not steps.wake(message.entity, message.value):
                        early.setdefault(message.entity, message.value)
                    concluded_now(steps.run())
                    state = results[message.entity][3] if message.entity in results else 0
                    rows.append((position, message.entity, b"%d%s" % (state, text)))
                elif kind is Outcome:
                    rows.append((position, message.entity, text))
                else:
                    continue
                position += 1
                if kind is Outcome:
                    name, predicted, reading, concluded = results[message.entity]
                    judged = verdict(predicted, message.label, message.acted_on)
                    self._finals.append(final(message.entity, name, predicted, reading, concluded, message.label, judged))
            self._table.append(rows)
            run.acknowledge([event.entity for event in events])

    def finals(self) -> list[str]:
        """What the assembled stages came to."""
        self._table.db.close()
        return self._finals

    def stored_bytes(self) -> int:
        """The table's file."""
        return size_of(self._run.store, "floor.db")
