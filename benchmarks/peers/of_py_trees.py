"""W through py_trees: a sequence of three behaviours for each event, ticked until it waits or is done. Nothing survives a crash.

Trees are used again for the next event, since making one costs more than ticking it; the root is ticked without visitors.
"""

from __future__ import annotations

from pathlib import Path

import py_trees
from py_trees.common import Status

from benchmarks.peers.beside import Limits
from benchmarks.peers.messages import Event, Evidence, Outcome, decode
from benchmarks.peers.running import Run, now_ns
from benchmarks.peers.treating import LIMIT_NS, WAITS, conclude, final, look, verdict, weigh


class Case:
    """What one tree is about at the moment."""

    def __init__(self) -> None:
        self.entity = self.treatment = self.label = ""
        self.load = 0.0
        self.waits = self.came = False
        self.reading: float | None = None
        self.state = 0


class Look(py_trees.behaviour.Behaviour):
    """Step 1."""

    def __init__(self, case: Case, run: Run) -> None:
        super().__init__("look")
        self._case, self._run = case, run

    def update(self) -> Status:
        """See."""
        case = self._case
        self._run.times.stepped[case.entity] = now_ns()
        case.state = look(case.entity, case.load)
        return Status.SUCCESS


class Weigh(Look):
    """Step 2, which may need a reading."""

    def update(self) -> Status:
        """Wait, or weigh."""
        case = self._case
        if case.waits:
            if not case.came:
                return Status.RUNNING
            self._run.times.resumed[case.entity] = now_ns()
        case.state = weigh(case.state, case.reading if case.waits else 0.0)
        self._run.call(case.entity)
        return Status.SUCCESS


class Conclude(Look):
    """Step 3."""

    def update(self) -> Status:
        """Conclude."""
        self._case.state = conclude(self._case.state, self._case.label)
        return Status.SUCCESS


class Tree:
    """A tree with its case."""

    def __init__(self, run: Run) -> None:
        self.case = Case()
        steps = [kind(self.case, run) for kind in (Look, Weigh, Conclude)]
        self.root = py_trees.composites.Sequence("treat", memory=True, children=steps)

    def tick(self) -> bool:
        """Whether it is done."""
        self.root.tick_once()
        return bool(self.root.status == Status.SUCCESS)


class PyTrees:
    """Takes messages in windows."""

    def __init__(self, run: Run, _variant: str) -> None:
        self._run = run
        self._limits = Limits()
        self._idle: list[Tree] = []
        self._waiting: dict[str, Tree] = {}
        self._results: dict[str, tuple[str, str, float | None, int]] = {}
        self._early: dict[str, float] = {}
        self._finals: list[str] = []

    def run(self) -> None:
        """Window by window."""
        run = self._run
        for came, texts in run.windows():
            messages = [decode(text) for text in texts]
            chosen = iter(run.lean.choose([message for message in messages if isinstance(message, Event)]))
            for came_ns, message in zip(came, messages, strict=True):
                for entity in self._limits.late(message.at_ns):
                    self._read(entity, None)
                if isinstance(message, Event):
                    chosen_now = next(chosen)
                    if message.entity in run.acknowledged:  # in an earlier life
                        continue
                    run.times.came[message.entity] = came_ns
                    self._start(message, *chosen_now)
                elif isinstance(message, Evidence):
                    run.times.read.setdefault(message.entity, came_ns)
                    if self._limits.end(message.entity):
                        self._read(message.entity, message.value)
                    elif message.entity not in run.times.came:
                        self._early.setdefault(message.entity, message.value)
                elif isinstance(message, Outcome) and message.entity in self._results:  # else a crash took it
                    self._judge(message)

    def _start(self, event: Event, treatment: str, label: str) -> None:
        tree = self._idle.pop() if self._idle else Tree(self._run)
        case = tree.case
        case.entity, case.load, case.treatment, case.label = event.entity, event.load, treatment, label
        case.waits, case.came, case.reading = event.category == WAITS, False, None
        self._run.acknowledge([event.entity])
        if tree.tick():
            self._done(tree)
            return
        self._waiting[event.entity] = tree
        if event.entity in self._early:
            self._read(event.entity, self._early.pop(event.entity))
        else:
            self._limits.begin(event.entity, event.at_ns + LIMIT_NS)

    def _read(self, entity: str, value: float | None) -> None:
        tree = self._waiting.pop(entity)
        tree.case.came, tree.case.reading = True, value
        tree.tick()
        self._done(tree)

    def _done(self, tree: Tree) -> None:
        case = tree.case
        self._results[case.entity] = case.treatment, case.label, case.reading, case.state
        self._idle.append(tree)

    def _judge(self, outcome: Outcome) -> None:
        treatment, predicted, reading, state = self._results.pop(outcome.entity)
        judged = verdict(predicted, outcome.label, outcome.acted_on)
        self._finals.append(final(outcome.entity, treatment, predicted, reading, state, outcome.label, judged))

    def finals(self) -> list[str]:
        """From memory."""
        return self._finals

    def stored_bytes(self) -> int:
        """Nothing is kept."""
        return 0


def answered(_store: Path, _variant: str) -> set[str]:
    """No answer is committed."""
    return set()
