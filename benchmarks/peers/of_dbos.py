"""W through DBOS Transact: a workflow for each event, its id the event's, readings as messages to it.

As cheap as its documentation allows: the database in WAL mode with the acknowledgement that W asks for, JSON instead of pickles,
steps that only compute in the workflow itself (they are deterministic), only the outside call as a step; readings sent in bulk;
workflows that wait for nothing run on the caller's thread. Limits pass in workload time, so the harness sends them.
"""

from __future__ import annotations

import logging
import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import cast

import msgspec
import sqlalchemy as sa
from dbos import DBOS, SendMessage, Serializer, SetWorkflowID, WorkflowHandle
from sqlalchemy.pool import QueuePool

from benchmarks.peers.beside import Limits, Outcomes
from benchmarks.peers.messages import Event, Evidence, Outcome, decode
from benchmarks.peers.postgres import cpu_s
from benchmarks.peers.running import Run, now_ns, size_of
from benchmarks.peers.treating import LIMIT_NS, TOPIC, WAITS, conclude, final, look, weigh

#: How long a workflow really waits at most: longer than any run, since limits pass in workload time.
LONG_S = 600.0
POLL_S = 0.05
THREADS = 256

Result = list[object]
_running: list[Run] = []


class Json(Serializer):
    """Shorter and faster than the default, which pickles."""

    def serialize(self, data: object) -> str:
        """To JSON."""
        return msgspec.json.encode(data).decode()

    def deserialize(self, serialized_data: str) -> object:
        """From JSON."""
        return msgspec.json.decode(serialized_data)


@DBOS.step()
def outside(entity: str) -> int:
    """The outside call, whose answer is recorded."""
    return _running[0].call(entity)


@DBOS.workflow()
def treat(entity: str, load: float, waits: bool, treatment: str, label: str, calls: bool) -> Result:
    """Three steps, and a reading where one is needed."""
    times = _running[0].times
    times.stepped[entity] = now_ns()
    seen = look(entity, load)
    reading = 0.0
    if waits:
        reading = DBOS.recv(TOPIC, timeout_seconds=LONG_S)
        times.resumed[entity] = now_ns()
    state = weigh(seen, reading)
    if calls:
        outside(entity)
    return [treatment, label, reading if waits else None, conclude(state, label)]


