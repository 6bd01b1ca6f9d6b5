"""A journal as a trace for Perfetto and Chrome: JSON in the Trace Event Format.

Each process is a thread whose slices are its states; a preemption is a flow arrow from the preempted to the preempting; what came
is an instant. Times are microseconds since the journal's first event.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import IO, TypeAlias

import msgspec

from wakeful.facts.processes import State
from wakeful.journal.lanes import Lane, Lanes, Preemption, Track

_THINKING, _SOURCES = 1, 2

#: Colours by the names that the format reserves; a viewer that has its own palette ignores them.
_COLOURS = {
    State.CREATED: "thread_state_unknown",
    State.ACTIVE: "thread_state_running",
    State.WAITING: "thread_state_sleeping",
    State.SUSPENDED: "thread_state_runnable",
}

Argument: TypeAlias = str | int | float
_Clock: TypeAlias = Callable[[int], float]


class TraceEvent(msgspec.Struct, kw_only=True, omit_defaults=True):
    """One event of the format, under its own field names; see "Trace Event Format", section "Event Descriptions"."""

    name: str
    ph: str
    pid: int
    tid: int
    ts: float
    cat: str = ""
    dur: float | None = None
    id: int | None = None
    bp: str = ""
    s: str = ""
    cname: str = ""
    args: dict[str, Argument] = {}


class Trace(msgspec.Struct, kw_only=True):
    """The whole file: a JSON object with its events, the earliest first."""

    traceEvents: list[TraceEvent]  # the format's own name
    displayTimeUnit: str = "ms"
    otherData: dict[str, str] = {}


def trace_of(told: Lanes) -> Trace:
    """The lanes as a trace."""

    def us(at_ns: int) -> float:
        return max(0, at_ns - told.begin_ns) / 1000

    names = [_named(_THINKING, 0, "process_name", "processes"), _named(_SOURCES, 0, "process_name", "sources")]
    events: list[TraceEvent] = []
    for lane in told.lanes:
        title = f"P{lane.process} {lane.treatment}: {lane.kind} of {lane.entity}"
        names += [_named(_THINKING, lane.process, "thread_name", title), _sorted(lane.process)]
        events += _slices(lane, us)
        events += [_instant(each.kind, each.says, us(each.at_ns), _THINKING, lane.process) for each in lane.marks]
    for tid, track in enumerate(told.tracks, start=1):
        names.append(_named(_SOURCES, tid, "thread_name", track.source))
        events += _source(track, tid, us)
    by_process = {lane.process: lane for lane in told.lanes}
    for number, each in enumerate(told.preemptions, start=1):
        events += _arrow(number, each, by_process[each.preempting], us)
    # Equal instants: slices before what binds to them.
    order = {"X": 0, "s": 1, "f": 2, "i": 3}
    events.sort(key=lambda event: (event.ts, order[event.ph]))
    return Trace(traceEvents=names + events, otherData={"began_ns": str(told.begin_ns), "made_by": "wakeful trace"})


def write_trace(told: Lanes, file: IO[bytes]) -> int:
    """Write the lanes as a trace; returns how many events of the format that took."""
    trace = trace_of(told)
    file.write(msgspec.json.encode(trace))
    return len(trace.traceEvents)


def _slices(lane: Lane, us: _Clock) -> list[TraceEvent]:
    found = []
    for stretch in lane.stretches:
        args: dict[str, Argument] = {
            "event": lane.event,
            "criticality": lane.criticality,
            "mode": lane.mode,
            "steps": stretch.steps,
            "began by": f"{stretch.why} {stretch.by}".strip() or "creation",
        }
        if lane.deadline_ns is not None:
            args["deadline_s"] = (lane.deadline_ns - stretch.begin_ns) / 1e9
        if lane.end:
            args["ended"] = lane.end
        begin_us, end_us = us(stretch.begin_ns), us(stretch.end_ns)
        found.append(
            TraceEvent(
                name=stretch.state,
                cat="state",
                ph="X",
                pid=_THINKING,
                tid=lane.process,
                ts=begin_us,
                dur=round(end_us - begin_us, 3),
                cname=_COLOURS[stretch.state],
                args=args,
            )
        )
    return found


def _arrow(number: int, each: Preemption, preempting: Lane, us: _Clock) -> list[TraceEvent]:
    """A flow from the slice that the preemption ended to the one that it began. Viewers bind an end to the slice around it: it
    stands a little within."""
    at_us = us(each.at_ns)
    begun = [us(stretch.end_ns) - at_us for stretch in preempting.stretches if stretch.begin_ns == each.at_ns]
    within_us = round(min(0.5, max(begun, default=0.0) / 2), 3)
    start = TraceEvent(name="preempts", cat="preemption", ph="s", pid=_THINKING, tid=each.preempted, ts=at_us, id=number)
    end = TraceEvent(
        name="preempts", cat="preemption", ph="f", bp="e", pid=_THINKING, tid=each.preempting, ts=at_us + within_us, id=number
    )
    return [start, end]


def _source(track: Track, tid: int, us: _Clock) -> list[TraceEvent]:
    begin_us = us(track.begin_ns)
    whole = TraceEvent(
        name=track.source, cat="source", ph="X", pid=_SOURCES, tid=tid, ts=begin_us, dur=round(us(track.end_ns) - begin_us, 3)
    )
    return [whole, *(_instant(each.kind, each.says, us(each.at_ns), _SOURCES, tid) for each in track.marks)]


def _instant(kind: str, says: str, at_us: float, pid: int, tid: int) -> TraceEvent:
    return TraceEvent(name=says, cat=kind, ph="i", s="t", pid=pid, tid=tid, ts=at_us)


def _named(pid: int, tid: int, what: str, name: str) -> TraceEvent:
    return TraceEvent(name=what, ph="M", pid=pid, tid=tid, ts=0.0, args={"name": name})


def _sorted(process: int) -> TraceEvent:
    return TraceEvent(name="thread_sort_index", ph="M", pid=_THINKING, tid=process, ts=0.0, args={"sort_index": process})
