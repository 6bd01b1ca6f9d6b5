"""Registration D(o, c): observation + memory → event. Most observations are no event; what lasts is one event."""

from wakeful.registration.registrar import CLEARED, REPEATED, SpecRegistrar

__all__ = ["CLEARED", "REPEATED", "SpecRegistrar"]
