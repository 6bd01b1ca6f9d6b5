"""Registration D(o, c): observation + memory → event. Most observations are no event; what lasts is one event."""

from wakeful.registration.recall import Incident, Recall, incidents_of, recall
from wakeful.registration.registrar import CLEARED, REPEATED, SpecRegistrar

__all__ = ["CLEARED", "REPEATED", "Incident", "Recall", "SpecRegistrar", "incidents_of", "recall"]
