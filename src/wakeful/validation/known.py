"""The events that a forecast may be about: remembered while a process is open on them, and for a while after."""

from __future__ import annotations

from collections import deque

from wakeful.facts.events import Event


class KnownEvents:
    """Events with open processes, and the last ``keep`` without: a result may be recorded just after its process has
    completed, and an event reopened."""

    def __init__(self, keep: int) -> None:
        self._keep = keep
        self._events: dict[str, Event] = {}
        self._since_ns: dict[str, int] = {}
        self._event_of: dict[int, str] = {}
        self._open_on: dict[str, int] = {}
        self._retired: deque[str] = deque()

    def get(self, event: str) -> Event | None:
        """The event of that id; None where it is unknown or forgotten."""
        return self._events.get(event)

    def since_ns(self, event: str) -> int:
        """When it happened, in kernel time: by its source's clock as that stood when it came."""
        return self._since_ns[event]

    def admitted(self, event: Event, since_ns: int) -> None:
        """An event entered cognition; ``since_ns`` is when it happened, in kernel time."""
        self._events[event.id] = event
        self._since_ns[event.id] = since_ns

    def created(self, process: int, event: str) -> None:
        """A process is open on the event."""
        self._event_of[process] = event
        self._open_on[event] = self._open_on.get(event, 0) + 1

    def covered(self, event: Event, since_ns: int, process: int) -> None:
        """Both at once: of an event that is new, or of a parked process that is taken up."""
        identity = event.id
        self._events[identity] = event
        self._since_ns[identity] = since_ns
        self._event_of[process] = identity
        self._open_on[identity] = self._open_on.get(identity, 0) + 1

    def park(self, process: int) -> int | None:
        """Give away an event that only this process is open on, and return when it happened; ``covered`` takes it back."""
        event = self._event_of.get(process)
        if event is None or self._open_on[event] != 1:
            return None
        del self._event_of[process], self._open_on[event], self._events[event]
        return self._since_ns.pop(event)

    def __contains__(self, event: str) -> bool:
        return event in self._events

    def ran(self, process: int, event: str) -> int:
        """The process is open no longer; when its event happened, in kernel time."""
        since_ns = self._since_ns[event]
        self.completed(process)
        return since_ns

    def completed(self, process: int) -> None:
        """The process is open no longer."""
        event = self._event_of.pop(process, None)
        if event is None:
            return
        self._open_on[event] -= 1
        if not self._open_on[event]:
            del self._open_on[event]
            self._retired.append(event)
        while len(self._retired) > self._keep:
            oldest = self._retired.popleft()
            if oldest not in self._open_on:
                self._events.pop(oldest, None)
                self._since_ns.pop(oldest, None)