class Dbos:
    """Takes messages in windows."""

    def __init__(self, run: Run, variant: str) -> None:
        self._run = run
        self._variant = variant
        _running[:] = [run]
        logging.disable(logging.WARNING)
        sync = "FULL" if run.load.full_sync else "NORMAL"
        url = f"sqlite:///{run.store}/dbos.db" if variant == "sqlite" else os.environ["PEERS_POSTGRES"]
        engine = _sqlite(url, sync) if variant == "sqlite" else _postgres(url, run.load.full_sync)
        self._engine = engine
        DBOS(
            config={
                "name": "peers",
                "system_database_url": url,
                "system_database_engine": engine,
                "serializer": Json(),
                "max_executor_threads": THREADS,
                "notification_listener_polling_interval_sec": POLL_S,
                "application_version": "1",
                "executor_id": "peers",
                "log_level": "CRITICAL",
            }
        )
        self._outcomes = Outcomes(run.store / "outcomes.db", run.load.full_sync)
        DBOS.launch()
        self.other_cpu_s = 0.0
        self._before = self._server_bytes()
        self._limits = Limits()
        self._handles: dict[str, WorkflowHandle[Result]] = {}
        self._results: dict[str, Result] = {}
        self._early: dict[str, Evidence] = {}

    def run(self) -> None:
        """All of W; the database server's CPU time counts too."""
        server = int(os.environ.get("PEERS_POSTGRES_PID", "0")) if self._variant != "sqlite" else 0
        before_s = cpu_s(server) if server else 0.0
        self._rebuild()
        self._windows()
        self.other_cpu_s = cpu_s(server) - before_s if server else 0.0

    def _rebuild(self) -> None:
        """After a crash: DBOS has resumed its workflows; who still waits for what is the harness's to know."""
        for message in self._run.before():
            if isinstance(message, Event) and message.category == WAITS:
                self._limits.begin(message.entity, message.at_ns + LIMIT_NS)
            elif isinstance(message, Evidence) and not self._limits.end(message.entity):
                self._early.setdefault(message.entity, message)

    def _windows(self) -> None:
        run = self._run
        for came, texts in run.windows():
            messages = [decode(text) for text in texts]
            events = [message for message in messages if isinstance(message, Event)]
            chosen = iter(run.lean.choose(events))
            sends: list[SendMessage] = []
            for came_ns, message in zip(came, messages, strict=True):
                sends += [_send(entity, None) for entity in self._limits.late(message.at_ns)]
                if isinstance(message, Event):
                    run.times.came[message.entity] = came_ns
                    self._start(message, *next(chosen))
                    if message.entity in self._early:
                        sends.append(self._reading(self._early.pop(message.entity)))
                elif isinstance(message, Evidence):
                    run.times.read.setdefault(message.entity, came_ns)
                    if message.entity in self._limits.waiting:
                        sends.append(self._reading(message))
                    elif message.entity not in run.times.came and message.entity not in run.acknowledged:
                        self._early.setdefault(message.entity, message)
                elif isinstance(message, Outcome):
                    if sends:
                        DBOS.send_bulk(sends)
                        sends = []
                    self._outcomes.add(
                        message.entity, cast("str", self._result(message.entity)[1]), message.label, message.acted_on
                    )
            if sends:
                DBOS.send_bulk(sends)
            self._outcomes.commit()

    def _start(self, event: Event, treatment: str, label: str) -> None:
        run, waits = self._run, event.category == WAITS
        with SetWorkflowID(event.entity):
            if waits:
                self._limits.begin(event.entity, event.at_ns + LIMIT_NS)
                self._handles[event.entity] = DBOS.start_workflow(
                    treat, event.entity, event.load, True, treatment, label, run.load.calls
                )
            else:
                self._results[event.entity] = treat(event.entity, event.load, False, treatment, label, run.load.calls)
        run.acknowledge([event.entity])

    def _reading(self, message: Evidence) -> SendMessage:
        self._limits.end(message.entity)
        return _send(message.entity, message.value, message.id)

    def _result(self, entity: str) -> Result:
        if entity not in self._results:
            self._results[entity] = (self._handles.pop(entity, None) or DBOS.retrieve_workflow(entity)).get_result()
        return self._results[entity]

    def finals(self) -> list[str]:
        """From the workflows' recorded outputs and the table of outcomes."""
        found = {each.workflow_id: cast("Result", each.output) for each in _all()}
        finals = []
        for entity, label, judged in self._outcomes.rows():
            treatment, predicted, reading, state = found[entity]
            finals.append(final(entity, treatment, predicted, reading, state, label, judged))  # type: ignore[arg-type]
        self._outcomes.close()
        DBOS.destroy()
        self._bytes = self._server_bytes() - self._before
        self._engine.dispose()
        return finals

    def _server_bytes(self) -> int:
        if self._variant == "sqlite":
            return 0
        with self._engine.connect() as connection:
            return int(connection.execute(sa.text("SELECT pg_database_size(current_database())")).scalar_one())

    def stored_bytes(self) -> int:
        """The databases' size."""
        beside = size_of(self._run.store, "outcomes.db")
        return beside + (size_of(self._run.store, "dbos.db") if self._variant == "sqlite" else self._bytes)


def answered(store: Path, variant: str) -> set[str]:
    """Whose outside call's answer is committed."""
    query = "SELECT workflow_uuid FROM {}operation_outputs WHERE function_name LIKE '%outside'"
    if variant != "sqlite":
        with sa.create_engine(os.environ["PEERS_POSTGRES"]).connect() as connection:
            return {row[0] for row in connection.execute(sa.text(query.format("dbos.")))}
    if not (store / "dbos.db").exists():
        return set()
    with closing(sqlite3.connect(store / "dbos.db")) as db:
        return {row[0] for row in db.execute(query.format(""))}


def _all() -> Iterator[object]:
    page = 0
    while found := DBOS.list_workflows(limit=1000, offset=page, load_input=False):
        yield from found
        page += len(found)


def _send(entity: str, value: float | None, key: str | None = None) -> SendMessage:
    return SendMessage(destination_id=entity, message=value, topic=TOPIC, idempotency_key=key)


def _sqlite(url: str, sync: str) -> sa.Engine:
    engine = sa.create_engine(url, poolclass=QueuePool, pool_size=8, max_overflow=8, connect_args={"check_same_thread": False})

    @sa.event.listens_for(engine, "connect")
    def prepare(connection: object, _record: object) -> None:
        connection.isolation_level = "IMMEDIATE"  # type: ignore[attr-defined]
        for pragma in ("busy_timeout=30000", "foreign_keys=ON", "journal_mode=WAL", f"synchronous={sync}"):
            connection.execute(f"PRAGMA {pragma}")  # type: ignore[attr-defined]

    return engine


def _postgres(url: str, full_sync: bool) -> sa.Engine:
    options = f"-c synchronous_commit={'on' if full_sync else 'off'}"
    return sa.create_engine(url, pool_size=8, max_overflow=8, connect_args={"options": options})
