"""Registration D(o, c): observation + memory → event. Most observations are no event; what lasts is one event."""

from wakeful.registration.heard import Sources, SourceState
from wakeful.registration.recall import Incident, Recall, incidents_of, recall
from wakeful.registration.registrar import CLEARED, REPEATED, SpecRegistrar

__all__ = ["CLEARED", "REPEATED", "Incident", "Recall", "SourceState", "Sources", "SpecRegistrar", "incidents_of", "recall"]
