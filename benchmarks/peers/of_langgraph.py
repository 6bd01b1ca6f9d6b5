"""W through LangGraph with its SQLite saver: a thread for each event, readings as resumptions of an interrupt.

As cheap as its documentation allows: WAL with the acknowledgement that W asks for, the synchronous saver on one connection (the
asynchronous one costs a thread's hand-over more), one node for what only computes, and a node of its own only for the outside
call. LangGraph has no timers, so the harness resumes what waited too long. An acknowledgement is the return of ``invoke``.
"""

from __future__ import annotations

import sqlite3
from pathlib import Path
from typing import Literal, TypedDict, cast

from langgraph.checkpoint.sqlite import SqliteSaver
from langgraph.graph import END, START, StateGraph
from langgraph.types import Command, interrupt

from benchmarks.peers.beside import Limits, Outcomes
from benchmarks.peers.lean import Lean
from benchmarks.peers.messages import Event, Evidence, Outcome, decode
from benchmarks.peers.running import Load, Run, now_ns, size_of
from benchmarks.peers.treating import LIMIT_NS, TOPIC, WAITS, conclude, final, look, weigh

Durability = Literal["exit", "async", "sync"]


class State(TypedDict, total=False):
    """What is known of one event."""

    entity: str
    load: float
    waits: bool
    treatment: str
    label: str
    reading: float | None
    state: int
    called: int


class LangGraph:
    """Takes messages in windows; each event is one ``invoke``, and one more where it waited."""

    def __init__(self, run: Run, variant: str) -> None:
        self._run = run
        self._durability = cast("Durability", variant)
        self._db = sqlite3.connect(run.store / "langgraph.db", check_same_thread=False)
        self._db.execute("PRAGMA journal_mode=WAL")
        self._db.execute(f"PRAGMA synchronous={'FULL' if run.load.full_sync else 'NORMAL'}")
        self._outcomes = Outcomes(run.store / "outcomes.db", run.load.full_sync)
        self._graph = self._built(SqliteSaver(self._db))
        self._limits = Limits()
        self._labels: dict[str, str] = {}
        self._early: dict[str, float] = {}

    def _built(self, saver: SqliteSaver) -> object:
        run, times = self._run, self._run.times

        def think(state: State) -> State:
            entity, reading = state["entity"], 0.0
            times.stepped.setdefault(entity, now_ns())
            seen = look(entity, state["load"])
            if state["waits"]:
                reading = interrupt(TOPIC)["value"]
                times.resumed[entity] = now_ns()
            return {"reading": reading if state["waits"] else None, "state": weigh(seen, reading)}

        def outside(state: State) -> State:
            return {"called": run.call(state["entity"])}

        def end(state: State) -> State:
            return {"state": conclude(state["state"], state["label"])}

        def all_at_once(state: State) -> State:
            return {**(known := think(state)), "state": conclude(known["state"], state["label"])}

        graph = StateGraph(State)
        if run.load.calls:
            for name, node in (("think", think), ("outside", outside), ("end", end)):
                graph.add_node(name, node)
            for before, after in ((START, "think"), ("think", "outside"), ("outside", "end"), ("end", END)):
                graph.add_edge(before, after)
        else:
            graph.add_node("think", all_at_once)
            graph.add_edge(START, "think")
            graph.add_edge("think", END)
        return graph.compile(checkpointer=saver)

    def run(self) -> None:
        """Window by window."""
        run = self._run
        self._rebuild()
        for came, texts in run.windows():
            messages = [decode(text) for text in texts]
            chosen = iter(run.lean.choose([message for message in messages if isinstance(message, Event)]))
            for came_ns, message in zip(came, messages, strict=True):
                for entity in self._limits.late(message.at_ns):
                    self._resume(entity, None)
                if isinstance(message, Event):
                    run.times.came[message.entity] = came_ns
                    self._start(message, *next(chosen))
                elif isinstance(message, Evidence):
                    run.times.read.setdefault(message.entity, came_ns)
                    if self._limits.end(message.entity):
                        self._resume(message.entity, message.value)
                    elif message.entity not in run.times.came:
                        self._early.setdefault(message.entity, message.value)
                elif isinstance(message, Outcome):
                    self._outcomes.add(message.entity, self._label(message.entity), message.label, message.acted_on)
            self._outcomes.commit()

    def _rebuild(self) -> None:
        """After a crash: who still waits for what is the harness's to know."""
        for message in self._run.before():
            if isinstance(message, Event) and message.category == WAITS:
                self._limits.begin(message.entity, message.at_ns + LIMIT_NS)
            elif isinstance(message, Evidence) and not self._limits.end(message.entity):
                self._early.setdefault(message.entity, message.value)

    def _start(self, event: Event, treatment: str, label: str) -> None:
        entity, waits = event.entity, event.category == WAITS
        given: State = {"entity": entity, "load": event.load, "waits": waits, "treatment": treatment, "label": label}
        if not (self._run.restarted and self._goes_on(entity)):
            self._invoke(entity, given)
        self._labels[entity] = label
        self._run.acknowledge([entity])
        if waits:
            self._limits.begin(entity, event.at_ns + LIMIT_NS)
            if entity in self._early:
                self._limits.end(entity)
                self._resume(entity, self._early.pop(entity))

    def _goes_on(self, entity: str) -> bool:
        """After a crash: whether the thread is there already; one that stood between two nodes is continued."""
        known = self._graph.get_state({"configurable": {"thread_id": entity}})  # type: ignore[attr-defined]
        if known.next and known.values and not known.interrupts:
            self._invoke(entity, None)
        return bool(known.values)

    def _resume(self, entity: str, value: float | None) -> None:
        if self._run.restarted:
            known = self._graph.get_state({"configurable": {"thread_id": entity}})  # type: ignore[attr-defined]
            if not known.interrupts:
                self._goes_on(entity)
                return
        self._invoke(entity, Command(resume={"value": value}))

    def _label(self, entity: str) -> str:
        if entity not in self._labels:
            self._labels[entity] = self._graph.get_state({"configurable": {"thread_id": entity}}).values["label"]  # type: ignore[attr-defined]
        return self._labels[entity]

    def _invoke(self, entity: str, given: object) -> None:
        self._graph.invoke(given, {"configurable": {"thread_id": entity}}, durability=self._durability)  # type: ignore[attr-defined]

    def finals(self) -> list[str]:
        """From each thread's last checkpoint and the table of outcomes."""
        finals = []
        for entity, label, judged in self._outcomes.rows():
            known = self._graph.get_state({"configurable": {"thread_id": entity}}).values  # type: ignore[attr-defined]
            finals.append(final(entity, known["treatment"], known["label"], known["reading"], known["state"], label, judged))
        self._outcomes.close()
        self._db.close()
        return finals

    def answered(self) -> set[str]:
        """Whose outside call's answer is committed: in a checkpoint, or in the writes beside one."""
        found = set()
        for (entity,) in self._db.execute("SELECT DISTINCT thread_id FROM checkpoints").fetchall():
            known = self._graph.get_state({"configurable": {"thread_id": entity}})  # type: ignore[attr-defined]
            if known.values.get("called") or any(task.name == "outside" and task.result for task in known.tasks):
                found.add(entity)
        return found

    def stored_bytes(self) -> int:
        """The two databases."""
        return size_of(self._run.store, "langgraph.db", "outcomes.db")


def answered(store: Path, variant: str) -> set[str]:
    """Whose outside call's answer is committed."""
    return LangGraph(Run([], Lean([]), store, store, Load(calls=True)), variant).answered()
