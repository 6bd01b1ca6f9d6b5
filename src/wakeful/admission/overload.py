"""Overload: deliberation is shed before coverage, what is not critical before what is, and each with its reason."""

from __future__ import annotations

from wakeful.facts.events import CRITICAL, Event
from wakeful.facts.overload import REFUSED, SHED, Load, OverloadSettings


class Overload:
    """Says what to give up at a load. Knows nothing but its settings: the load is the fold of what was recorded.

    Args:
        settings: the declared policy.
    """

    def __init__(self, settings: OverloadSettings) -> None:
        self.settings = settings
        self._room = int(settings.refuse_backlog * (1.0 - settings.reserve))
        self._share = int(self._room * settings.source_share)

    def objection(self, event: Event, load: Load) -> str:
        """Why the event is not to be admitted at this load; empty where it is."""
        own = self.settings
        if event.criticality >= CRITICAL:
            if load.backlog >= own.refuse_backlog:
                return f"{REFUSED}, the backlog has reached {own.refuse_backlog}, the room for criticals too"
            return ""
        if load.open >= own.most_open:
            return f"{REFUSED}, {own.most_open} processes are open"
        if load.backlog >= self._room:
            return f"{REFUSED}, the backlog has reached {self._room}; the rest of {own.refuse_backlog} is kept for criticals"
        if load.backlog >= own.shed_backlog and load.of_source >= self._share:
            return f"{REFUSED}, source {event.source} holds {self._share} of the backlog, its share of the room"
        return ""

    def sheds(self, event: Event, load: Load) -> str:
        """Why the event is not to be deliberated at this load; empty where it may be. A critical one always may."""
        own = self.settings
        if event.criticality >= CRITICAL or (load.backlog < own.shed_backlog and load.oldest_s < own.shed_age_s):
            return ""
        return f"{SHED}, {load.backlog} events wait to be treated, the oldest for {load.oldest_s:.1f} s"
